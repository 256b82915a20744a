"""Figures show the file's numbers, with labels and units, and their colours are distinguishable."""

import dataclasses
import re
import subprocess
import sys

import matplotlib.collections
import numpy as np
import pytest
from conftest import CASES, hawkmoth
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.quiver import QuiverKey
from matplotlib.text import Text
from PIL import Image

import taichiflap
from taichiflap import cli
from taichiflap.drawing import palette, scene
from taichiflap.errors import UserError
from taichiflap.metrics import summary as metrics
from taichiflap.metrics import waves
from taichiflap.metrics.beats import Beats
from taichiflap.plots import formats, style
from taichiflap.plots import result as plots

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def lattice(tmp_path_factory):
    """A result of UVLM with a beat of wake, in a file."""
    path = tmp_path_factory.mktemp("plots") / "lattice.h5"
    return taichiflap.simulate(hawkmoth("time.periods=2", "time.steps_per_period=80", "uvlm.panels=20"), path)


@pytest.fixture(scope="module")
def blades(tmp_path_factory):
    """A DBET result in a file, with a title that matplotlib could read as mathematics."""
    case = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", ("time.periods=2", 'title="a $x$ wing"'))
    return taichiflap.simulate(case, tmp_path_factory.mktemp("plots") / "blades.h5")


def texts(figure):
    """All visible text of a drawn figure, without ticks beyond the ends of an axis."""
    FigureCanvasAgg(figure).draw()
    beyond = [
        tick.label1
        for ax in figure.axes
        for axis in (ax.xaxis, ax.yaxis)
        for tick in axis.get_major_ticks()
        if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
    ]
    keys = [key.text for key in figure.findobj(QuiverKey)]
    return [
        text for text in (*figure.findobj(Text), *keys) if text.get_text() and text.get_visible() and text not in beyond
    ]


def test_three_results_have_three_colours_and_a_width_of_ones_own(lattice, blades, tmp_path):
    rigid = taichiflap.simulate(hawkmoth("solver=dbet", "wing.modes=0", "time.periods=2", "title=rigid"))
    results = [lattice, blades, rigid]
    figure = plots.summary(results, width=5.0)
    assert figure.get_figwidth() == 5.0
    lines = [line for line in figure.axes[1].lines if len(line.get_xdata()) > 10]
    assert len({line.get_color() for line in lines}) == 3
    for line, result in zip(lines, results, strict=True):
        np.testing.assert_allclose(line.get_ydata(), 1e3 * result.force_normal[scene.last_steps(result)])
    (legend,) = figure.legends
    assert len(legend.get_texts()) == 3
    assert all(one.name.endswith(".pdf") for one in plots.plot(results, tmp_path / "three.pdf", width=5.0))


@pytest.mark.parametrize("width", [60.0, 85.0, 180.0])
def test_every_text_lies_within_the_figure(lattice, blades, width):
    """In one column of a journal, too: panels stand one above the other, and long names take several lines."""
    inches = width / 25.4
    wings = [plots.wing(one, width=inches) for one in (lattice, blades)]
    for figure in (plots.summary([lattice, blades], width=inches), *wings):
        figure.draw_without_rendering()
        page = figure.bbox.padded(1.0)
        # Ticks beyond an axis have labels that are not drawn.
        ticks = {label for ax in figure.axes for label in (*ax.get_xticklabels(), *ax.get_yticklabels())}
        texts = [one for one in figure.findobj(Text) if one.get_text() and one not in ticks]
        assert len(texts) > 10
        for text in texts:
            box = text.get_window_extent()
            assert page.x0 <= box.x0 <= box.x1 <= page.x1, text.get_text()
            assert page.y0 <= box.y0 <= box.y1 <= page.y1, text.get_text()


def test_the_summary_holds_the_last_beat_of_both_results(lattice, blades):
    figure = plots.summary([lattice, blades])
    for ax, (label, unit, series) in zip(figure.axes, plots.panels([lattice, blades]), strict=True):
        assert ax.get_ylabel() == f"{label} (m{unit})"
        drawn = [line.get_ydata() for line in ax.lines if len(line.get_ydata()) > 2]
        expected = [
            1e3 * getattr(result, name)[scene.last_beats(result)] for result in (lattice, blades) for name in series
        ]
        assert len(drawn) == len(expected)
        for ours, theirs in zip(drawn, expected, strict=True):
            np.testing.assert_array_equal(ours, theirs)
        assert ax.get_xlim() == (0.0, 1.0)
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert ["UVLM" in name for name in names] == [True, False]
    assert "a $x$ wing" in names[1]
    mean = metrics.summarise(lattice).force_vertical.mean
    assert f"mean vertical force {1e3 * mean:.2f}\N{NO-BREAK SPACE}mN" in names[0]


