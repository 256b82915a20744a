"""Random wrong input: `python tests/fuzz.py 20000` counts what is accepted and rejected.

Case files, settings, tables of motion and sweep ranges are generated from the schema, half of them fitting it, and
good files are damaged byte by byte. Each is refused in sentences that name a key, or gives a case whose wing, motion
and step are finite. Damaged result files and maps go through the readers in a process of their own, with little
memory and little time: each is read, or refused in a sentence. So do files whose case names other files and modules:
none of those may be opened or imported.
"""

import collections
import math
import os
import random
import resource
import signal
import sys
import tempfile
import time
import tomllib
import traceback
import warnings
from pathlib import Path

import h5py
import numpy as np
import tomli_w
import xarray  # noqa: F401 - so that no child imports it again
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.case.case import CaseError, case_schema, load_case, parse_case
from taichiflap.case.time import IN_PERIODS, IN_SECONDS
from taichiflap.commands import summary as report
from taichiflap.commands.map_summary import map_lines
from taichiflap.errors import UserError
from taichiflap.export import table as tables
from taichiflap.export.vtkhdf import write_vtkhdf
from taichiflap.maps import file as maps
from taichiflap.maps.design import DesignError, design, read_vary
from taichiflap.motion import sampling
from taichiflap.results import hdf
from taichiflap.run import warnings as plausible
from taichiflap.structure import beam
from taichiflap.studies.sweep import sweep

SECONDS = 60
"""Longer than this nothing may take, on a busy machine."""
MEMORY = 2**30
"""More than this a reader may not take, bytes."""
NASTY = (
    math.nan, math.inf, -math.inf, -0.0, 0, 1, -1, 1e308, 5e-324, 1e-300, 1e30, 2**63 - 1, -(2**63), 10**30, True,
    False, "", "auto", "all", "table", "harmonic", "nan", "\x1b[31m", "é" * 200, [], [[]], [0.0, math.nan], [[0, 1]],
    [[0.0, 1.0], [1.0, 1e-300]], [[0, 0], [0, 0], [1, 0]], {}, {"kind": "ramp"}, {"kind": []}, {"x": {"y": 1}},
)  # fmt: skip
MATERIAL, MEASURED = (
    ("span", "thickness", "density", "youngs_modulus"),
    ("span", "mass_per_length", "flexural_rigidity"),
)
SCHEMA = case_schema()
GOOD = [path.read_text() for path in sorted(CASES.glob("*.toml"))]


def fitting(schema, rng):  # noqa: PLR0911
    """A value that fits a JSON schema."""
    schema = SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]] if "$ref" in schema else schema
    several = schema.get("oneOf") or schema.get("anyOf")
    if several:
        return fitting(rng.choice(several), rng)
    if "const" in schema or "enum" in schema:
        return rng.choice(schema.get("enum") or [schema["const"]])
    kind = schema.get("type")
    if kind == "object":
        needed = schema.get("required", ())
        return {
            name: fitting(part, rng)
            for name, part in schema.get("properties", {}).items()
            if name in needed or rng.random() < 0.4
        }
    if kind == "array" and "prefixItems" in schema:
        return [fitting(part, rng) for part in schema["prefixItems"]]
    if kind == "array":
        return [fitting(schema["items"], rng) for _ in range(rng.randrange(schema.get("minItems", 0), 7))]
    if kind == "boolean":
        return rng.random() < 0.5
    if kind == "string":
        return rng.choice(["", "a title", "é\n"])
    return number(schema, rng)


def number(schema, rng):
    """A number in a range, often near its ends, of any order of magnitude."""
    low = schema.get("minimum", schema.get("exclusiveMinimum", -1e6))
    high = schema.get("maximum", schema.get("exclusiveMaximum", 1e6))
    if schema["type"] == "integer":
        return rng.choice([low, high, rng.randint(int(low), int(high)), int(low) + rng.randrange(5)])
    drawn = rng.choice([low, high, rng.uniform(low, high), 10.0 ** rng.uniform(-12, 6), 1.0, 5e-324])
    return float(min(max(drawn, low), high))


