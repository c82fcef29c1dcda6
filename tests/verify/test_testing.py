"""What the package offers for tests of one's own: an assertion, and a plugin of pytest."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import urdf_ik
from urdf_ik import ArgumentError, ChainError
from urdf_ik.model import catalogue
from urdf_ik.verify.crosscheck import PROPERTIES, check
from urdf_ik.verify.testing import assert_agrees_with_pinocchio, verdict

ARM = catalogue.resolve("zyyzyz_6r").path
# Two joints about one axis: no solver takes it.
UNSOLVED = """<robot name="two"><link name="a"/><link name="b"/><link name="c"/>
<joint name="one" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="two" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
</robot>"""
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
        assert_agrees_with_pinocchio(UNSOLVED, n=3)
    report = check(urdf_ik.load(UNSOLVED), n=3)
    assert verdict(report, "duplicates")[0] is False
    assert verdict(report, "collision, distance")[0] is None
    assert verdict(report, "Jacobian")[0] is True


def test_plugin_runs_one_test_a_property(pytester: pytest.Pytester) -> None:
    """Without a test file; several arms, each with its own links; -k chooses."""
    words = ["--urdf", str(ARM), "--urdf", "planar_2r", "--base", "base_link", "--tip", "tool0", "--tip", "tool0"]
    done = run(pytester, *words, "--urdf-poses", "5", "-v")
    assert done.ret == 0
    done.assert_outcomes(passed=2 * len(PROPERTIES) + 2)
    done.stdout.fnmatch_lines(["*zyyzyz_6r.urdf::planted joint vector PASSED*", "*planar_2r::duplicates PASSED*"])
    chosen = run(pytester, "--urdf", "planar_2r", "--urdf-poses", "2", "-m", "urdf", "-k", "Jacobian")
    chosen.assert_outcomes(passed=1, deselected=len(PROPERTIES))


def test_plugin_stands_beside_the_users_tests(pytester: pytest.Pytester) -> None:
    """A wrong forward kinematics fails its own properties, in words; the user's tests run as well."""
    pytester.makeconftest(WRONG)
    pytester.makepyfile("def test_own(): pass")
    done = run(pytester, "--urdf", str(ARM), "--urdf-poses", "3", "-k", "forward or planted or test_own or read")
    done.assert_outcomes(passed=3, failed=2, deselected=len(PROPERTIES) - 3)
    done.stdout.fnmatch_lines(["*forward kinematics, position: worst *", "*replay: q, T =*"])
    done.stdout.no_fnmatch_line("*Traceback*")


def test_plugin_says_what_is_wrong_with_the_urdf(pytester: pytest.Pytester) -> None:
    """A file that is no URDF fails one test, with the reader's message; an unsolved arm fails what it lacks."""
    pytester.path.joinpath("broken.urdf").write_text("<robot name='x'><link")
    done = run(pytester, "--urdf", "broken.urdf", "-rs")
    done.assert_outcomes(failed=1, skipped=len(PROPERTIES))
    done.stdout.fnmatch_lines(["*broken.urdf:1*", "*not run: broken.urdf cannot be read*'can be read' failed*"])
    # Whatever is chosen, an arm that cannot be read is a failure.
    chosen = run(pytester, "--urdf", "broken.urdf", "-k", "Jacobian or duplicates")
    chosen.assert_outcomes(failed=1, skipped=1, deselected=len(PROPERTIES) - 1)
    assert chosen.ret == pytest.ExitCode.TESTS_FAILED
    pytester.path.joinpath("unsolved.urdf").write_text(UNSOLVED)
    run(pytester, "--urdf", "unsolved.urdf", "--urdf-poses", "2").assert_outcomes(passed=8, failed=5, skipped=2)
    wrong = run(pytester, *["--urdf", "planar_2r"] * 3, *["--tip", "tool0"] * 2)
    assert wrong.ret == pytest.ExitCode.USAGE_ERROR
    wrong.stderr.fnmatch_lines(["*--tip is given 2 times, --urdf 3 times*"])


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


def test_importing_the_plugin_imports_pytest_alone() -> None:
    """In a fresh interpreter."""
    code = (
        "import pytest, sys, json; before = set(sys.modules); import urdf_ik_pytest; "
        "print(json.dumps([*set(sys.modules) - before]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert json.loads(done.stdout) == ["urdf_ik_pytest"]
    assert Path(urdf_ik.__file__).parents[1].joinpath("urdf_ik_pytest.py").is_file()
