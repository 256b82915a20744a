"""The gallery contains every case file, with the numbers that the case gives."""

import runpy
from pathlib import Path

import pytest
from conftest import CASES

DOCS = Path(__file__).parent.parent / "docs"
GALLERY = runpy.run_path(str(DOCS / "gallery.py"))


def test_every_case_file_has_its_part_and_its_picture():
    names = {path.stem for path in CASES.glob("*.toml")}
    parts = GALLERY["parts"]()
    assert set(parts) == names
    for name, part in parts.items():
        assert f"(gallery/{name}.png)" in part
        assert (DOCS / "gallery" / f"{name}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", ["hawkmoth_dbet", "measured_moth", "tabulated_stroke"])
def test_the_numbers_are_those_of_the_case(name):
    path = CASES / f"{name}.toml"
    with GALLERY["compute"](path) as run:
        assert GALLERY["section"](path, run).strip() == GALLERY["parts"]()[name].strip()
