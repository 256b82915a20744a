"""The coupled march: energy, stability, limits, any number of modes, the same bits in any batch."""

import resource
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES, hawkmoth, march

import taichiflap
from taichiflap.kernels.arrays import octet_array
from taichiflap.kernels.runtime import available_threads, start, view
from taichiflap.march import loads
from taichiflap.march.state import MOMENT, RATE
from taichiflap.motion import sampling
from taichiflap.run import blocks


@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
@pytest.mark.parametrize("modes", range(9))
def test_runs_with_any_number_of_modes(solver, modes):
    case = hawkmoth(f"solver={solver}", f"wing.modes={modes}", "time.periods=1", "uvlm.panels=20")
    frames, marched = march(case)
    assert marched.failures().tolist() == [-1]
    assert frames.q.shape == (201, 3, modes)
    if modes:
        tip = np.abs(marched.sections[0].shape([0.02])[:, 0] @ frames.q[:, 0].T).max()
        assert 6e-3 < tip < 10e-3


@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
def test_a_stiffer_and_stiffer_wing_becomes_rigid(solver):
    short = (f"solver={solver}", "time.periods=1", "uvlm.panels=20", "uvlm.wake=all", "uvlm.core=0.1")
    rigid = march(hawkmoth(*short, "wing.modes=0"))[0].force[100:]
    errors = []
    for modulus in (1e12, 1e13):
        stiff, _ = march(hawkmoth(*short, "wing.modes=2", f"wing.youngs_modulus={modulus}", "wing.damping_ratio=1.0"))
        errors.append(np.abs(stiff.force[100:] - rigid).max() / np.abs(rigid).max())
    assert errors[1] < 5e-3
    assert errors[1] < errors[0] / 4


def energy_residual(solver, steps, *more):
    """Unaccounted fraction of the energy over the second of two beats."""
    case = hawkmoth(
        f"solver={solver}", "wing.modes=2", "time.periods=2", f"time.steps_per_period={steps}", "uvlm.panels=20",
        "uvlm.core=0.02", "wing.damping_ratio=[0.05, 0.2]", *more,
    )  # fmt: skip
    frames, marched = march(case)
    section, moved = marched.sections[0], marched.motion[0]
    state, force = frames.q, frames.force
    derived = loads.derive(case, section, np.array([0.0, 0.02]), moved, vars(frames))
    force_z, rate, theta_rate = derived["force_z"], moved[:, sampling.PLUNGE_RATE], moved[:, sampling.PITCH_RATE]
    by_fluid = force_z * rate + force[:, MOMENT] * theta_rate + derived["force_y"] * moved[:, sampling.SURGE_RATE]
    by_fluid += np.sum(frames.modal_force * state[:, RATE], axis=1)
    lost = np.sum(2 * section.damping_ratio * section.omega * state[:, RATE] ** 2, axis=1)
    energy = derived["energy"]
    flow = derived["power"] + by_fluid - lost
    beat = slice(steps, None)
    work = np.trapezoid(flow[beat], dx=case.step)
    scale = np.trapezoid(np.abs(derived["power"][beat]), dx=case.step)
    return abs(work - (energy[-1] - energy[steps])) / scale


@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
@pytest.mark.parametrize("more", [(), ("motion.surge={amplitude=0.008, phase_deg=40.0}",)])
def test_energy_balances_to_the_order_of_the_scheme(solver, more):
    coarse, fine = energy_residual(solver, 200, *more), energy_residual(solver, 800, *more)
    assert coarse < 2e-3
    assert fine < coarse / 8