def test_results_of_one_title_are_told_apart_by_their_files(lattice, tmp_path):
    other = taichiflap.simulate(lattice.case, tmp_path / "again.h5")
    names = [text.get_text() for text in plots.summary([lattice, other]).legends[0].get_texts()]
    assert ("lattice" in names[0], "again" in names[1]) == (True, True)


def test_chosen_series_over_some_beats_in_another_style(lattice, blades, tmp_path):
    names = ["lift_coefficient", "angle_of_attack", "power"]
    (tmp_path / "journal.mplstyle").write_text("axes.labelsize: 11\nlines.linestyle: --\n")
    with style.using(str(tmp_path / "journal.mplstyle")):
        figure = plots.summary([lattice, blades], metrics=names, beats=9)
    assert [ax.get_ylabel() for ax in figure.axes] == [
        "Lift coefficient",
        "Angle of attack (deg)",
        "Power (mW)",
    ]
    assert figure.axes[0].yaxis.label.get_size() == 11
    assert figure.axes[-1].get_xlim() == (0.0, 2.0)  # of nine beats there are two
    assert figure.axes[-1].get_xlabel() == "Time in the last 2 beats, t/T"
    for ax, name, factor in zip(figure.axes, names, (1.0, 180.0 / np.pi, 1e3), strict=True):
        first, second = (line.get_ydata() for line in ax.lines if len(line.get_ydata()) > 2)
        np.testing.assert_allclose(first, factor * getattr(lattice, name))
        np.testing.assert_allclose(second, factor * getattr(blades, name))
    assert plots.summary([lattice]).axes[0].yaxis.label.get_size() == 8  # the style is taken off again
    for words, said in (
        (["--metric", "lift_coeficient"], "not a series of .*; did you mean lift_coefficient?"),
        (["--style", "ggplt"], "--style ggplt: no such style; did you mean ggplot?"),
        (["--style", "absent.mplstyle"], "no such style; give a .mplstyle file"),
    ):
        with pytest.raises(UserError, match=said):
            cli.app(["plot", str(lattice.path), *words, "-o", str(tmp_path / "bad")], standalone_mode=False)
    assert not list(tmp_path.glob("bad*"))


def test_a_longer_run_is_drawn_over_the_time_of_a_shorter_one(blades):
    ramp = CASES / "pitch_ramp.toml"
    short, long = (
        taichiflap.simulate(taichiflap.load_case(ramp, ("solver=dbet", "time.step=0.05", f"time.duration={seconds}")))
        for seconds in (2.0, 4.0)
    )
    for results in ([short, long], [long, short]):
        ax = plots.summary(results).axes[0]
        assert ax.get_xlim() == pytest.approx((0.0, 4.0))  # chords, at 0.1 m/s
        first, second = (line.get_xydata() for line in ax.lines if len(line.get_xydata()) > 2)
        many = min(len(first), len(second))
        assert many == 41
        np.testing.assert_allclose(first[:many], second[:many], atol=1e-12)
    with pytest.raises(scene.SceneError, match=re.escape("'Time in the last beat, t/T'; plot each on its own")):
        plots.summary([blades, short])


def test_half_strokes_are_shaded_where_the_first_result_is_drawn(blades):
    one = taichiflap.simulate(hawkmoth("solver=dbet", "time.periods=1"))
    shaded = [
        sorted(patch.get_x() for patch in plots.summary(results, beats=2).axes[0].patches)
        for results in ([blades, one], [one, blades])
    ]
    np.testing.assert_allclose(shaded[0], [0.5, 1.5], atol=1e-9)
    np.testing.assert_allclose(shaded[1], [1.5], atol=1e-9)


