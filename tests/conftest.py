"""Shared helpers: cases from the shipped files, and marches that keep all their frames."""

import collections
import contextlib
import os
import runpy
import signal
import tempfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from browsing import CHROMIUM, FLAGS, NODE, PORT, SECONDS

import taichiflap
from taichiflap import fluids
from taichiflap.errors import UserError
from taichiflap.march.march import March
from taichiflap.metrics import waves
from taichiflap.motion import sampling, waveforms
from taichiflap.structure import beam

CASES = Path(__file__).parent.parent / "cases"

PAPERS_BLADES = (
    "dbet.coefficients=reade_jankauski",
    "dbet.frame=chord",
    "dbet.added_mass=strip",
    "dbet.attached=false",
    "dbet.rotation=0.0",
)
"""The founding paper's blade elements."""

# This process and those that it starts watch their sockets.
SOCKETS = Path(__file__).parent / "sockets"
if "TAICHIFLAP_SOCKETS" not in os.environ:
    os.environ["TAICHIFLAP_SOCKETS"] = tempfile.mkstemp(prefix="sockets")[1]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (str(SOCKETS), os.environ.get("PYTHONPATH"))))
runpy.run_path(str(SOCKETS / "sitecustomize.py"))

# The same examples for every mutant, and no search for the smallest one that fails.
if "MUTANT_UNDER_TEST" in os.environ:
    import hypothesis

    hypothesis.settings.register_profile("mutants", derandomize=True, database=None, phases=[hypothesis.Phase.generate])
    hypothesis.settings.load_profile("mutants")

# A job started in the background by a shell ignores Ctrl-C, and so would the commands that the tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items):
    """Put the files with the most slow tests first, so that all processes end at about the same time."""
    slow = collections.Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])


def hawkmoth(*settings):
    """The hawkmoth with some keys changed."""
    return taichiflap.load_case(CASES / "hawkmoth.toml", settings)


def march(cases, threads=None, block=10**9):
    """March a case, or several, and return their frames joined over all blocks, and the march."""
    single = not isinstance(cases, list)
    cases = [cases] if single else cases
    marched = March(cases, fluids.load(cases[0].solver), threads)
    blocks = []
    while not marched.done:
        blocks.append(marched.advance(block))
    joined = []
    for i in range(len(cases)):
        found = {name.replace("/", "_"): np.concatenate([b[i][name] for b in blocks]) for name in blocks[0][i]}
        if "wake_y" in found:
            found["wake"] = np.stack([found[f"wake_{name}"] for name in ("y", "z", "circulation")])
        joined.append(SimpleNamespace(**found))
    return (joined[0] if single else joined), marched


def done(path):
    """Number of completed cases of a map; none while the file is missing or being written."""
    try:
        with taichiflap.open_map(path) as sheet:
            return sheet.design.size - len(sheet.pending)
    except UserError:
        return 0


@pytest.fixture
def rng():
    return np.random.default_rng(20201122)


def assert_columns_agree(ours, theirs, tolerance):
    """Assert that the difference of each column is within `tolerance` of its size, or round-off of the largest."""
    difference = np.abs(ours - theirs).max(axis=0, initial=0.0)
    size = np.abs(theirs).max(axis=0, initial=0.0)
    assert np.all(difference <= tolerance * size + 1e-15 * size.max(initial=0.0)), (difference, size)


@pytest.fixture(autouse=True, scope="session")
def _all_stays_on_this_machine():
    """Fail if any test, or any command that it runs, connects beyond the loopback interface."""
    yield
    noted = Path(os.environ["TAICHIFLAP_SOCKETS"]).read_text()
    assert not noted, noted


@pytest.fixture(autouse=True)
def _no_mutant_hides():
    """Clear caches: mutants run in forks of a process that has run the tests already."""
    if "MUTANT_UNDER_TEST" in os.environ:
        for module in (beam, waves, sampling, waveforms):
            for cached in vars(module).values():
                getattr(cached, "cache_clear", bool)()


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """Files of two beats of the hawkmoth by name: by each model, and of one with three modes; computed when asked."""
    folder = tmp_path_factory.mktemp("results")
    settings = {"uvlm": (), "dbet": ("solver=dbet",), "modes": ("wing.modes=3", "uvlm.wake=40")}
    settings["short"] = ("solver=dbet", "time.periods=1")

    def path(name):
        file = folder / f"{name}.h5"
        if not file.exists():
            taichiflap.simulate(hawkmoth("time.periods=2", *settings[name]), file).close()
        return file

    return path


@pytest.fixture(scope="module")
def browser():
    """A browser without a window."""
    sync = pytest.importorskip("playwright.sync_api", reason="NO BROWSER TESTED: playwright is not installed")
    with sync.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield opened
        opened.close()


@pytest.fixture
def serve(recorded):
    """Start viewers of recorded results; they stop with the test."""
    from taichiflap_viewer import Viewer  # noqa: PLC0415 - most tests do without

    with contextlib.ExitStack() as stack:

        def start(*names):
            viewer = Viewer([recorded(name) for name in names], port=PORT)
            stack.callback(viewer.stop)
            return viewer

        yield start


@pytest.fixture
def look(browser):
    """Open pages; a page error fails the test at its end."""
    errors = []
    contexts = []

    def open_page(address, context=None, node="/wing", text="Reset view", query="", **options):
        if context is None:
            context = browser.new_context(**{"viewport": {"width": 1280, "height": 720}} | options)
            contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(1e3 * SECONDS)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda message: message.type == "error" and errors.append(message.text))
        page.goto(f"{address}?fixedDpr=1{query}")
        page.wait_for_function(f"() => {NODE.format(node)}")
        page.get_by_text(text, exact=True).wait_for(state="attached")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []
