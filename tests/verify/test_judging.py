"""Solvers judged: a right one passes, and each seeded fault is found with its pose."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call, succeed

import urdf_ik
from urdf_ik.errors import ArgumentError
from urdf_ik.verify import judge, judging
from urdf_ik.verify.judging import opened, replay
from urdf_ik.verify.sampling import least_singular_value

PUMA = urdf_ik.load("puma_560")


def right(T: Any) -> Any:
    """This package's own answers."""
    return PUMA.ik(T).to_array()


@pytest.mark.parametrize(
    "name", ["puma_560", "ur5", "zyyzyz_6r", "scara_rrpr", "stanford_rrprrr", "planar_2r", "srs_7r"]
)
def test_a_right_solver_passes(name: str) -> None:
    """At every kind of pose, singular ones too, in any order, with whole turns added."""
    arm = urdf_ik.load(name)
    turn = np.where(arm.chain.prismatic, 0.0, 2.0 * np.pi)

    def solve(T: Any) -> Any:
        if arm.task != "pose":
            return arm.for_task(arm.task).ik(arm.solver.control.target_of(T)).to_array()[::-1] + turn
        return arm.ik(T).to_array()[::-1] + turn

    found = judge(arm, solve, n=8)
    assert found.passed, found
    assert [kind.poses for kind in found.kinds] == [8] * 5


@pytest.mark.parametrize(
    ("seeded", "fault"),
    [
        (lambda q: q[1:], "missing"),  # a branch is lost
        (lambda q: q * [1.0, 1.0, -1.0, 1.0, 1.0, 1.0], "wrong"),
        (lambda q: q + [0.0, 0.0, 0.0, 0.0, 1e-6, 0.0], "wrong"),
        (lambda q: np.concatenate([q, q[:1]]), "doubled"),
    ],
)
def test_each_seeded_fault_is_found_with_its_pose(seeded: Callable[[np.ndarray], np.ndarray], fault: str) -> None:
    """One of 25 poses is enough, and its pose comes again."""
    at = replay(PUMA, n=5, seed=3, index=2)

    def solve(T: Any) -> Any:
        q = right(T)
        return seeded(q) if np.array_equal(T, at) else q

    found = judge(PUMA, solve, n=5, seed=3)
    assert not found.passed
    own = [each for each in found.faults if each.fault == fault]
    assert own and {each.index for each in found.faults} == {2}
    assert "index=2" in str(found)
    assert {kind.name for kind in found.kinds if kind.wrong or kind.missing or kind.doubled} == {"random"}


def test_what_is_flagged_as_approximate_is_no_claim() -> None:
    """Flagged, a wrong vector is not wrong and a right one is found; at a singular solution a copy is no fault."""

    def solve(T: Any) -> Any:
        q = right(T)
        return np.vstack([q, q[:1] + 0.1]), np.array([True] * len(q) + [True])

    assert judge(PUMA, solve, n=4).passed
    unflagged = judge(PUMA, lambda T: (solve(T)[0], np.zeros(len(solve(T)[0]), dtype=bool)), n=4)
    assert {each.fault for each in unflagged.faults} == {"wrong"}
    odd = judge(PUMA, lambda T: (right(T), np.zeros(3, dtype=bool)), n=1)
    assert {each.fault for each in odd.faults} == {"failed"}
    copies = judge(PUMA, lambda T: np.vstack([right(T), right(T)]), n=6).faults
    assert {each.kind for each in copies} >= {"random", "near singularity"}
    assert least_singular_value(PUMA, np.array([each.q for each in copies])).min() > 1e-6


def test_a_planted_vector_that_this_package_lacked_would_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a package that forgets a branch, the vectors that poses are made of are expected all the same."""
    whole = judging.solutions_of

    def forgetful(*given: Any) -> Any:
        found = whole(*given)
        return found.nearest(np.full(6, 0.1)) if found.count.any() else found

    monkeypatch.setattr(judging, "solutions_of", forgetful)
    found = judge(PUMA, right, n=6)
    assert sum(kind.further for kind in found.kinds) > 0 and "that the reference lacks" in str(found)


def test_limits_errors_and_odd_answers() -> None:
    """A solver that is to keep inside the limits; one that raises; one that returns other shapes, NaN or text."""
    assert judge(PUMA, lambda T: PUMA.ik(T).within_limits().to_array(), n=5, within_limits=True).passed
    outside = judge(PUMA, right, n=5, within_limits=True)
    assert any(each.fault == "outside limits" for each in outside.faults)

    def raises(T: Any) -> Any:
        raise RuntimeError("no")

    failed = judge(PUMA, raises, n=1)
    assert {each.fault for each in failed.faults} == {"failed"}
    assert 'raise RuntimeError("no")' in str(failed) and "self._solve" not in str(failed)
    for odd in (np.zeros((2, 5)), "text", np.zeros(()), object()):
        assert {each.fault for each in judge(PUMA, lambda T, odd=odd: odd, n=1).faults} == {"failed"}
    for nothing in (None, [], np.full((8, 6), np.nan)):
        found = judge(PUMA, lambda T, nothing=nothing: nothing, n=1)
        assert {each.fault for each in found.faults} == {"missing"}
    infinite = judge(PUMA, lambda T: [[np.inf] * 6], n=1)
    assert {"wrong", "missing"} == {each.fault for each in infinite.faults}
    with pytest.raises(ArgumentError):
        judge(PUMA, 3, n=1)  # type: ignore[arg-type]


SOLVER = """
import json, sys
import numpy as np
import urdf_ik
arm = urdf_ik.load("puma_560")
def solve(T):
    return arm.ik(np.array(T)).to_array()
if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps({"q": solve(json.loads(line)["T"]).tolist()}), flush=True)
"""


def test_a_file_a_process_and_their_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A function of a file, a process by lines of JSON; one that ends or talks nonsense is a fault."""
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(SOLVER)
    for number, code in enumerate(
        ("", "print('nonsense', flush=True); input()", "import json; input(); print(json.dumps({'error': 'no'}))")
    ):
        Path(f"odd_{number}.py").write_text(code)
        with opened(f"process:{sys.executable} odd_{number}.py") as solve:
            assert {each.fault for each in judge(PUMA, solve, n=1).faults} == {"failed"}
    for spec in ("mine.py:solve", f"process:{sys.executable} mine.py"):
        with opened(spec) as solve:
            assert judge(PUMA, solve, n=2).passed
    for spec in ("nothing", "mine.py:absent", "no.such.module:solve", "absent.py:solve", "process:/no/such/program"):
        with pytest.raises(ArgumentError), opened(spec):
            pass


def test_the_command_judges(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Status 0 and 1; an unknown solver is a usage error that lists the forms."""
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(SOLVER + "\ndef forgetful(T):\n    return solve(T)[1:]\n")

    judged = ("judge", "puma_560", "-n", "2", "--solver")
    for spec in ("mine.py:solve", f"process:{sys.executable} mine.py"):
        succeed(*judged, spec)
    result = call(*judged, "mine.py:forgetful")
    assert result.exit_code == 1 and "missing" in result.stdout
    names: dict[str, Any] = {}
    exec("\n".join(line[8:] for line in result.stdout.splitlines() if line.startswith("replay: ")), names)
    np.testing.assert_array_equal(names["T"], replay(PUMA, 2, 0, 0))
    assert "mine.py has no function 'nosuch'" in call(*judged, "mine.py:nosuch").stderr
    result = call(*judged, "nothing")
    assert result.exit_code == 2 and "process:COMMAND" in result.stderr
