"""Fast, trustworthy models of flexible flapping wings.

    case = taichiflap.load_case("cases/hawkmoth.toml")
    result = taichiflap.simulate(case)
    result.tip_deflection  # m, a NumPy array over result.time

Importing the package is light; heavy modules are imported at first use.
"""

from typing import TYPE_CHECKING, Any

from ._version import __version__
from .doors import lazy, leave_words

if TYPE_CHECKING:
    from .case.case import Case, CaseError, load_case
    from .maps.file import Map, open_map
    from .metrics.summary import summarise
    from .plots.preview import preview
    from .results.reader import Result, ResultError, open_result
    from .run.blocks import simulate
    from .studies.sweep import sweep

_HOMES = {
    "Case": "case",
    "CaseError": "case",
    "Map": "maps",
    "Result": "results",
    "ResultError": "results",
    "load_case": "case",
    "open_map": "maps",
    "open_result": "results",
    "preview": "plots.preview",
    "simulate": "run",
    "summarise": "metrics",
    "sweep": "studies.sweep",
}

__all__ = [
    "Case",
    "CaseError",
    "Map",
    "Result",
    "ResultError",
    "__version__",
    "load_case",
    "open_map",
    "open_result",
    "preview",
    "simulate",
    "summarise",
    "sweep",
]


leave_words()
_fetch = lazy(__name__, _HOMES)


def __getattr__(name: str) -> Any:
    value = _fetch(name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
