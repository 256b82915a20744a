"""Commands and code in the README and the documentation work, and print the stated output."""

import re
import runpy
import shlex
import shutil
import signal
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import typer
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap import cli
from taichiflap.case.case import case_schema, parse_case

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
TUTORIAL = ROOT / "docs" / "tutorial.md"
CAMERA = ROOT / "docs" / "howto" / "measured.md"
CASE_TABLES = runpy.run_path(str(ROOT / "docs" / "case_tables.py"))["case_tables"]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page, *kinds):
    found = re.findall(r"```(\w+)\n(.*?)```", page.read_text("utf-8"), re.DOTALL)
    return [(kind, text) for kind, text in found if kind in kinds]


def commands(text):
    return [line for line in text.replace("\\\n", " ").splitlines() if line.startswith("taichiflap ")]


def agree(shown, printed):
    """Whether two lines agree: numbers within 3 %; spreads and timings are ignored."""
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
    with pytest.raises(SystemExit) as stopped:
        cli.main()
    assert not stopped.value.code, line
    said = capsys.readouterr()
    return (said.out + said.err).splitlines()


@pytest.mark.slow
def test_the_tutorial_word_for_word(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    printed, shown, pythons = [], 0, 0
    for kind, block in blocks(TUTORIAL, "sh", "text", "python"):
        if kind == "sh":
            printed = []
            for line in commands(block):
                if "view" not in line:
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


@pytest.mark.slow
def test_from_a_camera_to_a_force_word_for_word(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    printed, shown = [], 0
    for kind, block in blocks(CAMERA, "sh", "text", "toml"):
        if kind == "sh":
            printed = []
            for line in commands(block):
                printed += run(line, monkeypatch, capsys)
            printed += (tmp_path / "measured_moth.csv").read_text().splitlines()
        elif kind == "text":
            rest = iter(printed) if "time (ms)" not in block else iter(printed[-300:])
            for line in block.splitlines():
                assert any(agree(line, other) for other in rest), f"{line!r} is not among {printed}"
                shown += 1
        else:
            written = tomllib.loads((tmp_path / "moth.toml").read_text())["motion"]
            assert written == tomllib.loads(block.replace("cases/", ""))["motion"]
    assert shown == 6
    assert (tmp_path / "moth-preview.png").exists()


@pytest.mark.parametrize(
    "page", [page for page in PAGES if "taichiflap " in page.read_text("utf-8")], ids=lambda page: page.stem
)
def test_commands_have_the_options_that_the_pages_give_them(page):
    group = typer.main.get_command(cli.app)
    lines = [line for _, block in blocks(page, "sh") for line in commands(block)]
    # In a sentence a command alone names itself; one that has arguments is there to be typed.
    lines += re.findall(r"`(taichiflap [a-z]+ [^`]+)`", page.read_text("utf-8"))
    for line in lines:
        _, *words = shlex.split(line.replace("\n", " "), comments=True)
        context = group.make_context("taichiflap", list(words))
        name, command, rest = group.resolve_command(context, [*context._protected_args, *context.args])
        command.make_context(name, rest)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the files that the pages use: cases, results and a map."""
    folder = tmp_path_factory.mktemp("pages")
    shutil.copytree(CASES, folder / "cases")
    shutil.copy(CASES / "measured_moth.csv", folder)  # as `init --from measured_moth` does
    short = hawkmoth("time.periods=3", "uvlm.panels=8", "uvlm.wake=40")
    for name, setting in (("hawkmoth", "wing.modes=1"), ("rigid", "wing.modes=0"), ("hawkmoth_dbet", "solver=dbet")):
        taichiflap.simulate(short.override(setting), folder / f"{name}.h5").close()
    (folder / "mine.toml").write_text(short.to_toml())
    taichiflap.sweep(short, {"wing.youngs_modulus": "2e10,3e10"}, output=folder / "map.h5")
    return folder


@pytest.mark.parametrize(
    "page", [page for page in PAGES if blocks(page, "python") and page != TUTORIAL], ids=lambda page: page.stem
)
def test_the_pythons_of_the_pages_run(page, folder, monkeypatch):
    monkeypatch.chdir(folder)
    names = {}
    before = signal.getsignal(signal.SIGINT)
    try:
        for _, block in blocks(page, "python"):
            exec(block, names)
    finally:
        signal.signal(signal.SIGINT, before)  # dask_jobqueue takes Ctrl-C for itself when it is imported


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "toml")], ids=lambda page: page.stem)
def test_the_cases_of_the_pages_are_cases(page, folder, monkeypatch):
    monkeypatch.chdir(folder)
    whole = tomllib.loads((CASES / "hawkmoth.toml").read_text())
    for _, block in blocks(page, "toml"):
        times = np.linspace(0.0, 1.0 if "periodic" in block else 5.0, 21)
        np.savetxt(
            "stroke.csv",
            np.stack([times, 0.01 * np.sin(2 * np.pi * times), 40 * np.cos(2 * np.pi * times)], 1),
            fmt="%.9f",
        )
        parse_case(whole | tomllib.loads(block), folder=folder)


def test_every_key_of_a_case_has_one_anchor_in_its_reference():
    anchors = re.findall(r'<span id="([^"]+)">', CASE_TABLES(case_schema()))
    assert len(anchors) == len(set(anchors))
    kinds = ("triangle", "trapezoid", "ramp", "table")
    keys = {anchor.removesuffix(f".{kind}") for anchor in anchors for kind in kinds}
    sections, wanted = case_schema()["$defs"], set()
    for name, section in case_schema()["properties"].items():
        reference = section.get("$ref", "").rpartition("/")[2]
        wanted |= {f"{name}.{key}" for key in sections[reference]["properties"]} if reference else {name}
    assert wanted - {"motion.plunge", "motion.pitch", "motion.surge", "motion.measured"} <= keys
    assert {"motion.plunge.amplitude", "motion.pitch.points_deg", "motion.measured.stroke"} <= keys