def test_the_wing_figure_holds_the_wake_at_its_instants(lattice):
    figure = plots.wing(lattice)
    axes = [ax for ax in figure.axes if ax.get_title()]
    assert [ax.get_title() for ax in axes] == [f"t/T = {k / 8:.3f}" for k in range(8)]
    for k, ax in enumerate(axes):
        index = 80 + 10 * k
        (dots,) = [c for c in ax.collections if isinstance(c, matplotlib.collections.PathCollection)]
        wake = lattice.wake(index)
        assert len(wake["y"]) == index + 1
        order = np.argsort(np.abs(wake["circulation"]))
        np.testing.assert_allclose(dots.get_offsets(), 1e3 * np.stack((wake["z"], -wake["y"]), 1)[order], rtol=1e-6)
        np.testing.assert_array_equal(dots.get_array(), wake["circulation"][order])
        assert dots.norm.vmin == -dots.norm.vmax
        nodes = lattice.frame("node_position", index)
        np.testing.assert_allclose(ax.lines[0].get_xydata(), 1e3 * np.stack((nodes[:, 1], -nodes[:, 0]), 1))
    words = " ".join(text.get_text() for text in texts(figure))
    for phrase in ("m² s⁻¹", "Z (mm)", "−Y (mm)", "mN, force of the fluid", "counter-clockwise", "beat 2"):
        assert phrase in words


def test_blades_show_the_load_along_the_chord(blades):
    figure = plots.wing(blades)
    words = " ".join(text.get_text() for text in texts(figure))
    assert ("Pa, force of the fluid per area" in words, "Circulation" in words) == (True, False)
    index = scene.last_beats(blades)[25]
    frame = scene.frame(blades, int(index))
    total = (frame.traction * (blades.case.wing.chord / 50) * blades.case.wing.span).sum(axis=0)
    np.testing.assert_allclose(total, frame.force, rtol=1e-5)


def test_no_text_leaves_the_page_or_meets_another(lattice, blades):
    for figure in (plots.summary([lattice, blades]), plots.wing(lattice), plots.wing(blades)):
        found = texts(figure)
        boxes = [text.get_window_extent() for text in found]
        page = figure.bbox
        for text, box in zip(found, boxes, strict=True):
            inside = page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1
            assert inside or not text.get_in_layout(), text
        for a in range(len(boxes)):
            for b in range(a):
                assert not boxes[a].shrunk(0.98, 0.9).overlaps(boxes[b].shrunk(0.98, 0.9)), (found[a], found[b])


def test_a_rigid_wing_that_only_pitches_is_drawn(tmp_path):
    case = hawkmoth("wing.modes=0", "motion.plunge.amplitude=0.0", "time.periods=1", "time.steps_per_period=50")
    result = taichiflap.simulate(case)
    figure = plots.summary([result])
    assert not [t for t in texts(figure) if "stroke to" in t.get_text()]
    # It does not bend: in the place of its deflection stands what moves.
    assert figure.axes[0].get_ylabel() == "Pitch (deg)"
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), np.degrees(result.pitch))
    assert len(plots.plot([result], tmp_path / "rigid")) == 4


def test_in_a_stream_lift_and_thrust_are_drawn_and_a_beat_of_them_is_the_summarys():
    case = hawkmoth("fluid.velocity=[1.2, 0.5]", "fluid.density=1e-3", "wing.modes=0", "time.periods=2")
    result = taichiflap.simulate(case)
    _, lift, thrust, _ = plots.summary([result]).axes
    assert (lift.get_ylabel(), thrust.get_ylabel()) == ("Lift across the stream (µN)", "Thrust against the stream (µN)")
    last = metrics.summarise(result, Beats(scene.last_beats(result)[[0, -1]]))
    for ax, force in ((lift, last.lift), (thrust, last.thrust)):
        assert ax.lines[0].get_ydata()[:-1].mean() == pytest.approx(1e6 * force.mean)


def test_the_page_ends_near_the_wing_and_its_colours_are_of_what_it_shows(lattice):
    frames = [scene.frame(lattice, int(index)) for index in scene.last_beats(lattice)]
    near = scene.bounds(frames, lattice.case)
    first = frames[0]
    away = np.vstack([first.wing.mean(axis=0) - np.array([0.0, 1.0]), first.wake])  # fifty chords below, and old
    strong = np.insert(first.circulation, 0, 1e3 * np.abs(first.circulation).max())
    edge, age = np.insert(first.edge, 0, first.edge[0]), np.insert(first.age, 0, first.age[0])
    far = [dataclasses.replace(first, wake=away, circulation=strong, edge=edge, age=age), *frames[1:]]
    assert scene.bounds(far, lattice.case) == near


def test_reversals_are_where_the_plunge_turns(lattice):
    turns = waves.reversals(lattice.case, 0.0, 1.0)
    np.testing.assert_allclose(turns, [0.0, 0.5, 1.0], atol=1e-12)
    for turn in turns:
        assert waves.after_reversal(lattice.case, turn) == pytest.approx(0.0, abs=1e-9)


