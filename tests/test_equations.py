"""The index of equations is complete and agrees with the docstrings."""

import runpy
from pathlib import Path

INDEX = runpy.run_path(str(Path(__file__).parent.parent / "docs" / "equations.py"))


def test_words_for_several_equations_are_understood():
    assert list(INDEX["numbers"]("28-31")) == [28, 29, 30, 31]
    assert list(INDEX["numbers"]("29 and 32")) == [29, 32]
    assert list(INDEX["numbers"]("28, 31")) == [28, 31]


def test_every_equation_of_the_paper_has_its_place():
    found = {number for number, _ in INDEX["mentions"]()}
    assert found == set(range(1, INDEX["LAST"] + 1))


def test_the_page_is_fresh():
    assert INDEX["PAGE"].read_text(encoding="utf-8") == INDEX["page"](), "write it again: python docs/equations.py"
