"""The preview of a case shows the motion of the march."""

import subprocess
import sys
from unittest.mock import MagicMock

import numpy as np
import pytest
from conftest import CASES, hawkmoth
from matplotlib.collections import LineCollection

import taichiflap
from taichiflap import cli
from taichiflap.errors import UserError
from taichiflap.motion import attack, sampling
from taichiflap.plots import preview


def beat(case):
    times = np.linspace(0.0, 1.0, preview.TIMES) * case.beat
    return sampling.sample(case.motion, times)


def test_in_hover_the_angle_of_attack_is_a_right_angle_less_the_pitch():
    case = hawkmoth()
    moved = beat(case)
    found, known = np.degrees(attack.angle_of_attack((0.0, 0.0), moved)), attack.tells((0.0, 0.0), moved)
    assert 0.9 < known.mean() < 1.0
    pitch = np.degrees(moved[:, sampling.PITCH])
    # The paper's stroke moves to -Z while it pitches by a positive angle: the leading edge goes first.
    np.testing.assert_allclose(found[known], (90.0 - np.abs(pitch))[known], atol=1e-6)


def test_in_a_stream_it_is_what_the_plunging_foil_has():
    case = taichiflap.load_case(CASES / "plunging_foil.toml")
    moved = beat(case)
    expected = np.abs(-4.0 + np.degrees(np.arctan2(moved[:, sampling.PLUNGE_RATE], case.fluid.velocity[0])))
    np.testing.assert_allclose(
        np.degrees(attack.angle_of_attack(case.fluid.velocity, moved)), expected, rtol=0, atol=1e-6
    )
    pivot, tip = attack.speeds(case.fluid.velocity, case.wing.chord, moved)
    np.testing.assert_allclose(pivot, tip)
    np.testing.assert_allclose(pivot, np.hypot(case.fluid.velocity[0], moved[:, sampling.PLUNGE_RATE]))


def test_a_pivot_at_rest_moves_to_neither_side():
    for name, words in {"pitch_ramp": ["not moving along Z"], "hawkmoth": ["moving to +Z", "moving to −Z"]}.items():
        ax = taichiflap.preview(taichiflap.load_case(CASES / f"{name}.toml")).axes[0]
        assert [text.get_text() for text in ax.get_legend().get_texts()] == words
        (lines,) = ax.findobj(LineCollection)
        assert len(np.unique(lines.get_colors(), axis=0)) == len(words)


def test_the_chords_drawn_are_those_of_the_motion():
    case = taichiflap.load_case(CASES / "measured_moth.toml")
    figure = taichiflap.preview(case)
    (lines,) = figure.axes[0].findobj(LineCollection)
    chords = np.array(lines.get_segments())
    assert chords.shape == (preview.CHORDS, 2, 2)
    moved = sampling.sample(case.motion, case.beat * np.arange(preview.CHORDS) / preview.CHORDS)
    leading = 1e3 * np.stack((moved[:, sampling.PLUNGE], -moved[:, sampling.SURGE]), axis=1)
    np.testing.assert_allclose(chords[:, 0], leading, atol=1e-9)  # the pivot is at the leading edge
    ways = chords[:, 1] - chords[:, 0]
    np.testing.assert_allclose(np.hypot(*ways.T), 1e3 * case.wing.chord)
    np.testing.assert_allclose(ways[:, 0], 1e3 * case.wing.chord * np.sin(moved[:, sampling.PITCH]), atol=1e-9)
    said = {text.get_text() for ax in figure.axes for text in ax.texts}
    assert {"gravity", "stroke plane"} <= said
    stream = taichiflap.preview(case.override("fluid.velocity=[0.0, -2.0]"))
    assert "stream, 2 m/s" in {text.get_text() for ax in stream.axes for text in ax.texts}


@pytest.mark.parametrize("kind", ["png", "svg", "pdf", "eps"])
def test_a_picture_is_written_as_its_name_ends(kind, tmp_path):
    path = tmp_path / f"moth.{kind}"
    preview.write(taichiflap.load_case(CASES / "pitch_ramp.toml"), path)
    beginnings = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF", "eps": b"%!PS"}
    assert path.read_bytes().startswith(beginnings[kind])
    with pytest.raises(UserError, match="exists already"):
        preview.write(hawkmoth(), path)
    with pytest.raises(UserError, match="unsupported picture type; end the name in pdf, eps, svg, png"):
        preview.write(hawkmoth(), tmp_path / "moth.jpeg")


def test_the_command_draws_and_says_what_is_implausible(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        sys, "argv", ["taichiflap", "preview", str(CASES / "hawkmoth.toml"), "--set", "motion.frequency=0.2"]
    )
    with pytest.raises(SystemExit) as stopped:
        cli.main()
    assert not stopped.value.code
    said = capsys.readouterr()
    assert "hawkmoth-preview.png written" in said.out
    assert "motion                0.2 Hz, plunge 20 mm" in said.out
    assert "Reynolds number" in said.err
    assert (tmp_path / "hawkmoth-preview.png").stat().st_size > 10_000


def test_the_viewer_shows_the_picture_and_takes_it_away():
    from taichiflap_viewer import motion  # noqa: PLC0415 - the viewer alone needs it

    client = MagicMock()
    shown = motion.Motion(client, taichiflap.load_case(CASES / "measured_moth.toml"))
    (push,), _ = client.gui.add_button.return_value.on_click.call_args
    push(None)
    (drawn,), _ = client.gui.add_image.call_args
    assert drawn.shape[2] == 3
    assert drawn.shape[0] > 400
    assert drawn.min() < 50
    assert drawn.max() == 255
    window = shown.window
    push(None)
    window.remove.assert_called_once_with()
    assert shown.window is None
    push(None)
    assert client.gui.add_image.call_args.args[0] is drawn  # drawn once


@pytest.mark.slow
def test_a_picture_needs_no_compiler():
    code = (
        "import sys, taichiflap; taichiflap.preview(taichiflap.load_case(sys.argv[1])); print('taichi' in sys.modules)"
    )
    found = subprocess.run(
        [sys.executable, "-c", code, CASES / "hawkmoth.toml"], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "False"
