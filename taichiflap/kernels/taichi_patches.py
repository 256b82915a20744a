"""Patches of Taichi 1.7 that skip unneeded work: a quarter of the time to read kernels, and a millisecond per array.
They also fix how arrays are freed.

The skipped work serves error messages about kernels, and kernels inside classes; TAICHIFLAP_DEBUG=1 restores it. The
compiled code is unchanged.
"""

import contextlib
import functools
import inspect
import linecache
import os
import sys
import textwrap
import types
from collections.abc import Callable, Iterator
from typing import Any

from ..doors import late

UNUSED = "dill", "urllib.request"
"""What Taichi imports and does not use here: for functions typed into a shell, and to ask for a newer version."""


@contextlib.contextmanager
def hurrying() -> Iterator[None]:
    """Around `import taichi`: modules that it does not use are loaded when somebody does.

    At each of its several hundred decorators it would read the line of the frame around it, and so its source files,
    to see whether that is a class; a class body is known by its name.
    """
    if os.environ.get("TAICHIFLAP_DEBUG"):
        yield
        return
    read = inspect.getframeinfo
    inspect.getframeinfo = _frame_around
    try:
        with late(*UNUSED):
            yield
    finally:
        inspect.getframeinfo = read


def _frame_around(frame: Any, context: int = 1) -> inspect.Traceback:
    line = "class " if "__qualname__" in frame.f_locals else ""
    return inspect.Traceback(frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name, [line], 0)


def hasten(taichi: Any) -> None:
    """Apply the patches; call directly after `import taichi`, before any decorator."""
    if os.environ.get("TAICHIFLAP_DEBUG"):
        return
    kernels = taichi.lang.kernel_impl
    # Taichi formats the source line of every node.
    taichi.lang.ast.ast_transformer_utils.ASTTransformerContext.get_pos_info = _position
    # At every decorator Taichi reads the line of the enclosing frame; a class body is recognised by its name.
    kernels._inside_class = _inside_class
    # At every call of a function Taichi searches all modules for its source.
    kernels.getsourcefile = lambda function: function.__code__.co_filename
    kernels.getsourcelines = _source
    # It wraps each of their lines at 9999 letters.
    kernels.textwrap = types.SimpleNamespace(fill=_unwrapped, dedent=textwrap.dedent)
    # For every array Taichi records the caller.
    taichi.lang._ndarray.get_traceback = taichi.lang.matrix.get_traceback = lambda: ""
    # Taichi builds every group of arrays twice, each time with a new class, and nested groups once more.
    taichi.lang.argpack.ArgPack._register_members = _register_members
    taichi.lang.argpack.ArgPackType.cast = _cast(taichi)


def _position(context: Any, node: Any) -> str:
    """Source position of a node for error messages; empty without an error."""
    if sys.exc_info()[0] is None:
        return ""
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _register_members(group: Any) -> None:
    kind: Any = type(group)
    group.__class__ = _class_with(kind, tuple(group.keys))


@functools.cache
def _class_with(kind: Any, names: tuple[str, ...]) -> Any:
    """Class of groups with members of these names."""
    members = {name: property(kind._make_getter(name), kind._make_setter(name)) for name in names}
    return type(kind.__name__, (kind,), members)


def _cast(taichi: Any) -> Callable[..., Any]:
    """Sets the types of a new group; nothing needs to be done if all members are arrays or groups of arrays."""
    cast = taichi.lang.argpack.ArgPackType.cast
    held = taichi.types.ndarray_type.NdarrayType, taichi.lang.argpack.ArgPackType

    def cast_numbers(kind: Any, group: Any) -> Any:
        return group if all(isinstance(one, held) for one in kind.members.values()) else cast(kind, group)

    return cast_numbers


def free_arrays(taichi: Any) -> None:
    """Free an array or a group only in the program that made it.

    Taichi never frees arrays of vectors, so that memory would grow with every batch. It frees others in the current
    program, which after a `ti.init` may own that memory for other fields.
    """
    numbers, vectors = taichi.lang._ndarray.ScalarNdarray, taichi.lang.matrix.VectorNdarray
    vectors.__del__ = numbers.__del__
    for kind in (numbers, vectors, taichi.lang.argpack.ArgPack):
        _tie(kind, taichi.lang.impl.get_runtime)


def _tie(kind: Any, runtime: Callable[[], Any]) -> None:
    """Make objects of a class remember the runtime that made them, and free them only there."""
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
    # A function of a script has fewer frames around it.
    with contextlib.suppress(ValueError):
        return "__qualname__" in sys._getframe(level_of_class_stackframe).f_locals
    return False


@functools.cache
def _source(function: Callable[..., Any]) -> tuple[list[str], int]:
    """Lines of a function and the number of the first, like `inspect.getsourcelines`, which reads the file in tokens.

    A function ends with its code, or with the brackets and comments behind it that are indented further than its first.
    """
    code = function.__code__
    first, lines = code.co_firstlineno, linecache.getlines(code.co_filename)
    if not lines:
        return inspect.getsourcelines(function)
    last = max(line or first for _, line, _, _ in code.co_positions())
    for number, line in enumerate(lines[last:], last + 1):
        if line.strip():
            if _indent(line) <= _indent(lines[first - 1]):
                break
            last = number
    return lines[first - 1 : last], first


def _unwrapped(line: str, **_: int) -> str:
    return line.rstrip()


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())