def properties(section):
    """Schemas of the keys of a section; none for a key that holds a value."""
    return (
        SCHEMA["$defs"].get(SCHEMA["properties"][section].get("$ref", "").rpartition("/")[2], {}).get("properties", {})
    )


def document(rng):
    """A case file as a dictionary: a valid one with changes, or one made from the schema."""
    if rng.random() < 0.5:
        made = fitting(SCHEMA, rng)
        # What excludes each other.
        for section, groups in (("wing", (MATERIAL, MEASURED)), ("time", (IN_PERIODS, IN_SECONDS))):
            chosen = rng.choice(groups)
            for key in {key for group in groups for key in group} - set(chosen):
                made.get(section, {}).pop(key, None)
            for key in chosen:
                made.setdefault(section, {})[key] = fitting(properties(section)[key], rng)
    else:
        made = tomllib.loads(rng.choice(GOOD))
    for _ in range(rng.choice([0, 0, 1, 2, 5])):
        section = rng.choice(list(SCHEMA["properties"]))
        inner = properties(section)
        value = rng.choice(NASTY)
        if not inner or rng.random() < 0.1:
            made[section] = value
            continue
        key = rng.choice(list(inner))
        if rng.random() < 0.5:
            value = fitting(inner[key], rng)
        if isinstance(made.setdefault(section, {}), dict):
            made[section][key if rng.random() < 0.95 else key[::-1]] = value
    return made


def damaged(data, rng):
    """Bytes with a part removed, changed, duplicated or moved."""
    data = bytearray(data)
    what = rng.randrange(5)
    place = rng.randrange(len(data))
    if what == 0:
        return bytes(data[:place])
    if what == 1:
        for _ in range(rng.choice([1, 1, 2, 5, 20])):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif what == 2:
        # Where HDF5 keeps what it finds its way by.
        for _ in range(rng.choice([1, 1, 2, 5, 20])):
            data[rng.randrange(min(len(data), 20_000))] = rng.choice([0, 255, 127, 128, rng.randrange(256)])
    elif what == 3:
        data[place : place + rng.randrange(1, 64)] = bytes([rng.choice([0, 10, 91, 255])]) * rng.randrange(64)
    else:
        data[place : place + 8] = rng.choice([2**63 - 1, 10**12, 2**40, 2**31]).to_bytes(8, "little")
    return bytes(data)


def examine(case):
    """Check that the initial data of a run are finite."""
    case.resolved()
    section = beam.modes(case.wing)
    for values in (section.omega, section.lam, section.psi, section.shape(np.linspace(0.0, case.wing.chord, 5))):
        assert np.isfinite(values).all(), f"modes of {case.wing}"
    assert 0.0 < section.mass < 1e15, f"mass of {case.wing}"
    assert (section.omega > 0.0).all(), f"frequencies of {case.wing}"
    assert 0.0 < case.step <= case.duration * (1 + 1e-9) < math.inf
    moved = sampling.sample(case.motion, np.linspace(0.0, case.duration, 33))
    assert np.isfinite(moved).all(), f"{case.motion}"
    plausible.warnings(case)
    assert parse_case(tomllib.loads(case.to_toml())) == case


def refusal_is_clear(error):
    """Check that every problem is one line that starts with a key of the file, or says why there is none."""
    for problem in error.problems:
        assert problem, error.problems
        assert "\n" not in problem, problem
        assert ":" in problem or " = " in problem or problem.startswith("not a "), problem


