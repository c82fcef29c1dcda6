"""Denavit-Hartenberg tables as CSV and text.

A CSV has a header with the columns in any order, one line a joint, and lines such as ``# convention: modified`` for
what belongs to the whole table.
"""

import csv
import io
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, PoseError, UrdfError
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.support import files
from urdf_ik.support.tables import csv_rows, number
from urdf_ik.support.text import aligned
from urdf_ik.typing import Array

CONVENTIONS = ("standard", "modified")
COLUMNS = ("alpha", "a", "d", "theta")
KEYS = ("name", "convention", "angles", "base", "tool")
OPTIONAL = ("name", "type", "offset", "lower", "upper")
_ALL = f"columns: {', '.join(COLUMNS)}, and where needed {', '.join(OPTIONAL)}"
_FRAME_FORM = "x y z roll pitch yaw: three numbers in m, three angles"


def table_error(problem: str, *, row: int | None = None, column: str | None = None) -> UrdfError:
    """The error for a table that makes no arm; rows count from 1."""
    where = [f"row {row}"] * (row is not None) + [f"column {column!r}"] * (column is not None)
    return UrdfError(problem, element=", ".join(where) or None)


def check_convention(convention: Any, error: Callable[[str], Exception] = ArgumentError) -> None:
    """Refuse what is not one of :data:`CONVENTIONS`."""
    if convention not in CONVENTIONS:
        raise error(f"unknown convention {convention!r}; there are {' and '.join(CONVENTIONS)} (Craig's)")


def read(path: str | os.PathLike[str], convention: str | None, degrees: bool) -> dict[str, Any]:
    """Arguments of :meth:`urdf_ik.DHTable.from_array` from a file."""
    content = files.read(path)
    try:
        text = content.decode("utf-8-sig")
        header, _, rows = csv_rows(text, "joint")
    except UnicodeDecodeError:
        raise table_error("is no text; a table is a CSV") from None
    except ValueError as error:
        raise table_error(f"the table{error}; {_ALL}") from None
    whole = {}
    for line in text.splitlines():
        key, _, value = line.lstrip("# ").partition(":")
        if line.startswith("#") and key.strip() in KEYS:  # any other line is a remark
            whole[key.strip()] = value.strip()
    if not set(COLUMNS) <= set(header or ()):
        raise table_error(f"the first line must be a header, and {','.join(header or rows[0])!r} lacks some; {_ALL}")
    chosen = whole.get("convention", convention)
    if chosen is None:
        how = "add the line '# convention: standard' or '# convention: modified', or give it (--convention standard)"
        raise table_error(f"the convention is not said; {how}")
    check_convention(chosen, table_error if "convention" in whole else ArgumentError)
    unit = whole.get("angles", "deg" if degrees else "rad")
    if unit not in ("rad", "deg"):
        raise table_error(f"angles in {unit!r}; there are rad and deg")
    numbers, kinds, names, limits = [], [], [], []
    for i, cells in enumerate(rows, start=1):
        if len(cells) != len(header or ()):
            raise table_error(f"{len(cells)} columns given, the header has {len(header or ())}: {_ALL}", row=i)
        joint = {key: cell for key, cell in zip(header or (), cells, strict=True) if cell}
        if unknown := [key for key in joint if key not in (*COLUMNS, *OPTIONAL)]:
            raise table_error(f"unknown column; {_ALL}", row=i, column=unknown[0])
        kind = joint.get("type", "revolute")
        if kind == "fixed":
            where = "the lines '# base: x y z roll pitch yaw' and '# tool: ...' hold what is fixed"
            raise table_error(f"a row is a joint, and this one is fixed; {where}", row=i, column="type")
        row = [_number(joint, key, i) for key in COLUMNS]
        if "angles" not in whole and unit == "rad" and abs(row[0]) >= 30.0:
            how = "add the line '# angles: deg' (or rad), or read it in degrees (--degrees)"
            raise table_error(f"{row[0]:g} rad may be degrees; {how}", row=i, column="alpha")
        row[2 if kind in ("prismatic", "P") else 3] += _number(joint, "offset", i, 0.0)
        numbers.append(row)
        kinds.append(kind)
        names.append(joint.get("name", f"joint_{i}"))
        limits.append([_number(joint, "lower", i, -np.inf), _number(joint, "upper", i, np.inf)])
    return {
        "rows": numbers,
        "joint_types": kinds,
        "joint_names": names,
        "limits": limits,
        "convention": chosen,
        "base": _frame(whole.get("base"), "base", unit == "deg"),
        "tool": _frame(whole.get("tool"), "tool", unit == "deg"),
        "name": whole.get("name") or Path(path).stem,
        "degrees": unit == "deg",
    }