def test_plot_writes_figures_that_name_no_machine(lattice, blades, tmp_path, capsys):
    cli.app(["plot", str(lattice.path), str(blades.path), "-o", str(tmp_path)], standalone_mode=False)
    names = {f"lattice-{name}.{kind}" for name in ("summary", "wing", "wing-2") for kind in ("png", "svg")}
    assert {file.name for file in tmp_path.iterdir()} == names
    assert len(capsys.readouterr().out.splitlines()) == 6
    for file in tmp_path.iterdir():
        content = file.read_bytes()
        assert str(tmp_path.parent).encode() not in content
        assert len(content) < 1_500_000
    drawing = (tmp_path / "lattice-summary.svg").read_text()
    assert set(re.findall(r"<!-- (.*?) -->", drawing)) >= {
        f"{label} (m{unit})" for label, unit, _ in plots.panels([lattice, blades])
    }
    with pytest.raises(UserError, match="--overwrite"):
        plots.plot([lattice], tmp_path / "lattice")
    assert {file.name for file in tmp_path.iterdir()} == names


@pytest.mark.parametrize(
    ("arguments", "phrase"),
    [
        (["absent.h5"], "absent.h5: no such file"),
        (["{file}", "absent.h5"], "absent.h5: no such file"),
        (["{file}", "-o", "no/such/stem"], "no/such is not a folder"),
    ],
)
def test_a_figure_that_cannot_be_drawn_gets_a_sentence(arguments, phrase, lattice, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=re.escape(phrase)):
        cli.app(["plot", *(a.format(file=lattice.path) for a in arguments)], standalone_mode=False)
    assert not list(tmp_path.iterdir())


def test_the_map_is_even_about_zero_and_told_apart_by_everyone():
    """Deuteranopia, protanopia and tritanopia as linear maps of linear RGB (Machado, Oliveira & Fernandes 2009)."""
    blindness = {
        "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    }
    for theme in (palette.LIGHT, palette.DARK):
        table = palette.table(theme.anchors) / 255.0
        linear = np.where(table <= 0.04045, table / 12.92, ((table + 0.055) / 1.055) ** 2.4)
        lightness = palette._oklab(table)[:, 0]
        steps = np.diff(lightness) * (1 if theme is palette.LIGHT else -1)
        half = palette.LEVELS // 2
        assert np.all(steps[:half] > -0.003)
        assert np.all(steps[half:] < 0.003)
        assert abs(lightness[: half + 1] - lightness[half:][::-1]).max() < 0.12
        for matrix in blindness.values():
            seen = np.clip(linear @ np.array(matrix).T, 0.0, 1.0)
            seen = palette._oklab(np.where(seen <= 0.0031308, 12.92 * seen, 1.055 * seen ** (1 / 2.4) - 0.055))
            apart = np.linalg.norm(seen - seen[::-1], axis=1)
            assert apart[: half - half // 4].min() > 0.06


def test_colours_follow_the_values():
    table = palette.table()
    np.testing.assert_array_equal(palette.colours([-9.0, -1.0, 0.0, 1.0, 9.0], 1.0), table[[0, 0, 128, 256, 256]])
    assert len(set(map(int, table[128]))) == 1
    assert palette.symmetric_limit([]) == palette.symmetric_limit([0.0]) == 1.0
    assert palette.symmetric_limit([-3.0, 0.1, 2.9]) == 3.0
    assert palette.symmetric_limit([0.01] * 99 + [5.0]) == pytest.approx(0.01)


@pytest.mark.parametrize(("transparent", "mode"), [(False, "RGB"), (True, "RGBA")])
def test_a_picture_has_no_transparency_unless_a_style_asks_for_it(transparent, mode, tmp_path):
    figure = Figure((1.0, 0.5))
    style = {"savefig.transparent": transparent}
    (path,) = formats.write({"": figure}, tmp_path / "one", ("png",), style, overwrite=False)
    with Image.open(path) as picture:
        assert (picture.mode, picture.size) == (mode, (300, 150))
        assert picture.getpixel((5, 5))[3:] == (0,) * transparent
        assert round(picture.info["dpi"][0]) == formats.RESOLUTION


def test_help_does_not_load_matplotlib():
    script = "import sys, taichiflap.cli as c\ntry: c.app([{!r}, '--help'])\nexcept SystemExit: pass\nsys.exit(" + (
        "'matplotlib' in sys.modules or 'h5py' in sys.modules)"
    )
    for command in ("plot", "export"):
        ran = subprocess.run([sys.executable, "-c", script.format(command)], capture_output=True, check=False)
        assert ran.returncode == 0
