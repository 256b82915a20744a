"""Sphinx: `make docs` builds the documentation, and fails on a warning."""

import html
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from docutils.nodes import SkipNode
from matplotlib.font_manager import FontProperties
from matplotlib.mathtext import MathTextParser
from matplotlib.path import Path as Outline
from matplotlib.textpath import TextPath

from taichiflap import __version__
from taichiflap.case.case import case_schema
from taichiflap.case.template import commented_case
from taichiflap.results.variables import AXES, MODE_VARIABLES, VARIABLES, WAKE_COUNT, WAKE_VARIABLES, Variable

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
from case_tables import case_tables  # noqa: E402

GENERATED = HERE / "generated"
COMMANDS = (
    "", "simulate", "sweep", "converge", "optimise", "score", "strips", "init", "preview", "view", "explore", "info",
    "plot", "export", "validate", "reproduce", "schema", "cite",
)  # fmt: skip

project = "taichiflap"
author = copyright = "The taichiflap authors"
release = version = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = f"taichiflap {release}"
html_show_sphinx = False
html_static_path = ["_static"]
html_css_files = ["own.css"]
html_theme_options = {"source_repository": "", "light_css_variables": {"color-brand-primary": "#2a5d9f"}}
html_math_renderer = "drawn"
exclude_patterns = ["_build", "generated"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
suppress_warnings = ["toc.not_included"]  # a page that only others link to
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_class_signature = "separated"
nitpicky = False
pygments_style = "friendly"


def write_generated() -> None:
    """Parts of pages that the program itself says: its case file, its variables, its commands."""
    GENERATED.mkdir(exist_ok=True)
    write("case.toml", commented_case())
    write("case.md", case_tables(case_schema()))
    write("variables.md", table(VARIABLES))
    write("axes.md", table(AXES))
    write("modes.md", table(MODE_VARIABLES))
    write("wake.md", table({"count": WAKE_COUNT} | WAKE_VARIABLES))
    for command in COMMANDS:
        words = [sys.executable, "-m", "taichiflap", *command.split(), "--help"]
        shown = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        write(f"help-{command or 'all'}.txt", shown.replace("python -m taichiflap", "taichiflap"))


def table(variables: dict[str, Variable]) -> str:
    """Variables as a table in Markdown."""
    rows = ["| name | over | unit | what |", "|---|---|---|---|"]
    for name, one in variables.items():
        what = "; ".join(text for text in (one.long_name, one.comment) if text)
        rows.append(f"| `{name}` | {', '.join(one.dimensions)} | {one.units} | {what} |")
    return "\n".join(rows) + "\n"


def write(name: str, text: str) -> None:
    """Write a file unless it holds the same, so that Sphinx reads anew only what has changed."""
    path = GENERATED / name
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def setup(app: Any) -> None:
    """Write what is generated, and register the drawing of equations."""
    write_generated()
    app.connect("autodoc-skip-member", left_out)
    app.add_html_math_renderer("drawn", (inline_equation, None), (displayed_equation, None))


def left_out(app: Any, what: str, name: str, obj: Any, skip: bool, options: Any) -> bool | None:
    """What autodoc shows of every class but nobody calls: `__new__`, and how pydantic begins."""
    return True if name == "__new__" or str(getattr(obj, "__module__", "")).startswith("pydantic") else None


def inline_equation(translator: Any, node: Any) -> None:
    """An equation within a line."""
    translator.body.append(drawn(node.astext()))
    raise SkipNode


def displayed_equation(translator: Any, node: Any) -> None:
    """An equation of its own; an empty line begins a new one."""
    texts = node.astext().replace(r"\frac", r"\dfrac").split("\n\n")
    rows = "".join(f"<div>{drawn(tex, 14.0)}</div>" for tex in texts)
    translator.body.append(f'<div class="math">{rows}</div>')
    raise SkipNode


def drawn(tex: str, size: float = 12.5) -> str:
    """An equation as a drawing, by Matplotlib: no script, no font of the reader's, nothing from elsewhere."""
    text = "$" + re.sub(r"\s+", " ", tex.strip()).replace(r"\left[", r"\left[ ") + "$"
    font = FontProperties(size=size, math_fontfamily="stix")
    width, height, depth, *_ = MathTextParser("path").parse(text, 72, font)
    path = TextPath((0, 0), text, prop=font)
    steps = {Outline.MOVETO: "M", Outline.LINETO: "L", Outline.CURVE3: "Q", Outline.CURVE4: "C", Outline.CLOSEPOLY: "Z"}
    line = "".join(
        steps[code] + ("" if code == Outline.CLOSEPOLY else " ".join(f"{x:.2f}" for x in points))
        for points, code in path.iter_segments(simplify=False)
    )
    em = 1.0 / 12.0
    place = {"width": (width + 1) * em, "height": (height + 2) * em, "vertical-align": -(depth + 1) * em}
    style = ";".join(f"{name}:{value:.3f}em" for name, value in place.items())
    return (
        f'<svg class="equation" role="img" aria-label="{html.escape(tex.strip())}" style="{style}" '
        f'viewBox="0 {depth - height - 1:.2f} {width + 1:.2f} {height + 2:.2f}">'
        f'<path transform="scale(1,-1)" fill="currentColor" d="{line}"/></svg>'
    )
