"""Compiled arms: JSON that reads back exactly, the same from every instruction set, solved alike in Python and C++."""

import json
import os
import pickle
import sys
from pathlib import Path
from typing import Any

import arms_general
import core_arms
import jsonschema
import native_arms
import numpy as np
import pytest
from cases import from_catalogue
from core_samples import fresh
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import _core
from urdf_ik.errors import UnsupportedArm, UrdfError
from urdf_ik.export import require_current
from urdf_ik.ik.solutions import limits

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = json.loads((ROOT / "docs" / "_static" / "compiled-arm.schema.json").read_text())

_MIMIC = '<child link="link_2"/><mimic joint="joint_1" multiplier="-1"/>'
_HASHES = """
import hashlib, core_arms, urdf_ik
for name, arm in core_arms.every_arm():
    print(name, hashlib.sha256(urdf_ik.compile(arm).encode()).hexdigest(), sep="|")
"""


def special_arms() -> list[tuple[str, urdf_ik.Arm]]:
    """Arms with wrappers around wrappers, and with settings: a tool, a locked joint, a free axis, a mimic."""
    puma, srs = urdf_ik.load("puma_560"), urdf_ik.load("srs_7r")
    mimic = urdf_ik.load("planar_2r").model.xml.decode().replace('<child link="link_2"/>', _MIMIC)
    return [
        ("tool", puma.with_tool(urdf_ik.pose([0.0, 0.05, 0.25], rpy=[0.5, 0.1, 0.0]), name="torch")),
        ("locked", puma.with_locked({puma.joint_names[5]: 0.3})),
        ("free axis", puma.with_free_axis([0.1, 0.2, 1.0], at=[0.0, 0.1, 0.0])),
        ("S-R-S, free axis", srs.with_free_axis("z")),
        ("first joint given", srs.with_redundancy(srs.joint_names[0])),
        ("mimic", urdf_ik.load(mimic)),
    ]


EVERY = [*core_arms.every_arm(), *special_arms()]


@pytest.mark.parametrize(("name", "arm"), EVERY, ids=[name for name, _ in EVERY])
def test_python_and_cpp_solve_a_compiled_arm_as_the_arm_itself(name: str, arm: urdf_ik.Arm, tmp_path: Path) -> None:
    """The text fits the schema and reads back; both solve with the same bits as the arm, without allocating."""
    text, file = urdf_ik.compile(arm), tmp_path / "arm.json"
    file.write_text(text)
    jsonschema.validate(json.loads(text), SCHEMA)
    again = urdf_ik.load_compiled(file)
    assert urdf_ik.compile(again) == text == urdf_ik.compile(pickle.loads(pickle.dumps(again)))
    T, values = native_arms.targets(arm)
    expected, in_python = native_arms.expected(arm, T, values), native_arms.expected(again, T, values)
    native = native_arms.solved(file, T, values)
    assert in_python.q.tobytes() == expected.q.tobytes()
    flags = native_arms.flags_of(expected)
    assert (native_arms.flags_of(in_python) == flags).all() and (native.flags == flags).all()
    valid = expected.valid
    assert native.q[valid].tobytes() == expected.q[valid].tobytes()
    assert valid.any(axis=-1).all()
    # The search for the solutions of joints that drive several axes takes its memory once a call.
    assert native.allocations == (0 if arm.chain.axes is arm.chain else 1)
    row = expected.q[np.arange(len(T)), valid.argmax(axis=-1)]
    assert native.pose.tobytes() == arm.fk(row).tobytes()
    assert np.abs(native.J - arm.jacobian(row)).max() < 1e-12
    if values is not None:
        apart = native.free - arm.solver.redundant_member.value_of(row, T)
        assert np.abs(np.remainder(apart + np.pi, 2 * np.pi) - np.pi).max() < 1e-9
    near = expected.nearest(np.zeros(arm.dof), within_limits=True)
    assert (native.column >= 0).tolist() == near.valid[:, 0].tolist()
    assert np.array_equal(native.nearest, near.q[:, 0], equal_nan=True)
    for i in range(0, len(T), 7):
        turned = limits.turns(row[i : i + 1], arm.limits, arm.chain.image_turns)
        images = turned.q[turned.valid]
        assert native.count[i] == len(images)
        assert np.array_equal(native.images[i, : len(images)], np.array(images[:4]).reshape(-1, arm.dof))


@pytest.mark.skipif(len(_core.levels()) < 2, reason="the core was built for one instruction set")
def test_the_text_is_the_same_from_every_instruction_set() -> None:
    """Each instruction set compiles every arm to the same text."""
    texts = {level: fresh(_HASHES, URDF_IK_ISA=level, PYTHONPATH=os.pathsep.join(sys.path)) for level in _core.levels()}
    first, *others = texts.values()
    assert len(first.splitlines()) > 100
    for text in others:
        assert not [a for a, b in zip(text.splitlines(), first.splitlines(), strict=True) if a != b]


def test_numbers_read_back_exactly() -> None:
    """The file's forward kinematics are those of Pinocchio, and its limits the URDF's, to the last digit."""
    case = from_catalogue("zyyzyz_6r")
    data = json.loads(urdf_ik.compile(case.arm))
    assert [[each["lower"], each["upper"]] for each in data["joints"]] == case.arm.limits.tolist()
    for each in data["checks"]:
        assert np.abs(case.oracle.pose(np.array(each["q"])) - np.array(each["T"])).max() < 1e-12


