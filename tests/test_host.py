"""taichiflap inside a program with its own Taichi, threads or processes: it works, or states why not."""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.kernels.runtime import ProgramError, check_threads
from taichiflap.studies.converge import converge
from taichiflap.studies.optimise import optimise

ROOT = Path(__file__).parent.parent
SHORT = ("solver=dbet", "wing.modes=1", "time.periods=1", "time.steps_per_period=20")
BEGIN = f"""
import multiprocessing, threading
import numpy as np
import taichi as ti
import taichiflap
from taichiflap.run import blocks

CASE = taichiflap.load_case({str(ROOT / "cases" / "hawkmoth.toml")!r}, {SHORT!r})
ALIKE = dict(arch=ti.cpu, default_fp=ti.f64, fast_math=False, real_matrix_scalarize=False)

def run(progress=None):
    return float(np.mean(taichiflap.simulate(CASE, progress=progress).force_vertical))

def held():
    field = ti.field(ti.f64, shape=4)
    field.fill(2.0)
    return field

def intact(field):
    return (field.to_numpy() == 2.0).all()

def refusal(*arguments):
    try:
        run(*arguments)
    except ValueError as error:
        return str(error)
    return "not refused"
"""


def play(script):
    """Run a script in a separate process."""
    code = BEGIN + textwrap.dedent(script)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=100, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_fields_of_a_host_survive_or_the_run_is_refused():
    play(
        """
        ti.init(**ALIKE)
        field = held()
        first = run()
        assert intact(field)
        ti.init(**ALIKE)  # between two runs
        field = held()
        assert run() == first and intact(field)
        ti.reset()
        assert run() == first
        blocks.BLOCK_STEPS = 8
        assert "called during a run" in refusal(lambda *_: ti.init(**ALIKE))
        for other in ({"default_fp": ti.f32}, {"fast_math": True}):
            ti.init(**ALIKE | other)
            field = held()
            said = refusal()
            assert "in a process of its own" in said and "initialise it there with ti.init(arch=" in said
            assert intact(field)
        """
    )


@pytest.mark.slow
def test_threads_may_begin_together_and_a_fork_after_them_is_refused():
    play(
        """
        found = []
        threads = [threading.Thread(target=lambda: found.append(run())) for _ in range(4)]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
        assert len(found) == 4 and set(found) == {run()}
        with multiprocessing.get_context("fork").Pool(1) as pool:
            assert '"spawn"' in pool.apply(refusal)
        """
    )


@pytest.mark.parametrize("threads", [0, -2, 1.5, True, "2"])
def test_a_number_of_threads_is_a_whole_number_above_zero(threads):
    with pytest.raises(ProgramError, match=r"must be a whole number >= 1"):
        check_threads(threads)


def test_no_study_takes_zero_threads(tmp_path):
    case = hawkmoth(*SHORT)
    vary, output = {"motion.pitch.amplitude_deg": "5:45"}, tmp_path / "study.h5"
    for study in (
        lambda: taichiflap.simulate(case, output, threads=0),
        lambda: taichiflap.sweep(case, {"wing.modes": [0, 1]}, output, threads=0),
        lambda: converge(case, 0.01, output, threads=0),
        lambda: optimise(case, vary, "power_mean", output=output, threads=0),
    ):
        with pytest.raises(ProgramError, match="threads = 0"):
            study()
    assert not list(tmp_path.iterdir())
