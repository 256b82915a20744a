"""Which package may import which: the floors, from the lowest up."""

import ast
import importlib
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FLOORS = (
    "_version doors errors notation pages theory",
    "disk kernels",
    "case",
    "motion structure",
    "vortex march",
    "results",
    "fluids",
    "files drawing metrics maps scored",
    "run export",
    "studies",
    "plots",
    "validation published",
    "commands notebook",
    "__init__",
    "viewer",
    "cli",
    "__main__",
)
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms.split()}
AGAINST = {("case", "motion"), ("case", "fluids"), *((room, "notebook") for room in ("case", "results", "maps"))}
"""Imports inside a function: what \"auto\" means asks the motion for its speed, and the fluid model for its step;
and a notebook asks an object for its picture."""


def rooms_imported(file, parts):
    """Rooms that a module imports from, each with the line and whether the import is at the module's top."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    package = parts[:-1]
    top = {id(node) for node in tree.body}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            whole = [*package[: len(package) - node.level + 1], *(node.module or "").split(".")] if node.level else (
                (node.module or "").split(".")
            )  # fmt: skip
            whole = [part for part in whole if part]
            if whole[:1] == ["taichiflap_viewer"]:
                yield "viewer", node.lineno, id(node) in top
            elif whole[:1] == ["taichiflap"]:
                for room in whole[1:2] or [alias.name if alias.name in FLOOR else "__init__" for alias in node.names]:
                    yield room, node.lineno, id(node) in top


def modules():
    for file in sorted((ROOT / "taichiflap").rglob("*.py")):
        parts = file.relative_to(ROOT).with_suffix("").parts
        yield file, parts, parts[1]
    for file in sorted((ROOT / "viewer").rglob("*.py")):
        yield file, ("taichiflap_viewer", *file.relative_to(ROOT / "viewer").with_suffix("").parts), "viewer"


def test_nothing_imports_upward():
    upward = []
    for file, parts, room in modules():
        for other, line, top in rooms_imported(file, parts):
            above = FLOOR[other] > FLOOR[room] or (FLOOR[other] == FLOOR[room] and other != room)
            if above and (top or (room, other) not in AGAINST):
                upward.append(f"{file.relative_to(ROOT)}:{line}: {room} imports {other}")
    assert not upward, "\n".join(upward)


def test_every_room_has_a_door_of_one_sentence():
    listed = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    for top in ("taichiflap", "viewer"):
        for door in sorted((ROOT / top).rglob("__init__.py")):
            said = ast.get_docstring(ast.parse(door.read_text(encoding="utf-8")))
            assert said, door
            assert re.match(r"[A-Z][^\n]*\.$", said.splitlines()[0]), door
            name = ".".join(door.parent.relative_to(ROOT).parts).removeprefix("taichiflap.")
            assert name == "taichiflap" or f"| `{name}` | {said.splitlines()[0]} |" in listed, door
    files = [file for file in (ROOT / "taichiflap").glob("*.py") if file.name != "__init__.py"]
    assert len(files) <= 12


@pytest.mark.parametrize("old", ["beam", "body", "linear", "profile", "profiles", "runtime", "variables"])
def test_modules_that_moved_answer_to_their_old_names(old):
    with pytest.warns(DeprecationWarning, match=f"taichiflap.{old} is now"):
        module = importlib.import_module(f"taichiflap.{old}")
    assert importlib.import_module(module.__name__) is module
    assert module.__spec__.name == module.__name__


def test_every_package_is_installed():
    listed = set(tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]["packages"])
    ours = {".".join(door.parent.relative_to(ROOT).parts) for door in (ROOT / "taichiflap").rglob("__init__.py")}
    viewers = {
        f"taichiflap_{'.'.join(door.parent.relative_to(ROOT).parts)}" for door in (ROOT / "viewer").rglob("__init__.py")
    }
    assert listed == ours | viewers | {"taichiflap.cases"}
