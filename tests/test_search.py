"""Convergence and optimisation: known functions, and real cases, none of which is run twice."""

import numpy as np
import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.commands.map_summary import map_lines
from taichiflap.errors import UserError
from taichiflap.maps import file as maps
from taichiflap.maps.design import DesignError, design
from taichiflap.maps.file import MapError
from taichiflap.maps.outcome import Outcome
from taichiflap.metrics.names import METRICS, MetricError, choose, gains, shown
from taichiflap.metrics.pareto import pareto_front
from taichiflap.plots import maps as map_plots
from taichiflap.studies import converge as convergence
from taichiflap.studies.converge import ConvergeError, converge, read_tolerance
from taichiflap.studies.expression import ExpressionError, read_constraint, read_expression
from taichiflap.studies.optimise import optimise, verdict

pytestmark = pytest.mark.slow

SHORT = ("solver=dbet", "time.periods=2", "time.steps_per_period=40", "dbet.elements=8")


def pretend(monkeypatch, metrics):
    """Replace runs by the function `metrics` of a case. Returns the list of requested cases."""
    asked = []

    def compute(cases, *_):
        asked.extend(cases)
        return [Outcome(dict.fromkeys(METRICS, 1.0) | metrics(case)) for case in cases]

    monkeypatch.setattr("taichiflap.studies.runner.compute", compute)
    return asked


def test_expressions_are_arithmetic():
    metrics = {"force_vertical_mean": 3.0, "power_mean": 2.0, "tip_peak_mean": 0.0}
    for text, value in {
        "vertical_force_mean / power_mean": 1.5,
        "-force_vertical_mean ** 2 + 1": -8.0,
        "sqrt(abs(-4 * force_vertical_mean * 3))": 6.0,
        "max(power_mean, 3.5) - min(power_mean, 1)": 2.5,
        "power_mean / tip_peak_mean": np.inf,
    }.items():
        assert read_expression(text).of(metrics) == value
    assert read_constraint("vertical_force_mean >= 2.5").of(metrics) == pytest.approx(0.5 / 5.5)
    assert read_constraint("2.5 >= vertical_force_mean").of(metrics) == pytest.approx(-0.5 / 5.5)
    assert read_constraint("tip_peak_mean <= 0").of(metrics) == 0.0


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')", "power_mean.real", "power_mean[0]", "(lambda: power_mean)()", "",
        "'a' * power_mean", "power_mean if 1 else 2", "power_mean >= 1", "power_mean +", "1 + 1", "exp(power_mean)",
        "abs(power_mean, 1)", "power_mean // 2", "True * power_mean", "abs(x=power_mean)", "(" * 500 + "power_mean",
    ],
)  # fmt: skip
def test_anything_but_arithmetic_is_refused(text):
    with pytest.raises(ExpressionError) as refused:
        read_expression(text)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("text", ["power_mean", "1 < power_mean < 2", "power_mean == 1", "power_mean >"])
def test_a_condition_is_one_comparison(text):
    with pytest.raises(ExpressionError):
        read_constraint(text)


def bowl(case):
    """A function with its minimum at a modulus of 2e10 Pa and a pitch of 20 degrees."""
    off = np.log10(case.wing.youngs_modulus / 2e10) ** 2 + (case.motion.pitch.amplitude_deg / 20 - 1) ** 2
    return {"power_mean": 1.0 + off, "force_vertical_mean": case.motion.pitch.amplitude_deg}


MODULUS = {"wing.youngs_modulus": "1e9:1e11:5:log"}
RANGES = {"wing.youngs_modulus": "5e9:60e9:log", "motion.pitch.amplitude_deg": "5:45"}


