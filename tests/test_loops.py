"""Loops counted in floating point pass as often as Python's, with the same numbers."""

import ast
import inspect
import itertools
import textwrap

import pytest

from taichiflap.kernels import loops


def visit(n, first, last):
    """Numbers of the passes of loops that are nested, skip and end early."""
    seen = []
    for i in range(n):
        if i == 3:
            continue
        for j in range(first, last):
            if j > i + 1:
                break
            for k in range(j, j + 2):
                seen.append(100 * i + 10 * j + k)
        for j in range(first * 2, last - 1):
            seen.append(-j)
    return seen


def counted(function):
    """The source of a function as Taichi reads it, as a Python function."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    named = {}
    tree.body = loops._counted(tree.body, itertools.count())
    exec(compile(tree, "counted", "exec"), named)
    assert not any(isinstance(node, ast.For) for node in ast.walk(tree))
    return named[function.__name__]


@pytest.mark.parametrize("bounds", [(0, 0, 0), (1, 0, 1), (6, -1, 4), (5, 3, 2), (7, 0, 9)])
def test_passes_are_those_of_range(bounds):
    assert counted(visit)(*bounds) == visit(*bounds)


def test_other_loops_stay():
    source = "def f(x):\n    for a in ti.static(range(3)):\n        x += a\n    for b in x:\n        x += b\n"
    tree = ast.parse(source)
    tree.body = loops._counted(tree.body, itertools.count())
    assert ast.unparse(tree) == ast.unparse(ast.parse(source))
