"""Arm and load: from every kind of source to an arm that answers, explains, refuses and travels."""

from __future__ import annotations

import io
import math
import pickle
import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin
import pytest
from arms import DescribedArm, industrial, random_arm, serial_urdf, ur_like
from cases import assert_exact, described, from_catalogue, nearest, rows
from numpy.typing import NDArray
from oracle import Oracle, angle_distance

import urdf_ik
from urdf_ik import arm as arm_module
from urdf_ik import catalogue
from urdf_ik.arm import Arm
from urdf_ik.errors import CatalogueError, ChainError, PoseError, UnsupportedArm, UrdfError

Array = NDArray[np.float64]
Q = np.array([0.3, 0.5, 0.9, 0.4, 0.8, -0.2])
TEXT = ur_like().urdf


# ---------------------------------------------------------------- load


def _write(folder: Path) -> Path:
    """The text as a file."""
    file = folder / "an arm.urdf"
    file.write_text(TEXT)
    return file


SOURCES: dict[str, Callable[[Path], Any]] = {
    "text": lambda folder: TEXT,
    "text behind white space": lambda folder: "\n  " + TEXT,
    "text with a declaration": lambda folder: '<?xml version="1.0"?>\n' + TEXT,
    "path": _write,
    "path as text": lambda folder: str(_write(folder)),
    "text stream": lambda folder: io.StringIO(TEXT),
    "binary stream": lambda folder: io.BytesIO(TEXT.encode()),
}


@pytest.mark.parametrize("kind", SOURCES)
def test_load_from(kind: str, tmp_path: Path) -> None:
    """XML text, a path of either type and an open file of either mode give the same arm."""
    arm = urdf_ik.load(SOURCES[kind](tmp_path), "base", "tool")
    expected = urdf_ik.load(TEXT, base="base", tip="tool")
    assert (arm.name, arm.base, arm.tip, arm.dof) == ("ur_like", "base", "tool", 6)
    assert arm.joint_names == expected.joint_names == tuple(f"joint_{i}" for i in range(1, 7))
    np.testing.assert_array_equal(arm.fk(Q), expected.fk(Q))
    np.testing.assert_array_equal(arm.limits, expected.limits)
    assert arm.structure == expected.structure


def test_load_from_an_open_file(tmp_path: Path) -> None:
    """A file that is open stays open, and is read from where it stands."""
    file = _write(tmp_path)
    for mode in ("r", "rb"):
        with file.open(mode) as stream:
            assert urdf_ik.load(stream, "base", "tool").name == "ur_like"
            assert not stream.closed


def test_load_by_name() -> None:
    """A catalogue name brings base and tip along, either of which may be replaced."""
    entry = catalogue.resolve("zyyzyz_6r")
    by_name, by_path = urdf_ik.load("zyyzyz_6r"), urdf_ik.load(entry.path)
    assert (by_name.base, by_name.tip) == (entry.base, entry.tip) == (by_path.base, by_path.tip)
    oracle = Oracle(entry.path, "base_link", "tool0")
    np.testing.assert_allclose(by_name.fk(Q), oracle.pose(Q), atol=1e-14)
    shorter = by_name.chain.joint_names[:3]
    link = by_name.model.joints[[joint.name for joint in by_name.model.joints].index(shorter[-1])].child
    assert urdf_ik.load("zyyzyz_6r", tip=link).joint_names == shorter


def test_a_file_goes_before_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a file in this folder has the name of a catalogue arm, the file is meant."""
    (tmp_path / "ur5").write_text(TEXT)
    monkeypatch.chdir(tmp_path)
    assert urdf_ik.load("ur5", "base", "tool").name == "ur_like"


def test_unknown_names_and_missing_files() -> None:
    """A bare word that is no name raises CatalogueError with what is near; what looks like a path, UrdfError."""
    with pytest.raises(CatalogueError, match="zyyzyz_6r"):
        urdf_ik.load("zyyzyz-6r")
    for missing in ("nowhere/arm.urdf", "arm.urdf", Path("zyyzyz_6r_not_here")):
        with pytest.raises((UrdfError, OSError), match=re.escape(str(missing))):
            urdf_ik.load(missing)


TWO_HANDS = """<robot name="two">
  <link name="base"/><link name="body"/><link name="left"/><link name="right"/>
  <joint name="waist" type="continuous"><parent link="base"/><child link="body"/><axis xyz="0 0 1"/></joint>
  <joint name="l" type="continuous"><parent link="body"/><child link="left"/><axis xyz="0 1 0"/></joint>
  <joint name="r" type="continuous"><parent link="body"/><child link="right"/><axis xyz="0 1 0"/></joint>
