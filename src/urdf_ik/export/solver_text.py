"""The C++ text of an arm's solver: the headers that it needs in one text, and the function that solves."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from urdf_ik._core import Solver
from urdf_ik.cmake import core
from urdf_ik.errors import UnsupportedArm

_CLOSED, _SINGLY = "solve_closed_form", "solve_singly"
_FORMS = "families/closed_forms/"
# Of each family of six joints: the header, and by variant the function and the class that it takes, as in the table of
# the .cpp file beside the header.
FAMILIES = {
    "spherical wrist": (
        f"{_FORMS}spherical_wrist.hpp",
        {
            "2||3": (_CLOSED, "SphericalWrist<Shoulder::parallel_23>"),
            "1x2": (_CLOSED, "SphericalWrist<Shoulder::intersecting_12>"),
            "1||2": (_CLOSED, "SphericalWrist<Shoulder::parallel_12>"),
            "general": (_SINGLY, "SphericalWrist<Shoulder::general>"),
        },
    ),
    "three parallel axes": (
        f"{_FORMS}three_parallel.hpp",
        {
            "5x6": (_CLOSED, "ThreeParallel<Hand::intersecting_56>"),
            "general": (_SINGLY, "ThreeParallel<Hand::general>"),
        },
    ),
    "parallel shoulder": (
        f"{_FORMS}parallel_shoulder.hpp",
        {
            "5x6": (_CLOSED, "ParallelShoulder<LastAxes::intersecting_56>"),
            "5||6": (_CLOSED, "ParallelShoulder<LastAxes::parallel_56>"),
            "4x5": (_CLOSED, "ParallelShoulder<LastAxes::intersecting_45>"),
            "4||5": (_CLOSED, "ParallelShoulder<LastAxes::parallel_45>"),
            "general": (_SINGLY, "ParallelShoulder<LastAxes::general>"),
        },
    ),
    "spherical middle": (
        f"{_FORMS}spherical_middle.hpp",
        {
            "5x6": (_CLOSED, "SphericalMiddle<LastPair::intersecting>"),
            "5||6": (_CLOSED, "SphericalMiddle<LastPair::parallel>"),
            "general": (_SINGLY, "SphericalMiddle<LastPair::general>"),
        },
    ),
}
_FEW = "families/few_joints/"
_WRAPPED = "arms/wrapped.hpp"
# Functions that a header declares and a unit of its own defines.
_DECLARED = re.compile(r"^(?!template|inline|extern|static|using|struct)[A-Za-z]\w* (\w+)\([^;{]*\);", re.MULTILINE)


class Node(NamedTuple):
    """One solver: its struct, the files that it needs, and the statement that solves a batch with it.

    Attributes:
        core: the compiled solver.
        files: headers and sources.
        text: C++ that returns the answer to ``batch``; ``arm`` is the struct, ``inner`` the other solver.
        inner: the solver that it uses, or None.
    """

    core: Solver
    files: tuple[str, ...]
    text: str
    inner: Node | None = None


def node_of(arm: Any, name: str) -> Node:
    """The solver of an arm's numbers, and those that it uses."""
    made, kind = Solver(arm), arm.kind
    if kind in ("one joint given", "axis free"):
        inserted = "true" if kind == "one joint given" else "false"
        inner = node_of(arm.solver, name)
        most = 8 * inner.core.branches
        text = f"solve_one_given<8, {most}>(arm, {inserted}, {_size(inner)}, inner, one_given_solvers, batch)"
        return Node(made, (_WRAPPED, "families/seven_joints/one_given.cpp"), text, inner)
    if kind == "reversed":
        inner = node_of(arm.solver, name)
        text = f"solve_reversed({_size(inner)}, inner, reversed_steps, batch)"
        return Node(made, (_WRAPPED, f"{_FORMS}reversed.cpp"), text, inner)
    if kind == "completed":
        inner = node_of(arm.six, name)
        text = (
            "struct Steps { void (*completed)(const CompletedArm&, const Batch&, const OfSix&) = keep_real; } steps;\n"
            f"    return solve_completed(arm, {_size(inner)}, inner, steps, batch)"
        )
        return Node(made, (_WRAPPED, f"{_FEW}completed.hpp"), text, inner)
    if kind == "coupled":
        n = int(arm.joints)
        text = (
            f"struct Scratch {{ double boxes[{n} * SCRATCH]; }};\n    URDF_IK_SCRATCH Scratch scratch;\n"
            f"    return solve_coupled<{n}>(arm, batch, scratch.boxes)"
        )
        return Node(made, ("families/mimics/coupled.hpp",), text)
    files, function = _own(arm, kind, name)
    return Node(made, files, f"{function}(arm, batch)")


def _size(inner: Node) -> str:
    of = inner.core
    return f"{{{of.joints}, {of.branches}, {of.parameters}}}"


