"""Sphinx: `make docs` builds the documentation, and fails on a warning."""

import subprocess
import sys
from pathlib import Path
from typing import Any

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

from taichiflap import __version__
from taichiflap.template import commented_case
from taichiflap.variables import AXES, MODE_VARIABLES, VARIABLES, WAKE_COUNT, WAKE_VARIABLES, Variable

HERE = Path(__file__).parent
GENERATED = HERE / "generated"
COMMANDS = (
    "", "simulate", "sweep", "converge", "optimise", "init", "view", "info", "plot", "export", "validate", "reproduce",
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
html_math_renderer = "mathml"
exclude_patterns = ["_build", "generated"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
nitpicky = False
pygments_style = "friendly"


def write_generated() -> None:
    """Parts of pages that the program itself says: its case file, its variables, its commands."""
    GENERATED.mkdir(exist_ok=True)
    write("case.toml", commented_case())
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
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_block, None))


def visit_math(translator: Any, node: Any) -> None:
    """An inline equation as MathML, which browsers draw themselves: no script and nothing from elsewhere."""
    translator.body.append(tex2mathml(node.astext(), as_block=False))
    raise SkipNode


def visit_block(translator: Any, node: Any) -> None:
    """A displayed equation."""
    translator.body.append(f'<div class="math">{tex2mathml(node.astext(), as_block=True)}</div>')
    raise SkipNode