</robot>"""


def test_ambiguous_tip() -> None:
    """With two movable chains the tip must be named; the error lists both ends, and naming one settles it."""
    with pytest.raises(ChainError) as error:
        urdf_ik.load(TWO_HANDS)
    assert {"left", "right"} <= set(error.value.candidates)
    assert "left" in str(error.value) and "right" in str(error.value)
    assert urdf_ik.load(TWO_HANDS, tip="left").joint_names == ("waist", "l")
    assert urdf_ik.load(TWO_HANDS, base="left", tip="right").joint_names == ("l", "r")


@pytest.mark.parametrize("which", ["base", "tip"])
def test_unknown_link(which: str) -> None:
    """An unknown base or tip raises ChainError with the links that there are, the nearest one first."""
    with pytest.raises(ChainError, match="rigth") as error:
        urdf_ik.load(TWO_HANDS, **{"base": "base", "tip": "left", which: "rigth"})
    assert error.value.candidates[0] == "right"
    assert set(error.value.candidates) == {"base", "body", "left", "right"}


def test_broken_urdf() -> None:
    """A defect in the file comes out of load as it came out of the reader, with its line."""
    with pytest.raises(UrdfError) as error:
        urdf_ik.load(TEXT.replace('type="revolute"', 'type="revolving"', 1), "base", "tool")
    assert error.value.line is not None


# ---------------------------------------------------------------- what an arm says of itself


def test_repr() -> None:
    """The name, the links and the family stand in the representation; the number of joints where there is none."""
    assert repr(urdf_ik.load(TEXT, "base", "tool")) == "<Arm 'ur_like': base to tool, 6R 2||3||4 and 5x6>"
    assert repr(urdf_ik.load(TWO_HANDS, tip="left")) == "<Arm 'two': base to left, 2R>"
    assert repr(urdf_ik.load(_long(8), "base", "tool")) == "<Arm '8R': base to tool, 8 joints>"


@pytest.mark.parametrize("attribute", ["name", "base", "tip", "joint_names", "dof", "limits"])
def test_an_arm_does_not_change(attribute: str) -> None:
    """What an arm says of itself cannot be assigned, and its arrays cannot be written to."""
    arm = urdf_ik.load(TEXT, "base", "tool")
    with pytest.raises(AttributeError):
        setattr(arm, attribute, None)
    with pytest.raises(ValueError, match="read-only"):
        arm.limits[0] = 0.0


@pytest.mark.parametrize("used", [False, True])
@pytest.mark.parametrize(
    "described_arm", [industrial(), ur_like(), random_arm("wrist, general", 1)], ids=lambda arm: arm.name
)
def test_pickle(described_arm: DescribedArm, used: bool) -> None:
    """An arm comes back from pickling with its structure and, before or after its first use, the same answers."""
    arm = urdf_ik.load(described_arm.urdf, "base", "tool")
    target = arm.fk(Q)
    expected = urdf_ik.load(described_arm.urdf, "base", "tool").ik(target)
    if used:
        arm.ik(target)
    again = pickle.loads(pickle.dumps(arm))
    assert repr(again) == repr(arm)
    assert again.structure == arm.structure
    np.testing.assert_array_equal(again.fk(Q), arm.fk(Q))
    np.testing.assert_array_equal(again.limits, arm.limits)
    np.testing.assert_array_equal(again.ik(target).q, expected.q)
    assert again.model.xml == arm.model.xml


# ---------------------------------------------------------------- ik


def test_nested_lists_of_pinocchio_poses() -> None:
    """SE3 objects in lists of lists are a batch of that shape."""
    case = from_catalogue("zyyzyz_6r")
    targets = case.oracle.poses(case.oracle.draw(np.random.default_rng(0), 6)).reshape(2, 3, 4, 4)
    given = [[pin.SE3(pose) for pose in row] for row in targets]
    solutions = case.arm.ik(given)
    assert solutions.q.shape == (2, 3, 8, 6)
    np.testing.assert_allclose(solutions.q, case.arm.ik(targets).q, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize("form", ["array", "Fortran", "read-only view", "float32", "list"])
def test_answers_do_not_follow_the_callers_array(form: str) -> None:
    """Overwriting the target after the call changes neither the solutions nor the pose that they belong to."""
    case = from_catalogue("zyyzyz_6r")
    far = np.eye(4)
    far[0, 3] = 3.0
    for target in (case.oracle.pose(Q), far):
        mine: Any = {
            "array": target.copy(),
            "Fortran": np.asfortranarray(target),
            "read-only view": target.copy(),
            "float32": target.astype(np.float32),
            "list": target.tolist(),
        }[form]
        given = mine
        if form == "read-only view":
            given = mine.view()
            given.setflags(write=False)
        wanted = np.array(mine, dtype=np.float64)
        solutions = case.arm.ik(given)
        q, text = solutions.q.copy(), solutions.explain()
        for row in mine:
            row[:] = [9.0] * 4
        np.testing.assert_array_equal(solutions.q, q)
        np.testing.assert_array_equal(solutions.poses, wanted)
        assert solutions.explain() == text


@pytest.mark.parametrize("described_arm", [industrial(), ur_like(), random_arm("2||3||4", 1)], ids=lambda a: a.name)
@pytest.mark.parametrize("threads", [2, 3, 4])
def test_threads_share_a_batch(described_arm: DescribedArm, threads: int) -> None:
    """Two, three and four threads give, bit for bit, what one thread gives, for batches that do not divide evenly."""
    arm = urdf_ik.load(described_arm.urdf, "base", "tool")
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (3001, 6))
    q[::9, 4] = 0.0
    targets = arm.fk(q)
    targets[::7, :3, 3] *= 5.0
    alone, together = arm.ik(targets), arm.ik(targets, threads=threads)
    np.testing.assert_array_equal(together.q, alone.q)
    np.testing.assert_array_equal(together.valid, alone.valid)
    np.testing.assert_array_equal(together.singular, alone.singular)


@pytest.mark.parametrize("bad", [(0,), (1700,), (2999,), (2500, 700), (700, 1600, 2999)])
def test_the_first_bad_pose_is_named_whatever_thread_meets_it(bad: tuple[int, ...]) -> None:
    """With bad poses in several threads' shares the error still tells the first."""
    arm = from_catalogue("zyyzyz_6r").arm
    targets = np.tile(np.eye(4), (3000, 1, 1))
    targets[:, 2, 3] = 2.0
    for index in bad:
        targets[index, 0, 0] = np.nan
    for threads in (1, 2, 4):
        with pytest.raises(PoseError) as error:
            arm.ik(targets, threads=threads)
        assert error.value.index == (min(bad),)


