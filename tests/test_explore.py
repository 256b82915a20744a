"""Explore: keys as controls, a process shared by many browsers, and a page that follows its sliders."""

import contextlib
import math
import os
import signal
import threading
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest
import viser
from conftest import CASES, hawkmoth
from taichiflap_viewer.explore.change import BEATS, History, addressed, brief, changed, short_text
from taichiflap_viewer.explore.keys import CHOICE, FIRST, NUMBER, SWITCH, WHOLE, controls, value_of
from taichiflap_viewer.explore.viewer import Explorer
from taichiflap_viewer.explore.worker import BEGUN, ENDED, Worker, received
from test_viewer import CAMERA
from websockets.sync.client import connect

import taichiflap
from taichiflap.case.case import CaseError, load_case

pytestmark = pytest.mark.filterwarnings("ignore:Queued a .*:UserWarning")

SMALL = ("solver=dbet", "time.periods=2", "time.steps_per_period=40", "dbet.elements=8")


@pytest.mark.parametrize("name", ["hawkmoth", "hawkmoth_dbet", "graded_wing", "plunging_foil", "tabulated_stroke"])
def test_every_control_holds_the_value_of_the_case_and_stays_within_what_it_may_say(name):
    case = load_case(CASES / f"{name}.toml")
    found = controls(case)
    keys = [one.key for one in found]
    assert len(set(keys)) == len(keys)
    assert keys[: len([key for key in FIRST if key in keys])] == [key for key in FIRST if key in keys]
    for one in found:
        assert value_of(case, one.key) == one.value
        if one.kind == CHOICE:
            assert one.value in one.options
        if one.kind in (NUMBER, WHOLE):
            assert one.meant(one.shown(one.value)) == pytest.approx(one.value, rel=1e-11)
            low, high, step = one.slider()
            assert low < high
            assert step > 0
            for end in (low, high):
                value = one.meant(end)
                with contextlib.suppress(CaseError):
                    assert value_of(case.changed({one.key: value}), one.key) == value
                assert one.low - 1e-9 <= value <= one.high * (1 + 1e-9) + 1e-9


def test_what_matters_is_shown_in_units_that_suit_it():
    found = {one.key: one for one in controls(hawkmoth())} | {one.key: one for one in controls(hawkmoth("solver=dbet"))}
    modulus = found["wing.youngs_modulus"]
    assert (modulus.label, modulus.shown(24.5e9)) == ("Young's modulus, GPa", pytest.approx(24.5))
    assert found["motion.pitch.amplitude_deg"].slider()[:2] == (0.0, 90.0)
    assert found["motion.plunge.amplitude"].label == "Plunge amplitude, mm"
    assert {"dbet", "uvlm"} <= set(found["solver"].options)
    assert SWITCH in {one.kind for one in found.values()}
    assert "title" not in found
    assert not any(math.isinf(end) for one in found.values() if one.kind in (NUMBER, WHOLE) for end in one.slider())


def test_an_explored_case_has_a_few_beats_and_its_settings_lead_back_to_it():
    case = hawkmoth("time.periods=15")
    assert brief(case).time.periods == BEATS
    assert brief(hawkmoth("time.periods=2")).time.periods == 2
    for key, value in (("wing.youngs_modulus", 1.5e10), ("uvlm.suction", True), ("solver", "dbet")):
        assert value_of(case.override(f"{key}={short_text(value)}"), key) == value


def test_an_address_gives_plain_values_and_names_no_file_or_module():
    case = hawkmoth()
    found = addressed(case, ["solver=dbet", "wing.youngs_modulus=15e9", "dbet.elements=40"])
    assert (found.solver, found.wing.youngs_modulus, found.dbet.elements) == ("dbet", 15e9, 40)
    for one in (
        "solver=module:os", 'motion.plunge={kind="table",file="/etc/passwd"}', "motion.plunge.file=/etc/passwd",
        'motion.plunge."file"=x', " solver = 'module:os'", "wing.span=[[0,1],[1,2]]",
    ):  # fmt: skip
        with pytest.raises(CaseError, match="an address gives plain values"):
            addressed(case, [one])


def test_a_model_that_needs_a_viscosity_is_given_one_also_without_beats():
    for name, viscosity in (("hawkmoth", 1.5e-5), ("pitch_ramp", 1e-6)):
        case = load_case(CASES / f"{name}.toml")
        viscous = changed(case, {"solver": "navier_stokes"})
        assert viscous.fluid.viscosity == (case.fluid.viscosity or viscosity)
        assert viscous.steps > 0


