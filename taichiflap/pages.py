"""Reports as Markdown and as one self-contained HTML page."""

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path


@dataclass(frozen=True)
class Heading:
    """A heading; level 1 is the title."""

    level: int
    text: str


@dataclass(frozen=True)
class Paragraph:
    """A paragraph; `backticks` mark code."""

    text: str


@dataclass(frozen=True)
class Table:
    """A table of text. Numbers are aligned to the right; a cell FAIL is in red."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Figure:
    """A figure: the stem of its PNG and SVG files, a caption, and a text where there is no caption."""

    name: str
    caption: str
    alt: str = ""


Block = Heading | Paragraph | Table | Figure

_STYLE = """
body{font:16px/1.5 system-ui,sans-serif;color:#16191d;background:#fff;max-width:64rem;margin:2rem auto;padding:0 1rem}
h1,h2{line-height:1.25}h2{margin-top:2.5rem;border-bottom:1px solid #d4d9de}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums;margin:1rem 0}
th,td{padding:.3rem .6rem;border-bottom:1px solid #d4d9de;text-align:left;vertical-align:top}th{border-color:#5c6570}
td.number{text-align:right;white-space:nowrap}figure{margin:1.5rem 0}img{max-width:100%;height:auto}
figcaption{color:#5c6570;font-size:.9rem}code{background:#eceff2;padding:0 .2em;border-radius:3px}
td.fail{color:#b3261e;font-weight:bold}
""".strip()


_NUMBER = re.compile(r"[+−-]?[\d.,]+(e[+-]\d+)?( ?%)?( ± [\d.]+)?")


def markdown(blocks: Sequence[Block], figures: str = "png") -> str:
    """The report as Markdown, with links to figures of a format, `png` or `svg`."""
    return "\n\n".join(_markdown(block, figures) for block in blocks) + "\n"


def html(blocks: Sequence[Block], folder: Path) -> str:
    """The report as one HTML page with embedded SVG figures from `folder`."""
    title = next((block.text for block in blocks if isinstance(block, Heading)), "")
    body = "\n".join(_html(block, folder) for block in blocks)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{_STYLE}\n</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def _markdown(block: Block, figures: str) -> str:
    match block:
        case Heading(level, text):
            return f"{'#' * level} {text}"
        case Figure(name, caption, alt):
            return f"![{caption or alt}]({name}.{figures})" + (f"\n\n*{caption}*" if caption else "")
        case Table(head, rows):
            lines = [head, ["---"] * len(head), *rows]
            return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
    return block.text


def _html(block: Block, folder: Path) -> str:
    match block:
        case Heading(level, text):
            return f"<h{level}>{_inline(text)}</h{level}>"
        case Figure(name, caption, alt):
            drawn = base64.b64encode((folder / f"{name}.svg").read_bytes()).decode()
            image = f'<img alt="{escape(caption or alt)}" src="data:image/svg+xml;base64,{drawn}">'
            below = f"<figcaption>{_inline(caption)}</figcaption>" if caption else ""
            return f"<figure>{image}{below}</figure>"
        case Table(head, rows):
            top = "".join(f"<th>{_inline(cell)}</th>" for cell in head)
            lines = "\n".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows)
            return f'<div class="wide"><table>\n<thead><tr>{top}</tr></thead>\n<tbody>\n{lines}\n</tbody></table></div>'
    return f"<p>{_inline(block.text)}</p>"


def _cell(text: str) -> str:
    kind = " class=fail" if text == "FAIL" else " class=number" if _NUMBER.fullmatch(text) else ""
    return f"<td{kind}>{_inline(text)}</td>"


def _inline(text: str) -> str:
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(text))