@pytest.mark.parametrize(
    "turns",
    [(0, 0), (1, -1), (-2, 1), (2, 0), (0, 2), (1, -4)],
    ids=str,
)
def test_reference_a_turn_away(turns: tuple[int, int]) -> None:
    """A reference counts modulo whole turns: near a free wrist the member nearest to it is the planted one.

    A joint with limits of +-2 pi, or a continuous one that has wound up, stands such turns away.
    """
    for name in ("zyyzyz_6r", "ur5"):
        case = from_catalogue(name)
        planted = Q.copy()
        planted[4] = 0.0
        reference = planted.copy()
        reference[[3, 5]] += 2.0 * np.pi * np.array(turns)
        found = rows(case.arm.ik(case.oracle.pose(planted), q_ref=reference))
        assert nearest(found, planted) < 1e-6, name


# ---------------------------------------------------------------- arms that no solver takes


def _long(n: int) -> str:
    """A chain of n skew axes."""
    rng = np.random.default_rng(n)
    origins = [(rng.uniform(0.1, 0.4, 3), rng.uniform(-1.0, 1.0, 3)) for _ in range(n + 1)]
    return serial_urdf(f"{n}R", origins, [*rng.normal(size=(n, 3)), None])


SLIDING = TEXT
for _joint in ("joint_2", "joint_5"):
    SLIDING = SLIDING.replace(f'name="{_joint}" type="revolute"', f'name="{_joint}" type="prismatic"')


