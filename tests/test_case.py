"""Case files: valid ones are accepted, and invalid ones get one clear message."""

import tomllib

import jsonschema
import pytest
import tomli_w
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.case.case import Case, CaseError, case_schema, load_case, parse_case
from taichiflap.case.template import commented_case
from taichiflap.run import warnings

GOOD = tomllib.loads((CASES / "hawkmoth.toml").read_text())

BAD = [
    # (setting, what the message must say)
    ("wing.chrod=0.02", ["wing.chrod: unknown key", "did you mean wing.chord?"]),
    ("wnig.chord=0.02", ["wnig: unknown key", "did you mean wing?"]),
    ("chord=0.02", ["chord: unknown key", "did you mean wing.chord?"]),
    ("uvlm.elements=5", ["uvlm.elements: unknown key", "did you mean dbet.elements?"]),
    ("motion.plunge.fase=5", ["motion.plunge.fase: unknown key", "amplitude, phase_deg"]),
    ("wing.chord=-0.02", ["wing.chord = -0.02", "> 0", "m"]),
    ("wing.chord=0", ["wing.chord = 0", "> 0"]),
    ("wing.chord=1e9", ["wing.chord = 1e9", "<= 100"]),
    ("wing.chord=nan", ["wing.chord = nan", "number"]),
    ("wing.span=inf", ["wing.span = inf", "number"]),
    ('wing.chord="0.02"', ['wing.chord = "0.02"', "a number"]),
    ("wing.thickness=true", ["wing.thickness = true", "a number"]),
    ("wing.density=[1000]", ["wing.density[0] = 1000", "a table [[s, value], ...]", "kg/m3"]),
    ("wing.modes=1.5", ["wing.modes = 1.5", "a whole number"]),
    ("wing.modes=-1", ["wing.modes = -1", ">= 0"]),
    ("wing.modes=21", ["wing.modes = 21", "<= 20"]),
    ("wing.damping_ratio=-0.1", ["wing.damping_ratio = -0.1", ">= 0"]),
    ("wing.damping_ratio=[0.1, -1]", ["wing.damping_ratio[1] = -1"]),
    ("wing.damping_ratio=[]", ["wing.damping_ratio", "too few values for 1 modes"]),
    ("wing.span=[[0, 0.05], [0.5, 0.04]]", ["wing.span = [[0, 0.05], [0.5, 0.04]]", "to s = 1"]),
    ("wing.span=[[0, 0.05], [0.6, 0.05], [0.4, 0.05], [1, 0.05]]", ["s must increase, but 0.4 follows 0.6"]),
    ("wing.span=[[0, 0.05], [1, -0.04]]", ["wing.span[1][1] = -0.04", "a table [[s, value], ...]"]),
    ("wing.thickness=[[0, 0], [1, 4e-5]]", ["wing.thickness = ", "must be > 0 but at the trailing edge"]),
    ("wing.density=[[0, 1000], [1, 0]]", ["wing.density = ", "must be > 0 everywhere"]),
    ("wing.pivot=0.25", ["wing.pivot = 0.25", "clamped at its leading edge", "wing.modes = 0"]),
    ("wing.pivot=7", ["wing.pivot = 7", "<= 5 chords"]),
    ("wing.point_masses=[[0.5, 0]]", ["wing.point_masses[0][1] = 0", "kg > 0"]),
    ("motion.frequency=0", ["motion.frequency = 0", "Hz"]),
    ("motion.plunge=0.02", ["motion.plunge = 0.02", "a table"]),
    ("motion.plunge.kind=bezier", ['motion.plunge.kind = "bezier"', '"harmonic" or "triangle"']),
    (
        "motion.pitch={kind='ramp', start=0.1, ramp=0.1, smoothing=5.0, amplitude_deg=9.0}",
        ["motion.pitch.smoothing = 5.0: rounds the corners over 0.2 s", ">= 10"],
    ),
    ("motion.plunge.kind=triangle", ["motion.plunge.sharpness: missing; give a number"]),
    ("motion.plunge.harmonics=[[3, 0.1]]", ["motion.plunge.harmonics[0]", "a table [[n, m, phase_deg], ...]"]),
    ("motion.plunge.amplitude=-1", ["motion.plunge.amplitude = -1", ">= 0"]),
    ("motion.pitch.amplitude_deg=400", ["motion.pitch.amplitude_deg = 400", "<= 360", "deg"]),
    ("fluid.density=-1", ["fluid.density = -1", ">= 0"]),
    ("fluid.velocity=[1]", ["fluid.velocity = [1]", "a list of 2 numbers"]),
    ("fluid.velocity=[1, 2, 3]", ["fluid.velocity", "a list of 2 numbers"]),
    ('fluid.velocity=[1, "a"]', ['fluid.velocity[1] = "a"']),
    ("dbet.elements=0", ["dbet.elements = 0", ">= 1"]),
    ('dbet.speed="half"', ['dbet.speed = "half"', '"full" or "truncated"']),
    ("dbet.added_mass=1", ["dbet.added_mass = 1", '"potential" or "strip" or "none"']),
    ("uvlm.panels=0", ["uvlm.panels = 0", ">= 1"]),
    ("uvlm.wake=0", ["uvlm.wake = 0", ">= 1", '"all"']),
    ("uvlm.wake=some", ['uvlm.wake = "some"', '"all"']),
    ("uvlm.shedding=global", ['uvlm.shedding = "global"', '"local" or "fixed"']),
    ("uvlm.core=-1", ["uvlm.core = -1", "chords"]),
    ("time.periods=1.5", ["time.periods = 1.5", "a whole number"]),
    ("time.steps_per_period=2", ["time.steps_per_period = 2", ">= 4"]),
    ("time.steps_per_period=900000", ["time.periods * time.steps_per_period = 13500000", "5000000"]),
    ("output.every=0", ["output.every = 0", ">= 1"]),
    ("solver=uvml", ['solver = "uvml"', '"uvlm" or "dbet"']),
    ("title=3", ["title = 3", "text"]),
    ("wing=3", ["wing = 3", "a table"]),
    ("wing.modes", ["--set wing.modes", "KEY=VALUE"]),
    ("=3", ["--set =3", "KEY=VALUE"]),
    ("wing..chord=1", ["--set wing..chord=1", "KEY=VALUE"]),
    ("wing.chord=1.2.3", ["--set wing.chord=1.2.3", "not a number"]),
    ("wing.chord.x=3", ["--set wing.chord.x=3", "chord is a value"]),
]