def try_case(rng, folder):
    """One case file, from a dictionary or from damaged text, with settings."""
    path = folder / "case.toml"
    if rng.random() < 0.3:
        path.write_bytes(damaged(rng.choice(GOOD).encode(), rng))
    else:
        path.write_text(tomli_w.dumps(document(rng)), encoding="utf-8")
    chosen = []
    if rng.random() < 0.3:
        key = rng.choice(["wing.modes", "motion.pitch.kind", "time.step", "uvlm.wake", "title", "wing", "", "a.b.c"])
        chosen.append(f"{key}={rng.choice(NASTY)}")
    return attempt(lambda: examine(load_case(path, chosen)))


def try_table(rng, folder):
    """One table of motion in a file beside a good case."""
    rows = "\n".join(
        rng.choice([", ", ";", " ", "\t"]).join(str(rng.choice([*NASTY[:14], i * 0.01, rng.gauss(0, 1)])) for _ in "12")
        if rng.random() < 0.1
        else f"{i * 0.05:.4f}, {rng.gauss(0, 0.01):.4g}"
        for i in range(rng.randrange(30))
    )
    data = rows.encode()
    (folder / "points.csv").write_bytes(damaged(data, rng) if data and rng.random() < 0.5 else data)
    path = folder / "table.toml"
    made = tomllib.loads(GOOD[0])
    made["motion"] = {
        "frequency": 1.0,
        "plunge": {"kind": "table", "file": "points.csv", "periodic": rng.random() < 0.5},
    }
    made["time"] = {"periods": 1, "steps_per_period": 20}
    path.write_text(tomli_w.dumps(made))
    return attempt(lambda: examine(load_case(path)))


def try_sweep(rng, _):
    """One design."""
    key = rng.choice(["wing.chord", "wing.modes", "uvlm.panels", "solver", "fluid.velocity", "wing.span", "x", "wing"])
    parts = [str(rng.choice([*NASTY[:24], 0.01, 0.02, 3, 5, "log"])) for _ in range(rng.randrange(1, 5))]
    vary = [f"{key}={rng.choice([':', ',', ';']).join(parts)}"]
    sample = rng.choice([None, None, "sobol:8", "lhs:3", "sobol:7", "lhs:-1", "x", "lhs:999999999999"])
    return attempt(lambda: design(hawkmoth(), read_vary(vary), sample))


def attempt(work):
    """Whether input was accepted or refused; anything else is raised."""
    signal.alarm(SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            work()
    except CaseError as error:
        refusal_is_clear(error)
        return "refused"
    except DesignError as error:
        if "\n" in str(error):
            raise
        return "refused"
    finally:
        signal.alarm(0)
    return "accepted"


def read(path, out):
    """Read a file as the reading commands do."""
    if maps.is_map(path):
        with maps.open_map(path) as sheet:
            "".join(map_lines(sheet))
            sheet.to_xarray()
        return
    with taichiflap.open_result(path) as result:
        "".join(report.summary_lines(result))
        tables.write_csv(result, out / "x.csv")
        write_vtkhdf(result, out / "x.vtkhdf")
        result.to_xarray()


def forbid(lures):
    """From now on, end this process if it opens, lists, starts or imports one of these."""

    def watch(event, arguments):
        if event in ("open", "import", "os.listdir", "subprocess.Popen") and any(
            lure in str(arguments[0]) for lure in lures
        ):
            os.write(2, f"{event} {arguments[0]}\n".encode())
            os._exit(99)

    sys.addaudithook(watch)


def try_file(path, out, lures=()):
    """Read a file in a child with little memory and time: 'accepted', 'refused', or what went wrong."""
    receiving, sending = os.pipe()
    child = os.fork()
    if not child:
        said = b""
        code = 1
        try:
            signal.alarm(SECONDS)
            taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, taken + MEMORY))
            if lures:
                forbid(lures)
            read(path, out)
            code = 0
        except UserError as error:
            code = 2 if "\n" not in str(error) else 1
        except BaseException:
            said = traceback.format_exc()[-4000:].encode()
        os.write(sending, said)
        os._exit(code)
    os.close(sending)
    with os.fdopen(receiving) as pipe:
        said = pipe.read()
    _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    return {0: "accepted", 2: "refused"}.get(code, f"code {code}: {said}")


