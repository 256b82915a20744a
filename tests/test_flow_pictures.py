"""The flow behind a wing on a uniform grid: positions, vorticity and velocity compared with exact values."""

import base64
import json
import re
import zlib

import h5py
import numpy as np
import pytest
import xarray
from conftest import hawkmoth

import taichiflap
from taichiflap import fluids
from taichiflap.drawing import flow, palette
from taichiflap.drawing.orientation import WING, Standpoint
from taichiflap.errors import UserError
from taichiflap.export import page
from taichiflap.export.film import Film
from taichiflap.export.formats import export
from taichiflap.fluids.navier_stokes.field import Field
from taichiflap.fluids.navier_stokes.grid import Grid, positions, slopes
from taichiflap.fluids.navier_stokes.inverse import inverted
from taichiflap.fluids.navier_stokes.wall_motion import WallMotion
from taichiflap.plots.result import wing

CHORD, PIVOT, PITCH = 0.02, 0.011 - 0.004j, 0.6
BENT = np.array([0.255, 0.3, 0.225, 0.0, 0.0]) + 1j * np.array([0.0, -0.05, 0.06, 0.02, -0.008])
"""Coefficients of the map of a section that is bent by a fifth of its chord."""
NS = ("solver=navier_stokes", "fluid.viscosity=4e-4", "time.periods=1", "time.steps_per_period=400",
      "navier_stokes.cells=96", "navier_stokes.radius=5.0", "output.every=50")  # fmt: skip


@pytest.fixture(scope="module")
def moth():
    settings = ("wing.modes=1", "motion.start_up_periods=1.0", "motion.surge={amplitude=0.004,phase_deg=20}")
    with taichiflap.simulate(hawkmoth(*NS, *settings)) as result:
        yield result


def field_of(vorticity=None, coefficients=BENT, wall=None, cells=128, stream=0.0):
    """A field whose vorticity is a function of points Y + i Z."""
    grid = Grid.stretched(cells, 0.02, 3.0, 0.02)
    rho = 0.5 * (grid.faces[1:] + grid.faces[:-1])
    still = WallMotion(0.0, 0.0, np.array([0.0, 1.0]), np.zeros(2))
    found = Field(
        rho, grid.centres, grid.faces, np.zeros((grid.rows, cells)), coefficients * CHORD, PIVOT, PITCH, CHORD,
        wall or still, stream,
    )  # fmt: skip
    if vorticity:
        found.vorticity[:] = vorticity(found.positions())
    return found


def blob(place):
    """Two smooth vortices, one of them across the seam phi = 0 behind the trailing edge."""
    near = PIVOT + CHORD * 0.9 * np.exp(1j * PITCH)
    far = PIVOT + CHORD * (0.2 - 1.1j)
    return 90.0 * np.exp(-(np.abs(place - near) ** 2) / (0.4 * CHORD) ** 2) - 40.0 * np.exp(
        -(np.abs(place - far) ** 2) / (0.5 * CHORD) ** 2
    )


def test_the_map_of_a_bent_section_is_inverted_from_the_wall_outwards():
    found = field_of()
    zeta = inverted(found.coefficients, found.positions(inertial=False), CHORD)
    np.testing.assert_allclose(zeta, np.exp(found.rho[:, None] + 1j * found.phi), rtol=1e-6)


@pytest.mark.parametrize("inertial", [True, False])
def test_an_analytic_vorticity_comes_back_on_a_plain_grid(inertial):
    found = field_of(blob)
    y, z = np.linspace(-0.03, 0.035, 41), np.linspace(-0.04, 0.03, 43)
    points = y[:, None] + 1j * z
    expected = blob(points if inertial else PIVOT + points * np.exp(1j * PITCH))
    values = found.resampled(y, z, inertial)
    outside = np.isfinite(values)
    assert 0 < np.count_nonzero(~outside) < 40
    assert np.abs(values - expected)[outside].max() < 2e-3 * 90.0


def test_without_vorticity_the_flow_is_potential_flow():
    """An ellipse in translation through fluid at rest: psi = (V_y (r - a) sin phi - V_z (r + a) cos phi)/|zeta|."""
    wall = WallMotion(1.3 - 0.7j, 0.0, np.array([0.0, 1.0]), np.zeros(2))
    straight = np.array([0.26, 0.5, 0.24], complex)
    found = field_of(coefficients=straight, wall=wall)
    zeta = 1.7 * np.exp(1j * np.linspace(0.1, 6.2, 17))
    points = PIVOT + CHORD * (straight[0] * zeta + straight[1] + straight[2] / zeta) * np.exp(1j * PITCH)
    # u - i v = dF/dw of F = -(r conj(V) - a V)/zeta ... with the wall at |zeta| = 1.
    strength = straight[2] * wall.pivot.conjugate() - straight[0] * wall.pivot
    slope = straight[0] - straight[2] / zeta**2
    expected = (-strength / zeta**2 / slope).conjugate() * CHORD * np.exp(1j * PITCH)
    velocity = found.velocity_at(np.stack((points.real, points.imag)))
    size = np.abs(expected).max()
    np.testing.assert_allclose(velocity[0] + 1j * velocity[1], expected, atol=2e-3 * size)


