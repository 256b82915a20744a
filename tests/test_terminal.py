"""Output on a terminal: progress bars, lines of searches, and advice at Ctrl-C."""

import contextlib
import os
import pty
import re
import signal
import subprocess
import sys

import pytest
from conftest import CASES

import taichiflap
from taichiflap import cli
from taichiflap.commands import interrupts, progress
from taichiflap.maps.outcome import Outcome
from taichiflap.metrics.names import METRICS

pytestmark = pytest.mark.slow

DBET = str(CASES / "hawkmoth_dbet.toml")
SHORT = ["--set=time.periods=2", "--set=time.steps_per_period=40", "--set=dbet.elements=8"]


def on_terminal(*arguments, cwd):
    """Run a command whose stderr is a terminal; returns its output, and the terminal's text without control codes."""
    ours, its = pty.openpty()
    command = [sys.executable, "-m", "taichiflap", *arguments]
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "120"}
    with subprocess.Popen(command, cwd=cwd, env=environment, stdout=subprocess.PIPE, stderr=its, text=True) as process:
        os.close(its)
        shown = b""
        with contextlib.suppress(OSError):  # what the other end of a terminal says when it is closed
            while part := os.read(ours, 4096):
                shown += part
        os.close(ours)
        printed = process.stdout.read()
    assert process.returncode == 0, shown
    return printed, re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode())


def test_a_run_counts_its_beats(tmp_path):
    printed, shown = on_terminal("simulate", DBET, *SHORT, cwd=tmp_path)
    assert "Hawkmoth" in shown
    assert "preparing the kernel" in shown
    assert "beat 2 of 2" in shown
    assert "beat 2" not in printed


def test_a_sweep_counts_its_cases(tmp_path):
    printed, shown = on_terminal("sweep", DBET, *SHORT, "--vary=wing.modes=0,1,2", cwd=tmp_path)
    assert "0 of 3 cases" in shown
    assert "3 of 3 cases" in shown
    assert "3 complete, 0 failed" in printed


@pytest.fixture
def terminal(monkeypatch, capsys):
    """As on_terminal, in this process: yields what gives what was shown."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    return lambda: re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", capsys.readouterr().err)


def test_a_run_that_does_not_repeat_counts_its_seconds(terminal):
    case = taichiflap.load_case(CASES / "pitch_ramp.toml")
    with progress.bar(case) as update:
        update(case.steps // 2, case.steps)
    assert f"{case.steps // 2 * case.step:.4g} of {case.duration:.4g} s" in terminal()


def test_a_long_title_leaves_room_for_the_count_and_the_time_left(terminal, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    with progress.cases(
        "The wing of a moth, of every stiffness and at every pitch amplitude that a moth may have"
    ) as tell:
        tell(0, 10_000, 0.0)
        tell(4_632, 10_000, 0.46)
    last = [line for line in terminal().replace("\r", "\n").splitlines() if "4,632" in line][-1]
    assert re.search(r"The wing of a.*… .* 4,632 of 10,000 cases, \S+ a second (\d\d:\d\d|--:--)\s*$", last), last
    assert len(last.rstrip()) <= 80


def test_a_share_is_shown_in_percent(terminal):
    with progress.share("much") as done:
        done(0.25)
    assert re.search(r"much .* 25 %", terminal())


def app(*arguments):
    """Run a command in this process; its exit code."""
    return cli.app([*map(str, arguments)], standalone_mode=False) or 0


def test_converge_tells_its_trials_and_its_verdict(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert app("converge", DBET, *SHORT, "--tolerance=20%", "--metric=power_mean") == 0
    said = capsys.readouterr().out
    assert "dbet.elements" in said
    assert "hawkmoth_dbet-converge" in said
    assert (tmp_path / "hawkmoth_dbet-converge.h5").exists()
    assert [file.suffix for file in sorted(tmp_path.glob("*.[ps][nv]g"))] == [".png", ".svg"]


def test_what_does_not_converge_is_exit_code_1(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "taichiflap.studies.runner.compute",
        lambda cases, *_: [Outcome(dict.fromkeys(METRICS, float(one.dbet.elements))) for one in cases],
    )
    assert app("converge", DBET, *SHORT, "--metric=power_mean") == 1
    assert "NOT converged to 1 % at the finest value: dbet.elements" in capsys.readouterr().out


def optimise(*more):
    range_ = "--vary=wing.youngs_modulus=1e10:4e10"
    return app("optimise", DBET, *SHORT, range_, "--generations=2", "--population=5", *more)


def test_optimise_tells_its_generations_and_the_best(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert optimise("--minimise=tip_peak_mean") == 0
    said = capsys.readouterr().out
    assert "generation   2:" in said
    assert "wing.youngs_modulus" in said
    assert optimise("--minimise=tip_peak_mean", "--subject-to=tip_peak_mean >= 1", "-o", "none.h5") == 1


def test_an_interrupted_study_says_how_to_go_on(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("taichiflap.studies.runner.compute", interrupt)
    assert app("sweep", DBET, *SHORT, "--vary=wing.modes=0,1") == 130
    said = capsys.readouterr().err
    assert said.splitlines()[-1] == (
        "interrupted: hawkmoth_dbet-map.h5 keeps every finished batch; the same command continues"
    )


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_ctrl_c_that_python_drops_is_heard_by_the_next_block():
    class Deaf:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    told = []
    with interrupts.heard(told.append) as update:
        update(1)
        Deaf()
        told.append("still here")
        with pytest.raises(KeyboardInterrupt):
            update(2)
    assert told == [1, "still here"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_who_ignores_ctrl_c_still_does():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts.heard() as update:
            signal.raise_signal(signal.SIGINT)
            update(1)
    finally:
        signal.signal(signal.SIGINT, before)
