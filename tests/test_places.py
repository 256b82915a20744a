"""Unusual environments: homes, users, limits, names, signals. Exit codes are right, and errors are one sentence."""

import contextlib
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import CASES

import taichiflap
from taichiflap import disk, files
from taichiflap.errors import UserError
from taichiflap.maps.design import design
from taichiflap.results import checkpoint
from taichiflap.results.ownership import check
from taichiflap.studies.sweep import prepare

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")

SHORT = ["--set=time.periods=1", "--set=time.steps_per_period=20", "--set=wing.modes=1", "--threads=1"]
SIMULATE = ["simulate", str(CASES / "hawkmoth_dbet.toml"), *SHORT, "-o", "run.h5"]
COMMANDS = {
    "simulate": SIMULATE,
    "sweep": ["sweep", str(CASES / "hawkmoth_dbet.toml"), *SHORT, "--vary=fluid.density=1,2", "-o", "map.h5"],
    "info": ["info", "whole.h5"],
    "csv": ["export", "whole.h5", "--to=csv", "-o", "out.csv"],
    "init": ["init", "mine.toml"],
    "cite": ["cite"],
}
WRITES = {"simulate": "run.h5", "sweep": "map.h5", "csv": "out.csv", "init": "mine.toml"}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    case = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", [word[6:] for word in SHORT if word.startswith("--set")])
    taichiflap.simulate(case, folder / "whole.h5", threads=1).close()
    return folder / "whole.h5"


