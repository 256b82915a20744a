"""A fluid model behind its interface: its outputs are stored, and no other code asks which model it is."""

import ast
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from conftest import hawkmoth
from taichiflap_viewer import charts
from taichiflap_viewer.frames import Run

import taichiflap
from taichiflap import fluids
from taichiflap.case.case import CaseError
from taichiflap.cli import main
from taichiflap.export import table
from taichiflap.studies.converge import converge
from taichiflap.vortex.sum import induced_velocity

ROOT = Path(__file__).parent.parent
OWN = ("fluids", "validation", "published", "scored")
"""Rooms that name a solver by right: the models, and the studies that compare certain ones."""
TABLES = ("case/case.py", "case/solver.py", "case/messages.py")
"""Where the case file's own words for its tables stand."""

MINE = '''
import numpy as np
from taichiflap.fluids.kit import PLUNGE, Axis, Model, Output, Refinement, Table, View, flow_of, key, standard, ti

class Numbers(Table):
    """What the model is told."""
    stiffness: float = key(2.0, unit="N/m", text="force over the plunge", gt=0, le=10)
    count: int = key(3, text="entries of its own axis", ge=1, le=99)

class Spring(Model):
    name, numbers, elements = "SPRING", Numbers, 6
    outputs = (
        *standard("pressure_jump"),
        Output("stretch", (), "m", "how far the spring is stretched", "s"),
        Output("square", (), "m2", "its square"),
        Output("ramp", ("rung",), "m", "multiples of the stretch"),
        Output("chain/link", ("place",), "m", "the stretch, once a step so far", dtype="f4", ragged=True),
    )

    def axes(self, case):
        return {"rung": Axis(np.arange(self.parameters(case).count) / 2, "1", "half numbers")}

    def entries(self, case, step):
        return np.asarray(step) + 1

    def problems(self, case):
        return ["wing.modes = 8: at most 7"] if case.wing.modes == 8 else []

    def completed(self, case):
        return case.override("output.every=7") if case.time.periods == 2 else case

    def refinements(self, case):
        return [Refinement("numbers.count", self.parameters(case).count)]

    def flow(self, cases, sections, body, threads):
        told = [self.parameters(case) for case in cases]
        return flow_of(
            prepare, settle, record, record_step, stiffness=np.array([one.stiffness for one in told]),
            count=np.array([one.count for one in told]), now=np.zeros((len(cases), 2)),
        )

@ti.func
def prepare(body: View, flow: View, b, n, rule):
    flow.now[b, 0] = body.motion[b, n, PLUNGE]

@ti.func
def settle(body: View, flow: View, b, n, rule):
    flow.now[b, 1] = flow.now[b, 1] + 1.0
    for c in range(4):
        body.force[b, c] = -flow.stiffness[b] * flow.now[b, 0]

@ti.func
def record(flow: View, output: View, b, frame):
    for i in range(6):
        output.pressure_jump[b, frame, i] = 1.0
    for i in range(flow.count[b]):
        output.ramp[b, frame, i] = i * flow.now[b, 0]
    output.chain_count[b, frame] = ti.cast(flow.now[b, 1], ti.i32)
    for i in range(output.chain_count[b, frame]):
        output.chain_link[b, frame, i] = ti.cast(flow.now[b, 0], ti.f32)

@ti.func
def record_step(flow: View, output: View, b, row):
    output.series[b, row, 0] = flow.now[b, 0]
    output.series[b, row, 1] = flow.now[b, 0] ** 2

MODEL = Spring()
'''


@pytest.fixture
def spring(tmp_path, monkeypatch):
    (tmp_path / "spring_model.py").write_text(MINE)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield "solver=module:spring_model"
    sys.modules.pop("spring_model", None)


SHORT = ("wing.modes=0", "time.periods=1", "time.steps_per_period=20")


