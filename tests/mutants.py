"""Changes the physics in pure Python with mutmut, and prints the share of mutants that the tests detect, by module.

With names on the command line (`taichiflap.motion.*`) those are tried anew, and others are as they were. A mutant is
noticed when a test fails, or runs until it is stopped. Exit code 1 if a module is below the share asked for.
"""

import collections
import shutil
import subprocess
import sys
from pathlib import Path

import libcst.matchers as match
from mutmut.__main__ import cli
from mutmut.mutation.file_mutation import MutationVisitor

LEAST = 0.8
NOTICED = ("killed", "timeout", "segfault")
CACHED = match.FunctionDef(
    decorators=[match.Decorator(match.Call(match.Attribute(match.Name("functools"), match.Name("lru_cache"))))]
)


def with_cached_functions(skip):
    """Include cached functions: mutmut skips whatever is decorated."""
    return lambda visitor, node: not match.matches(node, CACHED) and skip(visitor, node)


def try_mutants(names):
    """Run mutmut in this process, which forks two others."""
    if names:
        # Which tests reach what has changed, mutmut asks for new tests only.
        Path("mutants/mutmut-stats.json").unlink(missing_ok=True)
    else:
        shutil.rmtree("mutants", ignore_errors=True)
    MutationVisitor._skip_node_and_children = with_cached_functions(MutationVisitor._skip_node_and_children)
    cli(["run", "--max-children", "2", *names], standalone_mode=False)


def shares():
    """Print the results; returns the minimum share of a module."""
    found = collections.defaultdict(collections.Counter)
    listed = subprocess.run(
        [sys.executable, "-m", "mutmut", "results", "--all", "true"], capture_output=True, text=True, check=True
    )
    for line in listed.stdout.splitlines():
        name, _, status = line.strip().rpartition(": ")
        found[name.split(".x")[0]][status] += 1
    least = 1.0
    for name, counts in [*sorted(found.items()), ("all", sum(found.values(), collections.Counter()))]:
        untried = counts["not checked"]
        noticed, tried = sum(counts[status] for status in NOTICED), counts.total() - untried
        left = f", {untried} not tried" if untried else ""
        print(f"{name:<24}{noticed:>6} of {tried:>5} noticed{100.0 * noticed / max(1, tried):>7.1f} %{left}")
        least = min(least, noticed / counts.total())
    return least


if __name__ == "__main__":
    try_mutants(sys.argv[1:])
    sys.exit(shares() < LEAST)
