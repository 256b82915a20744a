"""Digests of two short runs: any change of a bit fails the test, intended or not."""

import hashlib
import platform
from pathlib import Path

import pytest
from conftest import PAPERS_BLADES, hawkmoth

import taichiflap

SHORT = ("time.periods=2", "time.steps_per_period=100", "uvlm.panels=12", "wing.modes=2")
CASES = {"uvlm": SHORT, "dbet": (*SHORT, "solver=dbet", *PAPERS_BLADES)}
DIGESTS = {
    ("GenuineIntel 6 avx512", "uvlm"): "5fd646ef5c9cf554ac42f7c22339a5f9660468093848da1d18f4b6701ed012b3",
    ("AuthenticAMD 25", "uvlm"): "5fd646ef5c9cf554ac42f7c22339a5f9660468093848da1d18f4b6701ed012b3",
    ("AuthenticAMD 25", "dbet"): "98493cb49fc8e317c47e934ae5c966d94a53992cb2e38c6b1e16f89ccce82525",
}
"""By processor and solver: on another family of processors the libraries round otherwise, and the test is skipped."""
MOVED = """The bits of a {solver} run have changed on {processor}:
{found}
If a change of the physics, the arithmetic or its order was meant, say so in CHANGELOG.md, check that the numbers of
tests/test_cases.py hold, and put the digest above into tests/test_digest.py. If not, find the change that did it, for
instance by git bisect with this test. A new NumPy, SciPy or Taichi may move the last bits as well."""


def processor():
    """Vendor and family of the processor; arithmetic and libraries are the same within a family."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    said = {name.strip(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    wide = "avx512f" in said.get("flags", "").split()
    return f"{said.get('vendor_id', platform.machine())} {said.get('cpu family', '')}{' avx512' if wide else ''}"


def digest(case, threads):
    with taichiflap.simulate(case, threads=threads) as result:
        found = hashlib.sha256()
        for name in ("q", "force_y", "force_z", "moment", "power"):
            found.update(getattr(result, name).tobytes())
    return found.hexdigest()


@pytest.mark.parametrize("solver", CASES)
def test_no_bit_has_moved(solver):
    case = hawkmoth(*CASES[solver])
    ours = digest(case, threads=1)
    assert digest(case, threads=2) == ours, "one thread and two give other bits"
    key = (processor(), solver)
    found = f'    ("{key[0]}", "{solver}"): "{ours}",'
    if key not in DIGESTS:
        pytest.skip(f"no digest is kept for this processor; to keep one add to DIGESTS:\n{found}")
    assert ours == DIGESTS[key], MOVED.format(solver=solver, processor=key[0], found=found)