@pytest.mark.parametrize("every", [1, 7])
def test_what_a_model_declares_is_stored_and_read_back(spring, every, tmp_path):
    case = hawkmoth(*SHORT, spring, f"output.every={every}", "numbers={count=4}")
    with taichiflap.simulate(case, tmp_path / "run.h5") as result:
        steps = [*range(0, 20, every), 20]
        np.testing.assert_array_equal(result.stretch, result.plunge)
        np.testing.assert_array_equal(result.square, result.stretch**2)
        assert len(result.stretch) == 21
        np.testing.assert_array_equal(result.ramp, np.outer(result.stretch[steps], np.arange(4)))
        for frame, step in enumerate(steps):
            link = result.ragged("chain", ["link"], frame)["link"]
            assert len(link) == step + 1
            assert set(link) == {np.float32(result.stretch[step])}
        assert result.describe("stretch").symbol == "s"
        table.write_csv(result, tmp_path / "run.csv")
        assert "stretch (m)" in (tmp_path / "run.csv").read_text()
        ours = result.to_xarray()
    field_axis = "time" if every == 1 else "field_time"
    with xarray.open_dataset(tmp_path / "run.h5", engine="h5netcdf") as theirs:
        assert theirs.ramp.dims == ours.ramp.dims == (field_axis, "rung")
        assert theirs.ramp.attrs["long_name"] == "multiples of the stretch"
        assert theirs.rung.values.tolist() == ours.rung.values.tolist() == [0.0, 0.5, 1.0, 1.5]
        assert theirs.stretch.dims == ("time",)
    with xarray.open_dataset(tmp_path / "run.h5", engine="h5netcdf", group="chain") as chain:
        assert chain.link.dims == ("place",)


def test_the_viewer_charts_what_only_the_model_knows(spring):
    run = Run(taichiflap.simulate(hawkmoth(*SHORT, spring)), "run")
    shown = {one.name: one for one in charts.quantities([run])}
    assert (shown["stretch"].title, shown["stretch"].unit) == ("How far the spring is stretched", "mm")
    assert "square" in shown
    assert "ramp" not in shown
    _, values = run.series("square", 0, 20, 100)
    np.testing.assert_array_equal(values, run.result.square)
    assert not run.draws_flow
    assert run.velocity(0) is None
    run.close()


def test_alone_or_beside_a_case_of_another_size_it_stores_the_same(spring):
    cases = [hawkmoth(*SHORT, spring, f"numbers={{count={count}}}", "output.every=7") for count in (2, 5)]
    for case, together in zip(cases, taichiflap.simulate(cases), strict=True):
        alone = taichiflap.simulate(case)
        for name in alone.variables:
            np.testing.assert_array_equal(getattr(alone, name), getattr(together, name), err_msg=name)
        np.testing.assert_array_equal(*(one.ragged("chain", ["link"], -1)["link"] for one in (alone, together)))


def test_the_table_of_a_model_is_checked_like_any_other(spring, tmp_path):
    for told, said in (
        ("{stiffness=12.0}", r"numbers\.stiffness = 12\.0: must be a number > 0 and <= 10 N/m"),
        ("{stifness=1.0}", r"numbers\.stifness: unknown key; did you mean numbers\.stiffness\?"),
        ("{count=0}", r"numbers\.count = 0: must be a whole number >= 1"),
    ):
        with pytest.raises(CaseError, match=said):
            taichiflap.simulate(hawkmoth(*SHORT, spring, f"numbers={told}"), tmp_path / "run.h5")
    assert not (tmp_path / "run.h5.part").exists()


def test_a_model_refuses_what_it_cannot_compute_and_chooses_what_is_left_open(spring, tmp_path):
    with pytest.raises(CaseError, match=r"wing\.modes = 8: at most 7"):
        taichiflap.simulate(hawkmoth(*SHORT, spring, "wing.modes=8"), tmp_path / "run.h5")
    assert not list(tmp_path.glob("run*"))
    with taichiflap.simulate(hawkmoth(*SHORT, spring, "time.periods=2")) as result:
        assert (result.case.output.every, result.frames, result.steps) == (7, 7, 41)


