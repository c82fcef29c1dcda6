"""An arm as one C++ file, or one header for C: its numbers, its solver and nothing else."""

import json
import re
import struct
from collections.abc import Iterable
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

from urdf_ik._core import Solver
from urdf_ik.arm import Arm
from urdf_ik.cmake import core
from urdf_ik.errors import ArgumentError, UnsupportedArm, escaped
from urdf_ik.export.compilation import compile
from urdf_ik.version import __version__

_TEMPLATES = Path(__file__).resolve().parent / "templates"
_SPACE = f"urdf_ik_{__version__.replace('.', '_')}"

# Of C++20 and of C; the name is a namespace, and begins the names of C's functions.
_WORDS = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t char8_t class co_await
co_return co_yield compl concept const const_cast consteval constexpr constinit continue decltype default delete do
double dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable namespace
new noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast requires restrict
return short signed sizeof static static_assert static_cast std struct switch template this thread_local throw true
try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor xor_eq
"""
_KEYWORDS = frozenset(_WORDS.split())


def cpp(arm: Arm, name: str | None = None) -> str:
    """The text of a C++20 header that solves one arm, without a library, heap or exceptions.

    Its namespace is ``name``; `NAME::ik`, `NAME::fk` and the rest stand at the end of the file. Several such files may
    be part of one unit. GCC 12, Clang 15 or later compile it. With ``-O3 -ffp-contract=fast -fno-math-errno
    -fno-trapping-math -fno-exceptions``, and with ``-ffreestanding -fno-rtti`` too, the compiler that built this
    package gives its answers at the same instruction set, to the last bit.

    Args:
        arm: as :func:`urdf_ik.load` returns it.
        name: a C++ name; default: made from the arm's.

    Raises:
        ArgumentError: ``name`` is no name in C++.
        UnsupportedArm: the arm cannot be compiled.

    Example:
        >>> import urdf_ik
        >>> text = cpp(urdf_ik.load("zyyzyz_6r"), "elbow")
        >>> "namespace elbow {" in text, "#include <vector>" in text
        (True, False)
    """
    name = _name(arm, name)
    document = json.loads(compile(arm))
    guard = f"{name.upper()}_HPP"
    start = f"#ifndef {guard}\n#define {guard}\n#ifndef {name.upper()}_EXAMPLE\n#pragma GCC system_header\n#endif"
    return "\n".join([_head(document, f"{name}: "), start, _body(arm, name, document), "#endif\n"])


def c(arm: Arm, name: str | None = None) -> str:
    """The text of a header for C that declares one arm's functions.

    One C++ unit of the program defines ``NAME_IMPLEMENTATION`` before it includes the header: there the functions are
    compiled. Arguments and errors are those of :func:`cpp`.

    Example:
        >>> import urdf_ik
        >>> "int elbow_ik(" in c(urdf_ik.load("zyyzyz_6r"), "elbow")
        True
    """
    name = _name(arm, name)
    document = json.loads(compile(arm))
    macro, sizes = name.upper(), {"JOINTS": "joints", "COLUMNS": "branches", "PARAMETERS": "parameters"}
    constants = ", ".join(f"{macro}_{size} = {len(document[key])}" for size, key in sizes.items())
    head, body = _head(document, f"{name}, for C: "), _body(arm, name, document)
    return _filled("one_file.h", name=name, macro=macro, constants=constants, head=head, body=body)


def _name(arm: Arm, name: str | None) -> str:
    if name is None:
        # Two underscores in a row belong to the compiler.
        made = re.sub(r"[\W_]+", "_", arm.name, flags=re.ASCII)
        return made if re.match(r"[A-Za-z]", made) and made not in _KEYWORDS else f"arm_{made.strip('_')}".rstrip("_")
    if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) or "__" in name:
        raise ArgumentError(f"name={name!r} given; letters, digits and single underscores are needed, such as my_arm")
    if name in _KEYWORDS:
        raise ArgumentError(f"name={name!r} given, a word of the language; take another, such as my_{name}")
    return name


def _head(document: dict[str, Any], what: str) -> str:
    licence = (
        "The solver is part of urdf-ik, under the BSD 3-Clause License: redistribution and use in source and binary\n"
        "forms, with or without modification, are permitted provided that this notice, the list of conditions and the\n"
        "disclaimer of https://opensource.org/license/bsd-3-clause are kept. It is provided as is, without warranty."
    )
    # A link's name is any text, which must not end the comment, nor seem to begin another.
    about = escaped(f"{what}{document['family']}, {document['base']} to {document['tip']}")
    about = re.sub(r"(?<=\*)(?=/)|(?<=/)(?=\*)", " ", about)
    return (
        f"/* {about}.\n"
        f"   Made by urdf-ik {__version__} from a URDF with the SHA-256 {document['urdf']['sha256']}. Do not edit.\n\n"
        f"{licence} */"
    )


def _filled(template: str, **values: Any) -> str:
    """A file of ``templates`` with values in place of its names."""
    return Template((_TEMPLATES / f"{template}.in").read_text()).substitute(values)


def _body(arm: Arm, name: str, document: dict[str, Any]) -> str:
    node = node_of(arm.solver.require_member().solver.arm, arm.name)
    files, solvers, needs_scratch = ["chain.cpp"], list[str](), False
    at: Node | None = node
    while at is not None:
        files += at.files
        needs_scratch |= "URDF_IK_SCRATCH" in at.text
        at = at.inner
    _solver(node, solvers)
    defined, undefined = macros()
    joints, parameters, chain = document["joints"], document["parameters"], document["chain"]
    defaults = f"\ninline constexpr double defaults[parameters] = {_row(each['default'] for each in parameters)};"
    gain = "" if chain["gain"] is None else f"inline constexpr double gain[][joints] = {_row_of_rows(chain['gain'])};\n"
    return _filled(
        "one_file.hpp",
        name=name,
        macro=f"{name.upper()}_EXAMPLE",
        space=_SPACE,
        scratch=_filled("scratch.hpp") if needs_scratch else "",
        macros=defined,
        undefined=undefined,
        core=inlined(files, _SPACE),
        joints=len(joints),
        columns=len(document["branches"]),
        parameters=len(parameters),
        defaults=defaults if parameters else "",
        base=_word(document["base"]),
        tip=_word(document["tip"]),
        sha256=document["urdf"]["sha256"],
        joint_names=", ".join(_word(joint["name"]) for joint in joints),
        branch_names=", ".join(map(_word, document["branches"])),
        lower=_row(joint["lower"] for joint in joints),
        upper=_row(joint["upper"] for joint in joints),
        turns=", ".join("true" if joint["turn"] else "false" for joint in joints),
        steps=",\n    ".join(map(_motion, chain["steps"])),
        slides=", ".join("true" if slides else "false" for slides in chain["slides"]),
        axes=len(chain["slides"]),
        gain=gain,
        solvers="".join(solvers),
        last=len(solvers) - 1,
        kinematics=_filled("kinematics_with_mimics.hpp" if gain else "kinematics.hpp").rstrip(),
    )


def _solver(node: "Node", made: list[str]) -> None:
    """Appends the functions that solve, those that are used first."""
    if node.inner is not None:
        _solver(node.inner, made)
    k, of = len(made), struct_of(node)
    image = node.core.image()
    lines = [f"inline long solve_{k}(const Batch& batch) {{\n"]
    if image:
        words = struct.unpack(f"<{len(image) // 8}Q", image)
        rows = [", ".join(f"{word:#x}" for word in words[i : i + 8]) for i in range(0, len(words), 8)]
        body = ",\n    ".join(rows)
        lines.insert(
            0, f"// {of}, as it is in memory.\nalignas(8) inline constexpr uint64_t words_{k}[] = {{\n    {body}}};\n"
        )
        lines.append(
            f"    static_assert(sizeof({of}) == sizeof words_{k} && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);\n"
            f"    const void* known = words_{k};\n"
            "    // The compiler must not fold the numbers into the code: the answers would have other last digits.\n"
            '    __asm__("" : "+r"(known));\n'
            f"    const {of}& arm = *static_cast<const {of}*>(known);\n"
        )
    if node.inner is not None:
        lines.append(f"    constexpr auto inner = [](const Batch& part) {{ return solve_{k - 1}(part); }};\n")
    text = node.text if node.text.startswith("struct") else f"return {node.text}"
    made.append("".join(lines) + f"    {text};\n}}\n")


def _motion(rows: list[list[float]]) -> str:
    return "{" + _row_of_rows([row[:3] for row in rows]) + ", " + _row(row[3] for row in rows) + "}"


def _row_of_rows(rows: list[list[float]]) -> str:
    return "{" + ", ".join(_row(row) for row in rows) + "}"


def _row(values: Any) -> str:
    return "{" + ", ".join(_number(each) for each in values) + "}"


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return {"inf": "__builtin_inf()", "-inf": "-__builtin_inf()"}[value]
    return repr(float(value))


def _word(text: str) -> str:
    """A C++ literal, with what is no plain character as octal digits."""
    return '"' + "".join(
        chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode()
    ) + '"'  # fmt: skip


_CLOSED, _SINGLY = "solve_closed_form", "solve_singly"
_FORMS = "families/closed_forms/"
# Of each family of six joints its class; a variant says how two axes lie to each other, as '2||3' or '5x6'.
_FAMILIES = {
    "spherical wrist": "SphericalWrist<Shoulder::{relation}_{axes}>",
    "three parallel axes": "ThreeParallel<Hand::{relation}_{axes}>",
    "parallel shoulder": "ParallelShoulder<LastAxes::{relation}_{axes}>",
    "spherical middle": "SphericalMiddle<LastPair::{relation}>",
}
_FEW = "families/few_joints/"
_WRAPPED = "solvers/wrapped.hpp"
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
    inner: "Node | None" = None


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
    if kind in _FAMILIES:
        header, family = _of_six(arm)
        return (header,), f"{_SINGLY if arm.variant == 'general' else _CLOSED}<{family}>"
    if kind == "imperfect":
        header, family = _of_six(arm.family)
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


def _of_six(arm: Any) -> tuple[str, str]:
    """Header and class of a family of six joints."""
    header, family = arm.kind.removesuffix(" axes").replace(" ", "_"), _FAMILIES[arm.kind]
    relation = "parallel" if "||" in arm.variant else "intersecting"
    family = family.format(relation=relation, axes=arm.variant[0] + arm.variant[-1])
    return f"{_FORMS}{header}.hpp", re.sub("::.*", "::general>", family) if arm.variant == "general" else family


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


_LEVEL = "numbers/level.hpp"


def macros() -> tuple[str, str]:
    """The core's macros, defined and taken back."""
    text = (core() / _LEVEL).read_text()
    # Of two definitions the first is WebAssembly's.
    lines = {line.split()[1]: line for line in re.findall(r"^#define \w+ .*$", text, re.MULTILINE)}
    return "\n".join(lines.values()), "\n".join(f"#undef {name}" for name in [*lines, "URDF_IK_LEVEL"])


def _guarded(name: str, text: str, space: str) -> str:
    text = re.sub(r'^#include "[^"]*"\n|^#pragma once\n', "", text, flags=re.MULTILINE)
    # One file is one unit: nothing is instantiated or defined elsewhere.
    text = re.sub(r"^extern template [^;]*;\n", "", text, flags=re.MULTILINE)
    text = re.sub(r"^extern const (\w+ \w+ = \{)", r"inline constexpr \1", text, flags=re.MULTILINE)
    if name.endswith(".cpp"):
        text = re.sub(r"^template (?!<)[^;{]*;\n", "", text, flags=re.MULTILINE)
    text = re.sub(r"\burdf_ik(?=::| \{|;)", space, text)
    guard = f"{space}_{re.sub(r'[^A-Za-z0-9]', '_', name)}".upper()
    return f"#ifndef {guard}\n#define {guard}\n{text.strip()}\n#endif\n"