def good_files(folder):
    """A result and a map, small."""
    small = ("time.periods=2", "time.steps_per_period=20", "uvlm.panels=6", "uvlm.wake=20", "wing.modes=2")
    taichiflap.simulate(hawkmoth(*small), folder / "run.h5").close()
    sweep(hawkmoth(*small, "solver=dbet"), {"wing.modes": "0,1", "fluid.density": "1:2:3"}, folder / "map.h5")
    for name in ("run.h5", "map.h5"):
        read(folder / name, folder)  # loads what the children would each load
    return [(folder / name).read_bytes() for name in ("run.h5", "map.h5")]


def try_files(count, rng, folder):
    """Read some damaged files; returns the number of each outcome."""
    found = collections.Counter()
    good = good_files(folder)
    path = folder / "damaged.h5"
    for _ in range(count):
        path.unlink(missing_ok=True)
        path.write_bytes(damaged(rng.choice(good), rng))
        found[try_file(path, folder)] += 1
    return found


LURES = ("lure_pipe", "lure_table", "lure_module", "/dev/zero", "/etc/passwd")


def stranger(made, rng, folder):
    """The text of a case that names other files and modules wherever possible."""
    place = rng.choice([str(folder / "lure_pipe"), str(folder / "lure_table.csv"), "/dev/zero", "/etc/passwd"])
    table = {"kind": rng.choice(["table", "measured"]), "periodic": True, "file": place}
    what = rng.randrange(4)
    if what == 0 or not isinstance(made.get("motion"), dict):
        made["motion"] = table
    elif what < 3:
        made["motion"][rng.choice(["plunge", "pitch", "surge"])] = table
    if what > 1:
        made["solver"] = rng.choice(["module:lure_module", f"module:{folder}/lure_module.py"])
    return tomli_w.dumps(made)


def try_strangers(count, rng, folder):
    """Read some files whose case names other files and modules; returns the number of each outcome."""
    found = collections.Counter()
    good = good_files(folder)
    os.mkfifo(folder / "lure_pipe")
    (folder / "lure_table.csv").write_text("0, 0\n0.5, 0.01\n1, 0\n")
    (folder / "lure_module.py").write_text("raise SystemExit('imported')\n")
    sys.path.insert(0, str(folder))
    path = folder / "stranger.h5"
    for _ in range(count):
        path.write_bytes(rng.choice(good))
        with h5py.File(path, "r+") as file:
            own = tomllib.loads(file.attrs["case"].decode())
            hdf.note(file, {"case": stranger(own if rng.random() < 0.7 else document(rng), rng, folder)})
        found[try_file(path, folder, LURES)] += 1
    sys.path.remove(str(folder))
    return found


def try_input(count, rng, folder):
    """Try some case files, tables and designs; returns the number of each outcome, and stops at the first failure."""
    found = collections.Counter()
    kinds = (try_case, try_case, try_case, try_table, try_sweep)
    for _ in range(count):
        attempted = rng.choice(kinds)
        found[f"{attempted.__name__.removeprefix('try_')} {attempted(rng, folder)}"] += 1
    return found


def main(count, seed):
    """Print the outcomes of `count` inputs, of a tenth as many damaged files, and of the untrusted files."""
    rng = random.Random(seed)
    began = time.monotonic()
    failed = False
    for name, kind, tried in (
        ("input", try_input, count),
        ("damaged files", try_files, count // 10),
        ("files from strangers", try_strangers, count // 10),
    ):
        with tempfile.TemporaryDirectory() as folder:
            found = kind(tried, rng, Path(folder))
        print(f"{name}: {', '.join(f'{what} {n}' for what, n in sorted(found.items()))}", flush=True)
        failed |= any(what.startswith("code") for what in found)
    print(f"seed {seed}, {time.monotonic() - began:.0f} s")
    return failed


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else random.randrange(10**6)))
