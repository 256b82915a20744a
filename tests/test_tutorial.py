"""The tutorial, word for word: its commands in their order, and the lines that it shows of what they print."""

import re
import shlex
import sys
from pathlib import Path

import pytest

import taichiflap
from taichiflap import cli

PAGE = Path(__file__).parent.parent / "docs" / "tutorial.md"
BLOCKS = re.findall(r"```(sh|text|python)\n(.*?)```", PAGE.read_text(), re.DOTALL)
ELSEWHERE = ("python3 -m venv", ".venv/bin/pip", ". .venv/bin/activate", "taichiflap view")
"""Commands that other tests run: the installation and the viewer."""


def agree(shown, printed):
    """Whether two lines say the same; numbers to 3 %, spreads and timings whatever they are."""
    shown, printed = shown.split(), printed.split()
    if len(shown) != len(printed):
        return False
    before = ""
    for ours, theirs in zip(shown, printed, strict=True):
        try:
            near = before == "±" or float(theirs) == pytest.approx(float(ours), rel=0.03)
        except ValueError:
            near = ours == theirs
        if not near and shown[:2] != ["solve", "time"]:
            return False
        before = ours
    return True


def run(line, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", shlex.split(line))
    try:
        cli.main()
    except SystemExit as stopped:
        assert not stopped.code, capsys.readouterr().err
    said = capsys.readouterr()
    return (said.out + said.err).splitlines()


@pytest.mark.slow
def test_the_tutorial_word_for_word(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    printed, shown, pythons = [], 0, 0
    for kind, block in BLOCKS:
        if kind == "sh":
            printed = []
            for line in block.replace("\\\n", " ").splitlines():
                if not line.startswith(ELSEWHERE):
                    printed += run(line, monkeypatch, capsys)
        elif kind == "text":
            rest = iter(printed)
            for line in block.splitlines():
                if line != "...":
                    assert any(agree(line, other) for other in rest), f"{line!r} is not among {printed}"
                    shown += 1
        else:
            exec(block, names := {})
            pythons += 1
            if "soft" in names:
                assert taichiflap.summarise(names["rigid"]).force_vertical.mean == pytest.approx(3.11e-3, rel=0.03)
    assert shown > 25
    assert pythons == 2