def test_the_optimum_of_a_bowl_is_its_bottom_or_the_edge_of_what_is_allowed(monkeypatch):
    pretend(monkeypatch, bowl)
    best = optimise(hawkmoth(*SHORT), RANGES, minimise="power_mean", population=16)
    assert best.holds
    assert best.value == pytest.approx(1.0, abs=1e-3)
    assert best.at_edge == []
    assert best == optimise(hawkmoth(*SHORT), RANGES, minimise="power_mean", population=16)
    limited = optimise(
        hawkmoth(*SHORT), RANGES, maximise="-power_mean", subject_to=["vertical_force_mean >= 30"], population=16
    )
    assert limited.holds
    assert limited.value == pytest.approx(-1.25, abs=5e-3)
    narrow = {**RANGES, "motion.pitch.amplitude_deg": "5:15"}
    edged = optimise(hawkmoth(*SHORT), narrow, minimise="power_mean", population=16)
    assert edged.at_edge == ["motion.pitch.amplitude_deg"]
    said = verdict(edged, "optimum.h5")
    assert any(line.startswith("motion.pitch.amplitude_deg = 1") and "at the end of its range" in line for line in said)
    assert any("deflection is 50 chords" in line for line in said)  # the pretended 1 m
    impossible = optimise(
        hawkmoth(*SHORT), RANGES, minimise="power_mean", subject_to=["power_mean <= 0.5"], population=8, generations=5
    )
    assert not impossible.holds


def test_a_search_over_lists_goes_on_in_its_file(monkeypatch, tmp_path):
    vary = {"solver": "dbet,uvlm", "fluid.velocity": "[1.0, 0.0],[2.0, 0.0]", "motion.frequency": "10:30"}
    power = lambda case: case.motion.frequency * (1 + (case.solver == "dbet")) + case.fluid.velocity[0]  # noqa: E731
    asked = pretend(monkeypatch, lambda case: {"power_mean": power(case)})
    how = {"minimise": "power_mean", "population": 6, "generations": 3}
    best = optimise(hawkmoth(*SHORT), vary, output=tmp_path / "search.h5", **how)
    count = len(asked)
    assert best == optimise(hawkmoth(*SHORT), vary, output=tmp_path / "search.h5", **how)
    assert len(asked) == count
    with maps.open_map(tmp_path / "search.h5") as sheet:
        assert sheet.design.size == count
        expected = [power(sheet.design.case(sheet.case, number)) for number in range(count)]
        np.testing.assert_array_equal(sheet.values("power_mean"), expected)
        assert (best.value, best.point) in [(expected[n], sheet.design.point(n)) for n in range(count)]


def test_a_search_that_was_interrupted_goes_on_and_stands_in_its_map(monkeypatch, tmp_path):
    asked = pretend(monkeypatch, bowl)
    options = {"minimise": "power_mean", "population": 8, "generations": 6, "seed": 3}
    whole = optimise(hawkmoth(*SHORT), RANGES, **options)
    every = len(asked)

    def stop(generation, _best):
        if generation == 3:
            raise KeyboardInterrupt

    asked.clear()
    with pytest.raises(KeyboardInterrupt):
        optimise(hawkmoth(*SHORT), RANGES, output=tmp_path / "optimum.h5", told=stop, **options)
    assert 0 < len(asked) < every
    assert optimise(hawkmoth(*SHORT), RANGES, output=tmp_path / "optimum.h5", **options) == whole
    assert len(asked) == every
    with maps.open_map(tmp_path / "optimum.h5") as sheet:
        assert sheet.design.size == every
        assert sheet.file.attrs["objective"] == b"power_mean"
        assert sheet.values("power_mean").min() == whole.value
    with pytest.raises(MapError, match="another case, --set or keys"):
        optimise(hawkmoth(*SHORT, "wing.modes=0"), RANGES, output=tmp_path / "optimum.h5", **options)


def test_an_optimum_of_real_cases_beats_a_grid():
    case = hawkmoth(*SHORT)
    best = optimise(
        case, RANGES, "lift_per_power", subject_to=["tip_peak_mean <= 0.008"], population=12, generations=15
    )
    grid = taichiflap.sweep(case, {"wing.youngs_modulus": "5e9:60e9:5:log", "motion.pitch.amplitude_deg": "5:45:5"})
    allowed = grid.lift_per_power.where(grid.tip_peak_mean <= 0.008)
    assert best.holds
    assert best.value >= 0.99 * float(allowed.max())
    assert best.value == best.metrics["lift_per_power"]


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({}, "no objective; give"),
        ({"minimise": "power_mean", "maximise": "power_mean"}, "two objectives; give either"),
        ({"minimise": "pwer_mean"}, "did you mean power_mean?"),
        ({"minimise": "power_mean", "vary": {}}, "no key varies"),
        ({"minimise": "power_mean", "vary": {"wing.chrod": "1:2"}}, "did you mean wing.chord?"),
        ({"minimise": "power_mean", "vary": {"wing.chord": "1:2:3"}}, "give only the range"),
        ({"minimise": "power_mean", "population": 3}, "at least 5"),
    ],
)
def test_a_search_that_cannot_be_is_refused(more, sentence):
    with pytest.raises(UserError) as refused:
        optimise(hawkmoth(*SHORT), **{"vary": RANGES, **more})
    assert sentence in str(refused.value)


