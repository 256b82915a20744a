"""Loads of the lattice compared with the momentum of its flow, which is independent of pressure."""

import numpy as np
import pytest
from conftest import hawkmoth

from taichiflap.validation import momentum

pytestmark = pytest.mark.slow

ACCURATE = (
    "uvlm.panels=20", "uvlm.spacing=cosine", "uvlm.loads=vortices", "uvlm.shedding=local",
    "uvlm.convection=second_order", "uvlm.core=0.02", "uvlm.core_growth=0.1", "uvlm.wake=all", "uvlm.suction=true",
    "time.periods=1",
)  # fmt: skip


def second_half(steps, *settings):
    """Balance of a first beat of `steps`, and the steps at which its second half begins and ends."""
    found = momentum.balance(hawkmoth(*ACCURATE, f"time.steps_per_period={steps}", *settings))
    return found, steps // 2, steps - 2


@pytest.mark.parametrize("modes", [0, 1, 3])
def test_force_and_moment_are_the_rate_of_impulse(modes):
    """Exact as the step goes to zero: the shed vorticity stands at 0.3 of a step's path, an error of first order."""
    errors = [
        found.error(first, last)
        for found, first, last in (second_half(steps, f"wing.modes={modes}") for steps in (100, 200))
    ]
    assert np.all(errors[1] < 0.03)
    assert np.all(errors[1] < 0.6 * errors[0])


def test_means_agree_in_the_limit_of_small_steps():
    """The difference is of first order; extrapolated from two steps it nearly vanishes."""
    gaps = []
    for steps in (200, 400):
        found, first, last = second_half(steps)
        by_momentum, by_loads = found.means(first, last)
        gaps.append((by_loads - by_momentum)[:2] / np.abs(by_loads[:2]))
    assert np.all(np.abs(gaps[0]) < 0.02)
    assert np.all(np.abs(2.0 * gaps[1] - gaps[0]) < 0.002)


def test_whole_panels_miss_the_momentum_of_a_bent_wing():
    """The paper's Eq. 33 neglects the velocity of the bound vortices along a bent wing; the error does not converge."""
    ours, whole = (second_half(200, f"uvlm.loads={loads}") for loads in ("vortices", "panels"))
    finer = second_half(400, "uvlm.loads=panels")
    assert whole[0].error(*whole[1:])[1] > 4.0 * ours[0].error(*ours[1:])[1]
    assert finer[0].error(*finer[1:])[1] > 0.8 * whole[0].error(*whole[1:])[1]


def test_a_wing_without_suction_lacks_just_that():
    """The suction does not change the flow of a rigid wing, only the force along the chord."""
    rigid = "wing.modes=0", "motion.pitch.amplitude_deg=0.0"
    (without, first, last), (full, *_) = (
        second_half(200, *rigid, f"uvlm.suction={value}") for value in ("false", "true")
    )
    np.testing.assert_allclose(without.impulse, full.impulse, rtol=0, atol=1e-12 * np.abs(full.impulse).max())
    assert np.abs(without.load[:, 0]).max() < 1e-9 * np.abs(full.load[:, 0]).max()
    np.testing.assert_allclose(without.load[:, 1], full.load[:, 1], rtol=1e-9, atol=1e-12)
    assert full.error(first, last)[0] < 0.03


@pytest.mark.parametrize("setting", ["fluid.velocity=[1, 0]", "wing.span=[[0, 0.05], [1, 0]]", "uvlm.wake=200"])
def test_other_cases_have_no_such_balance(setting):
    with pytest.raises(ValueError, match="uniform span"):
        momentum.balance(hawkmoth(*ACCURATE, "uvlm.old_wake=drop", setting))