def _own(arm: Any, kind: str, name: str) -> tuple[tuple[str, ...], str]:
    """Files and function of a solver that uses no other one."""
    if kind in FAMILIES:
        header, variants = FAMILIES[kind]
        function, family = variants[arm.variant]
        return (header,), f"{function}<{family}>"
    if kind == "imperfect":
        header, variants = FAMILIES[arm.family.kind]
        family = variants[arm.family.variant][1]
        return ("families/imperfect/imperfect.hpp", header), f"{_SINGLY}<Imperfect<{family}>>"
    if kind == "elimination":
        return ("families/general/elimination.hpp",), f"{_SINGLY}<General6>"
    if kind == "few joints":
        return (f"{_FEW}few_joints.hpp",), f"{_SINGLY}<FewJoints<{int(arm.joints)}, {int(arm.columns)}>>"
    if kind == "planar":
        return (f"{_FEW}planar.hpp",), f"{_CLOSED}<Planar<{int(arm.number)}>>"
    if kind == "slides":
        return (f"{_FEW}slides.hpp",), f"{_SINGLY}<Slides<{int(arm.columns)}>>"
    if kind in ("sampled", "sampled with one held"):
        return (f"{_FEW}sampled.hpp",), f"{_SINGLY}<{'Sampled' if kind == 'sampled' else 'SampledHeld'}>"
    if kind == "S-R-S":
        function = f"{_SINGLY}<SrsNear>" if arm.imperfection > 0.0 else f"{_CLOSED}<Srs>"
        return ("families/seven_joints/srs_near.hpp",), function
    if kind == "hollow wrist":
        return ("families/mimics/hollow_wrist.hpp",), f"{_SINGLY}<HollowWrist>"
    raise UnsupportedArm(f"{name}: a solver of the kind {kind!r} is not exported to one file")


def struct_of(node: Node) -> str:
    """The C++ type of a solver's numbers.

    It is that of the first parameter of the function that solves, so that no list of structs is kept here.
    """
    text = node.text
    if "solve_one_given" in text:
        return "GivenJoint"
    if "solve_completed" in text:
        return "CompletedArm"
    if coupled := re.search(r"solve_coupled<(\d)>", text):
        return f"CoupledArm<{coupled[1]}>"
    family = re.match(r"solve_\w+<(.*)>\(arm, batch\)$", text)
    return "" if family is None else f"{family[1]}::Arm"


def inlined(files: Iterable[str], space: str) -> str:
    """Sources of the core in the order of need, as parts of one unit, each behind a guard of its own.

    Args:
        files: what is needed; what they include comes before them.
        space: the namespace that replaces ``urdf_ik``.
    """
    root, seen, parts = core(), set[str](), list[str]()
    declared: set[str] = set()
    waiting = list(files)

    def take(name: str) -> None:
        if name in seen:
            return
        seen.add(name)
        text = (root / name).read_text()
        for included in re.findall(r'^#include "(.*)"\n', text, re.MULTILINE):
            take(included)
        # A function that another unit defines is defined here, behind all headers.
        if name.endswith(".hpp") and (functions := _DECLARED.findall(text)):
            declared.update(functions)
            unit = name.removesuffix(".hpp") + ".cpp"
            waiting.append(unit if (root / unit).is_file() else "families/general/elimination.hpp")
        if name != _LEVEL:
            parts.append(_guarded(name, text, space))

    while waiting:
        take(waiting.pop(0))
    whole = "\n".join(parts)
    for function in declared:
        whole = re.sub(rf"^(?!inline)([A-Za-z]\w* {function}\()", r"inline \1", whole, flags=re.MULTILINE)
    return whole


_LEVEL = "arithmetic/level.hpp"


def macros() -> tuple[str, str]:
    """The core's macros, defined and taken back."""
    text = (core() / _LEVEL).read_text()
    defined = re.findall(r"^#define (\w+) .*$", text, re.MULTILINE)
    lines = re.findall(r"^#define \w+ .*$", text, re.MULTILINE)
    return "\n".join(lines), "\n".join(f"#undef {name}" for name in [*defined, "URDF_IK_LEVEL"])


def _guarded(name: str, text: str, space: str) -> str:
    text = re.sub(r'^#include "[^"]*"\n|^#pragma once\n', "", text, flags=re.MULTILINE)
    # One file is one unit: nothing is instantiated or defined elsewhere.
    text = re.sub(r"^extern (template|const) [^;]*;\n", "", text, flags=re.MULTILINE)
    text = re.sub(r"^const (\w+ \w+ = \{)", r"inline constexpr \1", text, flags=re.MULTILINE)
    if name.endswith(".cpp"):
        text = re.sub(r"^template (?!<)[^;{]*;\n", "", text, flags=re.MULTILINE)
    text = re.sub(r"\burdf_ik(?=::| \{|;)", space, text)
    guard = f"{space}_{re.sub(r'[^A-Za-z0-9]', '_', name)}".upper()
    return f"#ifndef {guard}\n#define {guard}\n{text.strip()}\n#endif\n"