@pytest.mark.parametrize(("setting", "phrases"), BAD, ids=[setting for setting, _ in BAD])
def test_a_bad_setting_gets_its_message(setting, phrases):
    with pytest.raises(CaseError) as caught:
        hawkmoth(setting)
    (problem,) = caught.value.problems
    for phrase in phrases:
        assert phrase in problem
    assert str(caught.value).startswith(str(CASES / "hawkmoth.toml"))


@pytest.mark.parametrize(("setting", "phrases"), BAD[:-5], ids=[setting for setting, _ in BAD[:-5]])
def test_a_bad_file_gets_the_same_message_as_the_setting(setting, phrases, tmp_path):
    with pytest.raises(CaseError) as from_setting:
        hawkmoth(setting)
    document = tomllib.loads(tomli_w.dumps(GOOD))
    *tables, key = setting.partition("=")[0].split(".")
    table = document
    for name in tables:
        table = table.setdefault(name, {})
    try:
        table[key] = tomllib.loads(f"v = {setting.partition('=')[2]}")["v"]
    except tomllib.TOMLDecodeError:
        table[key] = setting.partition("=")[2]
    file = tmp_path / "case.toml"
    file.write_text(tomli_w.dumps(document))
    with pytest.raises(CaseError) as from_file:
        load_case(file)
    assert from_file.value.problems == from_setting.value.problems


@pytest.mark.parametrize("key", ["wing.chord", "wing.youngs_modulus", "motion.frequency", "wing"])
def test_a_missing_key_is_named_with_an_example(key):
    document = tomllib.loads(tomli_w.dumps(GOOD))
    *tables, last = key.split(".")
    table = document
    for name in tables:
        table = table[name]
    del table[last]
    with pytest.raises(CaseError) as caught:
        parse_case(document)
    (problem,) = caught.value.problems
    assert problem.startswith(f"{key}: missing; give a")


