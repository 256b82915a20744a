"""Scores: ratings, windows and sentences for known values, and one asserted error per regime."""

import math

import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.commands import score as command
from taichiflap.march.reference import reference
from taichiflap.published.scores import against, comparison, library, report, score, table, tiers, traces, verdict
from taichiflap.published.scores.measures import FAMILIES, QUANTITIES, Trace, measure
from taichiflap.published.scores.score import Outcome, Row
from taichiflap.published.scores.tiers import TIERS, ScoreError
from taichiflap.published.scores.truths import NEAR, OUTSIDE, WITHIN, Truth
from taichiflap.scored import nearest
from taichiflap.scored.ramps import RAMPS
from taichiflap.scored.regime import Regime

DBET = next(tier for tier in TIERS if tier.name == "dbet")
PAPER = next(tier for tier in TIERS if tier.name == "dbet-paper")
TIMES = np.linspace(0.0, 4.0, 801)


def trace(lift=0.0, drag=0.0, power=0.0, plunge=0.0, tip=0.0):
    return Trace(TIMES, *(value + 0.0 * TIMES for value in (lift, drag, power, plunge, tip)))


def test_a_value_is_inside_its_band_near_or_outside():
    truth = Truth("C_L mean", 2.0, 1.9, 2.2, (0.0, 1.0), "")
    assert [truth.word(value) for value in (1.9, 2.2, 2.4, 1.5, 2.6, -2.0)] == [
        WITHIN, WITHIN, NEAR, NEAR, OUTSIDE, OUTSIDE,
    ]  # fmt: skip
    assert truth.error(2.5) == pytest.approx(0.25)


def test_phases_wrap_and_err_as_shares_of_a_right_angle():
    truth = Truth("tip phase", -177.0, -178.0, -176.0, (0.0, 1.0), "")
    assert truth.error(174.0) == pytest.approx(-0.1)
    assert truth.word(182.5) == WITHIN
    assert truth.word(170.0) == NEAR
    assert truth.word(0.0) == OUTSIDE


def test_quantities_of_known_waves():
    angle = 2 * np.pi * TIMES
    known = trace(
        lift=1.0 + 0.5 * np.cos(2 * angle + 0.7), drag=-0.3 + 0.2 * np.cos(2 * angle - 1.0), power=2.0,
        plunge=0.01 * np.cos(angle), tip=0.02 * np.cos(angle - 0.4),
    )  # fmt: skip
    found = {name: measure([known], name, (2.0, 4.0)) for name in QUANTITIES}
    assert found["C_L mean"] == pytest.approx(1.0, abs=1e-6)
    assert found["C_T mean"] == -found["C_D mean"] == pytest.approx(0.3, abs=1e-6)
    assert found["C_P mean"] == pytest.approx(2.0)
    assert found["C_L amplitude"] == pytest.approx(0.0, abs=1e-6)
    assert found["C_L amplitude 2"] == pytest.approx(0.5, rel=1e-3)
    assert found["C_L phase 2"] == pytest.approx(math.degrees(0.7), abs=1e-3)
    assert found["C_D phase 2"] == pytest.approx(-math.degrees(1.0), abs=1e-3)
    assert found["C_L peak"] == pytest.approx(1.5, abs=1e-4)
    assert found["Strouhal number"] == pytest.approx(2.0, rel=1e-4)
    assert found["tip amplitude"] == pytest.approx(2.0, rel=1e-6)
    assert found["tip phase"] == pytest.approx(-math.degrees(0.4), abs=1e-4)
    assert found["pitch amplitude"] == pytest.approx(math.degrees(math.atan(0.02)), rel=1e-3)


