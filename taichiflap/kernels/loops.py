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
from collections.abc import Callable, Iterator
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
            tree.body = _counted(tree.body, itertools.count())
        return tree, context

    kernels._get_tree_and_ctx = read_counted


def _counted(body: list[ast.stmt], numbers: Iterator[int]) -> list[ast.stmt]:
    """Statements of one function with its loops replaced; `numbers` distinguish them."""
    found: list[ast.stmt] = []
    for statement in body:
        for part in ("body", "orelse"):
            if inner := getattr(statement, part, None):
                setattr(statement, part, _counted(inner, numbers))
        match statement:
            case ast.For(target=ast.Name(index), iter=ast.Call(func=ast.Name("range"), args=[stop])):
                found += _passes(statement, index, None, stop, next(numbers))
            case ast.For(target=ast.Name(index), iter=ast.Call(func=ast.Name("range"), args=[start, stop])):
                found += _passes(statement, index, start, stop, next(numbers))
            case _:
                found.append(statement)
    return found


def _passes(loop: ast.For, index: str, start: ast.expr | None, stop: ast.expr, number: int) -> list[ast.stmt]:
    following, count, last = (f"{name}_of_loop_{number}" for name in ("following", "count", "last"))
    # At the loop's place in the source, for messages.
    statements: Any = ast.parse(
        "\n" * (loop.lineno - 1) + f"{following} = int(0); {count} = float({following}); {last} = float(0)\n"
        f"while {count} < {last}: {index} = {following}; {following} += 1; {count} += 1.0"
    ).body
    first, _, end, passes = statements
    if start:
        first.value.args[0] = start
    end.value.args[0] = stop
    passes.body += loop.body
    return list(statements)