def test_velocity_streamfunction_and_vorticity_agree_in_a_run(moth):
    """The streamfunction's slope is the velocity, whose curl is the vorticity; the wall moves with the fluid."""
    found = fluids.load("navier_stokes").field(moth, -2)
    field = Field.of(moth, -2)
    node = moth.frame("node_position", -2)
    step = 0.0001
    y, z = np.arange(-0.012, 0.032, step), field.pivot.imag + np.arange(-0.02, 0.02, step)
    points = np.stack(np.meshgrid(y, z, indexing="ij"))
    velocity, vorticity, psi = found.velocity(points), found.vorticity(points), found.streamfunction(points)
    away = np.abs(points[0] + 1j * points[1] - (node[:, 0] + 1j * node[:, 1])[:, None, None]).min(axis=0) > 0.15 * CHORD
    away[[0, -1]] = away[:, [0, -1]] = False
    curl = np.gradient(velocity[1], step, axis=0) - np.gradient(velocity[0], step, axis=1)
    assert np.abs(curl - vorticity)[away].mean() < 0.01 * np.abs(vorticity)[away].max()
    slopes = np.stack((np.gradient(psi, step, axis=1), -np.gradient(psi, step, axis=0)))
    assert np.abs(slopes - velocity)[:, away].max() < 0.03 * np.abs(velocity[:, away]).max()
    # Fluid next to the wall has the wall's velocity across it.
    place = np.exp(1j * field.phi[8:-8:8])
    wall = field.coefficients[0] * place + sum(a * place**-n for n, a in enumerate(field.coefficients[1:]))
    normal = field.coefficients[0] * place - sum(n * a * place**-n for n, a in enumerate(field.coefficients[1:]))
    normal = normal / np.abs(normal) * np.exp(1j * field.pitch)
    out = field.pivot + wall * np.exp(1j * field.pitch) + 1e-5 * normal
    moving = field.wall.pivot + 1j * field.wall.rate * wall / CHORD
    moving = moving + 1j * np.interp(wall.real / CHORD, field.wall.node, field.wall.bending)
    fluid = found.velocity(np.stack((out.real, out.imag)))
    gap = (fluid[0] + 1j * fluid[1] - CHORD * moving * np.exp(1j * field.pitch)) * normal.conj()
    assert np.abs(gap.real).max() < 0.05 * np.abs(velocity[:, away]).max()


def test_streamlines_seen_from_the_wing_run_along_it():
    """A rigid wing is a streamline of the fluid's motion relative to it."""
    through, stream, rate = 0.9 - 0.4j, 0.3 + 0.2j, 35.0
    wall = WallMotion((through - stream) * np.exp(-1j * PITCH) / CHORD, rate, np.array([0.0, 1.0]), np.zeros(2))
    field = field_of(blob, np.array([0.26, 0.5, 0.24], complex), wall, stream=stream)
    carried = flow.Carried(PIVOT.real, PIVOT.imag, (through.real, through.imag), rate)
    place = field.positions()[0]
    points = np.stack((place.real, place.imag))
    psi, moving = field.streamfunction_at(points), carried.streamfunction(points)
    assert np.ptp(psi - moving) < 0.02 * np.ptp(psi)
    step = 1e-7
    aside, up = points + np.array([[step], [0.0]]), points + np.array([[0.0], [step]])
    slopes = (carried.streamfunction(up) - moving) / step, -(carried.streamfunction(aside) - moving) / step
    np.testing.assert_allclose(carried.velocities(points), slopes, atol=1e-4)


def test_the_wings_frame_holds_the_pivot_still(moth):
    for index in (3, 6):
        stand = Standpoint.of(moth, index, WING)
        node = moth.frame("node_position", index)
        places = stand.places(node[:, 0], node[:, 1])
        np.testing.assert_allclose(places[:, 0], moth.stations, atol=1e-8)
        deflection = moth.frame("q", index) @ moth.modes["shape"]
        np.testing.assert_allclose(places[:, 1], deflection, atol=1e-8)
        np.testing.assert_allclose(stand.points(places), node.T, atol=1e-8)


