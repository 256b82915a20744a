"""What mutmut found: `make mutants` prints the share of mutants that the tests notice, module by module.

A mutant is noticed when a test fails, or runs until it is stopped. Exit code 1 below the share that is asked for.
"""

import collections
import subprocess
import sys

LEAST = 0.8
NOTICED = ("killed", "timeout", "segfault")


def main():
    """Print the figures."""
    found = collections.defaultdict(collections.Counter)
    listed = subprocess.run(
        [sys.executable, "-m", "mutmut", "results", "--all", "true"], capture_output=True, text=True, check=True
    )
    for line in listed.stdout.splitlines():
        name, _, status = line.strip().rpartition(": ")
        found[name.split(".x")[0]][status] += 1
    total = sum(found.values(), collections.Counter())
    for name, counts in [*sorted(found.items()), ("all", total)]:
        untried = counts.pop("not checked", 0)
        noticed = sum(counts[status] for status in NOTICED)
        left = f", {untried} not tried" if untried else ""
        share = 100.0 * noticed / max(1, counts.total())
        print(f"{name:<24}{noticed:>6} of {counts.total():>5} noticed{share:>7.1f} %{left}")
    return sum(total[status] for status in NOTICED) < LEAST * total.total()


if __name__ == "__main__":
    sys.exit(main())
