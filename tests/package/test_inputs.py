"""What is given from outside is read in one way everywhere: numbers that are none, and numbers out of range."""

from __future__ import annotations

import datetime
import enum
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik import UrdfIkError
from urdf_ik.arm import with_positioner
from urdf_ik.kinematics import velocity
from urdf_ik.model import poses
from urdf_ik.support import inputs

SIX, SEVEN, TWO = (urdf_ik.load(name) for name in ("zyyzyz_6r", "srs_7r", "planar_2r"))
Q6, Q7 = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]), np.array([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])
T6, T7 = SIX.fk(Q6), SEVEN.fk(Q7)
SOLUTIONS = SIX.ik(T6)
TRACKER = SIX.tracker(Q6, dt=0.01)
REGION = urdf_ik.maps.workspaces.planar(TWO)
REPORT = urdf_ik.verify.crosscheck.check(TWO, 2)
CORNERS = np.stack([urdf_ik.pose([0, 0, 0]), urdf_ik.pose([0.1, 0, 0])])

# What takes an array, and an array that it takes.
ARRAYS: dict[str, tuple[Callable[[Any], Any], Any]] = {
    "fk": (SIX.fk, Q6), "jacobian": (SIX.jacobian, Q6), "link_poses": (SIX.link_poses, Q6), "ik": (SIX.ik, T6),
    "ik, reference": (lambda q: SIX.ik(T6, q), Q6), "ik, redundancy": (lambda v: SEVEN.ik(T7, redundancy=v), 0.3),
    "ik, task": (lambda x: TWO.ik(x, task="planar position"), [0.1, 0.1]), "explain": (SIX.explain, T6),
    "ik_nearest": (lambda q: SIX.ik_nearest(T6, q), Q6),
    "weights": (lambda w: SIX.ik_nearest(T6, Q6, weights=w), Q6**2),
    "within": (lambda w: SIX.ik_nearest(T6, Q6, within=w), np.ones(6)), "nearest": (SOLUTIONS.nearest, Q6),
    "redundancy_of": (SEVEN.redundancy_of, Q7), "sweep": (lambda T: SEVEN.sweep(T, 4), T7),
    "manipulability": (SIX.manipulability, Q6),
    "twist": (lambda v: velocity.joint_velocities(SIX.chain, Q6, v), np.ones(6)),
    "to_pinocchio": (SIX.to_pinocchio, Q6), "from_pinocchio": (SIX.from_pinocchio, Q6),
    "clearance": (SIX.clearance, Q6), "in_collision": (SIX.cell.collisions.in_collision, Q6),
    "motion_is_free": (lambda q: SIX.motion_is_free(q, Q6), Q6), "pose": (urdf_ik.pose, [0.1, 0.2, 0.3]),
    "rotation vector": (lambda r: urdf_ik.pose([0, 0, 0], rotvec=r), [0.1, 0.2, 0.3]),
    "to_rpy": (urdf_ik.model.poses.to_rpy, T6),
    "check_poses": (poses.check_poses, T6), "line": (lambda T: urdf_ik.line(T, T6, 3), T6),
    "arc": (lambda p: urdf_ik.arc(urdf_ik.pose([1, 0, 0]), p, urdf_ik.pose([-1, 0, 0]), 3), [0, 1, 0]),
    "polyline": (lambda T: urdf_ik.polyline(T, 0.05), CORNERS), "tracker": (lambda q: SIX.tracker(q, dt=0.01), Q6),
    "step": (TRACKER.step, T6), "Box": (urdf_ik.Box, (0.1, 0.1, 0.1)),
    "Points": (lambda p: urdf_ik.Points(p, 0.1), [[0, 0, 1]]),
    "obstacle": (lambda T: urdf_ik.World().add("box", urdf_ik.Box((1, 1, 1)), T), T6),
    "tool": (lambda T: SIX.with_tool(T), T6), "region": (REGION.reaches, [0.1, 0.1]),
    "elbow": (REGION.elbow, [0.1, 0.1]),
    "table": (lambda rows: urdf_ik.DHTable.from_array(rows, "standard"), [[0.1, 0.3, 0.2, 0.1]]),
}  # fmt: skip
# What takes a number, and one that it takes.
NUMBERS: dict[str, tuple[Callable[[Any], Any], float]] = {
    "locked": (lambda x: urdf_ik.load("zyyzyz_6r", locked={"joint_1": x}), 0.3),
    "explain, redundancy": (lambda x: SEVEN.explain(T7, x), 0.3), "tolerance": (SOLUTIONS.within_limits, 0.1),
    "turns": (SOLUTIONS.turns, 0.1), "margin": (lambda x: SOLUTIONS.collision_free(margin=x), 0.1),
    "in_collision, margin": (lambda x: SIX.cell.collisions.in_collision(Q6, x), 0.1),
    "length": (lambda x: velocity.condition_number(SIX.chain, Q6, length=x), 0.5),
    "dt": (lambda x: SIX.tracker(Q6, dt=x), 0.01),
    "damping": (lambda x: velocity.joint_velocities(SIX.chain, Q6, np.ones(6), damping=x), 0.1),
    "Sphere": (urdf_ik.Sphere, 0.1), "step": (lambda x: urdf_ik.polyline(CORNERS, x), 0.05),
    "blend": (lambda x: urdf_ik.polyline(CORNERS, 0.05, blend=x), 0.01),
    "voxel": (lambda x: urdf_ik.maps.workspace(TWO, voxel=x, orientations=2), 0.2),
    "project_rotation": (lambda x: poses.project_rotation(T6, x), 0.1),
}  # fmt: skip
# What takes a whole number, and one that it takes.
WHOLE: dict[str, tuple[Callable[[Any], Any], int]] = {
    "threads": (lambda n: SIX.ik(np.stack([T6, T6]), threads=n), 2), "sweep": (lambda n: SEVEN.sweep(T7, n), 4),
    "threads of a region": (lambda n: SIX.ik_nearest(T6, Q6, region=urdf_ik.Region(box=0.01), threads=n), 2),
    "threads of a sweep": (lambda n: SEVEN.sweep(T7, 4, threads=n), 2),
    "threads of intervals": (lambda n: SEVEN.intervals(T7, threads=n), 2),
    "threads of the nearest": (lambda n: SEVEN.ik_nearest(T7, Q7, threads=n), 2),
    "threads of a map": (lambda n: urdf_ik.maps.workspace(TWO, voxel=0.2, orientations=2, threads=n), 2),
    "columns": (lambda n: SOLUTIONS.nearest(Q6, n=n), 2), "line": (lambda n: urdf_ik.line(T6, T6, n), 3),
    "orientations": (lambda n: urdf_ik.maps.workspace(TWO, voxel=0.2, orientations=n), 2),
    "compare": (lambda n: urdf_ik.compare(TWO, TWO, n), 2),
    "crosscheck": (lambda n: urdf_ik.verify.crosscheck.check(TWO, n), 2),
}  # fmt: skip