@pytest.mark.parametrize(
    ("wing", "problems"),
    [
        (
            {"chord": 0.02, "span": 0.05},
            ["thickness: missing; give a", "density: missing; give a", "youngs_modulus: missing; give a"],
        ),
        ({"chord": 0.02, "span": 0.05, "modes": 0}, ["thickness: missing", "density: missing"]),
        ({"chord": 0.02, "span": 0.05, "mass_per_length": 2e-3}, ["flexural_rigidity: missing; give a"]),
        (
            {"chord": 0.02, "span": 0.05, "mass_per_length": 2e-3, "flexural_rigidity": 1e-6, "density": 1e3},
            ["density = 1000.0: give either thickness, density and youngs_modulus, or mass_per_length and"],
        ),
        ({"chord": 0.02, "span": 0.05, "flexural_rigidity": 1e-6}, ["flexural_rigidity = 1e-6: needs mass_per_len"]),
    ],
)
def test_a_wing_is_of_a_material_or_measured(wing, problems):
    with pytest.raises(CaseError) as caught:
        parse_case(GOOD | {"wing": wing})
    assert len(caught.value.problems) == len(problems)
    for problem, start in zip(caught.value.problems, problems, strict=True):
        assert problem.startswith(f"wing.{start}")


def test_a_rigid_wing_needs_no_stiffness():
    for given in ({"mass_per_length": 2e-3}, {"thickness": 4e-5, "density": 1e3}):
        case = parse_case(GOOD | {"wing": {"chord": 0.02, "span": 0.05, "modes": 0} | given})
        assert parse_case(tomllib.loads(case.to_toml())) == case
        with pytest.raises(CaseError, match="missing"):
            case.override("wing.modes=1")


def test_all_problems_are_reported_at_once():
    with pytest.raises(CaseError) as caught:
        hawkmoth("wing.chrod=1", "wing.span=-1", "uvlm.panels=0", "solver=x", "motion.frequency=0")
    assert len(caught.value.problems) == 5


@pytest.mark.parametrize(
    ("content", "phrase"),
    [
        (b"[wing\nchord = 1", "not valid TOML"),
        (b"title = 'a'\ntitle = 'b'", "not valid TOML"),
        (b"\xff\xfe\x00", "not a UTF-8 text file"),
        (b"", "wing: missing"),
        (b"a = " + b"[" * 5000 + b"]" * 5000, ""),
    ],
)
def test_a_damaged_file_is_refused_in_a_sentence(content, phrase, tmp_path):
    file = tmp_path / "case.toml"
    file.write_bytes(content)
    with pytest.raises(CaseError) as caught:
        load_case(file)
    assert phrase in str(caught.value)


def test_a_missing_file_names_its_neighbour(tmp_path):
    (tmp_path / "hawkmoth.toml").write_text("")
    with pytest.raises(CaseError, match=r"no such file; did you mean .*hawkmoth\.toml\?"):
        load_case(tmp_path / "hawkmot.toml")


def test_a_folder_is_no_case(tmp_path):
    with pytest.raises(CaseError, match="cannot be read"):
        load_case(tmp_path)


def test_settings_are_toml_and_bare_words_are_text():
    case = hawkmoth("solver=dbet", "wing.modes=2", "wing.damping_ratio=[0.1, 0.2]", 'title="a b"', "uvlm.wake=all")
    assert (case.solver, case.wing.modes, case.wing.damping_ratio, case.title) == (
        "dbet",
        2,
        (0.1, 0.2),
        "a b",
    )
    assert case.uvlm.wake == "all"


def test_a_case_survives_the_trip_through_toml():
    case = hawkmoth("wing.modes=2", "wing.damping_ratio=[0.1, 0.2]", "fluid.velocity=[0.1, -3.0]", "uvlm.core=1e-3")
    assert parse_case(tomllib.loads(case.to_toml())) == case


def test_override_makes_a_changed_copy():
    case = hawkmoth()
    rigid = case.override("wing.modes=0", title="rigid")
    assert (case.wing.modes, rigid.wing.modes, rigid.title) == (1, 0, "rigid")
    with pytest.raises(CaseError, match=r"wing\.modes = -1"):
        case.override("wing.modes=-1")


