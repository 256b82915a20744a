"""Standard output and error that cannot be written to: the work is done, without a traceback."""

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.commands.standard_streams import Stream, settle

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("result") / "run.h5"
    case = hawkmoth("solver=dbet", "wing.modes=1", "time.periods=24", "time.steps_per_period=40")
    taichiflap.simulate(case, path).close()
    return path


def shell(line, **environment):
    """Run a command line in a shell, with this version of `taichiflap`."""
    line = line.replace("taichiflap", f"{sys.executable} -m taichiflap")
    return subprocess.run(
        ["bash", "-c", line], capture_output=True, timeout=60, check=False, cwd=ROOT, env=os.environ | environment
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "code", "said"),
    [
        ("taichiflap info {} >/dev/full", 1, b"error: standard output cannot be written: No space left on device\n"),
        ("taichiflap info {} >/dev/full 2>/dev/full", 1, b""),
        ("taichiflap info {} >&- 2>&-", 0, b""),
        ("taichiflap info {} | head -n 1 >/dev/null; exit ${{PIPESTATUS[0]}}", 0, b""),
        ("taichiflap info /nowhere.h5 2>/dev/full", 2, b""),
    ],
)
def test_a_stream_that_takes_nothing_is_a_sentence_at_most(line, code, said, result):
    done = shell(line.format(result))
    assert (done.returncode, done.stderr) == (code, said)


@pytest.mark.slow
def test_a_run_with_all_streams_closed_writes_its_file_and_nothing_into_it(tmp_path):
    case, path = tmp_path / "case.toml", tmp_path / "run.h5"
    case.write_text(hawkmoth("solver=dbet", "wing.modes=0", "time.periods=1").to_toml())
    assert shell(f"taichiflap simulate {case} -o {path} <&- >&- 2>&-").returncode == 0
    with taichiflap.open_result(path) as found:
        assert found.status == "complete"


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["ascii", "cp437"])
def test_an_encoding_that_lacks_letters_gets_plain_ones(encoding, result):
    done = shell(f"taichiflap info {result}", PYTHONIOENCODING=encoding)
    assert (done.returncode, done.stderr) == (0, b"")
    sign = "+-" if encoding == "ascii" else "±"
    assert f"(mean {sign} standard error" in done.stdout.decode(encoding)


def test_letters_without_a_plain_form_are_question_marks(monkeypatch):
    raw = io.BytesIO()
    for name in ("stdout", "stderr", "__stdout__", "__stderr__"):
        monkeypatch.setattr(sys, name, io.TextIOWrapper(raw if name == "stdout" else io.BytesIO(), "ascii"))
    settle()
    print("−3 ± 2 µm, 蛾, 20°", flush=True)
    assert raw.getvalue() == b"-3 +- 2 um, ?, 20 deg\n"


def test_the_first_failure_is_kept_and_later_writes_are_quiet():
    class Full(io.StringIO):
        def write(self, text):
            raise OSError(28, "No space left on device")

    stream = Stream(Full())
    assert stream.write("abc") == 3
    assert stream.failure.errno == 28
    stream.writelines(["a", "b"])
    stream.flush()