LOOSE: dict[str, Callable[[Any], Any]] = {
    "masked": lambda a: np.ma.masked_array(a, np.zeros(np.shape(a), bool)),
    "masked in a list": lambda a: [np.ma.masked_array(each, True) for each in np.atleast_1d(a)],
    "complex": lambda a: np.asarray(a, dtype=complex),
    "dates": lambda a: np.zeros(np.shape(a), "M8[s]"),
    "durations": lambda a: np.zeros(np.shape(a), "m8[s]"),
    "structured": lambda a: np.zeros(np.shape(a), [("x", "f8")]),
    "text": lambda a: np.asarray(a).astype(str),
    "text in lists": lambda a: np.asarray(a).astype(str).tolist(),
    "bytes": lambda a: np.asarray(a).astype("S"),
    "truth values": lambda a: np.ones(np.shape(a), bool),
    "nothing": lambda a: np.full(np.shape(a), None),
    "objects": lambda a: np.full(np.shape(a), object()),
    "a set": lambda a: {1.0, 2.0},
    "a mapping": lambda a: {"a": a},
    "a member of an enumeration": lambda a: enum.Enum("Kind", "a b")["a"],
    "a module": lambda a: enum,
    "ragged": lambda a: [[1.0, 2.0], [3.0]],
}
HUGE = (1e155, -1e155, 1e200, 1e308, float("nan"), float("inf"), -float("inf"), 10**400)


@pytest.mark.parametrize("what", ARRAYS)
@pytest.mark.parametrize("kind", LOOSE)
def test_what_is_no_array_of_numbers_is_refused(what: str, kind: str) -> None:
    """By all functions alike, in words that hold what is valid; what is an array of numbers is not."""
    call, good = ARRAYS[what]
    call(good)
    call(np.asarray(good, dtype=np.float64).tolist())
    with pytest.raises(UrdfIkError):
        call(LOOSE[kind](good))


@pytest.mark.parametrize("what", ARRAYS)
def test_numbers_out_of_range_are_refused(what: str) -> None:
    """At every place of an array: no overflow, no warning, no answer that is none."""
    call, good = ARRAYS[what]
    for value in HUGE[:-1]:
        for place in range(min(np.size(good), 6)):
            array = np.array(good, dtype=np.float64)
            array.flat[place] = value
            if what == "within" and value == float("inf"):
                continue  # no bound
            with pytest.raises(UrdfIkError):
                call(array)


