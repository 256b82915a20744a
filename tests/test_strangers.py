"""Untrusted files: files that they name are not opened, modules not imported, and text is made printable."""

import contextlib
import os
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace

import h5py
import pytest
from conftest import hawkmoth
from taichiflap_viewer.explore.visit import Visit
from taichiflap_viewer.maps.viewer import MapViewer

import taichiflap
from taichiflap.case.case import CaseError, load_case, read_value
from taichiflap.cli import main
from taichiflap.commands.map_summary import map_lines
from taichiflap.commands.summary import summary_lines
from taichiflap.errors import UserError
from taichiflap.export.formats import export
from taichiflap.maps import file as maps
from taichiflap.plots import maps as map_plots
from taichiflap.plots.result import plot
from taichiflap.results import hdf
from taichiflap.studies.expression import read_constraint, read_expression

SHORT = ("time.periods=2", "time.steps_per_period=50", "wing.modes=1", "solver=dbet")
opened: list[str] = []
watching = False


def _watch(event, arguments):
    if watching and event in ("open", "import", "os.listdir", "subprocess.Popen"):
        opened.append(f"{event} {arguments[0]}")


sys.addaudithook(_watch)


@contextlib.contextmanager
def watched():
    """Context that records what Python opens, imports or starts."""
    global watching  # noqa: PLW0603 - a hook of the interpreter stays
    opened.clear()
    watching = True
    try:
        yield opened
    finally:
        watching = False


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A result and a map, as bytes."""
    folder = tmp_path_factory.mktemp("good")
    taichiflap.simulate(hawkmoth(*SHORT), folder / "run.h5").close()
    taichiflap.sweep(
        hawkmoth(*SHORT), {"motion.plunge.kind": ["harmonic"], "fluid.density": [1.0, 2.0]}, folder / "map.h5"
    )
    return {name: (folder / name).read_bytes() for name in ("run.h5", "map.h5")}


def doctored(good, name, folder, **attributes):
    """A copy of a valid file with other texts."""
    path = folder / name
    path.write_bytes(good[name])
    with h5py.File(path, "r+") as file:
        said = {key: value(file.attrs[key].decode()) if callable(value) else value for key, value in attributes.items()}
        hdf.note(file, said)
    return path


def with_table(place):
    """A case text whose plunge is a table in another file."""

    def change(text):
        table = f'[motion.plunge]\nkind = "table"\nperiodic = true\nfile = "{place}"\n'
        return re.sub(r"\[motion\.plunge\]\n(?:[^\[].*\n|\n)*", lambda _: table, text)

    return change


def open_both(path):
    return taichiflap.open_result(path) if path.name == "run.h5" else taichiflap.open_map(path)


@pytest.mark.parametrize("name", ["run.h5", "map.h5"])
@pytest.mark.parametrize("place", ["/etc/passwd", "/dev/zero", "pipe", "beside.csv"])
def test_no_other_file_is_opened(name, place, good, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "beside.csv").write_text("0 0\n0.2 1\n0.4 0\n1 0\n")
    named = place if place.startswith("/") else str(tmp_path / place)
    path = doctored(good, name, tmp_path, case=with_table(named))
    with watched() as found, pytest.raises(UserError, match=r"its case is invalid: motion\.plunge\.file"):
        open_both(path)
    assert not [one for one in found if named in one]


def test_a_value_of_a_map_opens_no_file(good, tmp_path):
    """Values of a map are TOML and may be tables."""
    path = tmp_path / "map.h5"
    (tmp_path / "beside.csv").write_text("0 0\n0.2 1\n0.4 0\n1 0\n")
    path.write_bytes(good["map.h5"])
    table = f'{{kind = "table", periodic = true, file = "{tmp_path / "beside.csv"}"}}'
    with h5py.File(path, "r+") as file:
        file.move("motion.plunge.kind", "motion.plunge")
        hdf.note(file, {"keys": "motion.plunge fluid.density"})
        hdf.note(file["motion.plunge"], {"labels": f"[{_json(table)}]"})
    with maps.open_map(path) as sheet, watched() as found:
        assert read_value(sheet.design.axes[0].values[0])["file"]
        with pytest.raises(CaseError, match=r"motion\.plunge\.file: no file may be read here"):
            sheet.design.case(sheet.case, 0)
    assert not [one for one in found if "beside" in one]


def _json(text):
    return '"' + text.replace('"', '\\"') + '"'


@pytest.mark.slow
@pytest.mark.parametrize(("name", "step"), [("run.h5", "50"), ("map.h5", "50"), ("map.h5", '"auto"')])
def test_no_module_is_imported_that_a_file_names(name, step, good, tmp_path, monkeypatch):
    """Not even by an automatic step, which its model alone knows, or by the button to explore."""
    (tmp_path / "burglar.py").write_text("raise SystemExit('code of a stranger has run')\n")
    monkeypatch.syspath_prepend(tmp_path)

    def altered(text):
        assert "steps_per_period = 50" in text
        return text.replace('"dbet"', '"module:burglar"').replace("_period = 50", f"_period = {step}")

    path = doctored(good, name, tmp_path, case=altered)
    with open_both(path) as file, watched() as found:
        if name == "run.h5":
            text = "\n".join(summary_lines(file))
            plot([file], tmp_path / "figure")
            for kind in ("csv", "html", "vtkhdf"):
                export(file, kind, tmp_path / f"export.{kind}")
            assert not Visit.may_explore([SimpleNamespace(live=False, case=file.case)])
        else:
            text = "\n".join(map_lines(file))
            map_plots.plot(file, tmp_path / "figure", False)
            with pytest.raises(UserError, match=r"runs the Python module of solver = \"module:burglar\".*--trust"):
                MapViewer.run(SimpleNamespace(path=path, trust=False), 0, None)
    assert "BURGLAR" in text
    assert not [one for one in found if "burglar" in one]
    assert "burglar" not in sys.modules


def test_a_result_whose_step_only_a_module_knows_is_refused_in_a_sentence(good, tmp_path):
    path = doctored(
        good, "run.h5", tmp_path,
        case=lambda text: text.replace('"dbet"', '"module:burglar"').replace("_period = 50", '_period = "auto"'),
    )  # fmt: skip
    with pytest.raises(UserError, match=r"only the module of solver = .module:burglar. knows"), open_both(path) as file:
        "".join(summary_lines(file))
    assert "burglar" not in sys.modules


def test_a_map_that_is_trusted_runs_its_module(good, tmp_path, monkeypatch):
    (tmp_path / "guest_model.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    path = doctored(good, "map.h5", tmp_path, case=lambda text: text.replace('"dbet"', '"module:guest_model"'))
    with pytest.raises(UserError, match=r"guest_model is not a fluid model"):
        MapViewer.run(SimpleNamespace(path=path, trust=True), 0, None)


STEERS = "\x1b[2J\rfaked\n\u202eline\x00\x85"
"""What TOML writes as escapes and a terminal, an SVG or a reader would obey."""
ESCAPED = "".join(f"\\u{ord(c):04x}" if not c.isprintable() else c for c in STEERS)


@pytest.mark.slow
def test_texts_of_a_file_are_printable_wherever_they_go(good, tmp_path):
    def titled(text):
        return re.sub(r'^title = ".*"$', lambda _: f'title = "{ESCAPED}"', text, flags=re.MULTILINE)

    path = doctored(good, "run.h5", tmp_path, case=titled, reason=STEERS, title=STEERS, warnings="one\n" + STEERS)
    with taichiflap.open_result(path) as result:
        lines = list(summary_lines(result))
        assert all(line.isprintable() for line in lines)
        assert result.case.title.isprintable()
        assert not [line for line in lines if line.startswith("faked")]
        figures = plot([result], tmp_path / "figure")
        export(result, "html", tmp_path / "page.html")
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", (tmp_path / "page.html").read_text())
    path = doctored(good, "map.h5", tmp_path, case=titled, title=STEERS)
    with taichiflap.open_map(path) as sheet:
        assert all(line.isprintable() for line in map_lines(sheet))
        figures += map_plots.plot(sheet, tmp_path / "map", False)
    for figure in figures:
        if figure.suffix == ".svg":
            assert ET.parse(figure).getroot().tag.endswith("svg")


def test_a_name_of_a_file_is_printable_too(good, tmp_path, monkeypatch, capsys):
    path = tmp_path / "run\x1b[31m\n.h5"
    path.write_bytes(good["run.h5"])
    with taichiflap.open_result(path) as result:
        assert all(line.isprintable() for line in summary_lines(result))
    monkeypatch.setattr(sys, "argv", ["taichiflap", "info", str(tmp_path / "none\x1b[31m")])
    with pytest.raises(SystemExit):
        main()
    assert "\x1b" not in capsys.readouterr().err


GOOD = hawkmoth().to_toml()


def replaced(pattern, text):
    return re.sub(pattern, lambda _: text, GOOD, count=1, flags=re.MULTILINE)


ABSURD = {
    "an integer of 5,000 digits": (replaced(r"^chord = .*", f"chord = {'9' * 5000}"), "4300 digits"),
    "4,000 digits": (replaced(r"^chord = .*", f"chord = {'9' * 4000}"), r"wing\.chord: .* 4000 digits"),
    "an integer of 4,000 digits in a list": (
        replaced(r"^velocity = \[[^\]]*\]", f"velocity = [{'9' * 4000}, 0.0]"), r"velocity: whole number with 4000 "
            "digits",
    ),
    "a header 20,000 deep": (f"[{'.'.join(['a'] * 20_000)}]\n{GOOD}", "nested too deeply"),
    "a quoted header 20,000 deep": ("[" + ".".join(['"a b"'] * 20_000) + "]\n", "nested too deeply"),
    "a key 20,000 deep": (f"{'.'.join(['a'] * 20_000)} = 1\n{GOOD}", "nested too deeply"),
    "an inline key 20,000 deep": (f"x = {{{'.'.join(['a'] * 20_000)} = 1}}\n{GOOD}", "nested too deeply"),
    "lists 20,000 deep": (f"x = {'[' * 20_000}{']' * 20_000}\n{GOOD}", "nested too deeply"),
    "lists 100 deep": (f"title = {'[' * 100}{']' * 100}\n", "nested too deeply"),
    "50,000 headers": (GOOD + "".join(f"[x{i}]\n" for i in range(50_000)), "more than 2,000 keys"),
    "50,000 keys": ("".join(f"x{i} = 1\n" for i in range(50_000)) + GOOD, "more than 2,000 keys"),
    "100,000 harmonics": (
        replaced(r"^harmonics = .*", f"harmonics = [{'[1, 0.0, 0.0],' * 100_000}]"),
        r"motion\.plunge\.harmonics = .*: has 100,000 terms; give at most 100",
    ),
    "a title with an escape": (replaced(r"^title = .*", f'title = "{ESCAPED}"'), "title = .*one line of printable "
    "characters"),
    "17 MB of nothing": ("#\n" * (17 * 2**19), "larger than the limit of 16 MB"),
}  # fmt: skip


@pytest.mark.parametrize("what", ABSURD)
@pytest.mark.timeout(60)
def test_an_absurd_case_file_is_refused_in_a_sentence(what, tmp_path):
    text, said = ABSURD[what]
    path = tmp_path / "case.toml"
    path.write_text(text)
    with pytest.raises(CaseError, match=said) as caught:
        load_case(path)
    assert len(str(caught.value).splitlines()) <= 2
    assert len(str(caught.value)) < 600


def test_a_case_file_without_end_is_refused():
    with pytest.raises(CaseError, match=r"/dev/zero: larger than the limit of 16 MB"):
        load_case("/dev/zero")


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("/dev/zero", "not a regular file"),
        ("pipe", "not a regular file"),
        (".", "not a regular file|cannot be read"),
        ("large.csv", "larger than the limit of 16 MB"),
        ("a\\u0000b", "a file name cannot contain NUL"),
        ("x" * 5000, "cannot be read: File name too long"),
        ("loop", "cannot be read: Too many levels of symbolic links"),
    ],
)
@pytest.mark.timeout(60)
def test_a_table_comes_from_a_regular_file_of_some_size(place, said, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    with open(tmp_path / "large.csv", "wb") as file:
        file.truncate(2**24 + 1)
    path = tmp_path / "case.toml"
    path.write_text(with_table(place)(GOOD))
    with pytest.raises(CaseError, match=rf"motion\.plunge\.file = .*: ({said})"):
        load_case(path)


@pytest.mark.parametrize("setting", [f"wing.chord={'9' * 5000}", f"wing.chord={'9' * 4000}", f"wing.modes=-{'9' * 30}"])
def test_an_absurd_setting_is_refused_in_a_sentence(setting):
    with pytest.raises(CaseError, match=r"digits|not a number") as caught:
        hawkmoth(setting)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    "formula",
    [
        f"power_mean * {'9' * 5000}",
        f"power_mean * {'9' * 400}",
        "power_mean" + " + power_mean" * 5000,
        "-" * 5000 + "power_mean",
        "(" * 5000 + "power_mean" + ")" * 5000,
        "power_mean\x00",
        "power_mean * 1" + "0" * 450,
    ],
)
def test_an_absurd_formula_is_refused_in_a_sentence(formula):
    for read in (read_expression, lambda text: read_constraint(f"{text} >= 1")):
        with pytest.raises(UserError, match=r"not a formula|longer than|too large") as caught:
            read(formula)
        assert len(str(caught.value)) < 300


def test_devices_and_pipes_are_no_results(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero", "/dev/null"):
        with pytest.raises(UserError, match="not a regular file"):
            taichiflap.open_result(path)
        with pytest.raises(UserError, match="not a regular file"):
            taichiflap.open_map(path)
        assert not maps.is_map(Path(path))