def light_motion(solver, mass_ratio, steps):
    density = mass_ratio * 4 * 1000.0 * 40e-6 / (np.pi * 0.02)
    return hawkmoth(
        f"solver={solver}", f"fluid.density={density}", f"time.steps_per_period={steps}", "time.periods=2",
        "motion.plunge.amplitude=2e-4", "motion.pitch.amplitude_deg=0.15",
        "wing.modes=2", "uvlm.wake=all", "uvlm.core=0.02",
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("steps", [200, 1000])
@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
def test_stable_at_any_mass_ratio(solver, steps):
    ratios = (0.05, 0.5, 2.0, 4.0, 10.0)
    runs, marched = march([light_motion(solver, mu, steps) for mu in ratios])
    assert marched.failures().tolist() == [-1] * len(ratios)
    phi = marched.sections[0].shape([0.02])[:, 0]
    for mu, frames in zip(ratios, runs, strict=True):
        tip = phi @ frames.q[:, 0].T / 2e-4
        assert np.abs(tip).max() < 4.0 + mu, mu
        force = frames.force[steps:, 0]
        zigzag = np.abs(np.diff(force, 2)).max() / np.abs(force).max()
        assert zigzag < 0.01 * (200 / steps), (mu, zigzag)


def several_cases():
    """Cases that differ in all respects that a batch allows."""
    common = ("time.periods=1", "time.steps_per_period=60", "uvlm.core=0.02")
    return [
        hawkmoth(*common, f"uvlm.panels={panels}", f"uvlm.wake={wake}", f"wing.modes={modes}", *more)
        for panels, wake, modes, more in (
            (20, 30, 1, ()),
            (50, '"all"', 3, ("uvlm.shedding=local",)),
            (7, 9, 0, ("fluid.density=2.0",)),
            (33, 200, 2, ("time.steps_per_period=80", "output.every=7")),
            (1, 1, 1, ()),
            (12, 40, 8, ("wing.youngs_modulus=1e11", "wing.damping_ratio=0.5")),
            (20, 31, 1, ("motion.frequency=30.0",)),
            (9, 17, 4, ("fluid.velocity=[0.5, 0.1]",)),
        )
    ]


def assert_identical(first, second):
    for name, values in vars(first).items():
        np.testing.assert_array_equal(values, getattr(second, name), err_msg=name)


@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
def test_bits_do_not_depend_on_the_batch_the_threads_or_the_blocks(solver):
    cases = [case.override(f"solver={solver}") for case in several_cases()]
    together, _ = march(cases)
    reversed_on_one_thread, _ = march(cases[::-1], threads=1)
    for i, case in enumerate(cases):
        alone, _ = march(case, block=11)
        assert_identical(together[i], alone)
        assert_identical(together[i], reversed_on_one_thread[-1 - i])


def test_a_case_that_fails_stops_alone():
    good = hawkmoth("solver=dbet", "time.periods=1")
    spinning = ("wing.youngs_modulus=1.0", "motion.pitch.amplitude_deg=360.0", "motion.frequency=100.0")
    bad = good.override(*spinning, "fluid.density=0.0", "time.periods=60")
    runs, marched = march([good, bad])
    assert marched.failures()[0] == -1
    failed = marched.failures()[1]
    assert failed >= 0
    assert len(runs[1].step) == failed
    assert_identical(runs[0], march(good)[0])


SHARES = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from conftest import hawkmoth
from taichiflap import fluids
from taichiflap.march import March

def busy():
    return {{task.name: int((task / "schedstat").read_text().split()[0]) for task in Path("/proc/self/task").iterdir()}}

cases = [hawkmoth("time.periods=10", f"fluid.density={{1.0 + 0.01 * i}}") for i in range(8)]
marched = March(cases, fluids.load("uvlm"))
marched.advance(0)
best = 0.0
for _ in range(20):
    before = busy()
    marched.advance(100)
    spent = [after - before.get(name, 0) for name, after in busy().items()]
    best = max(best, sum(spent) / max(spent))
print(best)
"""


@pytest.mark.slow
@pytest.mark.skipif(available_threads() < 2, reason="this machine has one processor")
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="no /proc to read a thread's time from")
def test_a_batch_of_eight_keeps_two_threads_busy():
    """Processor time of all threads over that of the busiest: unlike wall time, other programs do not stretch it."""
    script = SHARES.format(tests=str(CASES.parent / "tests"))
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert float(ran.stdout) >= 1.7


def test_arrays_of_octets_are_given_back():
    """Taichi would keep all of them, and the memory of a study would grow."""

    def taken():
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()

    start()
    values = np.ones((500, 2048))  # 8 MB
    octet_array(values)
    before = taken()
    for _ in range(20):
        assert view(octet_array(values)).all()
    assert taken() - before < 40e6


def test_blocks_grow_however_long_their_choice_takes(monkeypatch):
    """Only the time of the march counts: else blocks of a model that is slow to tell its work shrink to one step."""
    clock, chosen, choose = [0.0], [], blocks._block

    def perf_counter():
        clock[0] += 1e-3
        return clock[0]

    def slowly(*given):
        clock[0] += 10.0
        chosen.append(choose(*given)[0])
        return choose(*given)

    monkeypatch.setattr(blocks, "time", types.SimpleNamespace(perf_counter=perf_counter))
    monkeypatch.setattr(blocks, "_block", slowly)
    taichiflap.simulate(hawkmoth("solver=uvlm", "time.periods=2", "time.steps_per_period=200"))
    assert len(chosen) < 10
    assert chosen[1:] == sorted(chosen[1:])
