"""Published cases that a viscous fluid alone has: vortices behind a cylinder, boundary layers of a thin plate."""

import math

from .rigid_cases import document
from .truths import Published, Truth, around

VISCOUS = "Viscous flow at low Reynolds number"
"""Regime of the report."""
MODELS = ("navier-stokes",)


def cylinder() -> Published:
    """A cylinder in a stream, the section of one chord's thickness; it is turned to set the vortices going."""
    turn = {"pitch": {"kind": "ramp", "amplitude_deg": 180.0, "start": 2.0, "ramp": 1.0, "smoothing": 10.0}}
    window, sources = (75.0, 150.0), "computations and experiments; band: their scatter"
    return Published(
        name="cylinder",
        group=VISCOUS,
        about="cylinder in a stream, Re 100",
        document=document("Cylinder, Re 100", turn, 1.0, {"duration": 150.0, "step": 0.025}, 0.5, 0.01),
        reynolds=100.0,
        speed=1.0,
        truths=(
            Truth("C_D mean", 1.33, 1.32, 1.37, window, sources),
            Truth("Strouhal number", 0.165, 0.164, 0.166, window, sources),
        ),
        citation="Williamson, J. Fluid Mech. 206 (1989); Park, Kwon & Choi, KSME Int. J. 12 (1998)",
        settings={"navier-stokes": ("navier_stokes.thickness=1.0", "navier_stokes.cells=128")},
        models=MODELS,
    )


def thin_plate() -> Published:
    """A flat plate along a stream."""
    reynolds = 1000.0
    friction = 2.0 * (1.3282 / math.sqrt(reynolds) + 2.668 * reynolds**-0.875)
    theory = "boundary layers with the triple deck at the trailing edge; band: 5 %"
    return Published(
        name="thin-plate",
        group=VISCOUS,
        about="flat plate along a stream, Re 1,000",
        document=document("Thin plate, Re 1000", {}, 1.0, {"duration": 12.0, "step": 0.01}, 0.0, 1.0 / reynolds),
        reynolds=reynolds,
        speed=1.0,
        truths=(around("C_D mean", friction, 0.05, (11.0, 12.0), theory),),
        citation="Stewartson, Mathematika 16 (1969); Messiter, SIAM J. Appl. Math. 18 (1970)",
        settings={"navier-stokes": ("navier_stokes.thickness=0.01",)},
        models=MODELS,
    )
