"""What Taichi 1.7 need not do for us: a quarter of the time to read kernels, a millisecond for every array; and how it
frees arrays.

What is left out serves messages about errors in kernels, or kernels inside classes; TAICHIFLAP_DEBUG=1 gives it back.
None of it changes what is compiled.
"""

import ast
import contextlib
import functools
import inspect
import linecache
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any


def hasten(taichi: Any) -> None:
    """Call at once after `import taichi`, before any decorator."""
    if os.environ.get("TAICHIFLAP_DEBUG"):
        return
    kernels = taichi.lang.kernel_impl
    # It draws the source line of every node.
    taichi.lang.ast.ast_transformer_utils.ASTTransformerContext.get_pos_info = _position
    # At every decorator it reads the line of the frame around it; a class body is known by its name.
    kernels._inside_class = _inside_class
    # At every call of a function it searches all modules for its source.
    kernels.getsourcefile = lambda function: function.__code__.co_filename
    kernels.getsourcelines = _source
    # With every array it notes who has called for it.
    taichi.lang._ndarray.get_traceback = taichi.lang.matrix.get_traceback = lambda: ""
    # It makes every group of arrays twice, each time with a class of its own, and those inside it once more.
    taichi.lang.argpack.ArgPack._register_members = _register_members
    taichi.lang.argpack.ArgPackType.cast = _cast(taichi)


def _position(context: Any, node: Any) -> str:
    """Where a node is, for the message about what is wrong there; nothing while all is well."""
    if sys.exc_info()[0] is None:
        return ""
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _register_members(group: Any) -> None:
    kind: Any = type(group)
    group.__class__ = _class_with(kind, tuple(group.keys))


@functools.cache
def _class_with(kind: Any, names: tuple[str, ...]) -> Any:
    """The class of groups whose members have these names."""
    members = {name: property(kind._make_getter(name), kind._make_setter(name)) for name in names}
    return type(kind.__name__, (kind,), members)


def _cast(taichi: Any) -> Callable[..., Any]:
    """What gives a new group its types: nothing is to be done where all members are arrays, or groups of them."""
    cast = taichi.lang.argpack.ArgPackType.cast
    held = taichi.types.ndarray_type.NdarrayType, taichi.lang.argpack.ArgPackType

    def cast_numbers(kind: Any, group: Any) -> Any:
        return group if all(isinstance(one, held) for one in kind.members.values()) else cast(kind, group)

    return cast_numbers


def free_arrays(taichi: Any) -> None:
    """Free an array, or a group of them, in the program that made it, and in no other.

    Taichi frees no array of vectors: a study would grow with every batch. Others it frees in whichever program there is
    when they are collected, and after a `ti.init` that may be memory of somebody's fields.
    """
    numbers, vectors = taichi.lang._ndarray.ScalarNdarray, taichi.lang.matrix.VectorNdarray
    vectors.__del__ = numbers.__del__
    for kind in (numbers, vectors, taichi.lang.argpack.ArgPack):
        _tie(kind, taichi.lang.impl.get_runtime)


def _tie(kind: Any, runtime: Callable[[], Any]) -> None:
    """Let objects of a kind remember the runtime that made them, and be freed in that one alone."""
    make, free = kind.__init__, kind.__del__

    @functools.wraps(make)
    def init(self: Any, *arguments: Any, **named: Any) -> None:
        self.made_in = runtime()
        make(self, *arguments, **named)

    def delete(self: Any) -> None:
        if runtime() is getattr(self, "made_in", None):
            free(self)

    kind.__init__, kind.__del__ = init, delete


def _inside_class(level_of_class_stackframe: int) -> bool:
    # Around a function of a script there are not so many frames.
    with contextlib.suppress(ValueError):
        return "__qualname__" in sys._getframe(level_of_class_stackframe).f_locals
    return False


@functools.cache
def _source(function: Callable[..., Any]) -> tuple[list[str], int]:
    """Lines of a function, and the number of the first, as `inspect.getsourcelines` gives them."""
    first = function.__code__.co_firstlineno
    last = _ends(function.__code__.co_filename).get(first)
    if last is None:
        return inspect.getsourcelines(function)
    return linecache.getlines(function.__code__.co_filename)[first - 1 : last], first


@functools.cache
def _ends(path: str) -> dict[int, int]:
    """Last line of every function of a file, by its first, which is that of its first decorator."""
    functions = _functions(ast.parse("".join(linecache.getlines(path))).body)
    return {min([f.lineno, *(d.lineno for d in f.decorator_list)]): f.end_lineno or 0 for f in functions}


def _functions(body: list[ast.stmt]) -> Iterator[ast.FunctionDef]:
    for statement in body:
        if isinstance(statement, ast.FunctionDef):
            yield statement
        yield from _functions(getattr(statement, "body", []))
