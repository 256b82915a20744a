"""Unusual cases, maps and names cause no traceback and no loss of data."""

import csv
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.case.messages import holds_whole
from taichiflap.cli import main
from taichiflap.commands.summary import summary_lines
from taichiflap.errors import UserError
from taichiflap.export.formats import export_map
from taichiflap.files import OutputError
from taichiflap.maps import file as maps
from taichiflap.maps.design import Spread, design
from taichiflap.maps.outcome import Outcome
from taichiflap.metrics.names import METRICS
from taichiflap.plots import formats
from taichiflap.plots import maps as map_plots
from taichiflap.plots import result as plots
from taichiflap.studies.converge import converge

EXAMPLES = Path(__file__).parent.parent / "examples"
SHORT = ("solver=dbet", "wing.modes=1", "time.periods=2", "time.steps_per_period=20")


def own_model(monkeypatch, **more):
    """A case of the model of the examples."""
    monkeypatch.syspath_prepend(str(EXAMPLES))
    document = {
        "solver": "module:theodorsen",
        "wing": {"chord": 0.1, "span": 0.3, "thickness": 1e-3, "density": 1e3, "modes": 0, "pivot": 0.25},
        "motion": {"frequency": 2.0, "plunge": {"amplitude": 0.01}, "pitch": {"mean_deg": 2.0}},
        "fluid": {"velocity": [2.0, 0.0], "density": 1.2},
        "time": {"periods": 3, "steps_per_period": 20},
    }
    return parse_case(document | more)


@pytest.mark.slow
def test_a_model_of_ones_own_converges_in_steps_and_beats(monkeypatch):
    found = converge(own_model(monkeypatch), 0.2, metrics=["power_mean"])
    assert {trial.key for trial in found.trials} == {"time.steps_per_period", "time.periods"}


@pytest.mark.slow
def test_a_run_that_fails_at_its_first_step_is_told_of_in_every_way(monkeypatch, tmp_path, capsys):
    case = own_model(monkeypatch, numbers={"lift_slope": 1e302}, fluid={"velocity": [1000.0, 0.0], "density": 1e5})
    path = tmp_path / "run.h5"
    with taichiflap.simulate(case, path) as result:
        assert result.status == "failed"
        assert len(result.time) == 0
        lines = "\n".join(summary_lines(result))
        assert "for 0 steps" in lines
        assert "became infinite or undefined at step 0" in lines
        assert taichiflap.summarise(result) is None
        with pytest.raises(UserError):
            plots.plot([result], tmp_path / "fig")
    for command in (["info", str(path)], ["export", str(path), "--to", "csv"], ["plot", str(path)]):
        monkeypatch.setattr(sys, "argv", ["taichiflap", *command])
        monkeypatch.chdir(tmp_path)
        with pytest.raises(SystemExit) as stopped:
            main()
        assert stopped.value.code in (0, 2)
        assert "Traceback" not in capsys.readouterr().err


def test_higher_harmonics_are_told_of_and_a_run_of_less_than_a_beat_is_not_waited_for():
    document = hawkmoth(*SHORT).to_dict()
    document["motion"]["plunge"] = {"harmonics": [[1, 0.02, 0.0], [3, 0.001, 0.0]]}
    document["time"] = {"duration": 0.03, "step": 0.002}
    with taichiflap.simulate(parse_case(document)) as result:
        lines = "\n".join(summary_lines(result))
    assert "25 Hz, plunge 0 mm and 2 harmonics, pitch 15 deg, 15 steps of 0.002 s" in lines
    assert "less than a beat: no statistics" in lines


def test_sweep_asks_for_xarray_before_it_computes(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(UserError, match=r"xarray: pip install"):
        taichiflap.sweep(hawkmoth(*SHORT), {"wing.modes": [0, 1]}, tmp_path / "map.h5")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("key", "held", "whole"),
    [
        ("uvlm.wake", "all", True),
        ("uvlm.wake", 100, True),
        ("time.steps_per_period", "auto", True),
        ("time.steps_per_period", 200, True),
        ("wing.modes", 1, True),
        ("wing.chord", 0.02, False),
        ("fluid.density", 1.0, False),
        ("uvlm.suction", False, False),
        ("no.such_key", None, False),
    ],
)
def test_a_range_of_a_key_goes_by_what_it_may_hold_and_not_by_what_it_holds(key, held, whole):
    section, _, name = key.partition(".")
    document = hawkmoth().to_dict() | {section: {name: held}}
    assert holds_whole(key, document, taichiflap.Case) == whole
    values = Spread.read(key, "100:400:4", document).values()
    assert values == (100, 200, 300, 400)
    assert {type(value) for value in values} == {int if whole else float}


