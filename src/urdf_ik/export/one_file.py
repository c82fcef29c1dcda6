"""An arm as one C++ file, or one header for C: its numbers, its solver and nothing else."""

from __future__ import annotations

import json
import re
import struct
from typing import Any

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, escaped
from urdf_ik.export.compilation import compile
from urdf_ik.export.solver_text import Node, inlined, macros, node_of, struct_of
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.version import __version__

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

# GCC's AVX-512 headers use undefined registers on purpose, and it sees such uses where it inlines.
_QUIET = """\
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif"""
_LOUD = """\
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif"""
_LEVEL = """\
// The namespace of the solver names the instruction set, so that units compiled for several do not mix.
#if defined(__AVX512F__)
#define URDF_IK_LEVEL v4
#elif defined(__AVX2__)
#define URDF_IK_LEVEL v3
#elif defined(__SSE2__)
#define URDF_IK_LEVEL v2
#else
#define URDF_IK_LEVEL plain
#endif
"""
_SCRATCH = """\
// The search for the solutions of joints that drive several axes each has 1 to 4 MB of memory of its own, beside the
// stack. One thread at a time may then solve; #define URDF_IK_SCRATCH static thread_local lifts this.
#ifndef URDF_IK_SCRATCH
#define URDF_IK_SCRATCH static
#endif
"""


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
    return "\n".join([_head(arm, document, f"{name}: "), start, _body(arm, name, document), "#endif\n"])


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
    sizes = {
        "JOINTS": len(document["joints"]),
        "COLUMNS": len(document["branches"]),
        "PARAMETERS": len(document["parameters"]),
    }
    macro = name.upper()
    constants = ", ".join(f"{macro}_{key} = {value}" for key, value in sizes.items())
    return f"""{_head(arm, document, f"{name}, for C: ")}
#ifndef {macro}_H
#define {macro}_H
#include <stdint.h>
#ifdef __cplusplus
extern "C" {{
#endif
enum {{ {constants} }};
/* All solutions of a pose T (16, row by row), packed: q ({macro}_COLUMNS * {macro}_JOINTS) and flags ({macro}_COLUMNS),
   bit 0: valid, bits 1 to 4: singular. q_ref (joints) and values (parameters) may be null.
   The number of solutions, or -1: T is no pose. */
int {name}_ik(const double* T, double* q, uint8_t* flags, const double* q_ref, const double* values);
/* The pose T (16) and the Jacobian J (6, joints) at a joint vector. */
void {name}_fk(const double* q, double* T);
void {name}_jacobian(const double* q, double* J);
void {name}_limits(int joint, double* lower, double* upper);
const char* {name}_joint_name(int joint);
#ifdef __cplusplus
}}
#endif
#endif

#if defined({macro}_IMPLEMENTATION) && !defined({macro}_IMPLEMENTED)
#define {macro}_IMPLEMENTED
#pragma GCC system_header
{_body(arm, name, document)}
extern "C" {{
int {name}_ik(const double* T, double* q, uint8_t* flags, const double* q_ref, const double* values) {{
    return {name}::ik(T, q, flags, q_ref, values);
}}
void {name}_fk(const double* q, double* T) {{ {name}::fk(q, T); }}
void {name}_jacobian(const double* q, double* J) {{ {name}::jacobian(q, J); }}
void {name}_limits(int joint, double* lower, double* upper) {{
    *lower = {name}::lower[joint], *upper = {name}::upper[joint];
}}
const char* {name}_joint_name(int joint) {{ return {name}::joint_names[joint]; }}
}}
#endif
"""


def _name(arm: Arm, name: str | None) -> str:
    inputs.arm(arm)
    if name is None:
        # Two underscores in a row belong to the compiler.
        made = re.sub(r"[\W_]+", "_", arm.name, flags=re.ASCII)
        return made if re.match(r"[A-Za-z]", made) and made not in _KEYWORDS else f"arm_{made.strip('_')}".rstrip("_")
    if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) or "__" in name:
        raise ArgumentError(
            f"name={quoted(name)} given; letters, digits and single underscores are needed, such as my_arm"
        )
    if name in _KEYWORDS:
        raise ArgumentError(f"name={quoted(name)} given, a word of the language; take another, such as my_{name}")
    return name


def _head(arm: Arm, document: dict[str, Any], what: str) -> str:
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


def _body(arm: Arm, name: str, document: dict[str, Any]) -> str:
    node = node_of(arm.solver.require_member().solver.arm, arm.name)
    files = ["chain.cpp"]
    at: Node | None = node
    needs_scratch = False
    while at is not None:
        files += at.files
        needs_scratch |= "URDF_IK_SCRATCH" in at.text
        at = at.inner
    defined, undefined = macros()
    start = f"#include <stdint.h>\n#include <stddef.h>\n{_LEVEL}{_SCRATCH if needs_scratch else ''}{defined}"
    return "\n".join(
        [_QUIET, start, inlined(files, _SPACE), _interface(name, document, node), undefined, _LOUD, _example(name)]
    )


