"""An external fluid model: the example compared with theory, and errors for invalid models."""

import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import assert_columns_agree, hawkmoth, march

import taichiflap
from taichiflap import fluids, theory
from taichiflap.case.case import CaseError, parse_case
from taichiflap.cli import main
from taichiflap.errors import UserError

EXAMPLES = Path(__file__).parent.parent / "examples"
CHORD, SPAN, SPEED, AIR = 0.1, 0.3, 2.0, 1.2
STEPS = 200


@pytest.fixture(autouse=True)
def _beside_the_examples(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))


def plate(k, plunge=0.0, pitch=0.0, **more):
    """A plate in a stream, amplitudes in chords and radians; a quarter of the chord lies ahead of its pivot."""
    frequency = k * SPEED / (np.pi * CHORD)
    return parse_case(
        {
            "solver": "module:theodorsen",
            "wing": {"chord": CHORD, "span": SPAN, "thickness": 1e-3, "density": 1e3, "modes": 0, "pivot": 0.25},
            "motion": {
                "frequency": frequency,
                "plunge": {"amplitude": plunge * CHORD},
                "pitch": {"amplitude_deg": np.degrees(pitch)},
            },
            "fluid": {"velocity": [SPEED, 0.0], "density": AIR},
            "time": {"periods": 8, "steps_per_period": STEPS},
            **more,
        }
    )


def amplitude(series):
    """Complex amplitude of the last period, of `sin(omega t)`."""
    last = series[-STEPS:]
    return 2.0 * np.mean(last * np.exp(-2j * np.pi * np.arange(1, STEPS + 1) / STEPS)) * 1j


def jones(k):
    """The C(k) that the model's two lags amount to."""
    return 1.0 - sum(a * 1j * k / (1j * k + b) for a, b in ((0.165, 0.0455), (0.335, 0.3)))


@pytest.mark.parametrize("k", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("motion", [{"plunge": 0.01}, {"pitch": 0.01}])
def test_the_third_model_gives_theodorsens_loads(k, motion, monkeypatch):
    with taichiflap.simulate(plate(k, **motion)) as result:
        pressure = SPAN * CHORD / 64 * result.pressure_jump.sum(axis=1)
        np.testing.assert_allclose(pressure, result.force_normal, rtol=1e-4, atol=1e-6 * np.ptp(result.force_normal))
        scale = 0.5 * AIR * SPEED**2 * CHORD * SPAN
        ours = np.array([-amplitude(result.force_normal), CHORD**-1 * amplitude(result.moment)]) / scale
    exact = {"plunge": -motion.get("plunge", 0.0), "pitch": motion.get("pitch", 0.0), "axis": 0.25}
    assert np.abs(ours / theory.oscillating_loads(k, **exact) - 1.0).max() < 0.03
    monkeypatch.setattr(theory.classical, "theodorsen", jones)
    assert np.abs(ours / theory.oscillating_loads(k, **exact) - 1.0).max() < 0.002


def test_a_bending_wing_agrees_with_the_lattice_where_both_are_linear():
    bent = {"modes": 1, "youngs_modulus": 2e8, "pivot": 0.0}
    common = {"wing": {**plate(0.3).to_dict()["wing"], **bent}, "time": {"periods": 5, "steps_per_period": 100}}
    tips = [taichiflap.simulate(plate(0.3, plunge=0.01, solver=name, **common)).tip_deflection for name in MODELS]
    linear, lattice = (tip[-100:] for tip in tips)
    assert np.abs(lattice).max() > 1e-5
    assert np.abs(linear - lattice).max() < 0.05 * np.abs(lattice).max()


MODELS = ("module:theodorsen", "uvlm")


def test_alone_or_in_a_batch_it_gives_the_same_bits():
    case = hawkmoth("solver=module:theodorsen", "fluid.velocity=[3.0, 0.0]", "wing.modes=3", "time.periods=2")
    alone, _ = march(case, block=77)
    (together, _), _ = march([case, case.override("wing.modes=1")])
    for name in ("q", "force", "pressure_jump"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(together, name))


def test_its_added_mass_does_not_depend_on_the_step():
    """Strong coupling: a wing of a fiftieth of the air that moves with it still converges at second order."""
    settings = (
        "solver=module:theodorsen",
        "wing.density=10.0",
        "fluid.velocity=[3.0, 0.0]",
        "motion.plunge.amplitude=1e-4",
    )
    quiet = hawkmoth(*settings, "motion.pitch.amplitude_deg=0.0", "time.periods=2", "wing.youngs_modulus=1e9")
    coarse, middle, fine = (
        march(quiet.override(f"time.steps_per_period={n}"))[0].q[:: n // 100, 0] for n in (200, 400, 800)
    )
    assert np.linalg.norm(coarse - fine) > 3.0 * np.linalg.norm(middle - fine) > 0.0
    assert_columns_agree(middle, fine, 0.05)


def test_numbers_reach_the_model_and_unknown_ones_are_refused():
    steady = {"motion": {"pitch": {"mean_deg": 1.0}}, "time": {"duration": 0.1, "step": 0.01}}
    half = plate(0.3, numbers={"lift_slope": np.pi}, **steady)
    ours = [taichiflap.simulate(case).force_normal[-1] for case in (plate(0.3, **steady), half)]
    assert ours[0] == pytest.approx(2.0 * ours[1], rel=1e-6)
    with pytest.raises(UserError, match="lift_slope"):
        taichiflap.simulate(plate(0.3, numbers={"slope": 6.0}))


@pytest.mark.parametrize(
    ("name", "phrases"),
    [
        ("module:no_such_model", ["cannot find the module no_such_model", "PYTHONPATH"]),
        ("module:json.no_such_model", ["cannot find the module json.no_such_model"]),
        ("module:json", ["is not a fluid model", "MODEL", "interface"]),
    ],
)
def test_what_is_no_model_is_refused_in_a_sentence(name, phrases, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    case = EXAMPLES.parent / "cases" / "hawkmoth.toml"
    monkeypatch.setattr(
        sys, "argv", ["taichiflap", "simulate", str(case), "--set", f"solver={name!r}".replace("'", '"')]
    )
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    told = capsys.readouterr().err
    assert f'solver = "{name}"' in told
    assert all(phrase in told for phrase in phrases)
    assert not list(tmp_path.iterdir())


def test_an_error_within_a_model_is_not_hidden(monkeypatch, tmp_path):
    (tmp_path / "broken_model.py").write_text("import no_such_library\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(ModuleNotFoundError, match="no_such_library"):
        fluids.load("module:broken_model")


def test_a_result_opens_where_its_model_is_not(tmp_path, monkeypatch):
    taichiflap.simulate(plate(0.3, time={"periods": 1, "steps_per_period": 20}), tmp_path / "run.h5").close()
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place != str(EXAMPLES)])
    monkeypatch.delitem(sys.modules, "theodorsen")
    with taichiflap.open_result(tmp_path / "run.h5") as result:
        assert result.case.model == "THEODORSEN"


def test_a_misspelt_name_gets_both_ways_to_name_a_model():
    for wrong in ("uvml", "module:", "module:a-b", "theodorsen.model"):
        with pytest.raises(CaseError, match='"uvlm" or "dbet" or "navier_stokes" or "module:NAME"') as error:
            hawkmoth(f'solver="{wrong}"')
        assert wrong in str(error.value)
