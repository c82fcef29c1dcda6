"""The text of a compiled arm: JSON whose numbers read back exactly, the same from every processor."""

import json
import math
import os
from typing import Any

import numpy as np
from lxml import etree

from urdf_ik import _core
from urdf_ik.arm import Arm, compiled
from urdf_ik.arm.compiled import FORMAT, VERSION
from urdf_ik.errors import UnsupportedArm, UrdfError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.model.urdf import Joint, UrdfModel
from urdf_ik.support import files
from urdf_ik.support.angles import TURN
from urdf_ik.support.text import json_text
from urdf_ik.version import __version__

_CHECKS = 6
_SHAPES = ("visual", "collision", "inertial")


def compile(arm: Arm) -> str:  # noqa: A001  what it does, as re.compile
    """The text of a compiled arm, from which C++, C, WebAssembly and :func:`urdf_ik.load` solve.

    It is JSON, as ``docs/_static/compiled-arm.schema.json`` describes it. The same arm has the same text whatever
    instruction set is in use, and its numbers read back exactly.

    Args:
        arm: as :func:`urdf_ik.load` returns it, with its tool, locked joints, free axis and redundancy parameters.

    Raises:
        UnsupportedArm: no solver takes the arm, its targets are no poses (``for_task``), or a joint between the first
            and the last one is given.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> again = urdf_ik.load_compiled(urdf_ik.compile(arm))
        >>> T = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
        >>> bool((again.ik(T).q == arm.ik(T).q).all())
        True
    """
    solver, chain = arm.solver, arm.chain
    member = solver.require_member()
    if solver.task != "pose":
        raise UnsupportedArm(f"{arm.name}: an arm for the task {solver.task!r} is not compiled, only one for poses")
    if not isinstance(member.solver, _core.Solver):
        raise UnsupportedArm(
            f"{arm.name}: with {' and '.join(solver.chosen) or 'a joint in its middle'} given, each value is another "
            "arm, which is analysed when it is first used; an arm is compiled if its first or last joint is given"
        )
    axis = solver.free_axis
    return json_text(
        {
            "format": FORMAT,
            "version": VERSION,
            "urdf_ik": __version__,
            "name": arm.name,
            "base": arm.base,
            "tip": arm.tip,
            "urdf": {"sha256": arm.model.sha256, "chain": _used_part(arm.model, chain)},
            "locked": dict(chain.locked),
            "given": solver.chosen,
            "free_axis": None if axis is None else {"direction": axis.direction, "at": axis.at},
            "family": member.name,
            "branches": solver.branches,
            "joints": _joints(arm),
            "parameters": [
                {
                    "kind": each.kind,
                    "name": each.joint,
                    "unit": each.unit,
                    "lower": each.range[0],
                    "upper": each.range[1],
                    "default": each.default,
                }
                for each in solver.parameters
            ],
            "chain": {
                "steps": chain.motion.steps,
                "slides": chain.axes.prismatic,
                "gain": getattr(chain, "gain", None),
            },
            "checks": _checks(chain),
            "solver": _tree(member.solver.arm),
        }
    )


def _joints(arm: Arm) -> list[dict[str, Any]]:
    chain, speeds = arm.chain, arm.solver.velocity_limits
    return [
        {
            "name": chain.joint_names[k],
            "type": chain.joint_types[k],
            "lower": chain.limits[k, 0],
            "upper": chain.limits[k, 1],
            "turn": TURN * float(chain.image_turns[k]),
            "velocity": speeds[k],
        }
        for k in range(chain.n)
    ]


def _checks(chain: Chain) -> list[dict[str, Any]]:
    """Joint vectors and the tip's poses there, with which a reader checks its forward kinematics."""
    Q = np.random.default_rng(1).uniform(-math.pi, math.pi, (_CHECKS, chain.n))
    slides = [kind == "prismatic" for kind in chain.joint_types]
    Q[:, slides] *= chain.size / math.pi
    poses: Any = _core.prepared(lambda: chain.fk(Q))
    return [{"q": q, "T": T} for q, T in zip(Q, poses, strict=True)]


def _tree(value: Any) -> Any:
    """What a solver is made from, a dataclass or groups that were read, as named values; None counts as missing."""
    if isinstance(value, np.ndarray):
        return value.astype(np.float64)
    if not hasattr(value, "__dict__"):
        return value
    kind = {"kind": value.kind} if hasattr(value, "kind") else {}
    return kind | {name: _tree(held) for name, held in vars(value).items() if held is not None}


def _used_part(model: UrdfModel, chain: Chain) -> str:
    """The URDF without shapes, and without links and joints that the chain does not need."""
    robot = etree.fromstring(model.xml)
    joints, links = _used(model, chain)
    for element in robot.xpath("/robot/*"):
        held = joints if element.tag == "joint" else links
        if element.tag not in ("joint", "link") or element.get("name") not in held:
            robot.remove(element)
    for shape in robot.xpath("|".join(f"//{kind}" for kind in _SHAPES)):
        shape.getparent().remove(shape)
    for element in robot.iter():
        element.text = element.tail = None
    return str(etree.tostring(robot, encoding="unicode"))


def _used(model: UrdfModel, chain: Chain) -> tuple[set[str], set[str]]:
    """Names of the joints and links that the chain needs: its own, drivers, and joints beside it at a value."""
    path = model.path_between(chain.base, chain.tip)
    held = dict(chain.locked)
    others = [joint for joint in model.joints if joint.name in held]
    needed: dict[str, Joint] = {}
    waiting = [*path, *others]
    names = {joint.name: joint for joint in model.joints}
    while waiting:
        joint = waiting.pop()
        if joint.mimic is not None:
            waiting.append(names[joint.mimic[0]])
        # The tree stays one tree: with a joint, all that carry it from the root on.
        for each in (joint, *model.path_between(model.root, joint.parent)):
            if each.name not in needed:
                needed[each.name] = each
                waiting.append(each)
    ends = {end for joint in needed.values() for end in (joint.parent, joint.child)}
    return set(needed), {model.root, chain.base, chain.tip, *ends}


def require_current(path: str | os.PathLike[str], arm: Arm) -> None:
    """Refuse a compiled arm's file that is not what an arm is compiled to now.

    Args:
        path: the file.
        arm: the arm of today, loaded with the settings that the file was compiled with.

    Raises:
        UrdfError: the URDF or a setting changed since; the message says what.
        UnsupportedArm: the arm cannot be compiled.

    Example:
        >>> from pathlib import Path
        >>> import urdf_ik
        >>> _ = Path("arm.json").write_text(urdf_ik.compile(urdf_ik.load("planar_2r")))
        >>> require_current("arm.json", urdf_ik.load("planar_2r_unit"))
        Traceback (most recent call last):
        urdf_ik.errors.UrdfError: arm.json: compiled from another arm: chain, checks, joints, name, ...
    """
    then = compiled.read(path)
    now = json.loads(compile(arm))
    if then == now:
        return
    name = files.name_of(path)
    hint = "urdf-ik compile writes it anew"
    if {key for key in now if then.get(key) != now[key]} == {"urdf"} and then["urdf"]["chain"] == now["urdf"]["chain"]:
        raise UrdfError("the URDF's text changed since, though nothing that the chain uses", source=name, hint=hint)
    changed = sorted(key for key in {*then, *now} if then.get(key) != now.get(key))
    raise UrdfError(f"compiled from another arm: {', '.join(changed)} changed", source=name, hint=hint)