def broken(change: str) -> str:
    """The text of a compiled arm with one defect."""
    data: Any = json.loads(urdf_ik.compile(urdf_ik.load("puma_560")))
    if change == "no JSON":
        return json.dumps(data)[:-200]
    if change == "another format":
        data["format"] = "urdf-ik lock"
    elif change == "another version":
        data["version"] = 2
    elif change == "no size":
        del data["solver"]["written"]["size"]
    elif change == "few numbers":
        data["solver"]["ideal"]["a"] = data["solver"]["ideal"]["a"][:-1]
    elif change == "another kind":
        data["solver"]["kind"] = "octopus"
    elif change == "a branch less":
        data["branches"].pop()
    elif change == "another pose":
        data["checks"][0]["T"][0][3] += 1e-6
    return json.dumps(data)


DEFECTS = {
    "no JSON": "line 1",
    "another format": "no compiled arm",
    "another version": "version 2",
    "no size": "size",
    "few numbers": "4 numbers given, 5 needed",
    "another kind": "octopus",
    "a branch less": "branches",
    "another pose": "elsewhere",
}


@pytest.mark.parametrize("change", DEFECTS)
def test_a_broken_file_is_refused(change: str, tmp_path: Path) -> None:
    """Python and C++ name the file and what is wrong in it."""
    file = tmp_path / "arm.json"
    file.write_text(broken(change))
    with pytest.raises(UrdfError, match=rf"arm\.json.*{DEFECTS[change]}"):
        urdf_ik.load_compiled(file)
    refused = native_arms.refusal(file)
    assert str(file) in refused and DEFECTS[change] in refused


@pytest.mark.parametrize("path", ["solver.counter.inexact", "solver.near"])
def test_a_file_of_another_release_is_refused(path: str, tmp_path: Path) -> None:
    """What it lacks is named, with the way to it; names that no reader knows are no reason to refuse it."""
    described = arms_general.calibrated_ur()
    data: Any = json.loads(urdf_ik.compile(urdf_ik.load(described.urdf, base="base", tip="tool")))
    file, (*groups, last) = tmp_path / "arm.json", path.split(".")
    held = data
    for group in groups:
        held = held[group]
    held["invented later"] = 1.0
    file.write_text(json.dumps(data))
    assert urdf_ik.load_compiled(file).dof == 6
    native_arms.solved(file, urdf_ik.load_compiled(file).fk(np.zeros((1, 6))))
    del held[last]
    file.write_text(json.dumps(data))
    with pytest.raises(UrdfError, match=rf"arm\.json.*{last}.*missing"):
        urdf_ik.load_compiled(file)
    refused = native_arms.refusal(file)
    assert str(file) in refused and f"{path}: missing" in refused


def test_a_changed_urdf_is_noticed(tmp_path: Path) -> None:
    """A file of another URDF is refused; what changed is named, a comment apart from a joint."""
    arm = urdf_ik.load("planar_2r")
    file, xml = tmp_path / "arm.json", arm.model.xml.decode()
    file.write_text(urdf_ik.compile(urdf_ik.load(xml)))
    require_current(file, urdf_ik.load(xml))
    with pytest.raises(UrdfError, match="the URDF's text changed since, though nothing that the chain uses"):
        require_current(file, urdf_ik.load(xml.replace("</robot>", "<!-- later --></robot>")))
    with pytest.raises(UrdfError, match="compiled from another arm: chain, checks, solver, urdf changed"):
        require_current(file, urdf_ik.load(xml.replace("0.066", "0.067")))


def test_arms_that_cannot_be_compiled_are_refused() -> None:
    """A joint given in the middle and targets that are no poses are refused with the reason."""
    srs = urdf_ik.load("srs_7r")
    with pytest.raises(UnsupportedArm, match="first or last joint is given"):
        urdf_ik.compile(srs.with_redundancy(srs.joint_names[2]))
    with pytest.raises(UnsupportedArm, match="only one for poses"):
        urdf_ik.compile(urdf_ik.load("planar_2r").for_task("planar position"))


def test_the_c_interface(tmp_path: Path) -> None:
    """A C program prints names, limits and branches; it refuses what is no pose, and a file that is not there."""
    arm = urdf_ik.load("zyyzyz_6r")
    file = tmp_path / "arm.json"
    file.write_text(urdf_ik.compile(arm))
    program = str(native_arms.built("c_interface.c"))
    head, *lines = native_arms.run(program, str(file)).stdout.decode().splitlines()
    assert head.split() == [urdf_ik.__version__, arm.base, arm.tip, str(arm.dof), str(len(arm.solver.branches))]
    solutions = arm.ik(arm.fk(np.zeros(6)))
    names = [name for name, valid in zip(arm.solver.branches, solutions.valid, strict=True) if valid]
    assert [line.removesuffix(" *") for line in lines[: len(names)]] == names
    assert [line.split()[:3] for line in lines[len(names) : -1]] == [
        [name, f"{low:.17g}", f"{high:.17g}"] for name, (low, high) in zip(arm.joint_names, arm.limits, strict=True)
    ]
    assert lines[-1] == "0"
    assert native_arms.refusal(tmp_path / "none.json", "c_interface.c").endswith("none.json: it cannot be read\n")