def test_a_picture_takes_in_what_is_stirred(moth):
    found = flow.extent(moth, range(moth.frames))
    left, bottom, right, top = found.box
    place, vorticity = Field.of(moth, -1).positions(), Field.of(moth, -1).vorticity
    strong = Standpoint.of(moth, -1).places(place.real, place.imag)[np.abs(vorticity) > 0.5 * found.limit]
    inside = ((strong > (left, bottom)) & (strong < (right, top))).all(axis=1)
    assert inside.mean() > 0.99
    wing = Standpoint.of(moth, -1).places(*moth.frame("node_position", -1).T)
    assert ((wing >= (left, bottom)) & (wing <= (right, top))).all()


def test_holes_take_the_value_of_their_neighbours_and_lines_are_even():
    picture = np.outer(np.arange(6.0), np.ones(5))
    picture[2:4, 1:3] = np.nan
    filled = flow.filled(picture)
    assert np.isfinite(filled).all()
    assert 1.0 < filled[2, 1] < filled[3, 1] < 4.0
    across = np.tile(np.linspace(0.0, 2.0, 200), (40, 1))
    drawn = flow.lines(across, 0.5, width=2.0)
    # One line at each of 0.5, 1.0 and 1.5, two pixels of ink wide.
    assert drawn[20, 20:180].sum() == pytest.approx(3 * 2.0, rel=0.05)


def test_films_figures_and_pages_show_the_vorticity(moth, tmp_path):
    """The picture shows the colours of the file's vorticity, and the background elsewhere."""
    film = Film(moth, 1, 100, 25, theme=palette.DARK)
    assert film.keyed
    assert not film.dotted
    picture = next(film.pictures())
    colours = palette.table(palette.DARK.flow).astype(int)
    for end in (colours[0], colours[-1]):
        assert (np.abs(picture.astype(int) - end).max(axis=-1) < 12).sum() > 20
    figure = wing(moth)
    pictures = [one for ax in figure.axes for one in ax.images]
    assert len(pictures) == 8
    assert all(np.isfinite(np.asarray(one.get_array())).all() for one in pictures)
    path = tmp_path / "moth.html"
    count = page.write_html(moth, path, 1, WING)
    data = json.loads(re.search(r'id="data">(.*?)</script>', path.read_text(encoding="utf-8"), re.DOTALL)[1])
    assert len(data["pictures"]) == count
    columns, rows = data["size"]
    found = np.frombuffer(zlib.decompress(base64.b64decode(data["pictures"][-1])), np.uint8).reshape(rows, columns)
    found = np.cumsum(found, axis=1, dtype=np.uint8)[::-1]
    left, right, bottom, top = data["page"]
    index = range(moth.frames)[-2]
    places = flow.points(Standpoint.of(moth, index, WING), (left, bottom, right, top), (rows, columns))
    expected = np.clip(Field.of(moth, index).vorticity_at(places) / data["limit"], -1.0, 1.0)
    outside = np.isfinite(expected)
    assert np.abs((found.astype(float) - 128.0) / 127.0 - expected)[outside].max() < 0.01


@pytest.fixture(scope="module")
def exported(moth, tmp_path_factory):
    folder = tmp_path_factory.mktemp("grids")
    return {
        "nc": export(moth, "nc", folder / "moth.nc"),
        "wing": export(moth, "nc", folder / "wing.nc", reference=WING),
        "flow": export(moth, "flow.vtkhdf", folder / "moth.flow.vtkhdf"),
    }


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
@pytest.mark.parametrize("name", ["nc", "wing"])
def test_netcdf_has_the_flow_on_a_plain_grid(moth, exported, name, engine):
    inertial = name == "nc"
    along, up = ("Y", "Z") if inertial else ("y", "z")
    field = Field.of(moth, 5)
    with xarray.open_dataset(exported[name], engine=engine) as found:
        assert found.vorticity.dims == ("time", along, up)
        assert found.vorticity.attrs["units"] == "s-1"
        np.testing.assert_array_equal(found.time, moth.field_time)
        y, z = found[along].values, found[up].values
        expected = field.resampled(y, z, inertial)
        np.testing.assert_allclose(found.vorticity[5], expected, rtol=1e-5, atol=1e-3)
        points = y[:, None] + 1j * z
        turn = 1.0 if inertial else np.exp(1j * field.pitch)
        points = points if inertial else field.pivot + points * turn
        velocity = field.velocity_at(np.stack((points.real, points.imag)))
        velocity = (velocity[0] + 1j * velocity[1]) / turn
        np.testing.assert_allclose(found.velocity_y[5] + 1j * found.velocity_z[5], velocity, rtol=1e-5, atol=1e-5)
        node = moth.frame("node_position", 5)
        nodes = (found.wing_y[5] + 1j * found.wing_z[5]).values
        if not inertial:
            nodes = field.pivot + nodes * turn
        np.testing.assert_allclose(nodes, node[:, 0] + 1j * node[:, 1], atol=1e-8)