def test_coefficients_of_a_plate_in_a_stream():
    """C_L = 2 pi sin(alpha) of a steady plate, for any chord, span and speed."""
    case = parse_case({
        "solver": "uvlm",
        "wing": {"chord": 0.2, "span": 0.3, "modes": 0, "thickness": 1e-3, "density": 1000.0, "youngs_modulus": 1e9},
        "motion": {"pitch": {"mean_deg": -5.0}},
        "fluid": {"density": 2.0, "velocity": [3.0, 0.0]},
        "uvlm": {"panels": 8, "suction": True},
        "time": {"duration": 8.0, "step": 0.02},
    })  # fmt: skip
    with taichiflap.simulate(case) as result:
        found = Trace.of(result, 3.0)
    assert found.lift[-1] == pytest.approx(2 * math.pi * math.sin(math.radians(5.0)), rel=0.01)
    assert abs(found.drag[-1]) < 0.005


def test_every_published_case_is_sound():
    cases = library.published()
    assert len({one.name for one in cases}) == len(cases) > 40
    for one in cases:
        case = one.case()
        assert one.truths, one.name
        assert one.citation
        assert one.about
        for truth in one.truths:
            assert truth.quantity in QUANTITIES or (truth.quantity in FAMILIES and one.family)
            assert truth.low <= truth.value <= truth.high
            end = case.duration / case.beat if case.periodic else case.duration
            assert 0.0 <= truth.window[0] < truth.window[1] <= end * (1 + 1e-9)
        for tier in TIERS:
            if tier.runs(one):
                tier.cases(one)


@pytest.mark.parametrize(
    ("name", "tier", "quantity", "error"),
    [
        ("hover", "dbet-paper", "C_L mean", 0.46),
        ("ramp90", "dbet-paper", "C_D mean", 0.19),
        ("kinsey-dumas", "dbet", "C_L amplitude", 0.17),
        ("anderson-0.3", "dbet", "C_T mean", 0.01),
        ("heathcote-0.85-0.7", "dbet-paper", "pitch amplitude", 0.88),
        ("plate-0.2-2-2", "dbet-paper", "tip amplitude", -0.06),
        pytest.param("flutter-0.2", "dbet", "onset of flutter", -0.006, marks=pytest.mark.slow),
        pytest.param("ramp45", "uvlm", "C_L mean", -0.07, marks=pytest.mark.slow),
    ],
)
def test_a_figure_of_each_regime_errs_as_the_page_says(name, tier, quantity, error):
    rows = score.score(library.chosen([name]), tiers.chosen([tier]))
    (row,) = (row for row in rows if row.truth.quantity == quantity)
    found = row.truth.error(row.value(tier))
    assert found == pytest.approx(error, abs=0.005)
    assert found == pytest.approx(nearest.known()[name]["errors"][tier][quantity], abs=1e-4)


def test_onset_of_flutter_of_oscillations_that_grow_as_told():
    """With a growth rate proportional to the distance from the onset, at 2; far from it there is no onset."""

    def measured(speeds):
        traces = [trace(tip=np.exp(0.1 * (u - 2.0) * TIMES) * np.cos(10 * np.pi * TIMES)) for u in speeds]
        return measure(traces, "onset of flutter", (0.0, 4.0), speeds)

    assert measured((1.9, 1.95, 2.1)) == pytest.approx(2.0, abs=1e-6)
    assert math.isnan(measured((1.0, 1.05, 1.1)))


def test_a_quantity_that_does_not_occur_is_not_a_failure():
    row = rows_of("anderson-0.3", 0.0)[0]
    ran = Row(row.published, row.truth, {"dbet": Outcome("anderson-0.3", "dbet", "", {}, 0.0)})
    broken = Row(row.published, row.truth, {"dbet": Outcome("anderson-0.3", "dbet", "", {}, 0.0, "diverged")})
    assert [table.missing(one, DBET) for one in (ran, broken)] == ["none", "failed"]
    assert table.missing(row, PAPER) == "not run"
    assert math.isnan(verdict.mean_error([ran], "dbet"))
    assert verdict.mean_error([broken], "dbet") == verdict.WORST
    both = [Row(row.published, row.truth, {**row.outcomes, "dbet-paper": ran.outcomes["dbet"]})]
    assert verdict.sentence(both, [DBET, PAPER]).endswith("inside the band. Without a value: DBET, paper.")


