"""The gallery: every case file that comes with the package, with its picture and its numbers; `make reports` runs it.

    python docs/gallery.py [NAME ...]

writes `gallery/NAME.png` of the cases named, or of all, and their parts of `gallery.md`.
"""

import sys
from pathlib import Path

import taichiflap
from taichiflap.case import shipped
from taichiflap.case.case import Case, load_case
from taichiflap.metrics.summary import Statistic, summarise
from taichiflap.notation import prefixed
from taichiflap.plots import result, style

HERE = Path(__file__).parent
PAGE, FOLDER = HERE / "gallery.md", HERE / "gallery"
RESOLUTION = 110
"""Of a picture, dots an inch."""
INTRODUCTION = """# Gallery

Every case file that comes with taichiflap, with its wing and its numbers: means over the settled beats, ± the
standard deviation from beat to beat. `taichiflap init --from NAME` writes the file; `python docs/gallery.py` computed
what stands here.
"""
TERMS = (("lift", "lift", "N"), ("thrust", "thrust", "N"))
HOVER = (("force_vertical", "vertical force", "N"),)
REST = (("power", "mechanical power", "W"), ("tip_peak", "peak tip deflection", "m"))


def cases() -> list[Path]:
    """The case files, by name."""
    return sorted(Path(str(shipped.FOLDER)).glob("*.toml"))


def compute(path: Path) -> taichiflap.Result:
    """The result of a case file, in memory."""
    return taichiflap.simulate(load_case(path))


def numbers(run: taichiflap.Result) -> str:
    """What a case comes to, in a line."""
    found = summarise(run)
    assert found is not None
    said = []
    for name, words, unit in (*(TERMS if found.lift else HOVER), *REST):
        one: Statistic = getattr(found, name)
        if one.mean or name == "force_vertical":
            said.append(f"{words} {shown(one, unit)}")
    coefficients = {"C_L": found.lift_coefficient, "C_T": found.thrust_coefficient, "C_P": found.power_coefficient}
    said += [f"${name}$ = {one.mean:.3g}" for name, one in coefficients.items() if one]
    if found.propulsive_efficiency is not None and found.propulsive_efficiency > 0.0:
        said.append(f"efficiency {found.propulsive_efficiency:.2g}")
    return ", ".join(said)


def shown(one: Statistic, unit: str) -> str:
    """A quantity in the unit that suits it, with its spread where that is seen."""
    factor, name = prefixed(one.mean, unit)
    spread = f" ± {factor * one.spread:.1g}" if one.spread > 1e-3 * abs(one.mean) else ""
    return f"{factor * one.mean:.3g}{spread} {name}"


def section(path: Path, run: taichiflap.Result) -> str:
    """A case's part of the page."""
    case: Case = run.case
    comments = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        comments.append(line.lstrip("# "))
    about = " ".join(comments)
    return (
        f"## {path.stem}\n\n{about}\n\n{case.title} ({case.model}): {numbers(run)}.\n\n"
        f"![{case.title}](gallery/{path.stem}.png)\n"
    )


def parts() -> dict[str, str]:
    """The page's parts, by the names of their cases."""
    text = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    return {part.partition("\n")[0]: f"## {part.rstrip()}\n" for part in text.split("\n## ")[1:]}


def main(names: list[str]) -> None:
    """Compute some cases, or all, and write the page."""
    FOLDER.mkdir(exist_ok=True)
    found = parts()
    for path in cases():
        if names and path.stem not in names:
            continue
        run = compute(path)
        picture = result.wing(run, width=style.WIDTH)
        picture.savefig(FOLDER / f"{path.stem}.png", dpi=RESOLUTION)
        found[path.stem] = section(path, run)
        print(path.stem, numbers(run), flush=True)
    PAGE.write_text("\n".join([INTRODUCTION, *(found[name] for name in sorted(found))]), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