def _interface(name: str, document: dict[str, Any], node: Node) -> str:
    joints, parameters = document["joints"], document["parameters"]
    n, columns, p = len(joints), len(document["branches"]), len(parameters)
    solvers: list[str] = []
    _solver(node, solvers)
    slides = ", ".join("true" if each else "false" for each in document["chain"]["slides"])
    steps = ",\n    ".join(_motion(each) for each in document["chain"]["steps"])
    free = (
        f"\ninline constexpr double defaults[parameters] = {_row(each['default'] for each in parameters)};" if p else ""
    )
    turning = ", ".join("true" if each["turn"] else "false" for each in joints)
    return f"""
namespace {name} {{

inline constexpr int joints = {n}, columns = {columns}, parameters = {p};
inline constexpr const char *base = {_word(document["base"])}, *tip = {_word(document["tip"])};
inline constexpr const char* urdf_sha256 = "{document["urdf"]["sha256"]}";
inline constexpr const char* joint_names[joints] = {{{", ".join(_word(each["name"]) for each in joints)}}};
inline constexpr const char* branch_names[columns] = {{{", ".join(_word(each) for each in document["branches"])}}};
inline constexpr double lower[joints] = {_row(each["lower"] for each in joints)};
inline constexpr double upper[joints] = {_row(each["upper"] for each in joints)};{free}
// Bits of a column's flags: whether it holds a solution, and whether this is singular; of a pose's first column: the
// status, 0 if the solutions are all, 32 if some may be missing, 64 if some stand as one, 96 if a curve of solutions
// keeps the pose.
inline constexpr int valid = 1, singular = 30, status = 96;

namespace detail {{
using namespace {_SPACE};
using namespace {_SPACE}::URDF_IK_LEVEL;
inline constexpr Motion steps[] = {{
    {steps}}};
inline constexpr bool slides[] = {{{slides}}}, turns[] = {{{turning}}};
inline constexpr ChainArm chain = {{{len(document["chain"]["slides"])}, steps, slides}};
{_gain(document)}{"".join(solvers)}}}  // namespace detail

// All solutions of m poses T (m, 16), row by row: q (m, columns, joints) [rad, m], flags (m, columns). q_ref (joints):
// on a continuum, free joints take values near these. values (m, parameters); null: the defaults. Index of the first T
// that is no pose, or -1.
inline long ik_batch(const double* T, long m, double* q, uint8_t* flags, const double* q_ref = nullptr,
                     const double* values = nullptr) {{
    double near[joints];
    for (int j = 0; q_ref && j < joints; ++j) {{
        const bool inside = q_ref[j] > -3.141592653589793 && q_ref[j] <= 3.141592653589793;
        near[j] = inside || !detail::turns[j] ? q_ref[j] : detail::on_circle(q_ref[j]);
    }}
    return detail::solve_{len(solvers) - 1}({{T, m, q_ref ? near : nullptr, values, q, flags}});
}}

// The solutions of one pose, packed: flags and q of the first so many columns. The number of them, or -1: T is no pose.
inline int ik(const double* T, double* q, uint8_t* flags, const double* q_ref = nullptr,
              const double* values = nullptr) {{
    if (ik_batch(T, 1, q, flags, q_ref, values) >= 0) return -1;
    int count = 0;
    const int of_pose = flags[0] & status;
    for (int c = 0; c < columns; ++c) {{
        if (!(flags[c] & valid)) continue;
        for (int j = 0; j < joints; ++j) q[count * joints + j] = q[c * joints + j];
        flags[count++] = flags[c];
    }}
    flags[0] = uint8_t((count ? flags[0] & ~status : 0) | of_pose);
    return count;
}}

// The pose T (16) and the Jacobian J (6, joints), linear rows above angular ones, at a joint vector of any size.
{_kinematics(document)}

}}  // namespace {name}
"""


def _gain(document: dict[str, Any]) -> str:
    """How far each axis moves per unit of a joint, where joints drive several axes."""
    gain = document["chain"]["gain"]
    if gain is None:
        return ""
    return f"inline constexpr double gain[][joints] = {_row_of_rows(gain)};\n"


def _kinematics(document: dict[str, Any]) -> str:
    """The functions fk and jacobian."""
    if document["chain"]["gain"] is None:
        return """\
inline void fk(const double* q, double* T) { detail::chain_functions.poses(detail::chain, q, 1, T); }
inline void jacobian(const double* q, double* J) { detail::chain_functions.jacobians(detail::chain, q, 1, J); }"""
    return """\
inline void fk(const double* q, double* T) {
    constexpr int axes = int(sizeof detail::slides);
    double values[axes] = {};
    for (int k = 0; k < axes; ++k) for (int j = 0; j < joints; ++j) values[k] += q[j] * detail::gain[k][j];
    detail::chain_functions.poses(detail::chain, values, 1, T);
}
inline void jacobian(const double* q, double* J) {
    constexpr int axes = int(sizeof detail::slides);
    double values[axes] = {}, each[6 * axes];
    for (int k = 0; k < axes; ++k) for (int j = 0; j < joints; ++j) values[k] += q[j] * detail::gain[k][j];
    detail::chain_functions.jacobians(detail::chain, values, 1, each);
    for (int r = 0; r < 6; ++r) for (int j = 0; j < joints; ++j) {
        double sum = 0.0;
        for (int k = 0; k < axes; ++k) sum += each[axes * r + k] * detail::gain[k][j];
        J[joints * r + j] = sum;
    }
}"""


def _solver(node: Node, made: list[str]) -> None:
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


def _example(name: str) -> str:
    macro = f"{name.upper()}_EXAMPLE"
    return f"""
#ifdef {macro}
// c++ -std=c++20 -O3 -D{macro} -x c++ FILE
#include <cstdio>
int main() {{
    double zero[{name}::joints] = {{}}, T[16], q[{name}::columns * {name}::joints];
    uint8_t flags[{name}::columns];
    {name}::fk(zero, T);
    const int count = {name}::ik(T, q, flags);
    for (int k = 0; k < count; ++k) {{
        for (int j = 0; j < {name}::joints; ++j) std::printf("%.6f ", q[k * {name}::joints + j]);
        std::printf("\\n");
    }}
    return count > 0 ? 0 : 1;
}}
#endif
"""