def test_a_changed_case_is_the_case_of_a_changed_file():
    values = {"wing.modes": 0, "wing.pivot": 0.25, "fluid.velocity": [1.0, 0.0], "title": "turned", "uvlm.wake": "all"}
    document = hawkmoth().to_dict() | {"title": "turned"}
    document["wing"] |= {"modes": 0, "pivot": 0.25}
    document["fluid"]["velocity"], document["uvlm"]["wake"] = [1.0, 0.0], "all"
    changed = hawkmoth().changed(values)
    assert changed == parse_case(document)
    assert changed.to_toml() == parse_case(document).to_toml()


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"wing.pivot": 0.25}, "wing.pivot = 0.25: an elastic wing is clamped at its leading edge"),
        ({"motion.frequency": None}, "motion.frequency: missing"),
        ({"time.periods": 100_000, "time.steps_per_period": 1000}, "the limit is 5000000 steps"),
        ({"wing.chord.root": 1.0}, "wing.chord.root: chord is a value, not a table"),
        ({"wnig.chord": 1.0}, "wnig: unknown key; did you mean wing?"),
    ],
)
def test_what_a_change_spoils_is_found_wherever_it_shows(values, sentence):
    with pytest.raises(CaseError) as refused:
        hawkmoth().changed(values)
    assert sentence in str(refused.value)


@pytest.mark.slow
def test_shipped_cases_and_the_template_fit_the_schema():
    schema = case_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    for file in CASES.glob("*.toml"):
        jsonschema.validate(tomllib.loads(file.read_text()), schema)
    jsonschema.validate(tomllib.loads(commented_case()), schema)


def test_the_template_is_a_valid_case_that_names_every_key():
    case = parse_case(tomllib.loads(commented_case()))
    assert case.to_dict() == parse_case(case.to_dict()).to_dict()
    text = commented_case()
    for section in ("wing", "motion", "fluid", "dbet", "uvlm", "time", "output"):
        for key in type(getattr(case, section)).model_fields:
            assert f"{key} = " in text


@pytest.mark.parametrize(
    ("setting", "phrase"),
    [
        ("wing.youngs_modulus=1e9", "below the flapping frequency"),
        ("wing.density=1.0", "less dense than the fluid"),
        ("wing.thickness=0.01", "exceeds a fifth of the chord"),
        ("wing.thickness=[[0, 0.01], [1, 0]]", "wing.thickness = 0.01 m exceeds a fifth of the chord"),
        ("wing.density=[[0, 1000], [1, 1]]", "wing.density = 1 kg/m3"),
        ("wing.youngs_modulus=[[0, 2e9], [1, 1e9]]", "below the flapping frequency"),
        ("wing.density=1.5", "the wing's mass is 6e-08 kg, 0.0031 times its added mass"),  # 1,000 times less
        ("fluid.density=0.001", "the wing's mass is 4e-05 kg, 2.5e+03 times its added mass"),
        ("fluid.velocity=[40.0, 100.0]", "moves through the fluid at 108 m/s, but air is compressed at such speeds"),
        ("motion.frequency=0.2", "the Reynolds number is about 24 if the fluid is air"),
        ("fluid.density=998.0", "0.0026 times its added mass"),
        (
            'motion.plunge={kind="table", points=[[0, 0], [10, 0.02], [30, -0.02], [40, 0]]}',
            "motion.plunge is a table that lasts to 40 s, but the run ends at 0.6 s",
        ),
    ],
)
def test_implausible_cases_are_warned_about(setting, phrase):
    assert phrase in "\n".join(warnings.warnings(hawkmoth(setting)))


def test_shipped_cases_are_plausible():
    for file in CASES.glob("*.toml"):
        assert warnings.warnings(taichiflap.load_case(file)) == []


@pytest.mark.parametrize("name", ["fluid", "dbet", "uvlm", "navier_stokes", "time", "output"])
def test_a_section_that_is_left_out_is_an_empty_one(name):
    """Defaults are not validated, so they must be valid."""
    section = Case.model_fields[name].annotation
    assert section.model_construct() == section()
    assert section.model_construct().model_dump() == section().model_dump()
