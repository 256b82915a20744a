"""The commands as a user runs them: output, exit codes, --quiet, imports."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest
import yaml
from conftest import CASES

import taichiflap


def run(*arguments, cwd=None, **options):
    """Run the command line in a process of its own."""
    command = [sys.executable, "-m", "taichiflap", *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, **options)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder in which `simulate` has written hawkmoth.h5."""
    folder = tmp_path_factory.mktemp("runs")
    ran = run("simulate", CASES / "hawkmoth.toml", "--set", "time.periods=4", cwd=folder)
    assert ran.returncode == 0, ran.stderr
    (folder / "printed").write_text(ran.stdout)
    assert ran.stderr == ""
    return folder


def test_simulate_writes_the_result_and_says_what_it_amounts_to(folder):
    printed = (folder / "printed").read_text()
    for phrase in (
        "hawkmoth.h5, complete, 801 frames",
        "UVLM, 50 panels",
        "79.96 Hz",
        "over the last 2 beats",
    ):
        assert phrase in printed
    assert [file.name for file in folder.glob("*.h5*")] == ["hawkmoth.h5"]


@pytest.mark.slow
def test_info_prints_the_same_summary(folder):
    ran = run("info", "hawkmoth.h5", cwd=folder)
    assert ran.returncode == 0
    assert ran.stdout == (folder / "printed").read_text()
    given = run("simulate", "hawkmoth.h5", cwd=folder).stderr
    assert "hawkmoth.h5: this is a result or a map, not a case file" in given
    for phrase in (
        "vertical force",
        "peak tip deflection",
        "T after reversal",
        "first harmonic",
        "power",
        "solve time",
    ):
        assert phrase in ran.stdout


@pytest.mark.slow
def test_settings_change_the_case(tmp_path):
    ran = run(
        "simulate", CASES / "hawkmoth_dbet.toml", "-o", "rigid.h5", "--set", "wing.modes=0", "--set", "time.periods=2",
        cwd=tmp_path,
    )  # fmt: skip
    assert "rigid" in ran.stdout
    assert "DBET, 50 elements" in ran.stdout
    with taichiflap.open_result(tmp_path / "rigid.h5") as result:
        assert (result.case.wing.modes, result.case.time.periods) == (0, 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "phrases"),
    [
        (("simulate", "absent.toml"), ["absent.toml: no such file"]),
        (
            ("simulate", CASES / "hawkmoth.toml", "--set", "wing.chrod=1", "--set", "uvlm.panels=0"),
            ["did you mean wing.chord?", "uvlm.panels = 0: must be a whole number >= 1"],
        ),
        (("simulate", CASES / "hawkmoth.toml", "-o", "."), ["is a directory"]),
        (("simulate", CASES / "hawkmoth.toml", "-o", "no/such/folder.h5"), ["no/such is not a folder"]),
        (("info", "absent.h5"), ["absent.h5: no such file"]),
        (("info", 300 * "a"), ["aaa: not a readable result file"]),
        (("sweep", CASES / "hawkmoth.toml", "--vary", "wing.chrod=1:2:3"), ["did you mean wing.chord?"]),
        (("sweep", CASES / "hawkmoth.toml", "--vary", "wing.modes=0,1", "--metric", "lift"), ["metric lift: unknown"]),
        (("sweep", CASES / "hawkmoth.toml", "--vary", "wing.modes=0,1", "-o", "."), ["is a directory"]),
        (
            ("info", CASES / "hawkmoth.toml"),
            ["hawkmoth.toml: this is a case file, not a result; run it with taichiflap simulate"],
        ),
        (("plot", "run.h5", "--frame", "wnig"), ["--frame wnig: use inertial or wing"]),
        (("plot", "run.h5", "--whole"), ["--whole is for a map"]),
        (("init", "."), ["is a directory; name a file"]),
        (("init", "measured_moth.csv", "--from", "measured_moth"), ["name the case file measured_moth.toml"]),
        (("simulate", CASES / "hawkmoth.toml", "--threads", "0"), ["--threads"]),
        (("simulat",), ["simulat"]),
    ],
)
def test_mistakes_get_a_sentence_and_exit_code_2(arguments, phrases, tmp_path):
    ran = run(*arguments, cwd=tmp_path)
    assert ran.returncode == 2
    assert "Traceback" not in ran.stderr
    for phrase in phrases:
        assert phrase in ran.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_an_existing_result_is_kept_unless_told_otherwise(folder):
    before = (folder / "hawkmoth.h5").stat().st_mtime_ns
    ran = run("simulate", CASES / "hawkmoth.toml", cwd=folder)
    assert (ran.returncode, "--overwrite" in ran.stderr) == (2, True)
    assert (folder / "hawkmoth.h5").stat().st_mtime_ns == before


@pytest.mark.slow
def test_a_diverging_run_ends_with_code_1_and_its_frames(tmp_path):
    spinning = ("wing.youngs_modulus=1.0", "motion.pitch.amplitude_deg=360.0", "motion.frequency=100.0")
    settings = [part for s in (*spinning, "fluid.density=0.0", "time.periods=60") for part in ("--set", s)]
    ran = run("simulate", CASES / "hawkmoth_dbet.toml", *settings, cwd=tmp_path)
    assert ran.returncode == 1
    assert "at step" in ran.stderr
    assert ran.stderr.count("warning: the first natural frequency") == 1
    assert "the run failed: no statistics" in ran.stdout
    assert "beat to beat" not in ran.stdout
    assert not re.search("warning: the first natural|deflection diverged", ran.stdout)  # that has been said
    told = run("info", "hawkmoth_dbet.h5", cwd=tmp_path).stdout.splitlines()
    assert any(line.startswith("failed: ") for line in told)
    assert (tmp_path / "hawkmoth_dbet.h5").exists()


@pytest.mark.slow
def test_an_interrupted_run_says_where_its_frames_are(tmp_path):
    settings = [part for one in ("uvlm.wake=2000", "time.periods=300", "output.every=20") for part in ("--set", one)]
    command = [sys.executable, "-m", "taichiflap", "simulate", str(CASES / "hawkmoth.toml"), *settings]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        while process.poll() is None and not frames_in(tmp_path / "hawkmoth.h5"):
            time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        try:
            _, said = process.communicate(timeout=30)
        finally:
            process.kill()
    assert process.returncode == 130
    told, cure = said.splitlines()
    assert told == "interrupted: taichiflap info hawkmoth.h5 shows what has been computed"
    assert cure.startswith("continue with: taichiflap simulate ")
    assert cure.endswith("--set=uvlm.wake=2000 --set=time.periods=300 --set=output.every=20 --resume")
    ran = run("info", "hawkmoth.h5", cwd=tmp_path)
    assert (ran.returncode, "running" in ran.stdout) == (0, True)


def frames_in(path):
    try:
        with taichiflap.open_result(path) as result:
            return result.frames
    except taichiflap.ResultError:
        return 0


@pytest.mark.slow
def test_init_writes_a_case_that_runs(tmp_path):
    assert run("init", "mine.toml", cwd=tmp_path).returncode == 0
    ran = run("simulate", "mine.toml", "--set", "time.periods=1", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "mine.h5").exists()


@pytest.mark.slow
def test_init_takes_a_case_that_comes_along_with_its_tables(tmp_path):
    for name in ("hawkmoth", "tabulated_stroke"):
        ran = run("init", f"my_{name}.toml", "--from", name, cwd=tmp_path)
        assert ran.returncode == 0, ran.stderr
        assert taichiflap.load_case(tmp_path / f"my_{name}.toml") == taichiflap.load_case(CASES / f"{name}.toml")
    table = tmp_path / "tabulated_stroke.csv"
    assert run("init", "again.toml", "--from", "tabulated_stroke", cwd=tmp_path).returncode == 0
    table.write_text("0 0\n1 0\n")  # the user's own
    ran = run("init", "other.toml", "--from", "tabulated_stroke", cwd=tmp_path)
    assert (ran.returncode, table.read_text()) == (2, "0 0\n1 0\n")
    assert "tabulated_stroke.csv: exists already" in ran.stderr
    assert not (tmp_path / "other.toml").exists()
    ran = run("init", "other.toml", "--from", "hawkmot", cwd=tmp_path)
    assert ran.returncode == 2
    assert ran.stderr == "error: hawkmot: no bundled case has this name; did you mean hawkmoth?\n"
    assert not (tmp_path / "other.toml").exists()


@pytest.mark.slow
def test_cite_says_what_the_citation_file_says():
    ran = run("cite")
    assert ran.returncode == 0
    data = yaml.safe_load((CASES.parent / "CITATION.cff").read_text())
    assert data["version"] == taichiflap.__version__
    printed = " ".join(ran.stdout.split())
    (paper,) = data["references"]
    said = [data["title"], data["authors"][0]["name"], data["version"], data["license"]]
    said += [paper["title"], paper["doi"], paper["notes"], paper["collection-title"], str(paper["year"])]
    said += [person["family-names"] for person in paper["authors"]]
    assert [phrase for phrase in said if phrase not in printed] == []


@pytest.mark.slow
def test_schema_is_json():
    schema = json.loads(run("schema").stdout)
    assert schema["properties"]["wing"]["$ref"] == "#/$defs/Wing"


def test_version():
    assert run("--version").stdout == f"taichiflap {taichiflap.__version__}\n"


def test_help_loads_nothing_heavy():
    script = (
        "import sys, taichiflap, taichiflap.cli as c\n"
        "try: c.app(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'taichi', 'viser', 'numpy', 'h5py', 'pydantic'} & set(sys.modules)\n"
        "sys.exit(repr(heavy) if heavy else 0)"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert "simulate" in ran.stdout


def test_help_answers_at_once():
    """A bound on processor time, which depends less on the load than wall time."""
    unmeasured = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE")}
    before = os.times()
    run("--help", env=unmeasured)
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    assert used < 0.4