@pytest.mark.parametrize("what", NUMBERS)
def test_single_numbers(what: str) -> None:
    """A float or an integer of any kind; nothing else, and none that is out of range."""
    call, good = NUMBERS[what]
    for same in (good, np.float64(good), np.array(good)):
        call(same)
    bad: list[Any] = [
        *HUGE,
        "0.5",
        None if "tolerance" not in what else "x",
        True,
        1j,
        [good, good],
        np.array([good, good]),
    ]
    bad += [np.ma.masked, np.datetime64("2020-01-01"), np.timedelta64(1, "s"), datetime.timedelta(1), object(), {}]
    for value in bad:
        if value is None and what in ("length", "damping", "explain, redundancy"):
            continue  # the default
        with pytest.raises(UrdfIkError):
            call(value)


@pytest.mark.parametrize("what", WHOLE)
def test_whole_numbers(what: str) -> None:
    """An integer of any kind; no 2.5, no text, none that is out of range."""
    call, good = WHOLE[what]
    for same in (good, np.int64(good)):
        call(same)
    for value in (
        2.5,
        float(good),
        "2",
        None,
        True,
        0,
        -1,
        float("nan"),
        10**9,
        10**18,
        10**400,
        [good],
        np.array([good, good]),
    ):
        with pytest.raises(UrdfIkError):
            call(value)


def test_what_cannot_even_be_written_is_refused_in_words() -> None:
    """Objects whose ``repr`` or ``__array__`` raises, lists within themselves: an error of ours, and a short one."""

    class Odd:
        def __array__(self, *_: Any, **__: Any) -> Any:
            raise RuntimeError("no array")

        def __repr__(self) -> str:
            raise RuntimeError("no text")

    around: list[Any] = []
    around.append(around)
    deep: list[Any] = []
    for _ in range(3000):
        deep = [deep]
    for value in (Odd(), around, deep, "x" * 10**6, ["x"] * 10**5):
        for call, _ in (*ARRAYS.values(), *NUMBERS.values()):
            with pytest.raises(UrdfIkError) as refused:
                call(value)
            assert len(str(refused.value)) < 1000


class Endless:
    """Says that it has six parts, and goes on for ever."""

    def __len__(self) -> int:
        return 6

    def __getitem__(self, k: int) -> float:
        return 0.5


class Six(Endless):
    """Has the six parts that it says."""

    def __getitem__(self, k: int) -> float:
        if k > 5:
            raise IndexError
        return 0.5


@pytest.mark.parametrize("what", ARRAYS)
def test_sequences_that_are_too_long_are_refused_by_their_length(what: str) -> None:
    """Before they are written out: ranges, lists of the same lists, views that repeat a number, endless ones."""
    call, _ = ARRAYS[what]
    around: list[Any] = []
    around.append(around)
    thousand = [[[0.0] * 1000] * 1000] * 1000
    repeated = np.broadcast_to(np.zeros(6), (10**9, 6))
    longest = (range(10**9), range(10**30), [[0], [range(10**9)]], thousand, repeated)
    for value in (*longest, Endless(), [Endless()], around):
        with pytest.raises(UrdfIkError):
            call(value)


def test_other_sequences_than_lists_are_read() -> None:
    """Ranges and whatever has a length and numbered parts."""
    for same in (Six(), [0.5] * 6, np.broadcast_to(0.5, 6)):
        np.testing.assert_array_equal(SIX.fk(same), SIX.fk(np.full(6, 0.5)))
    np.testing.assert_array_equal(SIX.fk([range(6)] * 2), SIX.fk(np.array([range(6)] * 2)))


BATCHES: dict[str, Any] = {
    "solutions": SOLUTIONS, "solutions of a batch": SIX.ik(np.stack([T6, T6])), "intervals": SEVEN.intervals(T7),
    "intervals of a batch": SEVEN.intervals(np.stack([T7, T7])), "world": urdf_ik.World(),
}  # fmt: skip


@pytest.mark.parametrize("what", BATCHES)
def test_keys_of_every_kind_are_refused_in_words(what: str) -> None:
    """An index that leads nowhere, or is none, gives an error of this package, which is an IndexError or TypeError."""
    batch = BATCHES[what]
    for key in ("x", 1.5, 10**400, 99, None, {}, range(10**9), Endless(), object(), (0, 0, 0, 0), [[0.5]], slice("a"),
                np.array([7, 8]), np.full(2, np.nan), (slice(None), "x"), np.zeros(5, bool)):  # fmt: skip
        try:
            batch[key]
        except urdf_ik.ArgumentError as refused:
            assert len(str(refused)) < 500
        else:
            assert key is None and "batch" in what
    for key in ("x", None, 10**400, object(), [1], float("nan")):
        if what == "world":
            assert key not in batch
        elif what == "intervals":
            assert key not in batch[0]


