"""Loops that LLVM compiles as they stand.

On processors with a large loop buffer, such as AMD's Zen 3, LLVM repeats the body of a loop up to eight times, with a
remainder, wherever it can compute the number of passes. In kernels of many small loops this takes more than half of the
time of a start and gains nothing. A pass counted in floating point is beyond LLVM's analysis: a serial loop

    for i in range(start, stop): ...

of this package's functions is therefore compiled as

    following, count, last = start, float(start), float(stop)
    while count < last:
        i = following
        following += 1
        count += 1.0
        ...

Results are the same. Loops of functions marked with `repeated` are left to LLVM.
"""

import ast
import itertools
import os
from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

PACKAGE = __name__.partition(".")[0]


def repeated(function: F) -> F:
    """Mark a function whose loops LLVM may repeat, since this makes them faster; place it below `ti.func`."""
    function.repeated = True  # type: ignore[attr-defined]
    return function


def count_passes(taichi: Any) -> None:
    """Let Taichi compile the loops of this package's functions as above; call it before any kernel is compiled."""
    if os.environ.get("TAICHIFLAP_DEBUG"):
        return
    kernels = taichi.lang.kernel_impl
    read = kernels._get_tree_and_ctx

    def read_counted(function: Any, *arguments: Any, **named: Any) -> Any:
        tree, context = read(function, *arguments, **named)
        own = function.func.__module__.partition(".")[0] == PACKAGE
        # The outermost loop of a kernel is parallel.
        if own and not named.get("is_kernel", True) and not hasattr(function.func, "repeated"):
            tree = ast.fix_missing_locations(_Counted().visit(tree))
        return tree, context

    kernels._get_tree_and_ctx = read_counted


class _Counted(ast.NodeTransformer):
    """Replaces the loops of one function."""

    def __init__(self) -> None:
        self._loops = itertools.count()

    def visit_For(self, loop: ast.For) -> list[ast.stmt] | ast.For:
        self.generic_visit(loop)
        match loop:
            case ast.For(target=ast.Name(index), iter=ast.Call(func=ast.Name("range"), args=[stop])):
                return self._counted(loop, index, "0", stop)
            case ast.For(target=ast.Name(index), iter=ast.Call(func=ast.Name("range"), args=[start, stop])):
                return self._counted(loop, index, ast.unparse(start), stop)
        return loop

    def _counted(self, loop: ast.For, index: str, start: str, stop: ast.expr) -> list[ast.stmt]:
        number = next(self._loops)
        following, count, last = (f"{name}_of_loop_{number}" for name in ("following", "count", "last"))
        statements = ast.parse(
            f"{following} = int({start})\n"
            f"{count} = float({following})\n"
            f"{last} = float({ast.unparse(stop)})\n"
            f"while {count} < {last}:\n"
            f"    {index} = {following}\n"
            f"    {following} += 1\n"
            f"    {count} += 1.0\n"
        ).body
        for statement in statements:
            for node in ast.walk(statement):
                if isinstance(node, ast.stmt | ast.expr):
                    node.lineno = node.end_lineno = loop.lineno
        passes = statements[-1]
        assert isinstance(passes, ast.While)
        passes.body += loop.body
        return statements