def outcome(row, value, tier="dbet"):
    return Outcome(row.published.name, tier, "", {row.truth.quantity: value}, 0.0)


def rows_of(name, share, tier="dbet"):
    """Rows of a case with values that err by a share of the truth."""
    (one,) = library.chosen([name])
    values = {truth.quantity: truth.value * (1.0 + share) for truth in one.truths}
    return [Row(one, truth, {tier: Outcome(name, tier, "", values, 0.0)}) for truth in one.truths]


def test_the_sentence_names_the_best_model_or_none():
    good, bad = rows_of("anderson-0.3", 0.0), rows_of("anderson-0.3", 0.6)
    assert verdict.sentence(good, [DBET]) == "Use DBET: mean error 0 %, 2 of 2 figures inside the band."
    assert verdict.sentence(bad, [DBET]).startswith("No model comes within 25 % on the mean; the nearest is DBET")
    assert verdict.hopeless(bad[0])
    assert not verdict.hopeless(good[0])


def test_rows_that_every_model_misses_stand_first():
    rows = [*rows_of("anderson-0.2", 0.0), *rows_of("anderson-0.4", 0.9)]
    ((_, sorted_rows),) = table.groups(rows)
    assert [row.published.name for row in sorted_rows] == ["anderson-0.4"] * 2 + ["anderson-0.2"] * 2


def test_scores_are_kept_and_not_run_again(tmp_path, monkeypatch):
    path = tmp_path / "scores.json"
    cases = library.chosen(["anderson-0.2"])
    first = score.score(cases, [DBET], score.Store(path))
    monkeypatch.setattr(score, "simulate", lambda *a, **k: pytest.fail("ran again"))
    again = score.score(cases, [DBET], score.Store(path))
    assert [row.value("dbet") for row in again] == [row.value("dbet") for row in first]
    monkeypatch.setattr(score, "__version__", "9.9")
    with pytest.raises(pytest.fail.Exception):
        score.score(cases, [DBET], score.Store(path))
    path.write_text("[]")
    with pytest.raises(ScoreError, match="not a file of scores"):
        score.Store(path)


def test_names_that_are_none():
    with pytest.raises(ScoreError, match="did you mean hover"):
        library.chosen(["hoover"])
    with pytest.raises(ScoreError, match="no such model"):
        tiers.chosen(["dbett"])


def test_the_page_holds_rows_figures_and_what_is_left_out(tmp_path):
    cases = library.chosen(["hover", "anderson-0.2"])
    rows = score.score(cases, [DBET])
    pages = report.write(rows, [DBET], tmp_path)
    text = pages[0].read_text("utf-8")
    for row in rows:
        assert f"{row.truth.value:.4g}" in text
    assert "Not scored" in text
    for name in ("scores-1.png", "scores-2.svg", "scores-histories.png"):
        assert (tmp_path / name).stat().st_size > 5000


def test_a_regime_is_near_itself_and_far_from_others():
    hover, ramp = (Regime.of(one.case()) for one in library.chosen(["hover", "ramp45"]))
    assert hover.distance(hover) == 0.0
    assert math.isinf(hover.distance(ramp))
    moth = Regime.of(hawkmoth("wing.modes=0"))
    assert moth.distance(hover) == pytest.approx(hover.distance(moth), rel=1e-12)
    assert moth.distance(hover) > 0.0
    assert moth.stroke == pytest.approx(2.0, rel=1e-4)


def test_a_case_finds_itself_among_the_scored():
    (one,) = library.chosen(["anderson-0.3"])
    found = nearest.nearest(DBET.cases(one)[0])
    assert found[0].name == "anderson-0.3"
    assert found[0].distance == 0.0
    assert "anderson-0.3: C_T mean" in nearest.sentence(DBET.cases(one)[0])


def test_a_case_unlike_any_says_so():
    strange = parse_case(library.chosen(["hover"])[0].document).override("motion.plunge.amplitude=0.05", "solver=dbet")
    assert nearest.nearest(strange) == []
    assert nearest.sentence(strange).startswith("none is near; the least far is hover (rigid): C_L mean ")