@pytest.mark.parametrize(
    ("text", "words"),
    [(_long(8), "8 joints from 'base' to 'tool'"), (SLIDING, "6 joints (RPRRPR)")],
    ids=["8R", "RPRRPR"],
)
def test_unsupported_arm(text: str, words: str) -> None:
    """An arm of no family loads, moves and tells its axes; only asking for solutions raises, with a way out."""
    arm = urdf_ik.load(text, "base", "tool")
    names = tuple(f"joint_{i}" for i in range(1, arm.dof + 1))
    oracle = Oracle(text)
    assert arm.joint_names == oracle.names == names
    for q in np.random.default_rng(2).uniform(-1.0, 1.0, (3, arm.dof)):
        np.testing.assert_allclose(arm.fk(q), oracle.pose(q), atol=1e-13)
        np.testing.assert_allclose(arm.jacobian(q), oracle.jacobian(q), atol=1e-13)
        np.testing.assert_allclose(arm.link_poses(q)["tool"], oracle.pose(q), atol=1e-13)
    for ask in (arm.ik, arm.explain):
        with pytest.raises(UnsupportedArm) as error:
            ask(np.eye(4))
        assert words in str(error.value)
        assert "locked={" in str(error.value) or str(arm.structure) in str(error.value)
        assert arm.name in str(error.value)


# ---------------------------------------------------------------- explain


def numbers_in(text: str) -> list[float]:
    """The numbers that stand before 'm', a length."""
    return [float(number) for number in re.findall(r"(\d[\d.e+-]*) m\b", text)]


def origin_of(oracle: Oracle, joint: int, q: Array) -> Array:
    """Place (3,) [m] of a joint's frame in the base, by Pinocchio; joints count from 1."""
    oracle.pose(q)
    base = oracle.data.oMf[oracle.base]
    return base.actInv(oracle.data.oMi[oracle.joints[joint - 1]]).translation


def placed(arm: Arm, centre: Array, wrist: Array, turn: Array) -> Array:
    """The target (4, 4) with a rotation that brings the point ``centre`` of the tip's frame to ``wrist``."""
    target = np.eye(4)
    target[:3, :3] = turn
    target[:3, 3] = wrist - turn @ centre
    assert arm.ik(target).count == 0
    return target


def turns(m: int) -> Array:
    """Random rotation matrices (m, 3, 3)."""
    rng = np.random.default_rng(12)
    return np.array([pin.exp3(rng.uniform(-2.0, 2.0, 3)) for _ in range(m)])


def test_explain_the_article_arm_out_of_reach() -> None:
    """The text tells the wrist centre's true distance from the shoulder, and the reach: 1 m and 1.1 m in line."""
    case = from_catalogue("zyyzyz_6r")
    shoulder, centre = origin_of(case.oracle, 2, np.zeros(6)), origin_of(case.oracle, 5, np.zeros(6))
    np.testing.assert_allclose([shoulder, centre], [[0.0, 0.0, 1.0], [0.0, 0.0, 3.1]], atol=1e-15)
    in_tip = (np.linalg.inv(case.oracle.pose(np.zeros(6))) @ [*centre, 1.0])[:3]
    for distance, turn in zip((2.1001, 2.5, 3.0, 12.0), turns(4), strict=True):
        direction = turn[0]
        target = placed(case.arm, in_tip, shoulder + distance * direction, turn)
        for text in (case.arm.explain(target), case.arm.ik(target).explain()):
            assert numbers_in(text) == pytest.approx([distance, 2.1], rel=1e-5)
            assert "shoulder" in text and "reach" in text


