"""The variables of a result: names, dimensions, units, signs and descriptions."""

from dataclasses import dataclass, replace

NO_COORDINATE = "This is a netCDF dimension but not a netCDF variable."
"""NetCDF-4's name for a dimension without values."""
FIELD_TIME = "field_time"
"""Axis of the times at which fields are stored, if these are not all steps."""


AXES_OF = "axes"
"""Attribute of a variable defined by the fluid model: the names of its axes."""


@dataclass(frozen=True)
class Variable:
    """One array of the file: dimensions, units and description.

    A field is stored every `output.every` steps and at the last step; a series at every step.
    """

    dimensions: tuple[str, ...]
    units: str
    long_name: str
    symbol: str = ""
    comment: str = ""
    dtype: str = "f8"
    field: bool = False

    def axes(self, every: int) -> tuple[str, ...]:
        """The dimensions in a file that does not store fields at every step: `field_time` instead of `time`."""
        if not self.field or every == 1:
            return self.dimensions
        return tuple(FIELD_TIME if name == "time" else name for name in self.dimensions)

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the array in a file: `units`, `long_name`, `symbol` and `comment`, where defined."""
        words = {name: getattr(self, name) for name in ("units", "long_name", "symbol", "comment")}
        return {name: text for name, text in words.items() if text}


_NORMAL = "positive along the wing's normal e_z = (-sin pitch, cos pitch) in (Y, Z)"
_CHORD = "positive along the undeformed chord e_y = (cos pitch, sin pitch) in (Y, Z), leading to trailing edge"
_INERTIAL = "inertial frame; up is -Y; the stroke is along Z"
_SPIN = "positive counter-clockwise in (Y, Z)"

VARIABLES = {
    "plunge": Variable(("time",), "m", "position of the pivot along Z", "Z", _INERTIAL),
    "surge": Variable(("time",), "m", "position of the pivot along Y", "Y", _INERTIAL),
    "pitch": Variable(("time",), "rad", "pitch angle of the undeformed chord", "theta", _SPIN),
    "q": Variable(("time", "mode"), "m kg0.5", "modal amplitude", "q_k", "mass-normalised modes"),
    "q_rate": Variable(("time", "mode"), "m kg0.5 s-1", "rate of the modal amplitude", "dq_k/dt"),
    "q_acceleration": Variable(("time", "mode"), "m kg0.5 s-2", "acceleration of the modal amplitude", "d2q_k/dt2"),
    "modal_force": Variable(("time", "mode"), "N kg-0.5", "aerodynamic modal force", "Q_k"),
    "tip_deflection": Variable(("time",), "m", "deflection of the trailing edge", "W(c)", _NORMAL),
    "force_normal": Variable(("time",), "N", "fluid force along the wing's normal", "F_N", _NORMAL),
    "force_axial": Variable(("time",), "N", "fluid force along the chord", "F_A", _CHORD),
    "force_normal_unsteady": Variable(
        ("time",), "N", "part of force_normal due to acceleration", "F_N,AM",
        f"DBET: added mass; UVLM: the d(Gamma)/dt term; {_NORMAL}",
    ),
    "force_y": Variable(("time",), "N", "fluid force along Y, full vector", "F_Y", _INERTIAL),
    "force_z": Variable(("time",), "N", "fluid force along Z, full vector", "F_Z", _INERTIAL),
    "force_vertical": Variable(("time",), "N", "vertical force, full vector", "-F_Y", _INERTIAL),
    "force_vertical_normal": Variable(
        ("time",), "N", "vertical component of force_normal", "-F_N e_z . e_Y", _INERTIAL
    ),
    "lift": Variable(
        ("time",), "N", "force normal to the free stream", "L",
        "90 degrees counter-clockwise from the stream in (Y, Z); only with a stream",
    ),
    "thrust": Variable(("time",), "N", "force against the free stream", "T", "only with a stream"),
    "moment": Variable(("time",), "N m", "fluid moment about the pivot", "M", _SPIN),
    "power": Variable(
        ("time",), "W", "mechanical power of the actuator", "P", "power_aerodynamic + power_inertial"
    ),
    "power_aerodynamic": Variable(("time",), "W", "actuator power against the fluid", "P_a"),
    "power_inertial": Variable(("time",), "W", "actuator power for the wing's inertia", "P_i"),
    "power_net": Variable(
        ("time",), "W", "net power into the wing: from the actuator and the fluid, minus structural damping", "",
        "equals the rate of energy up to the time-stepping error",
    ),
    "energy": Variable(("time",), "J", "kinetic and elastic energy of the wing", "E"),
    "angle_of_attack": Variable(
        ("time",), "rad", "geometric angle of attack: of the chord to the pivot's motion through the fluid", "alpha",
        "0 with the leading edge first, up to pi; in hover a right angle less the size of the pitch",
    ),
    "lift_coefficient": Variable(
        ("time",), "1", "lift, in hover vertical force, over rho U^2 S / 2", "C_L",
        "U and S are the file's reference_speed and reference_area; so in the others",
    ),
    "drag_coefficient": Variable(("time",), "1", "force along the free stream over rho U^2 S / 2", "C_D"),
    "thrust_coefficient": Variable(("time",), "1", "force against the free stream over rho U^2 S / 2", "C_T"),
    "power_coefficient": Variable(("time",), "1", "mechanical power over rho U^3 S / 2", "C_P"),
    "circulation": Variable(("time",), "m2 s-1", "total bound circulation", "Gamma", _SPIN),
    "suction_velocity": Variable(
        ("time",), "m s-1", "suction velocity at the leading edge", "A",
        "U sin(alpha) on a steady flat plate; the suction per unit span is pi rho c A^2; A > 0: from below to above",
    ),
    "leading_edge_circulation": Variable(
        ("time",), "m2 s-1", "total circulation shed by the leading edge", "Gamma_LE", _SPIN
    ),
    "trailing_edge_circulation": Variable(
        ("time",), "m2 s-1", "total circulation shed by the trailing edge", "Gamma_TE", _SPIN
    ),
    "leading_edge_sheds": Variable(("time",), "1", "1 while the leading edge sheds, else 0"),
    "wake_crossings": Variable(
        ("time",), "1", "number of wake-wing crossings so far", "",
        "counted whether reflected or not; see uvlm.crossing",
    ),
    "wake_lost": Variable(
        ("time",), "m s-1", "velocity at the wing lost by dropping or absorbing wake vortices", "",
        "an estimate: velocity that the lost vortices would induce at mid-chord, decaying over a beat",
    ),
    "wake_far_error": Variable(
        ("time",), "m s-1", "largest measured error of a wake vortex's velocity by multipoles", "",
        "eight vortices per step compared with the direct sum; bounded by uvlm.far_error",
    ),
    "node_position": Variable(
        ("time", "node", "component"), "m", "position of the wing's nodes", "R", _INERTIAL, dtype="f4", field=True
    ),
    "panel_circulation": Variable(
        ("time", "panel"), "m2 s-1", "circulation of the bound vortices", "Gamma_i", _SPIN, dtype="f4", field=True
    ),
    "pressure_jump": Variable(
        ("time", "panel"), "Pa", "normal force of the fluid per area", "dP", _NORMAL, dtype="f4", field=True
    ),
    "shear": Variable(("time", "panel"), "Pa", "chordwise force of the fluid per area", "", _CHORD, "f4", True),
}  # fmt: skip

WAKE_VARIABLES = {
    "y": Variable(("vortex",), "m", "position of the wake vortices along Y", "Y", _INERTIAL, "f4"),
    "z": Variable(("vortex",), "m", "position of the wake vortices along Z", "Z", _INERTIAL, "f4"),
    "circulation": Variable(("vortex",), "m2 s-1", "circulation of the wake vortices", "Gamma", _SPIN, "f4"),
    "birth": Variable(("vortex",), "1", "time step at which the vortex was shed", dtype="i4"),
    "edge": Variable(("vortex",), "1", "edge that shed the vortex", "", "0: trailing edge, 1: leading edge", "i4"),
}
WAKE_EDGE = "edge"
"""The variable that exists only for a wake shed from two edges."""

WAKE_COUNT = Variable(("time",), "1", "number of wake vortices in the frame", dtype="i4", field=True)


def count_of(group: str) -> Variable:
    """The variable with the number of entries of a ragged group in each frame."""
    if group == "wake":
        return WAKE_COUNT
    return replace(WAKE_COUNT, long_name=f"number of entries of {group} in the frame")


COMPONENTS = ("Y", "Z")
"""Axes of the inertial frame."""

AXES = {
    "time": Variable((), "s", "time", "t"),
    FIELD_TIME: Variable((), "s", "time at which fields are stored", "t", "only if output.every is not 1"),
    "mode": Variable((), "1", "number of the elastic mode", "k"),
    "node": Variable((), "m", "chordwise position of the nodes, from the pivot", "y"),
    "panel": Variable((), "m", "chordwise position of the midpoints of panels or elements, from the pivot", "y"),
    "component": Variable((), "", "axis of the inertial frame"),
}

MODE_VARIABLES = {
    "frequency": Variable(("mode",), "Hz", "natural frequency", "f_k"),
    "damping_ratio": Variable(("mode",), "1", "modal damping ratio", "zeta_k"),
    "lambda": Variable(("mode",), "kg0.5", "integral of phi_k dm", "lambda_k"),
    "psi": Variable(("mode",), "m kg0.5", "integral of y phi_k dm", "psi_k"),
    "shape": Variable(("mode", "node"), "kg-0.5", "mass-normalised mode shape", "phi_k"),
}