def test_undo_and_redo_lead_through_the_cases_and_no_further():
    first, second, third = (hawkmoth(f"time.periods={number}") for number in (1, 2, 3))
    past = History(first)
    past.add(second)
    assert [past.undo(), past.undo(), past.redo(), past.redo()] == [first, first, second, second]
    past.undo()
    past.add(third)
    assert [past.redo(), past.undo()] == [third, first]


class Browser:
    """Answers of the worker to a browser."""

    def __init__(self, shared):
        self.heard, self.shared = {}, shared
        self.place = shared.enlist(lambda number, *answer: self.heard.update({number: answer}))

    def ask(self, case):
        return self.shared.ask(self.place, case)

    def wait(self, number):
        end = time.monotonic() + 60.0
        while number not in self.heard:
            assert time.monotonic() < end
            time.sleep(0.005)
        return self.heard[number]


@pytest.mark.slow
def test_the_worker_computes_what_simulate_does_and_gives_up_what_nobody_wants(monkeypatch):
    case = hawkmoth(*SMALL)
    shared = Worker(case, threads=1)
    try:
        first, second = Browser(shared), Browser(shared)
        path, reason, seconds = first.wait(first.ask(case))
        assert (reason, seconds > 0.0) == ("", True)
        with received(path) as found, taichiflap.simulate(case, threads=1) as expected:
            np.testing.assert_array_equal(found.force_z, expected.force_z)
        # A case that cannot be computed is a sentence, and the worker goes on.
        broken = case.changed({"wing.youngs_modulus": 1.0, "fluid.density": 0.0, "motion.frequency": 100.0})
        first.wait(first.ask(broken))
        # Of many wishes of one browser the first and the last at least are answered; another browser waits its turn.
        long = hawkmoth("solver=dbet", "time.periods=60", "time.steps_per_period=400")
        numbers = [first.ask(long.changed({"wing.damping_ratio": 0.01 * k})) for k in range(1, 6)]
        other = second.ask(case)
        path, reason, _ = second.wait(other)
        assert path is not None
        last = first.ask(case)
        path, reason, _ = first.wait(last)
        assert path is not None
        assert sum(number in first.heard for number in numbers) < len(numbers)
    finally:
        shared.close()
    assert not shared.alive


@pytest.mark.slow
def test_a_process_that_does_not_read_holds_nobody_up_and_one_that_ends_says_so():
    case = hawkmoth(*SMALL)
    shared = Worker(case, threads=1)
    try:
        browser = Browser(shared)
        assert shared.ready.wait(60.0)
        os.kill(shared._process.pid, signal.SIGSTOP)
        # Far more than a pipe holds.
        numbers = [browser.ask(case) for _ in range(1000)]
        os.kill(shared._process.pid, signal.SIGCONT)
        assert browser.wait(numbers[-1])[1] == ""
        shared._process.kill()
        until(lambda: (None, ENDED, 0.0) in list(browser.heard.values()))
        with pytest.raises(OSError, match="has ended"):
            browser.ask(case)
    finally:
        shared.close()


@pytest.mark.slow
def test_a_long_run_is_shown_as_it_is_computed_and_lets_others_go_first():
    long, short = hawkmoth("time.periods=6", "time.steps_per_period=400", "uvlm.wake=600"), hawkmoth(*SMALL)
    shared, order = Worker(short, threads=1), []
    try:
        slow, quick = (
            shared.enlist(lambda *answer, who=who: order.append((who, *answer))) for who in ("slow", "quick")
        )
        shared.ask(slow, long)
        until(lambda: order)
        who, _, path, reason, _ = order[0]
        assert (who, reason) == ("slow", BEGUN)
        with taichiflap.open_result(path) as begun:
            assert begun.status == "running"
        shared.ask(quick, short)
        until(lambda: len(order) == 3)
        assert [one[0] for one in order] == ["slow", "quick", "slow"]
        with received(order[2][2]) as found, taichiflap.simulate(long, threads=1) as expected:
            np.testing.assert_array_equal(found.force_z, expected.force_z)
    finally:
        shared.close()


