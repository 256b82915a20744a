"""The hashes of the archives belong to the tested versions."""

import re
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parent.parent


def pinned(name):
    lines = (ROOT / name).read_text().splitlines()
    found = (re.match(r"([\w.-]+)==([^\s;]+)", line) for line in lines)
    return {plain(match[1]): match[2] for match in found if match}


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def needed(name, found):
    """All run-time packages below a package, as they are installed here."""
    for text in metadata.requires(name) or ():
        requirement = Requirement(text)
        below = plain(requirement.name)
        if below not in found and (not requirement.marker or requirement.marker.evaluate({"extra": ""})):
            found.add(below)
            needed(below, found)
    return found


def test_hashes_are_of_the_constraints_and_cover_every_run_time_package():
    hashed, constraints = pinned("hashes.txt"), pinned("constraints.txt")
    assert hashed.items() <= constraints.items()
    assert needed("taichiflap", set()) <= hashed.keys()
