"""What spares Taichi work at the start finds what its own way finds."""

import inspect

import pytest

from taichiflap import absorb, body, haste, lattice, linear, march, slip, vortex, wake
from taichiflap.fluids import dbet, uvlm


@pytest.mark.parametrize("module", [absorb, body, lattice, linear, march, slip, vortex, wake, dbet, uvlm])
def test_sources_are_those_that_inspect_finds(module):
    functions = [inspect.unwrap(one) for one in vars(module).values() if hasattr(one, "_is_taichi_function")]
    functions = [one for one in functions if one.__module__ == module.__name__]
    assert functions
    for function in functions:
        assert haste._source(function) == inspect.getsourcelines(function)


def test_a_function_without_a_file_is_left_to_inspect():
    made: dict = {}
    exec(compile("def nowhere(): pass", "<nowhere>", "exec"), made)
    with pytest.raises(OSError, match="source"):
        haste._source(made["nowhere"])


def test_a_kernel_in_a_class_is_told_from_one_in_a_function():
    class Holder:
        inside = haste._inside_class(1)

    assert Holder.inside
    assert not haste._inside_class(1)
    assert not haste._inside_class(100_000)