def filled(vary, kept=("force_vertical_mean", "power_mean"), sample=None):
    case = hawkmoth(*SHORT)
    planned = design(case, vary, sample)
    sheet = maps.create(None, case, planned, {name: METRICS[name] for name in kept})
    last = planned.size - 1
    outcomes = [Outcome(dict.fromkeys(kept, 1.0 + n)) for n in range(last)] + [Outcome(reason='it, "failed"')]
    sheet.record(range(planned.size), outcomes)
    return sheet


@pytest.mark.slow
@pytest.mark.parametrize(
    ("vary", "sample", "kind"),
    [
        ({"wing.span": "0.05", "wing.chord": "0.01:0.02:3"}, None, "lines"),
        ({"wing.chord": "0.01:0.02:3", "wing.span": "0.05"}, None, "lines"),
        ({"wing.span": "0.05", "wing.chord": "0.01:0.02:3", "motion.frequency": "20:30:3"}, None, "map"),
        ({"wing.span": "0.05", "wing.chord": "0.01:0.02"}, "lhs:5", "scatter"),
    ],
)  # fmt: skip
def test_keys_of_a_single_value_span_no_picture(vary, sample, kind, tmp_path):
    with filled(vary, sample=sample) as sheet:
        names = [path.name for path in map_plots.plot(sheet, tmp_path / "fig.svg")]
    assert names == [f"fig-{kind}.svg", "fig-pareto.svg"]


@pytest.mark.parametrize(
    ("name", "stem", "kinds"),
    [
        ("fig.pdf", "fig", ("pdf",)),
        ("fig.EPS", "fig", ("eps",)),
        ("fig.svg", "fig", ("svg",)),
        ("fig.png", "fig", ("png",)),
        ("fig", "fig", ("png", "svg")),
        ("run.v2", "run.v2", ("png", "svg")),
        ("0.5", "0.5", ("png", "svg")),
    ],
)
def test_the_extension_of_a_figure_is_its_kind(name, stem, kinds):
    assert formats.asked(Path(name)) == (Path(stem), kinds)


@pytest.mark.parametrize("kind", ["jpg", "tiff", "gif"])
def test_a_kind_of_picture_that_is_not_written_is_refused(kind):
    with pytest.raises(OutputError, match=f"figures cannot be written as {kind}; use pdf, eps, svg, png"):
        formats.asked(Path(f"fig.{kind}"))
    assert formats.asked(None) == (None, ("png", "svg"))


@pytest.mark.slow
def test_figures_of_each_kind_are_of_that_kind_and_of_two_models_have_two_titles(tmp_path, caplog):
    runs = [taichiflap.simulate(hawkmoth(*SHORT, f"solver={name}", "uvlm.panels=8")) for name in ("dbet", "uvlm")]
    begins = {"pdf": b"%PDF", "eps": b"%!PS-Adobe-3.0 EPSF", "svg": b"<?xml", "png": b"\x89PNG"}
    names = [f"fig-{name}.{kind}" for name in ("summary", "wing", "wing-2") for kind in ("png", "svg")]
    assert sorted(path.name for path in plots.plot(runs, tmp_path / "fig")) == sorted(names)
    for kind in ("pdf", "eps"):
        assert next(path.name for path in plots.plot(runs[:1], tmp_path / f"fig.{kind}")) == f"fig-summary.{kind}"
    for path in tmp_path.glob("fig-*"):
        assert path.read_bytes().startswith(begins[path.suffix[1:]]), path
    assert not caplog.records
    titles = [" ".join(text.get_text() for text in plots.wing(run).texts) for run in runs]
    assert "DBET" in titles[0]
    assert "UVLM" in titles[1]


def test_a_map_is_a_table_of_its_cases(tmp_path):
    with filled({"wing.chord": "0.01:0.02:3", "solver": "dbet,uvlm"}) as sheet:
        path = export_map(sheet, "csv", tmp_path / "map.csv")
        with pytest.raises(OutputError, match="a map can only be exported as csv, not as 'gif'"):
            export_map(sheet, "gif", tmp_path / "map.gif")
        with pytest.raises(OutputError, match="exists already"):
            export_map(sheet, "csv", path)
        points = [sheet.design.point(n) for n in range(6)]
    header, *rows = csv.reader(path.read_text().splitlines())
    assert header[:3] == ["wing.chord (m)", "solver", "force_vertical_mean (N)"]
    assert [(float(row[0]), row[1]) for row in rows] == [tuple(point.values()) for point in points]
    np.testing.assert_array_equal([float(row[2]) for row in rows[:5]], np.arange(1.0, 6.0))
    assert rows[0][-2:] == ["complete", ""]
    assert rows[5][2:] == ["", "", "failed", 'it, "failed"']