def test_explain_the_article_arm_folded() -> None:
    """Closer to the shoulder than the folded arm, the text tells that distance and the folded length of 0.1 m."""
    case = from_catalogue("zyyzyz_6r")
    in_tip = (np.linalg.inv(case.oracle.pose(np.zeros(6))) @ [0.0, 0.0, 3.1, 1.0])[:3]
    for distance, turn in zip((0.0999, 0.05, 0.001), turns(3), strict=True):
        target = placed(case.arm, in_tip, [0.0, 0.0, 1.0] + distance * turn[1], turn)
        text = case.arm.explain(target)
        assert numbers_in(text) == pytest.approx([distance, 0.1], rel=1e-5)
        assert "folded" in text


def test_explain_with_a_shoulder_offset() -> None:
    """The distance is the nearer of both ways to turn the shoulder, the reach that of the elbow's own lengths."""
    case = described(industrial())
    upper, lower = 0.6, math.hypot(0.35 + 0.35, 0.12)  # axis 2 to 3; axis 3 to the centre at (0.85, 1.22)
    in_tip = (np.linalg.inv(case.oracle.pose(np.zeros(6))) @ [0.85, 0.0, 1.22, 1.0])[:3]
    for turn in turns(3):
        wrist = np.array([1.2, 1.3, 0.9])
        target = placed(case.arm, in_tip, wrist, turn)
        distance = math.hypot(math.hypot(1.2, 1.3) - 0.15, 0.9 - 0.5)
        assert numbers_in(case.arm.explain(target)) == pytest.approx([distance, upper + lower], rel=1e-5)


def test_explain_with_a_lateral_offset() -> None:
    """Closer to axis 1 than the lateral offset, the text tells the distance from the axis and the offset."""
    case = described(industrial(b=0.1))
    in_tip = (np.linalg.inv(case.oracle.pose(np.zeros(6))) @ [0.85, 0.1, 1.22, 1.0])[:3]
    for turn in turns(3):
        target = placed(case.arm, in_tip, np.array([0.03, 0.04, 1.0]), turn)
        text = case.arm.explain(target)
        assert numbers_in(text) == pytest.approx([0.05, 0.1], rel=1e-5)
        assert "axis 1" in text


def test_explain_a_ur_beside_its_first_axis() -> None:
    """Where the wrist would be closer to axis 1 than the sideways offset, the text tells both, as the URDF has them."""
    case = from_catalogue("ur5")
    wrist = origin_of(case.oracle, 6, np.zeros(6))
    # Axes 5 and 6 meet in the point of axis 6 at the height of axis 5; axis 1 is z, axes 2 to 4 are y.
    meeting = np.array([wrist[0], origin_of(case.oracle, 5, np.zeros(6))[1], wrist[2]])
    in_tip = (np.linalg.inv(case.oracle.pose(np.zeros(6))) @ [*meeting, 1.0])[:3]
    for turn in turns(3):
        target = placed(case.arm, in_tip, np.array([0.06, -0.02, 0.4]), turn)
        text = case.arm.ik(target).explain()
        assert numbers_in(text) == pytest.approx([math.hypot(0.06, 0.02), abs(meeting[1])], rel=1e-5)
        assert "axis 1" in text and "axes 5 and 6" in text


def test_explain_a_ur_out_of_reach() -> None:
    """The text tells how far apart the pose wants axes 2 and 4, and the reach of the two links between them."""
    case = from_catalogue("ur5")
    places = [origin_of(case.oracle, joint, np.zeros(6)) for joint in (2, 3, 4)]
    across = [np.array([p[0], p[2]]) for p in places]  # seen along y, the direction of axes 2 to 4
    links = math.dist(across[0], across[1]) + math.dist(across[1], across[2])
    for turn in turns(3):
        target = np.eye(4)
        target[:3, :3] = turn
        for place in ([0.0, 5.0, 0.0], [0.9, 0.9, 0.1]):
            target[:3, 3] = place
            wanted, reach = numbers_in(case.arm.explain(target))
            assert reach == pytest.approx(links, rel=1e-5)
            # Axis 2 is 0.09 m above the base's origin, axis 4 within 0.21 m of the tip, 0.11 m beside axis 2.
            assert links < wanted < math.hypot(*place) + 0.3
            assert wanted > math.hypot(*place) - 0.45


