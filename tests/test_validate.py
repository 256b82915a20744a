"""The validation on reduced settings: its numbers, its verdicts, its report, its command."""

import numpy as np
import pytest
from conftest import CASES
from typer.testing import CliRunner

from taichiflap import cli
from taichiflap.validation import (
    orders,
    oscillation,
    start,
    steady,
    structure,
    validate,
)
from taichiflap.validation import (
    report as validation_report,
)
from taichiflap.validation.checks import Chart, Check, Curve, Row, accurate, observed_order, papers

pytestmark = pytest.mark.slow


def errors(check):
    """Errors of a check's rows by setting."""
    return {row.setting: row.error for row in check.rows}


def test_steady_plate():
    check = steady.steady((accurate(10), accurate(), papers()))
    assert check.passed
    found = list(errors(check).values())
    assert max(map(abs, found[:3])) < 1e-7
    assert found[3] == pytest.approx(0.03, abs=0.005)
    uniform = next(curve for curve in check.charts[1].curves if curve.label == "uniform panels")
    assert uniform.y == pytest.approx([2.03], abs=0.01)


def test_camber_of_the_curve_itself_and_of_straight_panels():
    exact = 4 * np.pi * 0.01
    error = [steady.bent_lift(papers(panels), 0.01, 0.0) / exact - 1 for panels in (10, 50)]
    assert error == pytest.approx([-0.1, -0.02], abs=2e-3)
    check = steady.camber((accurate(10), accurate()))
    assert check.passed
    assert list(errors(check).values()) == pytest.approx([-0.0034, -0.0034, -0.02], abs=1e-3)


def test_added_mass():
    check = steady.added_mass((accurate(),))
    assert check.passed
    assert list(errors(check).values()) == pytest.approx([0.08, 0.12, 0.12, 0.16], abs=0.02)


def test_wagner():
    check = start.wagner(((accurate(), 0.02), (papers(), 0.02)))
    assert check.passed
    assert list(errors(check).values()) == pytest.approx([0.48, 0.3, 0.12, 0.05, 0.02], abs=0.04)
    assert check.charts[1].curves[1].y == pytest.approx([0.85, 0.47, 0.17, 0.06, 0.02], abs=0.02)


def test_theodorsen_and_garrick():
    lift, moment, thrust = oscillation.oscillation(frequencies=(0.5, 2.0), refined=(12, 24))
    assert lift.passed
    assert moment.passed
    assert thrust.passed
    found = errors(lift)
    assert found["plunge, k = 0.5, amplitude"] == pytest.approx(0.35, abs=0.05)
    assert found["plunge, k = 2, phase"] == pytest.approx(0.08, abs=0.05)
    assert found["pitch about quarter chord, k = 2, amplitude"] == pytest.approx(-0.09, abs=0.05)
    assert errors(moment)["plunge, k = 0.5, about quarter chord"] == pytest.approx(0.36, abs=0.1)
    uniform = {curve.label: curve.y[1] for curve in lift.charts[0].curves}
    assert uniform["pitch about quarter chord, uniform"] == pytest.approx(3.17, abs=0.03)
    assert len(thrust.rows) == 2 + 2 * 2 * 2
    for curve in lift.charts[-1].curves:
        assert curve.y[1] < 0.9 * curve.y[0]


def test_structure_and_vortices():
    for check in (structure.modes(), structure.vortices()):
        assert check.passed, errors(check)
    found = errors(structure.wet_frequency(steps=(200,)))
    assert len(found) >= 3
    assert max(map(abs, found.values())) < 0.1, found


def test_energy_balance_is_of_second_order():
    check = structure.energy(steps=(200, 400, 800))
    assert check.passed, errors(check)


def test_orders_of_the_blade_elements():
    for study in (orders.blade_steps, orders.elements, orders.modes):
        row, chart = study()
        assert row.passed, row
        assert len(chart.curves) == 2


def test_observed_order():
    assert observed_order([1, 0.5, 0.25], [3.0, 0.75, 0.1875]) == pytest.approx(2.0)
    assert Row.order("better than expected is no error", 3.0, 2.0).error == 0.0


def test_what_is_not_finite_does_not_pass():
    assert not Row.relative("blown up", float("nan"), 1.0, 3.0).passed


def made(measured):
    """A check of one row, and a chart."""
    x = np.array([1.0, 2.0])
    chart = Chart("Error <against> panels", "Panels", "Error (%)", (Curve("a", x, x / 10), Curve("b", x, x)), "xy")
    return Check(
        "made", "A <reference>", "From | a book.", (Row.relative("half | of it", measured, 1.0, 1.0),), (chart,)
    )


@pytest.fixture
def one_study(monkeypatch):
    def use(measured):
        monkeypatch.setattr(validate, "STUDIES", (("made", lambda: [made(measured)]),))

    return use


def test_command_prints_the_table_and_writes_the_report(tmp_path, one_study):
    one_study(1.005)
    ran = CliRunner().invoke(cli.app, ["validate", "-o", str(tmp_path / "report")])
    assert ran.exit_code == 0, ran.output
    assert "half | of it" in ran.stdout
    assert "1 of 1 rows pass" in ran.stdout
    names = {"validation.md", "validation.html", "validation-made.png", "validation-made.svg"}
    assert {file.name for file in (tmp_path / "report").iterdir()} == names
    text = (tmp_path / "report" / "validation.md").read_text()
    assert "| half \\| of it | 1.005 | 1 | 0.50 % | 1 | pass |" in text
    page = (tmp_path / "report" / "validation.html").read_text()
    assert "A &lt;reference&gt;" in page
    assert 'src="data:image/svg+xml;base64,' in page
    assert 'src="http' not in page


def test_command_fails_when_a_row_does(one_study):
    one_study(1.1)
    ran = CliRunner().invoke(cli.app, ["validate"])
    assert ran.exit_code == 1
    assert "FAIL" in ran.stdout
    assert "0 of 1 rows pass, 1 fail" in ran.stdout


def test_a_report_is_not_overwritten_by_accident(tmp_path):
    (tmp_path / "validation.md").write_text("mine")
    with pytest.raises(validation_report.files.OutputError, match="exists already; use --overwrite"):
        validation_report.check_folder(tmp_path, overwrite=False)
    validation_report.check_folder(tmp_path, overwrite=True)
    with pytest.raises(validation_report.files.OutputError, match="cannot be created"):
        validation_report.check_folder(CASES / "hawkmoth.toml", overwrite=True)
