"""Expressions of metrics: `vertical_force_mean / power_mean`, `tip_peak_mean <= 0.01`."""

import ast
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import UserError
from ..metrics.names import resolve

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos}
_FUNCTIONS: dict[str, Callable[..., Any]] = {"abs": np.abs, "sqrt": np.sqrt, "min": np.minimum, "max": np.maximum}
_SIGNS: dict[type[ast.cmpop], float] = {ast.GtE: 1.0, ast.Gt: 1.0, ast.LtE: -1.0, ast.Lt: -1.0}

LONGEST = 500
"""Maximum length of a formula, for which nested brackets can be parsed."""
SHOWN = 60
"""Maximum length of a wrong formula in a message."""
LARGEST = 1e100
TINY = 1e-300
"""Added to avoid a division of zero by zero."""


class ExpressionError(UserError):
    """Raised for an invalid expression; one sentence with the problem."""


@dataclass(frozen=True)
class Expression:
    """An expression of metrics; `of` evaluates it. Overflow and division by zero give NaN or infinity."""

    text: str
    names: tuple[str, ...]
    _tree: ast.expr

    def of(self, metrics: Mapping[str, float]) -> float:
        """Value for the metrics of a case."""
        with np.errstate(all="ignore"):
            return float(_evaluate(self._tree, metrics))


def read_expression(text: str) -> Expression:
    """A formula of metrics and numbers: `+ - * / **`, brackets, abs, sqrt, min, max.

    Raises:
        ExpressionError: for anything else.
        MetricError: for an unknown metric.
    """
    tree = _parse(text)
    if isinstance(tree, ast.Compare):
        raise ExpressionError(f"{text!r}: this is a comparison; give the expression to maximise or minimise")
    return _expression(text, tree)


def read_constraint(text: str) -> Expression:
    """A constraint `A >= B` or `A <= B` as an expression from -1 to 1 that is non-negative where it is met.

    It is the difference divided by the sum of both magnitudes, so that constraints on forces and on angles have equal
    weight.

    Raises:
        ExpressionError, MetricError: as in `read_expression`, and for anything but one comparison.
    """
    tree = _parse(text)
    if not isinstance(tree, ast.Compare) or len(tree.ops) != 1 or type(tree.ops[0]) not in _SIGNS:
        raise ExpressionError(f"{text!r}: write one comparison, for example force_vertical_mean >= 2.5e-3")
    sides = (tree.left, tree.comparators[0])
    high, low = sides if _SIGNS[type(tree.ops[0])] > 0 else sides[::-1]
    size = ast.BinOp(_call("abs", high), ast.Add(), _call("abs", low))
    margin = ast.BinOp(high, ast.Sub(), low)
    return _expression(text, ast.BinOp(margin, ast.Div(), _call("max", size, ast.Constant(TINY))))


def _call(name: str, *inside: ast.expr) -> ast.expr:
    return ast.Call(ast.Name(name), list(inside), [])


def _parse(text: str) -> ast.expr:
    if len(text) > LONGEST:
        raise ExpressionError(f"{_shown(text)}: longer than {LONGEST} characters")
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"{_shown(text)}: not a formula; for example force_vertical_mean / power_mean") from None


def _shown(text: str) -> str:
    return repr(text if len(text) <= SHOWN else f"{text[:SHOWN]}...")


def _expression(text: str, tree: ast.expr) -> Expression:
    names = tuple(dict.fromkeys(resolve(name) for name in _names(text, tree)))
    if not names:
        raise ExpressionError(f"{text!r}: contains no metric")
    return Expression(text, names, tree)


def _names(text: str, node: ast.expr) -> list[str]:
    """Names in a formula; raises an error for invalid syntax."""
    match node:
        case ast.Constant(value=bool() | complex()):
            pass
        case ast.Constant(value=int() | float() as value):
            if not abs(value) < LARGEST:
                raise ExpressionError(f"{_shown(text)}: a number is too large; give one below {LARGEST:g}")
            return []
        case ast.Name(id=name):
            return [name]
        case ast.UnaryOp(op=sign, operand=inner) if type(sign) in _UNARY:
            return _names(text, inner)
        case ast.BinOp(left=left, op=sign, right=right) if type(sign) in _BINARY:
            return _names(text, left) + _names(text, right)
        case ast.Call(func=ast.Name(id=name), args=inside, keywords=[]) if name in _FUNCTIONS and inside:
            arguments = 1 if name in ("abs", "sqrt") else 2
            if len(inside) != arguments:
                raise ExpressionError(f"{text!r}: {name} takes {arguments}")
            return [found for one in inside for found in _names(text, one)]
    raise ExpressionError(
        f"{text!r}: {ast.unparse(node)} is not supported; use metrics, numbers, + - * / **, {', '.join(_FUNCTIONS)}"
    )


def _evaluate(node: ast.expr, metrics: Mapping[str, float]) -> Any:
    match node:
        case ast.Constant(value=value):
            return np.float64(value)  # type: ignore[arg-type]
        case ast.Name(id=name):
            return np.float64(metrics[resolve(name)])
        case ast.UnaryOp(op=sign, operand=inner):
            return _UNARY[type(sign)](_evaluate(inner, metrics))
        case ast.BinOp(left=left, op=operation, right=right):
            return _BINARY[type(operation)](_evaluate(left, metrics), _evaluate(right, metrics))
        case ast.Call(func=ast.Name(id=name), args=inside):
            return _FUNCTIONS[name](*(_evaluate(one, metrics) for one in inside))
    raise AssertionError(node)
