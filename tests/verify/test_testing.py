"""What the package offers for tests of one's own: an assertion, and a plugin of pytest."""

import pytest
from command import TWO_JOINTS
from urdf_mutants import mutants

import urdf_ik
from urdf_ik import ArgumentError, ChainError
from urdf_ik.model import catalogue
from urdf_ik.verify.crosscheck import PROPERTIES, check
from urdf_ik.verify.testing import assert_agrees_with_pinocchio, verdict
from urdf_ik_pytest import UNCHANGED

ARM = catalogue.resolve("zyyzyz_6r").path
WRONG = """
import urdf_ik
from urdf_ik.arm import Arm

solve = Arm.fk
Arm.fk = lambda self, q: solve(self, q) + 1e-6
"""


def run(pytester: pytest.Pytester, *args: str) -> pytest.RunResult:
    """Run pytest in a process of its own, with the plugin; as if the package had been installed."""
    # A configuration and a root of its own: pytest looks for them beside every file that it is given.
    pytester.makeini("[pytest]")
    root = f"--rootdir={pytester.path}", "-c", str(pytester.path / "tox.ini")
    return pytester.runpytest_subprocess("-p", "urdf_ik_pytest", "-p", "no:cacheprovider", *root, *args)


def test_properties_are_the_rows_of_a_report() -> None:
    """An arm of which everything can be checked has a row for each, in this order."""
    report = check(urdf_ik.load(ARM), n=3)
    assert tuple(row.name for row in report.rows) == PROPERTIES
    assert all(verdict(report, name)[0] is True for name in PROPERTIES)
    with pytest.raises(ArgumentError):
        verdict(report, "elegance")


def test_an_arm_that_agrees_gives_its_report() -> None:
    """By path, name, text or as an arm; the report is that of the cross-check."""
    report = assert_agrees_with_pinocchio(ARM, base="base_link", tip="tool0", n=5, seed=7)
    assert report.passed
    assert (report.n, report.seed, report.base, report.tip) == (5, 7, "base_link", "tool0")
    for urdf in ("zyyzyz_6r", ARM.read_text(), urdf_ik.load(ARM)):
        assert assert_agrees_with_pinocchio(urdf, n=2).joint_names == report.joint_names
    with pytest.raises(ChainError, match="hand"):
        assert_agrees_with_pinocchio(ARM, tip="hand")


def test_a_wrong_arm_fails_with_the_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """The message names the property, the worst value and how to replay it."""
    right = urdf_ik.Arm.fk
    monkeypatch.setattr(urdf_ik.Arm, "fk", lambda arm, q: right(arm, q) + 1e-6)
    with pytest.raises(AssertionError, match="FAILED forward kinematics, position: pose") as caught:
        assert_agrees_with_pinocchio(ARM, n=3)
    assert "replay" in str(caught.value)


def test_an_arm_that_cannot_be_solved_does_not_pass() -> None:
    """Kinematics alone is no agreement on inverse kinematics."""
    with pytest.raises(AssertionError, match="not checked: inverse kinematics"):
        assert_agrees_with_pinocchio(TWO_JOINTS, n=3)
    report = check(urdf_ik.load(TWO_JOINTS), n=3)
    assert verdict(report, "duplicates")[0] is False
    assert verdict(report, "collision, distance")[0] is None
    assert verdict(report, "Jacobian")[0] is True


def test_plugin_runs_one_test_a_property(pytester: pytest.Pytester) -> None:
    """Without a test file; several arms, each with its own links; -k chooses."""
    words = ["--urdf", str(ARM), "--urdf", "planar_2r", "--base", "base_link", "--tip", "tool0", "--tip", "tool0"]
    done = run(pytester, *words, "--urdf-poses", "5", "-v", "--urdf-no-lock")
    assert done.ret == 0
    done.assert_outcomes(passed=2 * len(PROPERTIES) + 2, skipped=2 * len(UNCHANGED))
    done.stdout.fnmatch_lines(["*zyyzyz_6r.urdf::planted joint vector PASSED*", "*planar_2r::duplicates PASSED*"])
    chosen = run(pytester, "--urdf", "planar_2r", "--urdf-poses", "2", "-m", "urdf", "-k", "Jacobian")
    chosen.assert_outcomes(passed=1, deselected=len(PROPERTIES) + len(UNCHANGED))