def test_a_model_of_ones_own_converges(spring):
    case = hawkmoth(spring, "wing.modes=0", "time.periods=1", "time.steps_per_period=200")
    found = converge(case, 0.01, metrics=["force_normal_peak_mean"])
    assert set(found.accepted) == {"numbers.count", "time.steps_per_period", "time.periods"}
    assert not found.open


@pytest.mark.parametrize(
    ("wrong", "line", "said"),
    [
        ("flow.nonsense[b, 0] = body.motion[b, n, PLUNGE]", "prepare", "nonsense"),
        ("flow.now[b, 0, 5] = body.motion[b, n, PLUNGE]", "prepare", "indices of dim 3"),
    ],
)
def test_what_does_not_compile_is_told_with_file_and_line(wrong, line, said, tmp_path, monkeypatch, capsys):
    text = MINE.replace("flow.now[b, 0] = body.motion[b, n, PLUNGE]", wrong)
    file = tmp_path / "wrong_model.py"
    file.write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)
    sys.modules.pop("wrong_model", None)
    case = ROOT / "cases" / "hawkmoth.toml"
    settings = [part for one in (*SHORT, "solver=module:wrong_model") for part in ("--set", one)]
    monkeypatch.setattr(sys, "argv", ["taichiflap", "simulate", str(case), *settings])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    told = capsys.readouterr().err
    number = 1 + text[: text.index(wrong)].count("\n")
    assert f"{file}, line {number}: " in told
    assert said in told
    assert "Traceback" not in told
    assert sorted(one.name for one in tmp_path.iterdir() if one.suffix) == ["wrong_model.py"]


def test_the_lattices_flow_is_that_of_its_vortices():
    """Also for a cosine lattice, whose vortices are not at the quarter of their panels."""
    for spacing in ("uniform", "cosine"):
        case = hawkmoth("time.periods=1", "uvlm.panels=8", f"uvlm.spacing={spacing}", "fluid.velocity=[0.5, -0.2]")
        result = taichiflap.simulate(case)
        model = fluids.load("uvlm")
        points = np.array([[0.1, -0.05], [0.02, 0.07]])
        far = model.velocity(result, -1)(points)
        wake = result.wake(-1)
        at = fluids.uvlm.stations.stations(case)
        cosine, sine = np.cos(result.pitch[-1]), np.sin(result.pitch[-1])
        w = np.interp(at.vortex, at.node, _deflection(result))
        y, z = at.vortex * cosine - w * sine, result.plunge[-1] + at.vortex * sine + w * cosine
        strength = np.r_[result.panel_circulation[-1], wake["circulation"]]
        vortices = np.stack([np.r_[y, wake["y"]], np.r_[z, wake["z"]], strength])
        expected = induced_velocity(points, vortices, 0.08 * case.wing.chord) + np.array([[0.5], [-0.2]])
        np.testing.assert_allclose(far, expected, rtol=1e-5)


def _deflection(result):
    return result.q[-1] @ result.modes["shape"]


ASKED = re.compile(r"\bsolver\s*(==|!=|in\b)")


def test_nothing_outside_a_fluid_model_asks_which_one_it_is():
    """No comparison with a solver's name, and no access to a model's table, outside the models."""
    found = []
    for folder in ("taichiflap", "viewer"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            where = file.relative_to(ROOT / folder).as_posix()
            if folder == "taichiflap" and (where.split("/")[0] in OWN or where in TABLES):
                continue
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                name = isinstance(node, ast.Constant) and node.value in fluids.MODELS
                looked = isinstance(node, ast.Attribute) and node.attr in fluids.MODELS
                compared = isinstance(node, ast.Compare) and ASKED.search(ast.unparse(node))
                if name or looked or compared:
                    found.append(f"{folder}/{where}:{node.lineno}: {ast.unparse(node)}")
    assert not found, "\n".join(found)
