"""Write `hashes.txt`: the run-time packages at the versions of `constraints.txt`, with the hashes of their archives.

    python tests/hashes.py

pip is asked what it would install for each platform and Python, from whatever index it is set up to use; the file
names no index. `pip install --require-hashes -r hashes.txt` then refuses any archive with other bytes.
"""

import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
WRITTEN = ROOT / "hashes.txt"
PYTHONS = ("3.11", "3.12", "3.13")
PLATFORMS = {
    "Linux x86-64": [f"manylinux_2_{minor}_x86_64" for minor in range(17, 35)] + ["manylinux2014_x86_64"],
    "macOS arm64": [f"macosx_{major}_0_arm64" for major in range(11, 16)],
}
HEAD = """\
# The run-time packages with the SHA-256 of their archives for {platforms}; Python {first} to {last}.
# Written by tests/hashes.py from constraints.txt. To install nothing but these bytes:
#   pip install --require-hashes -r hashes.txt && pip install --no-deps .
"""


def archives(python, tags):
    """What pip would install for one Python on one platform: hashes by pinned package."""
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        command = [
            sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed",
            "--report", report, "--target", folder, "--only-binary=:all:", "--python-version", python,
            "--constraint", ROOT / "constraints.txt", *(f"--platform={tag}" for tag in tags), *wanted,
        ]  # fmt: skip
        subprocess.run(command, check=True)
        found = json.loads(report.read_text())["install"]
    return {
        f"{item['metadata']['name'].lower()}=={item['metadata']['version']}": item["download_info"]["archive_info"][
            "hashes"
        ]["sha256"]
        for item in found
    }


def main():
    found = {}
    for tags in PLATFORMS.values():
        for python in PYTHONS:
            for package, digest in archives(python, tags).items():
                found.setdefault(package, set()).add(digest)
    head = HEAD.format(platforms=", ".join(PLATFORMS), first=PYTHONS[0], last=PYTHONS[-1])
    body = (
        " \\\n".join([package, *(f"    --hash=sha256:{digest}" for digest in sorted(digests))])
        for package, digests in sorted(found.items())
    )
    WRITTEN.write_text(head + "\n".join(body) + "\n", encoding="utf-8")
    print(f"{WRITTEN.name}: {len(found)} packages, {sum(map(len, found.values()))} archives")


if __name__ == "__main__":
    main()
