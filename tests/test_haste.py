"""Patches that save time at the start of Taichi give the same results as Taichi's own code."""

import inspect
import sys

import pytest

from taichiflap import doors
from taichiflap.fluids.dbet import added_mass, attached, elements, loads, separated, strips
from taichiflap.fluids.dbet import flow as dbet
from taichiflap.fluids.uvlm import flow as uvlm
from taichiflap.fluids.uvlm import lattice, merging, tangential, wake
from taichiflap.kernels import linear, taichi_patches
from taichiflap.march import march
from taichiflap.march import state as body
from taichiflap.vortex import sum as vortex


@pytest.mark.parametrize(
    "module",
    [
        merging,
        body,
        lattice,
        linear,
        march,
        tangential,
        vortex,
        wake,
        dbet,
        uvlm,
        elements,
        attached,
        added_mass,
        loads,
        separated,
        strips,
    ],
)
def test_sources_are_those_that_inspect_finds(module):
    functions = [inspect.unwrap(one) for one in vars(module).values() if hasattr(one, "_is_taichi_function")]
    functions = [one for one in functions if one.__module__ == module.__name__]
    assert functions
    for function in functions:
        assert taichi_patches._source(function) == inspect.getsourcelines(function)


def test_a_function_without_a_file_is_left_to_inspect():
    made: dict = {}
    exec(compile("def nowhere(): pass", "<nowhere>", "exec"), made)
    with pytest.raises(OSError, match="source"):
        taichi_patches._source(made["nowhere"])


def test_a_kernel_in_a_class_is_told_from_one_in_a_function():
    class Holder:
        inside = taichi_patches._inside_class(1)

    assert Holder.inside
    assert not taichi_patches._inside_class(1)
    assert not taichi_patches._inside_class(100_000)


def test_a_late_module_is_loaded_at_its_first_use(monkeypatch):
    monkeypatch.delitem(sys.modules, "json.tool", raising=False)
    with doors.late("json.tool"):
        import json.tool  # noqa: PLC0415 - what is tested
    assert "json.tool" not in sys.modules
    assert callable(json.tool.main)
    assert json.tool is sys.modules["json.tool"]