def run(words, folder, prepare=None, **environment):
    """A command in a folder and an environment; its exit code, output and errors."""
    inherited = {name: value for name, value in os.environ.items() if environment.get(name, value) is not None}
    given = inherited | {name: value for name, value in environment.items() if value is not None}
    ran = subprocess.run(
        [sys.executable, "-m", "taichiflap", *words], cwd=folder, env=given, preexec_fn=prepare, timeout=280,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return ran.returncode, ran.stdout, ran.stderr


def clean(text):
    """Output without the messages of libraries about an unusable home folder."""
    ours = ("error: ", "warning: ", "interrupted", "continue with")
    return [line for line in text.splitlines() if line.startswith(ours) or "Traceback" in line]


HOMES = {
    "a home that is missing": {"HOME": "{folder}/missing"},
    "a home that cannot be": {"HOME": "/proc/nothing"},
    "a home that is a file": {"HOME": "{folder}/file"},
    "a home that is a device": {"HOME": "/dev/null"},
    "an empty home": {"HOME": ""},
    "no home at all": {"HOME": None},
    "a cache that is a file": {"XDG_CACHE_HOME": "{folder}/file", "HOME": "{folder}/file"},
    "no home and no place for the temporary": {"HOME": "/proc/nothing", "TMPDIR": "/proc/nothing"},
    "a cache of Taichi's that cannot be": {"TI_OFFLINE_CACHE_FILE_PATH": "/proc/nothing"},
    "another language": {"LC_ALL": "C", "LANG": "C", "PYTHONUTF8": "0"},
}


@pytest.mark.slow
@pytest.mark.parametrize("command", ["simulate", "sweep"])
@pytest.mark.parametrize("home", HOMES)
def test_a_run_ends_well_wherever_home_is(home, command, tmp_path):
    (tmp_path / "file").write_text("")
    environment = {name: value and value.format(folder=tmp_path) for name, value in HOMES[home].items()}
    code, _, said = run(COMMANDS[command], tmp_path, **environment)
    assert (code, [line for line in clean(said) if "warning" not in line]) == (0, []), said
    with contextlib.suppress(UserError):
        taichiflap.open_result(tmp_path / "run.h5").close()
    assert (tmp_path / WRITES[command]).exists()


def foreign():
    """A user without a name, as in a container."""
    os.setgid(54321)
    os.setuid(54321)


@pytest.mark.slow
@pytest.mark.skipif(os.geteuid() != 0, reason="needs root to become another")
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("home", [None, "/", "/root"])
def test_a_user_without_a_name_has_all_commands(command, home, tmp_path_factory, whole):
    try:
        subprocess.run([sys.executable, "-c", "import taichi"], preexec_fn=foreign, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("Python itself is not for every user here")
    folder = Path(subprocess.run(["mktemp", "-d"], capture_output=True, text=True, check=True).stdout.strip())
    (folder / "whole.h5").write_bytes(whole.read_bytes())
    os.chown(folder, 54321, 54321)
    try:
        code, _, said = run(COMMANDS[command], folder, foreign, HOME=home, TMPDIR=str(folder), USER=None)
        assert (code, "Traceback" in said) == (0, False), said
    finally:
        subprocess.run(["rm", "-rf", str(folder)], check=True)


def limited(bytes_):
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (bytes_, bytes_))


NAMES = {
    "a link to nothing": (lambda folder: (folder / "out").symlink_to("nothing"), "out", "is a broken link"),
    "a loop": (lambda folder: (folder / "out").symlink_to("out"), "out", "Too many levels|is a broken link"),
    "249 bytes": (None, "x" * 249, "the name has 249 bytes; give one with at most 224"),
    "225 bytes": (None, "x" * 225, "the name has 225 bytes"),
    "255 umlauts": (None, "ä" * 255, "the name has 510 bytes"),
    "300 bytes": (None, "x" * 300, "the name has 300 bytes"),
    "a folder": (lambda folder: (folder / "out").mkdir(), "out", "is a directory"),
    "in a file": (lambda folder: (folder / "file").write_text(""), "file/out", "is not a folder"),
    "in no folder": (None, "none/out", "is not a folder"),
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["result", "map", "export"])
def test_a_name_that_cannot_be_written_is_refused_before_the_run(name, kind, tmp_path, whole):
    make, place, said = NAMES[name]
    if make:
        make(tmp_path)
    path = tmp_path / place
    case = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", ["time.periods=1", "time.steps_per_period=20"])
    before = sorted(tmp_path.iterdir())
    planned = design(case, {"fluid.density": "1,2"})
    looks = {"result": check, "map": lambda *given: prepare(case, planned, path), "export": files.check}
    with pytest.raises(UserError, match=said) as caught:
        looks[kind](path, True)
    assert "\n" not in str(caught.value)
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
@pytest.mark.parametrize("command", ["simulate", "sweep"])
def test_a_signal_ends_a_command_with_words_on_how_to_go_on(number, code, command, tmp_path):
    words = {
        "simulate": ["simulate", str(CASES / "hawkmoth.toml"), "--set=time.periods=2000", "-o", "run.h5"],
        "sweep": ["sweep", str(CASES / "hawkmoth.toml"), "--vary=fluid.density=1:2:4000", "-o", "map.h5"],
    }[command]
    # Coverage would take SIGTERM for itself before the command can.
    plain = {name: value for name, value in os.environ.items() if not name.startswith("COV")}
    process = subprocess.Popen(
        [sys.executable, "-m", "taichiflap", *words], cwd=tmp_path, text=True, env=plain,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    until = time.monotonic() + 250
    wanted = tmp_path / {"simulate": "run.h5.state", "sweep": "map.h5"}[command]
    while not wanted.exists() and time.monotonic() < until and process.poll() is None:
        time.sleep(0.1)
    process.send_signal(number)
    _, said = process.communicate(timeout=280)
    assert process.returncode == code, said
    assert "interrupted: " in said
    assert ("continue with: taichiflap simulate" if command == "simulate" else "the same command continues") in said
    assert not list(tmp_path.glob("*.lock"))


def locked_by(folder, text):
    path = folder / "run.h5"
    (folder / "run.h5.lock").write_text(text)
    return path


def test_a_lock_keeps_others_away_until_it_is_released(tmp_path):
    held = disk.Lock(tmp_path / "run.h5")
    with pytest.raises(disk.Busy, match=rf"process {os.getpid()} on "):
        disk.Lock(tmp_path / "run.h5")
    held.release()
    held.release()
    disk.Lock(tmp_path / "run.h5").release()
    assert not list(tmp_path.iterdir())


def test_the_lock_of_a_process_that_is_gone_is_taken_over(tmp_path):
    process = os.fork()
    if not process:
        disk.Lock(tmp_path / "run.h5")
        os._exit(0)
    os.waitpid(process, 0)
    assert (tmp_path / "run.h5.lock").exists()
    disk.Lock(tmp_path / "run.h5").release()
    host, own, began = disk._sign().split()
    # The number of a process is given again: it began at another time.
    disk.Lock(locked_by(tmp_path, f"{host} {own} {began}1\n")).release()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", ["elsewhere 1 77\n", "", "\x00\xff", "a line of something else"])
def test_a_lock_of_which_nobody_knows_is_left_alone(text, tmp_path):
    path = locked_by(tmp_path, text)
    with pytest.raises(disk.Busy, match=r"if it no longer runs, remove .*run\.h5\.lock"):
        disk.Lock(path)
    assert (tmp_path / "run.h5.lock").read_text() == text


@pytest.mark.parametrize("variable", ["0", "FALSE"])
def test_two_writers_do_not_share_a_file_without_hdf5s_lock(variable, tmp_path, monkeypatch):
    monkeypatch.setenv("HDF5_USE_FILE_LOCKING", variable)
    case = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", ["time.periods=1", "time.steps_per_period=20"])
    path = tmp_path / "run.h5"
    refused = []

    def intrude(done, total):
        for options in ({}, {"overwrite": True}, {"resume": True}):
            with pytest.raises(UserError, match="another run is writing it") as caught:
                taichiflap.simulate(case, path, **options)
            refused.append(caught)

    taichiflap.simulate(case, path, progress=intrude).close()
    assert refused
    taichiflap.open_result(path).close()
    assert not checkpoint.beside(path).exists()


@pytest.mark.slow
@pytest.mark.parametrize("megabytes", [300, 600, 1000])
def test_too_little_memory_is_a_sentence(megabytes, tmp_path):
    code, _, said = run(SIMULATE, tmp_path, limited(megabytes * 2**20))
    assert code in (1, 2), said
    (line,) = [line for line in clean(said) if not line.startswith("warning")]
    assert line.startswith(("error: out of memory", "error: the limit of address space is"))
