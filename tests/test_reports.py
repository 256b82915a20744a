"""The reports in the documentation agree with those that the commands write: rows, verdicts, and numbers.

`make reports` writes them again. Numbers are compared where that is cheap.
"""

import re
from pathlib import Path

import pytest

import taichiflap
from taichiflap import pages
from taichiflap._version import __version__
from taichiflap.published.reade2020 import models, models_page, paper
from taichiflap.published.reade2020.paper import Settings
from taichiflap.validation import oscillation, start, steady, structure
from taichiflap.validation.checks import accurate

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
VALIDATION = (ROOT / "docs" / "validation.md").read_text("utf-8")
REPRODUCTION = (ROOT / "docs" / "reproduction" / "report.md").read_text("utf-8")


def rows(page):
    """Cells of every line of a page's tables."""
    cells = [re.split(r"(?<!\\) ?\| ?", line)[1:-1] for line in page.splitlines() if line.startswith("|")]
    return [[cell.strip().replace(r"\|", "|") for cell in row] for row in cells]


def test_pages_are_of_this_version():
    assert f"version {__version__}:" in VALIDATION
    assert f"Version {__version__}." in REPRODUCTION


def test_validation_holds_what_the_studies_measure():
    cheap = (
        steady.steady(), steady.camber(), steady.added_mass(), structure.modes(), structure.wet_frequency(steps=(200,)),
        start.wagner(((accurate(), start.TRAVEL),)), *oscillation.oscillation(frequencies=(0.5,), refined=(8, 12)),
    )  # fmt: skip
    written = {row[0]: row for row in rows(VALIDATION)}
    for check in cheap:
        assert f"## {check.reference}" in VALIDATION
        for row in check.rows:
            _, measured, expected, _, tolerance, verdict = written[row.setting]
            assert float(measured) == pytest.approx(row.measured, rel=1e-3, abs=1e-9), row.setting
            assert float(expected) == pytest.approx(row.expected, rel=1e-5), row.setting
            assert float(tolerance) == row.tolerance
            assert verdict == ("pass" if row.passed else "FAIL")
    for picture in re.findall(r"\]\(([^)]*)\)", VALIDATION):
        assert (ROOT / "docs" / picture).is_file()


def test_reproduction_holds_the_papers_cases_as_they_come_out_now():
    written = {row[0]: row for row in rows(REPRODUCTION)}
    for solver in ("dbet", "uvlm"):
        cases = [paper.case(Settings(), solver, *more) for more in (("wing.modes=0",), ())]
        for wing, result in zip(("rigid", "flexible"), taichiflap.simulate(cases), strict=True):
            with result:
                summary = taichiflap.summarise(result)
            full, normal = (float(cell) for cell in written[f"{solver.upper()}, {wing}"][2:4])
            assert full == pytest.approx(1e3 * summary.force_vertical.mean, abs=0.006)
            assert normal == pytest.approx(1e3 * summary.force_vertical_normal.mean, abs=0.006)


def test_the_wing_in_every_model_is_what_was_kept_and_comes_out_now():
    known = models.known()
    written = (ROOT / "docs" / "reproduction" / "models.md").read_text("utf-8")
    assert written == pages.markdown(models_page.page_of(known))
    assert pages.markdown(models_page.closing(known)) in REPRODUCTION
    assert {key[0] for key in known} == {model.name for model in models.MODELS}
    assert all(one.beats >= 10 for one in known.values())
    wing = known["dbet", 15.0, 1]
    model = next(model for model in models.MODELS if model.name == wing.model)
    with taichiflap.simulate(model.case(wing.pitch, wing.modes)) as result:
        again = taichiflap.summarise(result)
    assert again.force_vertical.mean == pytest.approx(wing.force, rel=1e-3)
    assert again.tip_peak.mean == pytest.approx(wing.tip_peak, rel=1e-3)


def test_readme_counts_as_the_pages_do():
    readme = (ROOT / "README.md").read_text("utf-8")
    passed, everything = re.search(r"(\d+) of (\d+) rows pass", VALIDATION).groups()
    assert passed == everything
    assert f"with {everything} exact results" in " ".join(readme.split())
    found, compared = re.search(r"Verdicts: (\d+) of (\d+) reproduced", REPRODUCTION).groups()
    assert f"{found} of {compared} statements" in " ".join(readme.split())