def test_vtkhdf_has_the_flow_as_a_temporal_image(moth, exported):
    with h5py.File(exported["flow"]) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"ImageData"
        extent, origin, spacing = (root.attrs[name] for name in ("WholeExtent", "Origin", "Spacing"))
        columns, rows = extent[1] + 1, extent[3] + 1
        assert root["PointData/vorticity"].shape == (moth.frames, 1, rows, columns)
        assert root["PointData/velocity"].shape == (moth.frames, 1, rows, columns, 3)
        assert root["Steps"].attrs["NSteps"] == moth.frames
        np.testing.assert_array_equal(root["Steps/Values"], moth.field_time)
        np.testing.assert_array_equal(root["Steps/PointDataOffsets/vorticity"], np.arange(moth.frames))
        right, up = origin[0] + spacing[0] * np.arange(columns), origin[1] + spacing[1] * np.arange(rows)
        # The page is (Z, -Y).
        expected = Field.of(moth, 5).resampled(-up, right)
        np.testing.assert_allclose(root["PointData/vorticity"][5, 0], expected, rtol=1e-4, atol=1e-2)


@pytest.mark.slow
def test_in_a_stream_the_flow_lies_where_the_wing_does(tmp_path):
    """Both files of ParaView have the page (Z, -Y), whatever the direction of the stream."""
    with taichiflap.simulate(hawkmoth(*NS, "wing.modes=0", "fluid.velocity=[2.0, 0.5]", "output.every=200")) as result:
        with h5py.File(export(result, "vtkhdf", tmp_path / "wing.vtkhdf")) as file:
            wing_points = file["VTKHDF/Points"][-len(result.stations) :, :2]
        with h5py.File(export(result, "flow.vtkhdf", tmp_path / "flow.vtkhdf")) as file:
            root = file["VTKHDF"]
            extent, origin, spacing = (root.attrs[name] for name in ("WholeExtent", "Origin", "Spacing"))
            spin, velocity = root["PointData/vorticity"][-1, 0], root["PointData/velocity"][-1, 0]
        right, up = (origin[i] + spacing[i] * np.arange(extent[2 * i + 1] + 1) for i in (0, 1))
        field = Field.of(result, result.frames - 1)
        np.testing.assert_allclose(spin, field.resampled(-up, right), rtol=1e-4, atol=1e-2)
        y, z = field.velocity_at(np.stack(np.broadcast_arrays(-up[:, None], right[None, :])))
        np.testing.assert_allclose(velocity[..., 0], z, rtol=1e-5, atol=1e-5)
        np.testing.assert_allclose(velocity[..., 1], -y, rtol=1e-5, atol=1e-5)
    # Mid-chord lies within the section, where the flow has no value.
    across, along = wing_points.mean(axis=0)
    row, column = np.argmin(np.abs(up - along)), np.argmin(np.abs(right - across))
    assert np.isnan(spin[row - 1 : row + 2, column - 1 : column + 2]).any()


def test_a_model_without_vorticity_has_no_grid_of_it(tmp_path):
    with (
        taichiflap.simulate(hawkmoth("solver=dbet", "time.periods=1", "time.steps_per_period=40")) as result,
        pytest.raises(UserError, match="stores no vorticity"),
    ):
        export(result, "nc", tmp_path / "blades.nc")


def test_a_gust_that_covers_everything_is_a_stream():
    node, still = np.array([0.0, 1.0]), np.zeros(2)
    plain = WallMotion(1.1 - 0.4j - (0.2 + 0.6j), 3.0, node, still)
    blown = WallMotion(1.1 - 0.4j, 3.0, node, still, lambda place: np.full(place.shape, 0.2 + 0.6j))
    field = field_of()
    place = positions(field.coefficients / CHORD, np.zeros(1), field.phi)[0]
    slope = slopes(field.coefficients / CHORD, field.phi)
    (tangent, psi), (also, other) = plain.on(place, slope), blown.on(place, slope)
    np.testing.assert_allclose(also, tangent, atol=1e-12)
    np.testing.assert_allclose(other - other[0], psi - psi[0], atol=1e-12)