def second_order(case):
    """Errors of second order in the elements and in the step, and independent of the modes."""
    error = (8 / case.dbet.elements) ** 2 + 0.5 * (40 / case.time.steps_per_period) ** 2
    return {"force_vertical_mean": 1.0 + 0.04 * error, "power_mean": 2.0, "tip_peak_mean": 0.0}


@pytest.mark.parametrize(
    ("objective", "sentence"),
    [
        ("thrust_mean / power_mean", "metric thrust_mean: not defined in hover"),
        ("vertical_force_mean / tip_peak_mean", "no finite value in the first 5 cases: tip_peak_mean is 0$"),
        ("power_mean - tip_peak_after_reversal", "tip_peak_after_reversal has no value$"),
        ("sqrt(-power_mean)", "or takes the root of a negative number"),
    ],
)
def test_an_objective_that_is_defined_nowhere_ends_the_search_at_its_first_generation(objective, sentence, monkeypatch):
    nothing = {"tip_peak_mean": 0.0, "tip_peak_after_reversal": np.nan, "power_mean": 2.0, "force_vertical_mean": 1.0}
    asked = pretend(monkeypatch, lambda _: nothing)
    with pytest.raises(UserError, match=sentence):
        optimise(hawkmoth(*SHORT), RANGES, maximise=objective, population=5)
    assert len(asked) <= 6


def test_a_condition_that_is_defined_nowhere_is_refused_before_any_case(monkeypatch):
    asked = pretend(monkeypatch, lambda _: {"power_mean": 1.0})
    with pytest.raises(MetricError, match="metric lift_mean: not defined in hover"):
        optimise(hawkmoth(*SHORT), RANGES, minimise="power_mean", subject_to=["lift_mean >= 1"], population=5)
    assert not asked


def test_a_case_without_the_objective_is_never_the_best(monkeypatch):
    def metrics(case):
        good = case.motion.pitch.amplitude_deg > 25.0
        return {"power_mean": 1.0, "lift_per_power": case.motion.pitch.amplitude_deg if good else np.nan}

    pretend(monkeypatch, metrics)
    best = optimise(hawkmoth(*SHORT), RANGES, minimise="lift_per_power", population=8, generations=3)
    assert np.isfinite(best.value)


def test_convergence_of_what_is_not_defined_is_refused(monkeypatch):
    asked = pretend(monkeypatch, lambda _: {"force_normal_phase": np.nan, "force_normal_peak_mean": 1.0})
    with pytest.raises(MetricError, match="metric thrust_mean: not defined in hover"):
        converge(hawkmoth(*SHORT), metrics=["thrust_mean"])
    assert not asked
    with pytest.raises(UserError, match="metric force_normal_phase: undefined in this case"):
        converge(hawkmoth(*SHORT), metrics=["force_normal_phase"])


def test_a_mean_force_that_cancels_out_is_no_scale_for_its_own_changes(monkeypatch):
    """The mean lift of a symmetrical stroke is round-off; the scale of its changes is the peak force."""
    noise = np.random.default_rng(5)
    steady = {"power_mean": 2.0, "tip_peak_mean": 0.0, "force_normal_peak_mean": 1.0, "thrust_mean": 0.1}
    pretend(monkeypatch, lambda _: steady | {"lift_mean": 1e-6 * noise.standard_normal()})
    stream = hawkmoth(*SHORT, "fluid.velocity=[1.0, 0.0]")
    assert not converge(stream).open