def test_a_flexible_wing_in_hover_is_told_of_the_rigid_one():
    assert nearest.nearest(hawkmoth("wing.modes=1")) == []
    assert "hover (rigid)" in nearest.sentence(hawkmoth("wing.modes=1"))


def test_what_is_known_covers_the_fast_tiers():
    known = nearest.known()
    for one in library.published():
        assert {tier.name for tier in TIERS if tier.runs(one)} == known[one.name]["errors"].keys(), one.name
        assert Regime(**known[one.name]["regime"]).distance(Regime.of(one.case())) < 1e-9


def written(path, names, *columns):
    rows = "".join(",".join(map(str, row)) + "\n" for row in zip(*columns, strict=True))
    path.write_text(f"# measured by nobody\n{names}\n{rows}")
    return traces.read_trace(path)


def test_a_models_own_trace_compares_without_a_difference_whatever_its_units_and_shift(tmp_path):
    case = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=4")
    with taichiflap.simulate(case) as result:
        beat = slice(600, 801)
        time, force, moment = result.time[beat], result.force_vertical[beat], result.moment[beat]
    names = "time [ms],force_vertical [mN],moment [uN m]"
    mine = written(tmp_path / "mine.csv", names, 1e3 * time, 1e3 * force, 1e6 * moment)
    late = written(tmp_path / "late.csv", names, 1e3 * (time + 0.2 * case.beat), 1e3 * force, 1e6 * moment)
    for trace, shift, told in ((mine, 0.0, 0.0), (late, 0.2, 0.2), (late, None, 0.2)):
        (found,) = against.compare(case, [trace], [DBET], shift=shift)
        assert found.shift == pytest.approx(told, abs=0.003)
        for quantity in trace.values:
            measured, model = found.measured[quantity], found.modelled[quantity]["dbet"]
            assert found.rms(quantity, "dbet") < 0.02
            assert measured.mean == pytest.approx(model.mean, abs=0.01 * abs(model.peak))
            assert measured.harmonics == pytest.approx(model.harmonics, abs=0.01 * abs(model.peak))
            assert measured.peak_time % 0.5 == pytest.approx(model.peak_time % 0.5, abs=0.01)  # two like peaks a beat


def test_a_trace_has_one_shift_for_all_quantities_and_models(tmp_path):
    """The shift minimises the sum of squares over all; a force with two periods per beat gets the smaller shift."""
    case = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=4")
    at = np.arange(80) / 80
    waves = 2e-3 * (1.0 + np.cos(4 * np.pi * (at - 0.1))), 1e-6 * np.cos(2 * np.pi * at)
    trace = written(tmp_path / "a.csv", "t/T,force_vertical [N],moment [N m]", at, *waves)
    (found,) = against.compare(case, [trace], [DBET, PAPER], shift=None)
    shifts = at - 0.5

    def apart(late):
        (one,) = against.compare(case, [trace], [DBET, PAPER], shift=late)
        return sum(one.rms(name, tier.name) ** 2 for name in trace.values for tier in (DBET, PAPER))

    assert apart(found.shift) <= min(map(apart, shifts[::16])) + 1e-3
    assert found.alone.keys() == {"dbet", "dbet-paper"}
    assert min(found.alone.values()) - 0.01 < found.shift < max(found.alone.values()) + 0.01
    force = written(tmp_path / "b.csv", "t/T,force_vertical", at, waves[0])
    (twice,) = against.compare(case, [force], [DBET], shift=None)
    assert abs(twice.shift) < 0.26


def test_files_of_a_comparison_on_one_page(tmp_path):
    case = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=4")
    at = np.arange(20) / 20
    traced = [written(tmp_path / f"{name}.csv", f"t/T,{name}", at, 1.0 + at) for name in ("C_V", "power")]
    found = against.compare(case, traced, [DBET, PAPER], speed=2.0, area=1e-3)
    markdown, page = report.write_comparison(found, [DBET, PAPER], tmp_path)
    text = markdown.read_text("utf-8")
    for part in (
        "## C_V.csv",
        "## power.csv",
        "power [W]",
        "2 m/s (as stated), 0.001 m2 (as stated)",
        "beats, as stated",
    ):
        assert part in text
    assert page.read_text("utf-8").count("data:image/svg") == text.count("![") == 2
    printed = "\n".join(comparison.lines(found[0], [DBET, PAPER]))
    assert "rms diff." in printed
    assert "DBET, paper" in printed