def as_csv(table: Any, degrees: bool) -> str:
    """CSV text with every digit."""
    out = io.StringIO()
    whole = {"name": table.name, "convention": table.convention, "angles": "deg" if degrees else "rad"}
    whole |= {key: " ".join(map(repr, numbers)) for key, numbers in _frames(table, degrees).items()}
    out.writelines(f"# {key}: {text}\n" for key, text in whole.items())
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["name", "type", *COLUMNS, "lower", "upper"])
    for name, kind, numbers, limits in _joints(table, degrees):
        writer.writerow([name, kind, *numbers, *("" if np.isinf(x) else x for x in limits)])
    return out.getvalue()


def as_text(table: Any, degrees: bool = False) -> str:
    """A table for people; the joint's variable stands where it acts."""
    unit = "deg" if degrees else "rad"
    rows = [["#", "joint", "type", f"alpha [{unit}]", "a [m]", "d [m]", f"theta [{unit}]", "lower", "upper"]]
    for i, (name, kind, numbers, limits) in enumerate(_joints(table, degrees), start=1):
        shown = [f"{x:.8g}" for x in numbers]
        varied = 2 if kind == "prismatic" else 3
        shown[varied] = f"q{i}" + (f" {numbers[varied]:+.8g}" if numbers[varied] else "")
        rows.append([str(i), name, kind, *shown, *("none" if np.isinf(x) else f"{x:.6g}" for x in limits)])
    lines = [
        f"{table.name}: {table.convention} Denavit-Hartenberg table",
        "",
        *aligned(rows, left=(1, 2), rule=True),
        "",
    ]
    for key, values in _frames(table, degrees).items():
        x, y, z, *rpy = (f"{value:.8g}" for value in values)
        lines.append(f"{key}: xyz {x}, {y}, {z} m, rpy {', '.join(rpy)} {unit}")
    return "\n".join(lines)


def _frames(table: Any, degrees: bool) -> dict[str, list[float]]:
    """Position and angles of base and tool, where they are not the identity."""
    out = {}
    for key, T in (("base", table.base), ("tool", table.tool)):
        if not np.array_equal(T, np.eye(4)):
            rpy = to_rpy(T)
            out[key] = (np.append(T[:3, 3], np.rad2deg(rpy) if degrees else rpy) + 0.0).tolist()
    return out


def _joints(table: Any, degrees: bool) -> list[tuple[str, str, list[float], list[float]]]:
    """Name, type, numbers in the order of the columns, and limits of each joint."""
    turn = np.rad2deg(1.0) if degrees else 1.0
    rows = np.stack([table.alpha * turn, table.a, table.d, table.theta * turn], axis=1)
    limits = table.limits * np.where(table.prismatic, 1.0, turn)[:, None]
    return list(zip(table.joint_names, table.joint_types, rows.tolist(), limits.tolist(), strict=True))


def _number(joint: dict[str, str], key: str, row: int, default: float | None = None) -> float:
    if key not in joint and default is not None:
        return default
    if math.isfinite(value := number(joint.get(key, ""))):
        return value
    problem = f"{joint[key]!r} is no finite number" if key in joint else "the value is missing"
    raise table_error(problem, row=row, column=key)


def _frame(text: str | None, name: str, degrees: bool) -> Array:
    """A pose (4, 4) from x y z roll pitch yaw; the identity for None."""
    try:
        numbers = np.array([0.0] * 6 if text is None else text.replace(",", " ").split(), dtype=np.float64)
    except ValueError:
        raise table_error(f"{name} transform: {text!r} are no numbers; {_FRAME_FORM}") from None
    if numbers.shape != (6,):
        raise table_error(f"{name} transform: {numbers.size} numbers given; {_FRAME_FORM}")
    try:
        return pose(numbers[:3], rpy=np.deg2rad(numbers[3:]) if degrees else numbers[3:])
    except PoseError as error:
        raise table_error(f"{name} transform: {error}") from None
