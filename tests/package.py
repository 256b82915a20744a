"""Build the wheel and the source archive, install each in clean environments, and use them.

    python tests/package.py python3.11 python3.12 python3.13

Every Python that is given gets two environments: of the newest versions that `pyproject.toml` allows, and of the
lowest. The wheel goes into them; the source archive into one more of the first Python. The environments take minutes,
so this is no part of the tests: `make package` runs it.
"""

import contextlib
import gzip
import hashlib
import io
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parent.parent
CHECK = """
import pathlib, taichiflap, taichiflap_viewer
home = pathlib.Path(taichiflap.__file__).parent
assert "site-packages" in str(home), home
assert (home / "py.typed").is_file()
with taichiflap.open_result("mine.h5") as result:
    tip = 1e3 * taichiflap.summarise(result).tip_peak.mean
assert abs(tip - 7.80) < 0.01, tip
print(f"tip {tip:.4f} mm, {taichiflap.__version__}")
"""


def run(*command, cwd=None):
    ran = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False)
    if ran.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{ran.stdout}\n{ran.stderr}")
    return ran.stdout


def build(folder):
    """Build the wheel and the source archive, byte-identical for a commit on any machine."""
    # In a copy: what an earlier build has left behind would go into the wheel.
    tracked = run("git", "ls-files", "--cached", "--others", "--exclude-standard", cwd=ROOT).splitlines()
    for name in filter(lambda name: (ROOT / name).is_file(), tracked):
        place = folder / "source" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, place)
    # Nothing of the machine: neither its modes and its owner nor its clock.
    when = os.environ.get("SOURCE_DATE_EPOCH") or run("git", "log", "-1", "--format=%ct", cwd=ROOT).strip()
    for place in ((folder / "source"), *(folder / "source").rglob("*")):
        place.chmod(0o755 if place.is_dir() else 0o644)
    with at(when):
        run(sys.executable, "-m", "build", "--outdir", folder / "dist", folder / "source")
    (wheel,), (archive,) = (folder / "dist").glob("*.whl"), (folder / "dist").glob("*.tar.gz")
    normalise(archive, int(when))
    return wheel, archive


@contextlib.contextmanager
def at(when):
    """Environment with the time of the commit, and a default file mask."""
    mask, before = os.umask(0o022), os.environ.get("SOURCE_DATE_EPOCH")
    os.environ["SOURCE_DATE_EPOCH"] = when
    try:
        yield
    finally:
        os.umask(mask)
        os.environ.pop("SOURCE_DATE_EPOCH")
        if before is not None:
            os.environ["SOURCE_DATE_EPOCH"] = before


def normalise(archive, when):
    """Rewrite a source archive: sorted, without owner, with one time; setuptools keeps the builder's."""
    with tarfile.open(archive) as file:
        members = sorted(file.getmembers(), key=lambda member: member.name)
        contents = [file.extractfile(member).read() if member.isfile() else None for member in members]
    with (
        open(archive, "wb") as raw,
        gzip.GzipFile("", "wb", mtime=when, fileobj=raw) as packed,
        tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as file,
    ):
        for member, content in zip(members, contents, strict=True):
            clean = tarfile.TarInfo(member.name)
            clean.type, clean.mtime, clean.mode = member.type, when, 0o755 if member.isdir() else 0o644
            clean.size = len(content or b"")
            file.addfile(clean, io.BytesIO(content) if content is not None else None)


def check_same(wheel, archive, folder):
    """Check that a second build in another place with another mask gives the same bytes."""
    mask = os.umask(0o077)
    try:
        again = build(folder)
    finally:
        os.umask(mask)
    for one, other in zip((wheel, archive), again, strict=True):
        if one.read_bytes() != other.read_bytes():
            sys.exit(f"{one.name}: two builds differ")
    print("two builds: the same bytes, sha256", *(hashlib.sha256(one.read_bytes()).hexdigest()[:16] for one in again))


def lowest(version):
    """The lowest versions that are allowed for a Python, as constraints."""
    given = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    wanted = [Requirement(text) for text in given]
    wanted = [one for one in wanted if one.marker is None or one.marker.evaluate({"python_version": version})]
    return [f"{one.name}=={bound.version}" for one in wanted for bound in one.specifier if bound.operator == ">="]


def use(folder, python, what, constraints=()):
    """Install in a new environment, and use the package from an empty folder."""
    run(python, "-m", "venv", folder)
    place = folder / "work"
    place.mkdir()
    pip = (folder / "bin/python", "-m", "pip", "--quiet", "--disable-pip-version-check", "install")
    run(*pip, *constraints, what)
    command = folder / "bin" / "taichiflap"
    for words in ("--version", "cite", "init mine.toml --from hawkmoth", "simulate mine.toml", "info mine.h5"):
        run(command, *words.split(), cwd=place)
    return run(folder / "bin/python", "-c", CHECK, cwd=place).strip()


def main(pythons):
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        wheel, archive = build(folder)
        check_same(wheel, archive, folder / "again")
        print(f"{wheel.name} {wheel.stat().st_size / 1e3:.0f} kB, {archive.name} {archive.stat().st_size / 1e3:.0f} kB")
        for python in pythons:
            version = run(python, "-c", "import sys; print('%d.%d' % sys.version_info[:2])").strip()
            for kind, constraints in (("newest", ()), ("lowest", lowest(version))):
                said = use(folder / f"{version}-{kind}", python, wheel, constraints)
                print(f"Python {version}, {kind}: {said}", flush=True)
        print("source archive:", use(folder / "archive", pythons[0], archive), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or [sys.executable])