def test_plugin_stands_beside_the_users_tests(pytester: pytest.Pytester) -> None:
    """A wrong forward kinematics fails its own properties, in words; the user's tests run as well."""
    pytester.makeconftest(WRONG)
    pytester.makepyfile("def test_own(): pass")
    done = run(pytester, "--urdf", str(ARM), "--urdf-poses", "3", "-k", "forward or planted or test_own or read")
    done.assert_outcomes(passed=3, failed=2, deselected=len(PROPERTIES) - 3 + len(UNCHANGED))
    done.stdout.fnmatch_lines(["*forward kinematics, position: worst *", "*replay: q, T =*"])
    done.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.slow
def test_plugin_says_what_is_wrong_with_the_urdf(pytester: pytest.Pytester) -> None:
    """A file that is no URDF fails one test, with the reader's message; an unsolved arm fails what it lacks."""
    pytester.path.joinpath("broken.urdf").write_text("<robot name='x'><link")
    done = run(pytester, "--urdf", "broken.urdf", "-rs")
    done.assert_outcomes(failed=1, skipped=len(PROPERTIES) + len(UNCHANGED))
    done.stdout.fnmatch_lines(["*broken.urdf:1*", "*not run: broken.urdf or its lock cannot*'can be read' failed*"])
    # Whatever is chosen, an arm that cannot be read is a failure.
    chosen = run(pytester, "--urdf", "broken.urdf", "-k", "Jacobian or duplicates")
    chosen.assert_outcomes(failed=1, skipped=1, deselected=len(PROPERTIES) - 1 + len(UNCHANGED))
    assert chosen.ret == pytest.ExitCode.TESTS_FAILED
    pytester.path.joinpath("unsolved.urdf").write_text(TWO_JOINTS)
    run(pytester, "--urdf", "unsolved.urdf", "--urdf-poses", "2", "--urdf-no-lock").assert_outcomes(
        passed=8, failed=5, skipped=2 + len(UNCHANGED)
    )
    wrong = run(pytester, *["--urdf", "planar_2r"] * 3, *["--tip", "tool0"] * 2)
    assert wrong.ret == pytest.ExitCode.USAGE_ERROR
    wrong.stderr.fnmatch_lines(["*--tip is given 2 times, --urdf 3 times*"])


@pytest.mark.slow
@pytest.mark.parametrize("spelled", ["--urdf {0}", "--urdf={0}", "--urdf {0} --urdf-lock {1}"])
def test_plugin_leaves_the_root_and_the_configuration_alone(pytester: pytest.Pytester, spelled: str) -> None:
    """An absolute URDF of another folder, in any spelling: rootdir and pytest.ini stay those of the working folder."""
    elsewhere = pytester.path.parent / f"elsewhere_{pytester.path.name}"
    elsewhere.mkdir()
    elsewhere.joinpath("arm.urdf").write_text(ARM.read_text())
    lock = elsewhere / "arm.lock.json"
    urdf_ik.freeze(urdf_ik.load(ARM)).save(lock)
    pytester.path.joinpath("pytest.ini").write_text("[pytest]\nmarkers = mine: a mark\naddopts = --strict-markers\n")
    pytester.makepyfile("import pytest\n\n@pytest.mark.mine\ndef test_own(pytestconfig):\n"
                        f"    assert str(pytestconfig.rootpath) == {str(pytester.path)!r}\n")  # fmt: skip
    words = spelled.format(elsewhere / "arm.urdf", lock).split()
    done = pytester.runpytest_subprocess(
        "-p", "urdf_ik_pytest", *words, "--urdf-poses", "2", "-k", "read or own or names"
    )
    done.assert_outcomes(passed=3, deselected=len(PROPERTIES) + len(UNCHANGED) - 1)
    done.stdout.fnmatch_lines([f"rootdir: {pytester.path}", "configfile: pytest.ini"])
    assert (
        "arm.urdf::unchanged names"
        in pytester.runpytest_subprocess("-p", "urdf_ik_pytest", *words, "-k", "names", "-v").stdout.str()
    )