def test_numbers_of_every_kind_are_read() -> None:
    """Integers, fractions, half and long floats, other byte orders, strided and read-only arrays: their values."""
    from fractions import Fraction

    for same in (Q6.astype(">f8"), Q6.astype(np.longdouble), np.repeat(Q6, 2)[::2], memoryview(Q6), tuple(Q6)):
        np.testing.assert_allclose(SIX.fk(same), T6, atol=1e-15)
    assert inputs.real([Fraction(1, 2), 2**70], "x", "numbers").tolist() == [0.5, 2.0**70]
    assert inputs.number(np.float16(0.5), "x") == 0.5 and inputs.whole(np.uint8(3), "n") == 3


def test_lists_in_lists_are_named_without_being_written(tmp_path: Path) -> None:
    """A thousand million numbers that share one list, where a name or a path is wanted."""
    many: list[Any] = [[[0.0] * 1000] * 1000] * 1000
    calls: tuple[Callable[[Any], Any], ...] = (
        urdf_ik.DHTable.read, urdf_ik.load, SIX.model.write, urdf_ik.World().__getitem__, SIX.for_task,
        lambda name: SIX.with_tool(np.eye(4), name=name),
    )  # fmt: skip
    for call in calls:
        with pytest.raises(UrdfIkError) as refused:
            call(many)
        assert len(str(refused.value)) < 1000


def test_a_name_that_no_disk_holds_is_refused(tmp_path: Path) -> None:
    """Half of a surrogate pair, as half-read names have."""
    with pytest.raises(UrdfIkError, match="cannot write"):
        SIX.model.write(tmp_path / "\ud800.urdf")
    with pytest.raises(UrdfIkError, match="name too long"):
        urdf_ik.maps.workspace(TWO, 0.2, 2, store=tmp_path / ("x" * 300))


def test_an_arm_is_no_chain() -> None:
    """Both have forward kinematics; only the one can be what the other is made of."""
    with pytest.raises(urdf_ik.ArgumentError, match="a chain, as"):
        urdf_ik.arm.assemble(SIX.model, SIX)  # type: ignore[arg-type]


def test_a_seed_may_be_a_number_of_numpy() -> None:
    """As one has it from an array of seeds."""
    q, _ = urdf_ik.verify.crosscheck.replay(SIX, seed=np.array(3, dtype=np.uint8), index=2)  # type: ignore[arg-type]
    np.testing.assert_array_equal(q, urdf_ik.verify.crosscheck.replay(SIX, seed=3, index=2)[0])


GROUP = '<robot name="r"><group name="g"><chain base_link="base_link" tip_link="tool0"/></group></robot>'
URDF = SIX.model.xml.decode()
# What takes a name, a word or an object of this package, and none of those below.
NAMES: dict[str, Callable[[Any], Any]] = {
    "positioner": lambda x: with_positioner(SIX, TWO, np.eye(4), name=x), "tool": lambda x: SIX.with_tool(T6, name=x),
    "group": lambda x: urdf_ik.load(URDF, srdf=GROUP, chain=x),
    "base": lambda x: urdf_ik.load(URDF, srdf=GROUP, base=x),
    "xacro argument": lambda x: urdf_ik.load(URDF, xacro_args={"a": 1, 2.5 if isinstance(x, float) else 3: x}),
    "report": lambda x: urdf_ik.verify.testing.verdict(x, "Jacobian"),
    "property": lambda x: urdf_ik.verify.testing.verdict(REPORT, x),
    "redundancy": lambda x: SEVEN.with_redundancy(x),
    "given": lambda x: urdf_ik.arm.assemble(SEVEN.model, SEVEN.chain, given=x),
    "task": lambda x: urdf_ik.arm.assemble(SIX.model, SIX.chain, task=x), "axis": SIX.with_free_axis,
    "free_axis": lambda x: urdf_ik.arm.assemble(SIX.model, SIX.chain, free_axis=x),
    "pairs": SIX.cell.collisions.checking,
    "self_collision": lambda x: SIX.tracker(Q6, 0.01, self_collision=x),
    "cuspidality": urdf_ik.ik.cuspidality.is_cuspidal,
    "client": lambda x: urdf_ik.maps.engine.run(lambda k: {}, None, client=x),  # type: ignore[arg-type,return-value]
}  # fmt: skip


@pytest.mark.parametrize("what", NAMES)
def test_names_and_objects_of_every_kind_are_refused_in_words(what: str) -> None:
    """Numbers, arrays, lists and bytes where there should be a name, and names that no URDF can hold."""
    table = urdf_ik.DHTable.from_chain(SIX.chain)
    for value in (3, 2.5, np.zeros(3), ["g"], b"x", "\x1b", "\ud800", memoryview(np.eye(4)), table):
        with pytest.raises(ValueError) as refused:  # noqa: PT011
            NAMES[what](value)
        assert isinstance(refused.value, UrdfIkError)
        assert len(str(refused.value)) < 1500