def test_the_command_compares_files_and_names_the_page(tmp_path, capsys):
    case = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=4")
    file = tmp_path / "wing.toml"
    file.write_text(case.to_toml())
    at = np.arange(20) / 20
    traced = [written(tmp_path / f"{name}.csv", f"t/T,{name}", at, at).path for name in ("C_V", "power")]
    given = {"models": "dbet", "cases": "", "speed": None, "area": None, "shift": "best", "output": tmp_path}
    command.score(file, traced, **given)
    printed = capsys.readouterr().out
    assert printed.count("one shift for all its quantities and models") == 2
    assert "rms of the middle of the chord over a beat" in printed
    assert f"{tmp_path / 'comparison.html'} written" in printed
    with pytest.raises(ScoreError, match="go together"):
        command.score(None, traced, **given)


def test_a_mean_has_its_standard_error_of_ten_beats_and_more(tmp_path):
    at = np.arange(20) / 20
    trace = written(tmp_path / "a.csv", "t/T,power", at, at)
    for beats, known in ((8, False), (24, True)):
        case = hawkmoth("solver=dbet", "wing.modes=0", f"time.periods={beats}")
        (found,) = against.compare(case, [trace], [DBET])
        assert math.isfinite(found.modelled["power"]["dbet"].error) == known
    wave = against.Figures(found.phases, 2.0, 3.0, 0.5, (0.0, 0.0, 0.0), 0.05)
    found.modelled["power"]["dbet"] = wave
    assert "2 ± 0.05" in "\n".join(comparison.lines(found, [DBET]))


def test_coefficients_have_the_stated_reference_or_that_of_the_case(tmp_path):
    case = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=4")
    at = np.arange(20) / 20
    trace = written(tmp_path / "a.csv", "t/T,C_V", at, 1.0 + at)
    own, stated = (against.compare(case, [trace], [DBET], **given)[0] for given in ({}, {"speed": 3.0, "area": 2e-3}))
    scale = reference(case)
    ratio = 3.0**2 * 2e-3 / (scale.speed**2 * scale.area)
    assert own.modelled["C_V"]["dbet"].mean == pytest.approx(ratio * stated.modelled["C_V"]["dbet"].mean)


def test_a_ramp_compares_at_the_times_that_were_measured(tmp_path):
    (one,) = library.chosen(["ramp45"])
    case = one.case()
    time = np.linspace(0.5, 3.0, 30)
    (found,) = against.compare(case, [written(tmp_path / "a.csv", "time [s],C_L", time, time)], [DBET], shift=0.5)
    assert found.phases[[0, -1]] == pytest.approx([0.0, 2.5])
    assert found.measured["C_L"].values == pytest.approx(found.phases + 0.5)
    assert found.measured["C_L"].harmonics == ()
    with pytest.raises(ScoreError, match="does not repeat; state the shift"):
        against.compare(case, [], [DBET], shift=None)
    with pytest.raises(ScoreError, match="has no beat"):
        against.compare(case, [written(tmp_path / "b.csv", "t/T,C_L", time, time)], [DBET])


def test_lift_needs_a_stream(tmp_path):
    case = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=4")
    at = np.arange(20) / 20
    with pytest.raises(ScoreError, match="lift needs a stream"):
        against.compare(case, [written(tmp_path / "a.csv", "t/T,lift", at, at)], [DBET])