@pytest.mark.slow
def test_plugin_freezes_verifies_and_names_the_joint(pytester: pytest.Pytester) -> None:
    """--urdf-freeze writes what is missing; every small change fails the test of its kind, and names the joint."""
    arm = urdf_ik.load(ARM)
    path = pytester.path / "my_arm.urdf"
    path.write_text(ARM.read_text())
    quick = "--urdf-poses", "2", "-k", "unchanged"
    alone = run(pytester, "--urdf", "my_arm.urdf", *quick)
    alone.assert_outcomes(failed=1, skipped=len(UNCHANGED) - 1, deselected=len(PROPERTIES) + 1)
    alone.stdout.fnmatch_lines(["*no lock file *my_arm.lock.json*--urdf-no-lock*"])
    run(pytester, "--urdf", "my_arm.urdf", "--urdf-no-lock", *quick).assert_outcomes(
        skipped=len(UNCHANGED), deselected=len(PROPERTIES) + 1
    )
    run(pytester, "--urdf", "my_arm.urdf", "--urdf-freeze", *quick).assert_outcomes(
        passed=len(UNCHANGED), deselected=len(PROPERTIES) + 1
    )
    assert path.with_name("my_arm.lock.json").is_file()
    for mutant in list(mutants(arm))[::4]:
        path.write_bytes(mutant.xml)
        done = run(pytester, "--urdf", "my_arm.urdf", *quick)
        assert done.ret == pytest.ExitCode.TESTS_FAILED, mutant.what
        done.stdout.fnmatch_lines(
            [f"*{mutant.names[0]}*: *", "*if that is meant: urdf-ik verify my_arm.urdf*--update*"]
        )
        done.stdout.no_fnmatch_line("*Traceback*")
    missing = run(pytester, "--urdf", "my_arm.urdf", "--urdf-lock", "other.lock.json", *quick)
    assert missing.ret == pytest.ExitCode.TESTS_FAILED


@pytest.mark.slow
def test_plugin_hands_arms_and_locks_to_the_users_tests(pytester: pytest.Pytester) -> None:
    """Each test that takes them runs once an arm; without --urdf it is skipped; a fixture of the user's goes first."""
    pytester.makepyfile("def test_own(arm, arm_lock):\n    assert arm_lock.verify(arm).passed\n")
    done = run(pytester, "--urdf", "planar_2r", "--urdf", "scara_rrpr", "--urdf-freeze", "-k", "own", "-v")
    done.assert_outcomes(passed=2, deselected=2 * (len(PROPERTIES) + len(UNCHANGED) + 1))
    done.stdout.fnmatch_lines(["*test_own[[]planar_2r[]] PASSED*"])
    run(pytester).assert_outcomes(skipped=1)
    pytester.makepyfile("import pytest\n\n@pytest.fixture\ndef arm():\n    return 3\n\n"
                        "def test_own(arm):\n    assert arm == 3\n")  # fmt: skip
    run(pytester).assert_outcomes(passed=1)


def test_plugin_costs_nothing_where_it_is_not_asked_for(pytester: pytest.Pytester) -> None:
    """A run without --urdf collects what it did before, and imports neither the package nor what it needs."""
    pytester.makepyfile(
        """
        import sys

        def test_own():
            assert not {"urdf_ik", "pinocchio"} & set(sys.modules)  # numpy may be there: zarr's plugin imports it
        """
    )
    # An editable install is a module that Python imports at its start, of which pytest warns.
    editable = "ignore:Module already imported so cannot be rewritten; _editable:pytest.PytestAssertRewriteWarning"
    done = run(pytester, "--strict-markers", "-W", "error", "-W", editable)
    done.assert_outcomes(passed=1)