def test_convergence_follows_its_rule(monkeypatch, tmp_path):
    asked = pretend(monkeypatch, second_order)
    found = converge(hawkmoth(*SHORT), 0.01, tmp_path / "c.h5")
    # With 8 elements the next two values differ by 4 % * (1 - 1/4) and (1 - 1/16), with 16 by a quarter of that.
    assert found.accepted == {
        "dbet.elements": 16, "time.steps_per_period": 80, "time.periods": 2, "wing.modes": 1,
    }  # fmt: skip
    assert (found.open, len(asked), len(set(map(repr, asked)))) == ([], 12, 12)
    assert found.together == pytest.approx(0.04 * (0.25 + 0.125) * 0.75, rel=0.05)
    assert found.settings[0] == "dbet.elements=16"
    again = converge(hawkmoth(*SHORT), 0.01, tmp_path / "c.h5")
    assert (len(asked), again.trials[1:4]) == (12, found.trials[1:4])
    for path in map_plots.convergence(found, tmp_path / "c"):
        assert path.stat().st_size > 5000
    assert any("together" in line for line in convergence.verdict(found))


def test_the_figure_of_a_study_shows_what_its_rule_compares(monkeypatch, tmp_path):
    """Also for a mean that nearly cancels, and a deflection that is zero everywhere."""
    lift = {8: 1e-5, 16: -1e-5}  # N, at a peak force of 1 N
    pretend(
        monkeypatch,
        lambda case: {
            "force_normal_peak_mean": 1.0, "tip_peak_mean": 0.0, "power_mean": 1.0 + 0.5 * (case.dbet.elements == 8),
            "force_vertical_mean": lift.get(case.dbet.elements, 0.0),
        },
    )  # fmt: skip
    found = converge(hawkmoth(*SHORT), 0.01)
    drawn = []
    monkeypatch.setattr(map_plots.formats, "write", lambda figures, *_, **__: drawn.extend(figures.values()))
    map_plots.convergence(found, tmp_path / "c")
    curves = {line.get_label(): line.get_ydata() for line in drawn[0].axes[0].lines}
    np.testing.assert_allclose(curves["Mean vertical force"][:3], [0.1, -0.1, 0.0], atol=1e-12)
    np.testing.assert_allclose(curves["Mean power"][:3], [50.0, 0.0, 0.0], atol=1e-12)
    assert not curves["Peak tip deflection"].any()


def test_what_never_converges_is_said(monkeypatch):
    pretend(monkeypatch, lambda case: {"force_vertical_mean": np.log(case.dbet.elements)})
    found = converge(hawkmoth(*SHORT), 0.01)
    assert found.open == ["dbet.elements"]
    assert found.accepted["dbet.elements"] == 8 * 2**5
    assert "NOT converged to 1 %" in convergence.verdict(found)[0]


def test_a_wake_stays_as_long_when_steps_are_refined_and_is_at_most_whole(monkeypatch):
    case = hawkmoth("time.periods=2", "time.steps_per_period=50", "uvlm.panels=8", "uvlm.wake=30")
    asked = pretend(monkeypatch, lambda one: {"force_vertical_mean": 1.0 + 0.1 * (one.uvlm.wake < 60)})
    found = converge(case, 0.01)
    refined = [one for one in asked if one.time.steps_per_period == 100]
    assert {one.uvlm.wake for one in refined} >= {60}
    assert all(one.uvlm.wake <= one.steps + 1 for one in asked)
    assert found.accepted["uvlm.wake"] >= 60


def test_convergence_of_a_real_case_holds_against_a_much_finer_one():
    found = converge(hawkmoth(*SHORT), 0.02, metrics=["power_mean"])
    assert found.open == []
    fine = hawkmoth(*SHORT, "dbet.elements=100", "time.steps_per_period=400")
    coarse = hawkmoth(*SHORT).override(*found.settings)
    power = [taichiflap.summarise(taichiflap.simulate(one)).power.mean for one in (coarse, fine)]
    assert power[0] == pytest.approx(power[1], rel=0.02)


def test_steps_in_seconds_cannot_be_refined():
    with pytest.raises(ConvergeError, match="give both as numbers"):
        converge(hawkmoth().override(time={"duration": 0.1, "step": 1e-3}))