@pytest.mark.parametrize("kind", ["wrist, 1x2", "wrist, 1||2", "wrist, general", "2||3||4"])
def test_explain_every_family(kind: str) -> None:
    """Whatever the family, a pose far away is explained by a length in metres, and a reachable one by nothing."""
    case = described(random_arm(kind, 1))
    far = np.eye(4)
    far[:3, 3] = [40.0, 30.0, 20.0]
    assert max(numbers_in(case.arm.ik(far).explain())) > 10.0
    assert case.arm.ik(case.oracle.pose(Q)).explain() == ""


@pytest.mark.parametrize(
    "bad",
    [np.full((4, 4), np.nan), np.eye(3), np.zeros((2, 4, 4)), "pose"],
    ids=["NaN", "3 by 3", "a batch", "text"],
)
def test_explain_wants_one_pose(bad: Any) -> None:
    """What is no single pose is refused by explain as by ik, instead of being read beyond its end."""
    with pytest.raises(PoseError):
        from_catalogue("zyyzyz_6r").arm.explain(bad)


# ---------------------------------------------------------------- the first call


class AtOnce:
    """A timer that does not wait, and tells how long it was to."""

    waits: ClassVar[list[float]] = []

    def __init__(self, seconds: float, function: Callable[[], None]) -> None:
        """Keep both."""
        self.waits.append(seconds)
        self.function = function
        self.daemon = False

    def start(self) -> None:
        """Do it now."""
        self.function()

    def cancel(self) -> None:
        """Too late."""


def test_a_slow_first_call_says_so(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    """A first call that takes over two seconds tells stderr what it is doing, once."""
    arm = urdf_ik.load(TEXT, "base", "tool")
    monkeypatch.setattr(AtOnce, "waits", [])
    monkeypatch.setattr(arm_module.threading, "Timer", AtOnce)
    for _ in range(2):
        assert arm.ik(arm.fk(Q)).count > 0
    written = capfd.readouterr()
    assert written.out == ""
    assert written.err.count("compiling the solver for '6R 2||3||4 and 5x6'") == 1
    assert set(AtOnce.waits) == {2.0}


def test_a_fast_first_call_is_silent(capfd: pytest.CaptureFixture[str]) -> None:
    """Where it does not take so long nothing is written, and no timer is left behind."""
    case = from_catalogue("zyyzyz_6r")
    case.arm.ik(np.eye(4))  # whatever there is to compile is compiled
    before = threading.active_count()
    arm = urdf_ik.load("zyyzyz_6r")
    assert arm.ik(arm.fk(Q)).count == 8
    for thread in threading.enumerate():
        if isinstance(thread, threading.Timer):
            thread.join(5.0)
    assert threading.active_count() == before
    assert capfd.readouterr() == ("", "")


# ---------------------------------------------------------------- a chain with other ends


@pytest.mark.parametrize("described_arm", [ur_like(), industrial()], ids=lambda a: a.name)
def test_an_arm_that_is_solved_from_its_tool(described_arm: DescribedArm) -> None:
    """With base and tip swapped the arm still loads and moves; where a family takes it, its solutions are exact."""
    arm = urdf_ik.load(described_arm.urdf, "tool", "base")
    forward = described(described_arm)
    q = Q[::-1]
    target = np.linalg.inv(forward.oracle.pose(Q))
    np.testing.assert_allclose(arm.fk(q), target, atol=1e-13)
    assert arm.joint_names == forward.arm.joint_names[::-1]
    if not arm.structure.family:
        return
    found = rows(arm.ik(target))
    expected = rows(forward.arm.ik(np.linalg.inv(target)))
    assert len(found) == len(expected)
    for solution in found:
        assert forward.oracle.error(solution[::-1], np.linalg.inv(target)) < 1e-9
        assert float(angle_distance(expected, solution[::-1]).min()) < 1e-6


def test_solutions_belong_to_their_arm() -> None:
    """Two arms in one process, each with its own URDF, do not share state: each answers for its own."""
    short, tall = described(industrial()), described(industrial(tool=(0.3, 0.1, 0.2)))
    target = short.oracle.pose(Q)
    for case in (short, tall, short):
        assert_exact(case, case.arm.ik(target), target)
        assert case.arm.ik(target).arm is case.arm
