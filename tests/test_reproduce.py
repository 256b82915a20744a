"""The reproduction with reduced settings: numbers, files, and a report without traces of the machine."""

import re
from dataclasses import replace
from pathlib import Path

import h5py
import literal
import numpy as np
import pytest
import rigid_lattice
from conftest import CASES
from test_cli import run
from test_reports import REPRODUCTION, ROOT, rows

import taichiflap
from taichiflap import pages
from taichiflap.files import OutputError
from taichiflap.metrics.beats import settled_beats
from taichiflap.metrics.waves import harmonic
from taichiflap.published.reade2020 import paper, plan, reproduce
from taichiflap.published.reade2020.paper import Settings
from taichiflap.published.reade2020.plan import RIGID, key
from taichiflap.published.reade2020.verdict import Verdict

pytestmark = pytest.mark.slow

QUICK = Settings(
    periods=3,
    steps_per_period=200,
    elements=(1, 5, 50),
    panels=(10, 50),
    wakes=(20, 200),
    long_wakes=("all",),
    modes=(1, 2),
    densities=(1.0, paper.AIR),
)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The folder of a reduced study, its verdicts, and how the progress went."""
    folder, shares = tmp_path_factory.mktemp("study") / "new" / "folder", []
    found = reproduce.reproduce(folder, settings=QUICK, progress=shares.append)
    return folder, found, shares


def named(found, text):
    return next(verdict for verdict in found if verdict.what.startswith(text))


def test_shipped_case_files_are_the_papers():
    for name, solver in (("hawkmoth", "uvlm"), ("hawkmoth_dbet", "dbet")):
        shipped = taichiflap.load_case(CASES / f"{name}.toml")
        ours = paper.case(Settings(), solver).override(title=shipped.title).to_dict()
        unused = {"uvlm", "dbet"} - {solver}
        theirs = shipped.to_dict()
        assert {key: ours[key] for key in ours if key not in unused} == {
            key: theirs[key] for key in theirs if key not in unused
        }


def test_verdicts_hold_the_known_numbers(study):
    _, found, _ = study
    assert named(found, "first natural frequency").here == "79.96 Hz"
    expected = {"DBET rigid": 2.78, "DBET flexible": 3.08, "UVLM rigid": 3.1, "UVLM flexible": 7.2}
    for wing, force in expected.items():
        here = float(named(found, f"mean vertical force, {wing}").here.split()[0])
        assert here == pytest.approx(force, rel=0.08), wing
    assert float(named(found, "largest tip deflection, DBET").here.split()[0]) == pytest.approx(7.6, rel=0.03)
    phase = named(found, "normal force, flexible")
    assert not phase.reproduced
    assert float(phase.here.split()[0]) == pytest.approx(-16.0, abs=4.0)
    assert named(found, "Fig. 4").reproduced
    assert named(found, "time, UVLM over DBET").reproduced is None
    assert named(found, "half the time step, DBET").reproduced
    half = named(found, "half the time step, UVLM, 200")
    assert not half.reproduced
    assert float(half.here.split()[1].rstrip("%")) == pytest.approx(-19.0, abs=3.0)
    whole = named(found, "the whole of the paper's DBET")
    assert whole.here == "6 of 8"
    assert "no added mass, undamped" in whole.why
    assert whole.why.endswith("tip 5.38 mm")


def test_progress_rises_to_the_end(study):
    shares = study[2]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


def test_every_file_is_there(study):
    folder, _, _ = study
    names = {path.name for path in folder.iterdir()}
    figures = {"figure4", "figure5", "wake", "figure6", "figure7", "cause", "table5", "density"}
    figures |= {"models-forces", "models-histories"}
    assert names == {f"{name}.{kind}" for name in figures for kind in ("png", "svg")} | {
        reproduce.REPORT, reproduce.PAGE, reproduce.DATA, "models.md", "models.html",
    }  # fmt: skip


def test_report_says_the_same_in_both_forms_and_nothing_of_the_machine(study):
    folder, found, _ = study
    markdown, page_ = ((folder / name).read_text("utf-8") for name in (reproduce.REPORT, reproduce.PAGE))
    for verdict in found:
        assert verdict.here in markdown
    text = re.sub(r"base64,[^\"]*", "", page_)
    assert text.count("<img") == 8
    assert len(re.findall(r"^\|.*reproduced", markdown, re.M)) == sum(one.reproduced is not None for one in found)
    assert "http" not in text
    for written in (markdown, text, *(path.read_text("utf-8") for path in folder.glob("*.svg"))):
        assert str(folder) not in written
        assert str(Path.home()) not in written
        assert str(Path(taichiflap.__file__).parent) not in written


def test_data_holds_every_run(study):
    with h5py.File(study[0] / reproduce.DATA) as file:
        assert len(file) == len(plan.keys(QUICK))
        group = next(group for name, group in file.items() if name.endswith(" dbet"))
        assert group.attrs["tip_peak"] == pytest.approx(7.6e-3, rel=0.03)
        assert group["force_normal"].attrs["units"] == "N"
        assert len(group["turns"]) == len(group["force_normal"]) == QUICK.steps_per_period


def test_the_blades_of_post_processing_are_the_solvers():
    settings = replace(QUICK, periods=2)
    for more in ((), (RIGID,)):
        with taichiflap.simulate(paper.case(settings, "dbet", *more)) as result:
            frames = settled_beats(result).frames
            ours = literal.blades(result)
            theirs = (result.force_normal - result.force_normal_unsteady)[frames]
            axial = result.force_axial[frames]
            turned = literal.blades(result, arctangent=True)
        np.testing.assert_allclose(ours.normal, theirs, atol=1e-6)
        np.testing.assert_allclose(ours.axial, axial, atol=1e-6)
        assert turned.vertical == pytest.approx(-ours.vertical)


def test_the_rigid_lattice_is_the_solvers_until_vortices_meet():
    case = paper.case(replace(QUICK, periods=1), "uvlm", RIGID)
    ours = rigid_lattice.fly(case)
    with taichiflap.simulate(case) as result:
        np.testing.assert_allclose(ours.normal, result.force_normal, atol=1e-7 * np.abs(result.force_normal).max())
        np.testing.assert_allclose(ours.vertical, result.force_vertical, atol=1e-9)
    np.testing.assert_array_equal(rigid_lattice.fly(case, heard=200).normal, ours.normal)
    deaf, still = rigid_lattice.fly(case, heard=50), rigid_lattice.fly(case, still=True)
    np.testing.assert_array_equal(deaf.normal[:50], ours.normal[:50])
    assert np.abs(deaf.normal - ours.normal).max() > 1e-3
    assert np.abs(still.normal).max() > 1.2 * np.abs(ours.normal).max()


def test_quarter_panels_of_post_processing_undo_what_the_solver_counts():
    case = paper.case(replace(QUICK, periods=2), "uvlm", "uvlm.panels=10", "uvlm.core=0.02")
    with taichiflap.simulate(case) as result:
        printed, meant = literal.whole_panels(result)
        own = np.array([result.frame("panel_circulation", n) for n in range(result.frames)], dtype=float)
        frames, size = settled_beats(result).frames, case.wing.chord / 10
        time = result.time

        def unsteady(share):
            sums = np.sum(np.cumsum(own, axis=1) - (1 - share) * own, axis=1)
            growth = (1.5 * sums[2:] - 2 * sums[1:-1] + 0.5 * sums[:-2]) / case.step
            force = -case.fluid.density * case.wing.span * size * growth
            return harmonic(case, time[frames], force[frames.start - 2 : frames.stop - 2])

        theirs = harmonic(case, result.time[frames], result.force_normal_unsteady[frames])
    assert unsteady(1.0) == pytest.approx(theirs, rel=1e-4)
    assert printed - meant == pytest.approx(unsteady(1.0) - unsteady(0.75), rel=1e-3)


def test_energy_of_pitch_as_printed_lacks_the_rate_of_pitch():
    case = paper.case(QUICK, "dbet", RIGID, "motion.pitch.amplitude_deg=0.1")
    speed, rate = (case.motion.frequency * 2 * np.pi * one for one in (0.02, np.radians(0.1)))
    expected = 40e-6 * 0.01 * speed, 40e-6 * 0.01 * speed * rate / 2, 0.5 * 40e-6 * speed**2
    assert literal.pitch_energy(case) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("more", "printed"), [((RIGID,), (2.36, -2.36, 0.16, 2.36)), ((), (2.78, -2.78, 0.34, 2.77))])
def test_blade_misprints_have_the_effects_that_the_documentation_lists(more, printed):
    with taichiflap.simulate(paper.case(Settings(), "dbet", *more)) as result:
        taken = {}, {"arctangent": True}, {"cosines": True}, {"outside": True}
        found = [1e3 * literal.blades(result, **how).vertical for how in taken]
    assert found == pytest.approx(printed, abs=0.006)
    listed = (ROOT / "docs" / "theory" / "errata.md").read_text("utf-8").replace("−", "-")
    assert all(f"{force:.2f} mN" in listed for force in printed)


def test_energy_of_pitch_in_the_papers_case():
    energies = literal.pitch_energy(paper.case(Settings(), "dbet", RIGID))
    assert [1e6 * energy for energy in energies] == pytest.approx([1.2, 25.4, 201], rel=0.03)


def test_keys_name_a_case_once():
    assert key("uvlm", "uvlm.wake=200", RIGID) == ("uvlm", RIGID)
    assert len(set(plan.keys(Settings()))) == len(plan.keys(Settings()))
    planned = [one for part in plan.batches(QUICK) for one, _ in part]
    assert sorted(planned) == sorted(plan.keys(QUICK))


def test_a_page_escapes_what_it_is_given(tmp_path):
    blocks = [pages.Heading(1, "a < b"), pages.Table(("x|y",), [("−1.5 ± 0.2",), ("`code` & text",)])]
    assert "a &lt; b" in pages.html(blocks, tmp_path)
    assert "<td class=number>−1.5 ± 0.2</td>" in pages.html(blocks, tmp_path)
    assert "<code>code</code> &amp; text" in pages.html(blocks, tmp_path)
    assert "x\\|y" in pages.markdown(blocks)


def test_a_verdict_reads_as_a_sentence():
    verdict = Verdict("tip", "7.5 mm", "7.6 mm", True, "within 1 %")
    assert str(verdict) == "reproduced: tip: paper 7.5 mm, here 7.6 mm; within 1 %"


def test_folders_that_cannot_be_used_are_refused_in_a_sentence(tmp_path):
    (tmp_path / "old").write_text("")
    with pytest.raises(OutputError, match="is not empty"):
        reproduce.prepare(tmp_path, overwrite=False)
    reproduce.prepare(tmp_path, overwrite=True)
    with pytest.raises(OutputError, match="cannot be written"):
        reproduce.prepare(tmp_path / "old" / "below", overwrite=False)


def test_command_refuses_a_full_folder(tmp_path):
    (tmp_path / "old").write_text("")
    ran = run("reproduce", "-o", tmp_path)
    assert ran.returncode == 2
    assert "is not empty" in ran.stderr
    assert len(ran.stderr.splitlines()) == 1


def test_reproduction_has_the_verdicts_and_tables_of_a_quick_one(study):
    quick = (study[0] / reproduce.REPORT).read_text("utf-8")
    for level in (r"^##? (?!Verdicts).*$", r"^!\[.*$"):
        assert re.findall(level, REPRODUCTION, re.M) == re.findall(level, quick, re.M)
    names = [[row[0] for row in rows(text) if row[-2] in STATES] for text in (REPRODUCTION, quick)]
    assert names[0] == names[1]
    assert len(names[0]) > 20
    assert paper.described(Settings()) in REPRODUCTION


STATES = {"reproduced", "NOT reproduced", "measured"}
