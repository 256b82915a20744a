"""A few of the inputs of `make fuzz`, and hostile files made by hand."""

import random
import re
from pathlib import Path

import fuzz
import h5py
import numpy as np
import pytest

import taichiflap
from taichiflap.errors import UserError
from taichiflap.maps import file as maps
from taichiflap.results import hdf


@pytest.mark.slow
def test_input_is_refused_with_its_key_or_makes_sense(tmp_path):
    found = fuzz.try_input(400, random.Random(20261127), tmp_path)
    assert found["case refused"] > 50
    assert found["case accepted"] > 10
    assert found["table accepted"]
    assert found["sweep refused"]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return fuzz.good_files(tmp_path_factory.mktemp("good"))


@pytest.mark.slow
def test_damaged_files_are_read_or_refused(tmp_path, good):
    rng = random.Random(20201122)
    path = tmp_path / "damaged.h5"
    found = set()
    for _ in range(30):
        path.write_bytes(fuzz.damaged(rng.choice(good), rng))
        found.add(fuzz.try_file(path, tmp_path))
    assert found <= {"accepted", "refused"}


def replaced(file, name, *arguments, **options):
    del file[name]
    return file.create_dataset(name, *arguments, **options)


def external(file):
    replaced(file, "time", (41,), "f8", external=[("/etc/hostname", 0, 8 * 41)])


def elsewhere(file):
    del file["time"]
    file["time"] = h5py.ExternalLink("/etc/hostname", "time")


def virtual(file):
    layout = h5py.VirtualLayout((41,), "f8")
    layout[:] = h5py.VirtualSource("other.h5", "time", (41,))
    del file["time"]
    file.create_virtual_dataset("time", layout)


HOSTILE = {
    "a million million numbers": lambda file: replaced(file, "power", (10**12,), "f8", chunks=(1024,)),
    "a compressed nothing": lambda file: replaced(file, "plunge", (41,), "f8", chunks=(41,), compression=9),
    "text for numbers": lambda file: replaced(file, "pitch", data=np.array(["x"] * 41, dtype=object)),
    "a group for numbers": lambda file: (file.__delitem__("pitch"), file.create_group("pitch")),
    "complex numbers": lambda file: replaced(file, "pitch", (41,), "c16"),
    "bytes of another file": external,
    "a link to another file": elsewhere,
    "a view of another file": virtual,
    "a link to nowhere": lambda file: (file.__delitem__("time"), file.__setitem__("time", h5py.SoftLink("/time"))),
    "an endless title": lambda file: file.attrs.create("title", np.zeros(1000)),
    "a status of its own": lambda file: file.attrs.modify("status", np.bytes_(b"perfect")),
    "time from elsewhere": lambda file: file["time"].write_direct(np.linspace(0.0, 1e300, 41)),
    "a frame out of time": lambda file: file["time"].__setitem__(7, 1e30),
    "a frame twice": lambda file: file["time"].__setitem__(7, file["time"][8]),
    "forces that are none": lambda file: file["force_y"].__setitem__(20, np.nan),
    "forces beyond measure": lambda file: file["force_y"].__setitem__(20, 1e200),
    "no wing": lambda file: file.__delitem__("node"),
    "a shorter wake": lambda file: replaced(file["wake"], "y", (3,), "f4"),
}


@pytest.mark.parametrize("trick", HOSTILE)
def test_a_hostile_file_is_refused_in_a_sentence(trick, tmp_path, good):
    path = tmp_path / "hostile.h5"
    path.write_bytes(good[0])
    with h5py.File(path, "r+", track_order=True) as file:
        HOSTILE[trick](file)
    with pytest.raises(UserError, match=r"hostile\.h5: (damaged|not a|this HDF5 file is not a)") as caught:
        fuzz.read(path, tmp_path)
    assert "\n" not in str(caught.value)


def test_text_in_a_file_cannot_steer_the_terminal(tmp_path, good):
    path = tmp_path / "run.h5"
    path.write_bytes(good[0])
    with h5py.File(path, "r+") as file:
        case = file.attrs["case"].decode().replace('title = "', 'title = "\x7f')
        hdf.note(file, {"title": "\x1b[2Jcleared", "warnings": "\x1b]0;title\x07", "case": case})
    with taichiflap.open_result(path) as result:
        said = "\n".join(taichiflap.commands.summary.summary_lines(result)) + str(result.attributes)
    assert "\x1b" not in said
    assert "\x07" not in said


def test_a_map_of_impossible_size_is_refused(tmp_path, good):
    path = tmp_path / "map.h5"
    path.write_bytes(good[1])
    with h5py.File(path, "r+") as file:
        replaced(file, "status", (10**6, 10**6), "i1", chunks=(64, 64))
    with pytest.raises(maps.MapError, match=r"damaged: status has shape"):
        maps.open_map(path)


def test_no_reader_needs_the_heap_of_texts(tmp_path, good):
    """HDF5 loops endlessly if that heap is damaged."""
    for whole in good:
        data = bytearray(whole)
        heaps = [found.start() for found in re.finditer(b"GCOL", whole)]
        assert heaps  # what dimensions have which scale stands there, for other programs
        for heap in heaps:
            data[heap + 16 : heap + 80] = bytes(64)
        path = tmp_path / "run.h5"
        path.write_bytes(data)
        assert fuzz.try_file(path, tmp_path) == "accepted"


def test_a_text_of_varying_length_is_refused(tmp_path, good):
    path = tmp_path / "run.h5"
    path.write_bytes(good[0])
    with h5py.File(path, "r+") as file:
        file.attrs["title"] = "of another program"
    with pytest.raises(UserError, match=r"damaged: title is text of variable length"):
        taichiflap.open_result(path)


def test_no_code_comes_from_a_file():
    """Nothing in the package evaluates text, loads pickles or starts a shell."""
    package = Path(taichiflap.__file__).parent
    viewer = package.parent / "viewer"
    risky = re.compile(r"\b(eval|exec)\(|\bpickle\b|\bmarshal\b|allow_pickle=True|yaml\.load|shell=True|os\.system")
    # What a worker unpickles comes through a pipe from the process that started it, and from no file.
    pipes = package / "studies" / "workers.py"
    for path in (*package.rglob("*.py"), *viewer.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        assert not risky.search(text.replace("pickle", "") if path == pipes else text), path