def test_convergence_starts_from_an_automatic_step(monkeypatch):
    """As in a viscous flow, and with it the cells around the section."""
    viscous = hawkmoth("solver=navier_stokes", "fluid.viscosity=4e-4", "time.periods=2", "time.steps_per_period=auto")
    asked = pretend(monkeypatch, lambda case: {"force_vertical_mean": 1.0 + (case.navier_stokes.cells < 200)})
    found = converge(viscous, 0.01)
    assert asked[0].time.steps_per_period == viscous.resolved().time.steps_per_period > 400
    assert found.accepted["navier_stokes.cells"] == 256
    assert found.accepted["time.steps_per_period"] == asked[0].time.steps_per_period


@pytest.mark.parametrize("text", ["1", "0", "-1%", "100%", "little"])
def test_a_tolerance_is_a_share(text):
    with pytest.raises(ConvergeError, match="write a share such as 1%"):
        read_tolerance(text)
    assert read_tolerance("1%") == read_tolerance("0.01") == 0.01


def filled(vary, values, sample=None, case=None):
    """A map in memory that holds given values of lift and power."""
    case = case or hawkmoth()
    planned = design(case, vary, sample)
    kept = {name: METRICS[name] for name in choose((), list(planned.examples(case)))}
    sheet = maps.create(None, case, planned, kept)
    others = dict.fromkeys(kept, 1.0) | {"tip_peak_mean": 1e-3, "energy_residual": 0.0}
    sheet.record(range(planned.size), [Outcome(others | values(i)) for i in range(planned.size)])
    return sheet


def test_a_map_in_words_counts_what_is_not_to_be_trusted():
    tips, settled = (0.001, 0.0059, 0.0061, 0.05), (1.0, 1.0, 0.0, np.nan)  # m, of a chord of 0.02
    values = lambda i: {"tip_peak_mean": tips[i], "settled": settled[i]}  # noqa: E731
    lines = list(map_lines(filled({"wing.youngs_modulus": "15e9:60e9:4"}, values)))
    assert "  model                UVLM" in lines
    assert any("15e9 to 60e9 Pa, 4 values" in line for line in lines)
    # The extremes are those of the cases in which the model is valid.
    assert any("max 0.0061 m at wing.youngs_modulus = 45e9" in line for line in lines)
    broken, bent, restless = (line for line in lines if line.startswith("warning: "))
    assert "in 1 of 4 cases the model is invalid" in broken
    assert "in 1 of 4 cases the tip deflection exceeds 0.3 chords" in bent
    assert "in 1 of 4 cases the run is not yet periodic" in restless


def test_no_point_of_a_pareto_front_is_beaten_and_all_others_are(rng):
    cost, gain = rng.normal(size=(2, 200))
    cost[3] = np.nan
    front = pareto_front(cost, gain)
    beaten = [np.any((cost <= cost[i]) & (gain >= gain[i]) & ((cost < cost[i]) | (gain > gain[i]))) for i in range(200)]
    assert set(front) == {i for i in range(200) if not beaten[i]} - {3}
    assert np.all(np.diff(cost[front]) > 0)
    assert not len(pareto_front(np.array([np.nan]), np.array([1.0])))


@pytest.mark.parametrize(
    ("vary", "sample", "names"),
    [
        (
            {"wing.youngs_modulus": "1e9:1e11:5:log", "wing.modes": "1,2,3", "solver": "dbet,uvlm"},
            None,
            ["map", "pareto"],
        ),
        ({"wing.youngs_modulus": "1e9:1e11:5:log", "solver": "dbet,uvlm"}, None, ["lines", "pareto"]),
        ({"wing.youngs_modulus": "1e9:1e11:log", "solver": "dbet,uvlm"}, "lhs:20", ["scatter", "pareto"]),
    ],
)
def test_a_map_is_drawn_in_the_way_that_suits_it(vary, sample, names, tmp_path):
    with filled(vary, lambda i: {"force_vertical_mean": 1e-3 * i, "power_mean": 1e-3 * (i % 7)}, sample) as sheet:
        paths = map_plots.plot(sheet, tmp_path / "fig")
        assert [path.name for path in paths] == [f"fig-{name}.{kind}" for name in names for kind in ("png", "svg")]
        assert "mathdefault" not in paths[1].read_text()
        with pytest.raises(UserError, match="exists already"):
            map_plots.plot(sheet, tmp_path / "fig")


def test_in_a_stream_lift_and_thrust_are_shown_and_weighed():
    stream = hawkmoth("fluid.velocity=[1.0, 0.0]")
    vary = {"wing.youngs_modulus": "1e9:1e11:5:log"}
    with filled(vary, lambda i: {"lift_mean": 1e-3 * i, "thrust_mean": -1e-3 * i}, case=stream) as sheet:
        assert shown(sheet.metrics)[:3] == ["lift_mean", "thrust_mean", "power_mean"]
        assert gains(sheet.metrics) == ["lift_mean", "thrust_mean"]
        lines = "\n".join(map_lines(sheet))
        assert "lift_mean" in lines
        assert "force_vertical_mean" not in lines
        figure = map_plots.pareto(sheet)
        assert [ax.get_ylabel() for ax in figure.axes] == ["Mean lift (mN)", "Mean thrust (mN)"]
        assert "propulsive_efficiency" in lines
    with filled(vary, lambda _: {}) as sheet:
        assert gains(sheet.metrics) == ["force_vertical_mean"]
        assert "lift_mean" not in sheet.metrics


def test_the_heat_map_shows_the_values_of_the_map():
    vary = {"solver": "dbet,uvlm", "wing.modes": "1,2", "motion.frequency": "10:30:3"}
    with filled(vary, lambda i: {"force_vertical_mean": 1e-3 * i}) as sheet:
        figure = map_plots.heat_maps(sheet, ["force_vertical_mean"])
        drawn = [ax.collections[0].get_array().ravel() for ax in figure.axes[:2]]
    np.testing.assert_allclose(np.concatenate(drawn), np.arange(12.0), atol=1e-12)


@pytest.mark.parametrize("frequencies", ["20", "10,20,30,40"])
def test_figures_of_a_map_do_not_depend_on_the_order_of_its_values(frequencies, tmp_path):
    """Heat maps with contours, grey and hatched cells; or lines, over the chord alone."""
    found = []
    backwards = ",".join(frequencies.split(",")[::-1])
    for chords, frequency in (("0.03,0.04,0.05", frequencies), ("0.05,0.03,0.04", backwards)):
        planned = design(hawkmoth(), vary := {"wing.chord": chords, "motion.frequency": frequency})
        points = [planned.point(i) for i in range(planned.size)]
        values = lambda i, points=points: {  # noqa: E731
            "force_vertical_mean": points[i]["wing.chord"] * points[i]["motion.frequency"],
            "force_coefficient_peak": 99.0 if points[i]["wing.chord"] == 0.04 else 1.0,
            "tip_peak_mean": 0.5 * points[i]["wing.chord"] if points[i]["motion.frequency"] == 30.0 else 0.0,
        }
        with filled(vary, values) as sheet:
            figure = map_plots.plot(sheet, tmp_path / "map.svg", overwrite=True)[0]
            found.append((figure.name, figure.read_bytes(), sheet._repr_html_()))
    assert found[0] == found[1]


def test_points_of_a_sample_are_told_apart_by_their_solver():
    vary = {"motion.frequency": "10:30", "solver": "dbet,uvlm"}
    with filled(vary, lambda i: {"force_vertical_mean": 1e-3 * i}, "sobol:8") as sheet:
        ax = map_plots.scatter(sheet, ["force_vertical_mean"]).axes[0]
        names = [text.get_text() for text in ax.get_legend().get_texts()]
        shown_by = {line.get_label(): list(line.get_ydata()) for line in ax.lines if line.get_label() in names}
        solvers = [sheet.design.point(i)["solver"] for i in range(8)]
    expected = {kind: [i for i, solver in enumerate(solvers) if solver == kind] for kind in ("dbet", "uvlm")}
    for kind, numbers in expected.items():
        np.testing.assert_allclose(shown_by[kind], numbers, atol=1e-12)


def test_a_map_without_a_numeric_key_has_no_figure():
    with filled({"solver": "dbet,uvlm"}, lambda _i: {}) as sheet, pytest.raises(MapError, match="nothing to draw"):
        map_plots.plot(sheet)


def test_designs_of_a_search_are_ranges():
    with pytest.raises(DesignError, match="the number of values"):
        design(hawkmoth(), {"wing.chord": "0.01:0.02"})