def test_a_shift_is_a_number_or_best():
    assert against.read_shift("best") is None
    assert against.read_shift("-0.25") == -0.25
    for text in ("later", "nan", "inf"):
        with pytest.raises(ScoreError, match="give a number of beats, or best"):
            against.read_shift(text)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("t/T,C_V\n0,1\n", "give a line of names and at least 4 rows"),
        ("C_V,power [mW]\n" + "1,2\n" * 5, "needs one column of time"),
        ("t/T,force\n" + "1,2\n" * 5, 'column "force" is not known'),
        ("t/T,power [hp]\n" + "1,2\n" * 5, "unit hp is not one of power"),
        ("t/T,C_V\n0,1\n0.1,a\n0.2,1\n0.3,1\n0.4,1\n", "give numbers"),
        ("t/T,C_V\n0,1\n0.1,1\n0.1,1\n0.3,1\n0.4,1\n", "times must rise"),
        ("t/T,power [mN]\n" + "1,2\n" * 5, "unit mN is not one of power"),
        ("t/T,power [mW],power [W]\n0,1,1\n1,1,1\n2,1,1\n3,1,1\n", "a quantity has two columns"),
        ("t/T\n0\n1\n2\n3\n4\n", "no quantity beside the time"),
    ],
)
def test_traces_that_cannot_be_read(tmp_path, text, problem):
    file = tmp_path / "trace.csv"
    file.write_text(text)
    with pytest.raises(ScoreError, match=problem):
        traces.read_trace(file)


def test_a_model_that_the_case_cannot_have_is_named_and_the_others_are_compared(tmp_path):
    at = np.arange(20) / 20
    trace = written(tmp_path / "a.csv", "t/T,power", at, 1.0 + at)
    sheds = next(tier for tier in TIERS if tier.name == "uvlm-sheds")
    (found,) = against.compare(hawkmoth("time.periods=4"), [trace], [sheds, DBET])  # the paper's uniform panels
    assert "spacing" in found.failed["uvlm-sheds"]
    assert any(f"{sheds.label} failed" in line for line in comparison.lines(found, [sheds, DBET]))
    assert found.rms("power", "dbet") > 0.0


def test_a_comparison_warns_of_a_mean_of_too_few_beats(tmp_path):
    at = np.arange(20) / 20
    trace = written(tmp_path / "a.csv", "t/T,power", at, 1.0 + at)
    few, enough = (against.compare(hawkmoth(f"time.periods={n}"), [trace], [DBET])[0] for n in (2, 15))
    assert f"  warning: {DBET.label}: {few.doubts['dbet']}" in comparison.lines(few, [DBET])
    assert "too few beats" in few.doubts["dbet"]
    assert not enough.doubts


def test_a_comparison_names_the_settings_that_are_the_cases_own(tmp_path):
    """The blades of the paper's case are the paper's in both columns, which the numbers alone do not tell."""
    at = np.arange(20) / 20
    trace = written(tmp_path / "a.csv", "t/T,power", at, 1.0 + at)
    case = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", ["time.periods=4"])
    (found,) = against.compare(case, [trace], [DBET, PAPER])
    assert "dbet.coefficients" in found.own["dbet"]
    assert "dbet.coefficients" not in found.own.get("dbet-paper", ())
    assert any(
        line.startswith(f"  {DBET.label} has the case's own dbet.added_mass")
        for line in comparison.lines(found, [DBET, PAPER])
    )
    (plain,) = against.compare(hawkmoth("time.periods=4", "solver=dbet"), [trace], [DBET])
    assert not plain.own


@pytest.mark.parametrize("angle", RAMPS)
def test_a_published_ramp_keeps_what_its_series_resolves(angle):
    """Components of the series are kept, faster ones are not."""
    ramp = RAMPS[angle]
    for name in ("C_L", "C_D"):
        exact = ramp.published(name, ramp.times)
        np.testing.assert_allclose(ramp.filtered(name, ramp.times, exact), exact, atol=1e-12)
        assert exact.mean() == pytest.approx(ramp.cosines[name][0], abs=0.06)
        share = (ramp.times - ramp.first) / (ramp.last - ramp.first)
        fast = ramp.filtered(name, ramp.times, exact + np.cos(np.pi * 15 * share))
        assert np.sqrt(np.mean((fast - exact) ** 2)) < 0.2