@contextlib.contextmanager
def explored(folder, count):
    """An explorer with the sessions of several pages."""
    (folder / "case.toml").write_text(hawkmoth(*SMALL).to_toml())
    explorer = Explorer(folder / "case.toml", ["wing.modes=1"], threads=1, port=18800)
    try:
        with contextlib.ExitStack() as stack:
            for _ in range(count):
                address = explorer.address.replace("http", "ws", 1)
                page = stack.enter_context(
                    connect(address, subprotocols=[f"viser-v{viser.__version__}"], max_size=None, proxy=None)
                )
                page.send(msgspec.msgpack.encode(CAMERA))
                threading.Thread(target=lambda page=page: [None for _ in page], daemon=True).start()
            until(lambda: len(explorer.sessions) == count and all(one._started for one in explorer.sessions))
            yield explorer, explorer.sessions
        until(lambda: not explorer.sessions)
    finally:
        explorer.stop()


def settled(one):
    """Wait until a session shows the completed result of its request."""
    until(lambda: one.run.case == one.case.resolved() and not one.run.live and not one._wishes)


@pytest.mark.slow
def test_a_browser_changes_its_own_case(tmp_path, capfd):
    with explored(tmp_path, 2) as (explorer, (one, other)):
        folder, before = Path(explorer.worker._folder.name), one.run
        one._change({"wing.youngs_modulus": 12e9}, "wing.youngs_modulus")
        settled(one)
        assert (one.run.case.wing.youngs_modulus, other.run.case.wing.youngs_modulus) == (12e9, 24.5e9)
        with taichiflap.simulate(one.case, threads=1) as expected:
            np.testing.assert_array_equal(one.run.result.force_z, expected.force_z)
        assert one.pinned is before
        until(lambda: "youngs_modulus=12000000000.0" in one._line.content)
        assert "+" in one._numbers.content or "-" in one._numbers.content
        # Refused values are told, and change nothing.
        one._change({"wing.chord": -1.0}, "wing.chord")
        assert "data-notice" in one._message.content
        assert one.case.wing.chord == 0.02
        for step, modulus in ((one._undo, 24.5e9), (one._redo, 12e9)):
            step()
            settled(one)
            assert one.run.case.wing.youngs_modulus == modulus
        # An address of a colleague.
        one.act("address", {"set": one._address()["set"] + ";wing.modes=2"})
        settled(one)
        assert (one.run.case.wing.modes, one.run.case.wing.youngs_modulus) == (2, 12e9)
        one.sliders.find("added mass")
        assert one.sliders.handles["dbet.added_mass"][0].visible
    assert "Traceback" not in capfd.readouterr().err
    assert not folder.exists()


@pytest.mark.slow
def test_a_browser_compares_models_and_takes_other_cases(tmp_path, capfd):
    with explored(tmp_path, 1) as (_, (one,)):
        # Another model, other modes, a stream: the scene is built anew, and the controls are those of the case.
        for values in ({"wing.modes": 0}, {"fluid.velocity": (1.0, 0.0)}, {"solver": "uvlm", "uvlm.panels": 8}):
            one._change(values, "wing.modes")
            settled(one)
        assert one.run.has_wake
        # The page offers and shows what this model has, which DBET has not.
        assert one.playback.layers["wake"]
        assert one.panel.layers["wake"].value
        assert not one.panel.layers["wake"].disabled
        assert not one.panel.background.disabled
        assert "uvlm.panels" in one.sliders.keys
        one._pin()
        assert one.pinned is one.run
        # The second model goes along with every change, until there is none.
        one._set_second("dbet")
        one._change({"wing.youngs_modulus": 20e9}, "wing.youngs_modulus")
        settled(one)
        until(lambda: (one.pinned.case.solver, one.pinned.case.wing.youngs_modulus) == ("dbet", 20e9))
        assert one.run.case.solver == "uvlm"
        assert "DBET" in one._numbers.content
        one._set_second("none")
        assert one.pinned is one.run
        one._take_preset("hawkmoth_dbet")
        settled(one)
        assert "dbet.elements" in one.sliders.keys
        # The Navier-Stokes equations ask for a viscosity, which no other model needs.
        assert changed(one.case, {"solver": "navier_stokes"}).fluid.viscosity == 1.5e-5
    assert "Traceback" not in capfd.readouterr().err


def until(condition):
    end = time.monotonic() + 90.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)
