"""How numbers are written for people."""

import math

import numpy as np
import pytest

from taichiflap.notation import engineering, prefixed, short


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (24.5e9, "24.5e9"), (-60e9, "-60e9"), (4e-5, "40e-6"), (0.001, "0.001"), (0.0, "0.0"), (25.0, "25.0"),
        (1e6, "1e6"), (5e-324, "5e-324"), (math.inf, "inf"), (math.nan, "nan"), (3, "3"),
    ],
)  # fmt: skip
def test_large_and_small_numbers_have_exponents_in_threes(value, text):
    assert engineering(value) == text


def test_a_number_reads_back_as_the_same():
    rng = np.random.default_rng(0)
    for value in (rng.choice([-1, 1], 500) * 10.0 ** rng.uniform(-300, 300, 500)).tolist():
        assert float(engineering(value)) == value


@pytest.mark.parametrize(
    ("size", "factor", "unit"),
    [
        (0.031, 1e3, "mN"), (-0.99, 1e3, "mN"), (1.5e-5, 1e6, "µN"), (1e-8, 1e9, "nN"), (1.0, 1.0, "N"),
        (2e4, 1e-3, "kN"), (0.0, 1e3, "mN"), (math.nan, 1e3, "mN"), (math.inf, 1e3, "mN"),
    ],
)  # fmt: skip
def test_a_unit_suits_what_is_shown_in_it(size, factor, unit):
    assert prefixed(size, "N") == (factor, unit)


@pytest.mark.parametrize(
    ("value", "text"), [(60e9, "60e9"), (44.95801803, "44.96"), (15.0, "15"), (7, "7"), ("uvlm", "uvlm")]
)
def test_a_short_number_has_four_digits(value, text):
    assert short(value) == text
