"""Every class of the public interface, listed from the interface itself: its objects can be pickled and copied."""

from __future__ import annotations

import copy
import dataclasses
import importlib
import inspect
import pickle
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms_general import unstructured
from test_copies import OBJECTS, Q

import urdf_ik
from urdf_ik import calibration
from urdf_ik.calibration import universal_robots
from urdf_ik.ik.solutions import Cluster
from urdf_ik.kinematics.derivatives import Points, written
from urdf_ik.maps import workspaces
from urdf_ik.show.plot import figures
from urdf_ik.verify import check_proof, completeness, crosscheck, judging, surveys

HELD_OPEN = {"CLibrary", "Folder", "IKFastLibrary", "RerunArm", "Sliders", "SolverProcess", "Viewer", "ViserArm"}
"""Classes whose objects hold a window, a server, a process, a library, a recording or a locked store."""
INNER = ("urdf_ik.cli", "urdf_ik.ik.families")
"""Packages without objects for users: the command, and how an arm is solved."""
WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda each: pickle.loads(pickle.dumps(each)),
    "deepcopy": copy.deepcopy,
}


def public_classes() -> dict[type, str]:
    """The classes in the ``__all__`` of every package and module, with a name of each."""
    folder = str(Path(urdf_ik.__file__).parent)
    names = ["urdf_ik", *(each.name for each in pkgutil.walk_packages([folder], "urdf_ik."))]
    found: dict[type, str] = {}
    for module in (importlib.import_module(name) for name in names if not name.startswith(INNER)):
        for name in getattr(module, "__all__", ()):
            value = getattr(module, name)
            own = inspect.isclass(value) and value.__module__.startswith("urdf_ik.")
            if own and not issubclass(value, BaseException) and name not in HELD_OPEN:
                found.setdefault(value, f"{module.__name__}.{name}")
    return found


def more_objects(folder: Path) -> Iterator[Any]:
    """What the objects of ``test_copies`` do not lead to."""
    two, six, seven = (urdf_ik.load(name) for name in ("planar_2r", "zyyzyz_6r", "srs_7r"))
    T = seven.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])
    yield from (urdf_ik.Capsule(0.1, 0.3), urdf_ik.Cylinder(0.1, 0.3), urdf_ik.Sphere(0.1))
    intervals = seven.intervals(T)
    yield from (intervals, *intervals, urdf_ik.Region(cone=0.2), six.ik(six.fk(Q)).explain())
    map_ = urdf_ik.maps.workspace(six, 0.8, 5)
    stored = urdf_ik.maps.workspace(six, 0.8, 5, store=folder / "map.zarr")
    yield from (map_, stored, map_.totals(), map_.branch_shares(), workspaces.boundary(map_))
    yield from (workspaces.differences(stored, stored), workspaces.planar(two))
    bases = urdf_ik.maps.placement(six, six.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5)
    yield from (bases, bases.places(1), urdf_ik.paths.PathSettings(margin=0.01))
    puma = urdf_ik.model.catalogue.resolve("puma_560").path
    yield surveys.survey([puma], n=1)
    yield completeness.compare(six, n=2)
    yield crosscheck.check(six, n=2)
    yield urdf_ik.compare(six, urdf_ik.load("puma_560"), n=2)
    lock = urdf_ik.freeze(two)
    yield from (lock, lock.verify(two), urdf_ik.compare_many({"two": two}, two.fk([[0.1, 0.2]])))
    yield judging.judge(two, lambda T: np.zeros((1, 2)), n=2)
    left_over = '<robot name="r"><link name="a"/><link name="b"/><xacro:left xmlns:xacro="x"/><joint name="j" '
    left_over += 'type="revolute"><parent link="a"/><child link="b"/><limit lower="-1" upper="1" effort="1" '
    left_over += 'velocity="1"/></joint></robot>'
    yield from urdf_ik.load(left_over).model.warnings
    yield from six.model.chains()
    yield from (OBJECTS["plan"].margins, urdf_ik.paths.Change(1, "elbow up", "elbow down", True))
    yield completeness.Difference(0, None, (0.1,), (0.2,), "solver", "elbow up", 0.1, 0.5, 1e-12, 1e-12)
    yield figures.bodies(two)
    general = urdf_ik.load(unstructured(1).urdf)
    proven = general.ik(general.fk(Q))
    yield from (proven.proof, check_proof(general, proven))
    yield Cluster(np.zeros(6, dtype=complex), np.eye(6, dtype=complex), 1e-6, 1e-3, 1, 2)
    geometry = written(two.chain)
    yield from (geometry, *geometry.parameters, Points(np.zeros(3), np.zeros(3), np.array([0.0, 0.0, 1.0])))
    vectors = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 2))
    fitted = urdf_ik.calibrate(two, vectors, two.fk(vectors))
    yield from (fitted, calibration.best_poses(fitted, 2))
    yield calibration.UrKinematics(dict.fromkeys(universal_robots.JOINTS, (0.0,) * 6), "calib_1")


def leads_to(value: Any, seen: dict[int, Any], depth: int = 5) -> None:
    """Collect an object and all that its public attributes hold."""
    if id(value) in seen or depth < 0:
        return
    if isinstance(value, Mapping):
        value = tuple(value.values())
    if isinstance(value, tuple | list):
        seen[id(value)] = value
        for each in value[:50]:
            leads_to(each, seen, depth)
    if not type(value).__module__.startswith("urdf_ik."):
        return
    seen[id(value)] = value
    names = [each.name for each in dataclasses.fields(value)] if dataclasses.is_dataclass(value) else dir(value)
    for name in names:
        if not name.startswith("_"):
            try:
                leads_to(getattr(value, name), seen, depth - 1)
            except Exception:  # a property that this object does not have
                continue


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    """Objects of the package, and all that they lead to."""
    seen: dict[int, Any] = {}
    for each in (*OBJECTS.values(), *more_objects(tmp_path_factory.mktemp("stores"))):
        leads_to(each, seen)
    return list(seen.values())


@pytest.mark.parametrize("kind", public_classes().items(), ids=lambda kind: kind[1])
@pytest.mark.parametrize("way", WAYS)
def test_objects_of_every_public_class_are_copied(kind: tuple[type, str], way: str, objects: list[Any]) -> None:
    """There is an object of the class, and a copy of it is of the same class and reads the same."""
    found = [each for each in objects if isinstance(each, kind[0])][:3]
    assert found, f"no object of {kind[1]}"
    for each in found:
        again = WAYS[way](each)
        assert type(again) is type(each)
        assert repr(again) == repr(each) or " at 0x" in repr(each)


@pytest.mark.parametrize("way", WAYS)
def test_copied_intervals_are_sampled_as_before(way: str) -> None:
    """Their curves are followed by the compiled core, which the copy builds anew."""
    arm = urdf_ik.load("srs_7r")
    intervals = arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]))
    for one, other in zip(intervals.samples(0), WAYS[way](intervals).samples(0), strict=True):
        np.testing.assert_array_equal(one, other)
