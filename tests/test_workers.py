"""Studies in several processes give the same map, even if processes die."""

import dataclasses
import io
import subprocess
import sys

import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.errors import UserError
from taichiflap.maps.file import open_map
from taichiflap.studies import workers

SHORT = ("solver=dbet", "dbet.added_mass=true", "time.periods=3", "dbet.elements=8")
VARY = {"fluid.density": "1.0:1.4:6", "motion.pitch.amplitude_deg": "10:60:4"}


@pytest.fixture
def little(monkeypatch):
    """Start processes for few cases, and make small batches."""
    monkeypatch.setattr(workers, "SHARE", 5)
    monkeypatch.setattr(workers, "JOB", 2)
    monkeypatch.setattr(workers, "SMALLEST", 2)
    monkeypatch.setattr("taichiflap.studies.sweep.available_threads", lambda: 2)


def assert_same_maps(first, second):
    for name in first.data_vars:
        if name != "reason":
            np.testing.assert_array_equal(first[name].values, second[name].values, err_msg=name)


def test_what_is_worth_a_process(monkeypatch):
    short, long = hawkmoth("solver=dbet"), hawkmoth()
    assert workers.worth(short, 10_000, 2) == 2
    assert workers.worth(short, 2 * workers.SHARE, 64) == 2
    assert workers.worth(short, 2 * workers.SHARE - 1, 64) == 1
    assert workers.worth(long, 10_000, 2) == 1
    monkeypatch.setattr(sys, "executable", "/usr/bin/blender")
    assert workers.worth(short, 10_000, 2) == 1


@pytest.mark.slow
def test_a_study_in_two_processes_is_that_in_one(tmp_path, little, monkeypatch):
    case = hawkmoth(*SHORT)
    shared = []
    run = workers.shared
    monkeypatch.setattr(workers, "shared", lambda *how: shared.append(1) or run(*how))
    two = taichiflap.sweep(case, VARY, tmp_path / "two.h5", keep="series")
    assert shared
    one = taichiflap.sweep(case, VARY, tmp_path / "one.h5", keep="series", threads=1)
    assert len(shared) == 1
    assert_same_maps(one, two)
    assert np.all(two.status == 1)


class Killed(workers.Worker):
    """A process that ends at its first batch."""

    def send(self, *what):
        super().send(*what)
        self._process.kill()


class Failing(workers.Worker):
    """A process that receives an invalid task."""

    def __init__(self, study, come):
        super().__init__(dataclasses.replace(study, metrics=[[]]), come)


class Garbled(workers.Worker):
    """A process of whose answer something else is read."""

    def __init__(self, study, come):
        super().__init__(study, come)
        self._process.stdout.close()
        self._process.stdout = io.BytesIO(b"cnowhere\nnothing\n.")


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Killed, Failing, Garbled])
def test_what_a_process_has_not_done_is_done_here(tmp_path, little, monkeypatch, kind):
    monkeypatch.setattr(workers, "Worker", kind)
    two = taichiflap.sweep(hawkmoth(*SHORT), VARY, tmp_path / "two.h5", metrics=["power_mean"])
    one = taichiflap.sweep(hawkmoth(*SHORT), VARY, metrics=["power_mean"], threads=1)
    assert_same_maps(one, two)


def test_what_fails_here_leaves_no_process(little, monkeypatch):
    def broken(*_):
        raise UserError("as it says")

    begun = []
    monkeypatch.setattr("taichiflap.studies.runner.compute", broken)
    monkeypatch.setattr(workers.Worker, "__enter__", lambda self: begun.append(self) or self)
    with pytest.raises(UserError, match="as it says"):
        taichiflap.sweep(hawkmoth(*SHORT), VARY)
    assert [worker._process.poll() is not None for worker in begun] == [True]


SCRIPT = """
import sys
sys.path.insert(0, {root!r})
import taichiflap
from taichiflap.studies import sweep, workers
workers.SHARE, workers.JOB, workers.SMALLEST = 5, 2, 2
sweep.available_threads = lambda: 2
case = taichiflap.load_case({case!r}, {settings!r})
taichiflap.sweep(case, {vary!r}, {path!r})
print("done")
"""


@pytest.mark.slow
def test_a_script_from_standard_input_needs_no_guard(tmp_path):
    """Its processes do not import it."""
    path, file = tmp_path / "map.h5", str(CASES / "hawkmoth.toml")
    script = SCRIPT.format(root=str(CASES.parent), case=file, settings=SHORT, vary=VARY, path=str(path))
    ended = subprocess.run([sys.executable, "-"], input=script, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout == "done\n"
    with open_map(path) as sheet:
        assert len(sheet.pending) == 0
