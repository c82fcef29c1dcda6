"""Denavit-Hartenberg tables as CSV, JSON and text.

CSV: a header with the columns in any order, one line a joint, and lines such as ``# convention: modified`` for what
belongs to the whole table. JSON: the same keys in one object, the rows under ``joints``.
"""

import csv
import io
import json
import math
import os
from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, PoseError, UrdfError
from urdf_ik.kinematics.dh.frames import rotation_z, slide_z, step_x
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.support import files
from urdf_ik.support.tables import csv_rows
from urdf_ik.support.text import aligned
from urdf_ik.typing import Array

CONVENTIONS = ("standard", "modified")
COLUMNS = ("alpha", "a", "d", "theta")
KEYS = ("name", "convention", "angles", "base", "tool")
OPTIONAL = ("name", "type", "offset", "lower", "upper")
_UNITS = {"rad": False, "deg": True}
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
    try:
        text = files.read(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise table_error("is no text; a table is CSV or JSON") from None
    parse = _from_json if text.lstrip().startswith(("{", "[")) else _from_csv
    whole, joints = parse(text)
    if unknown := [key for key in whole if key not in KEYS]:
        raise table_error(f"unknown key {unknown[0]!r}; there are {', '.join(KEYS)}")
    chosen = whole.get("convention") or convention
    if chosen is None:
        raise table_error("the convention is not said; add 'convention: standard' or 'modified', or name it")
    if whole.get("convention") is not None:
        check_convention(chosen, table_error)
    unit = whole.get("angles", "deg" if degrees else "rad")
    if unit not in _UNITS:
        raise table_error(f"angles in {unit!r}; there are rad and deg")
    base, tool = (_frame(whole.get(key), key, _UNITS[unit]) for key in ("base", "tool"))
    moving = [i for i, joint in enumerate(joints) if joint.get("type") != "fixed"] or [0]
    for i, joint in enumerate(joints, start=1):
        if joint.get("type") == "fixed" and moving[0] < i < moving[-1] + 1:
            problem = "a fixed row between joints; first rows (the base) and last rows (the tool) may be fixed"
            raise table_error(problem, row=i, column="type")
    first, last = joints[: moving[0]], joints[moving[-1] + 1 :]
    if first:
        base = reduce(np.matmul, (_step(joint, i, chosen, _UNITS[unit]) for i, joint in enumerate(first, 1)), base)
    if last:
        steps = (_step(joint, i, chosen, _UNITS[unit]) for i, joint in enumerate(last, moving[-1] + 2))
        tool = reduce(np.matmul, steps) @ tool
    return {
        **_columns(joints[moving[0] : moving[-1] + 1]),
        "convention": chosen,
        "base": base,
        "tool": tool,
        "name": whole.get("name") or Path(path).stem,
        "degrees": _UNITS[unit],
    }


def as_csv(table: Any, degrees: bool) -> str:
    """CSV text with every digit."""
    out = io.StringIO()
    for key, value in _whole(table, degrees).items():
        text = value if isinstance(value, str) else " ".join(map(repr, value))
        out.write(f"# {key}: {text}\n")
    writer = csv.writer(out, lineterminator="\n")
    joints = _joints(table, degrees)
    writer.writerow(joints[0])
    writer.writerows(["" if value is None else value for value in joint.values()] for joint in joints)
    return out.getvalue()


def as_json(table: Any, degrees: bool) -> str:
    """JSON text with every digit, a line for every joint."""
    whole = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in _whole(table, degrees).items()]
    joints = ",\n".join(f"    {json.dumps(joint)}" for joint in _joints(table, degrees))
    return "\n".join(["{", *whole, '  "joints": [', joints, "  ]", "}", ""])


def as_text(table: Any, degrees: bool = False) -> str:
    """A table for people."""
    header, rows = cells(table, degrees)
    lines = aligned([header, *rows], left=(1, 2), rule=True)
    title = f"{table.name}: {table.convention} Denavit-Hartenberg table"
    return "\n".join([title, "", *lines, "", *frames(table, degrees)])


def cells(table: Any, degrees: bool) -> tuple[list[str], list[list[str]]]:
    """Header and rows of texts; the joint's variable stands where it acts."""
    unit = "deg" if degrees else "rad"
    header = ["#", "joint", "type", f"alpha [{unit}]", "a [m]", "d [m]", f"theta [{unit}]", "lower", "upper"]
    rows = []
    for i, joint in enumerate(_joints(table, degrees), start=1):
        shown = {key: f"{joint[key]:.8g}" for key in COLUMNS}
        varied = "d" if joint["type"] == "prismatic" else "theta"
        shown[varied] = f"q{i}" + (f" {joint[varied]:+.8g}" if joint[varied] else "")
        limits = ["none" if joint[key] is None else f"{joint[key]:.6g}" for key in ("lower", "upper")]
        rows.append([str(i), joint["name"], joint["type"], *shown.values(), *limits])
    return header, rows


def frames(table: Any, degrees: bool) -> list[str]:
    """A line for base and tool each, where they are not the identity."""
    whole = _whole(table, degrees)
    unit = whole["angles"]
    lines = []
    for key in ("base", "tool"):
        if key in whole:
            x, y, z, *rpy = (f"{value:.8g}" for value in whole[key])
            lines.append(f"{key}: xyz {x}, {y}, {z} m, rpy {', '.join(rpy)} {unit}")
    return lines


def _whole(table: Any, degrees: bool) -> dict[str, Any]:
    out: dict[str, Any] = {"name": table.name, "convention": table.convention, "angles": "deg" if degrees else "rad"}
    for key in ("base", "tool"):
        T = getattr(table, key)
        if not np.array_equal(T, np.eye(4)):
            rpy = to_rpy(T)
            out[key] = (np.append(T[:3, 3], np.rad2deg(rpy) if degrees else rpy) + 0.0).tolist()
    return out


def _joints(table: Any, degrees: bool) -> list[dict[str, Any]]:
    """One dictionary a row, keys in the order of the columns; a limit that is not there is None."""

    def angle(value: float) -> float:
        return float(np.rad2deg(value)) if degrees else float(value)

    out = []
    for i, kind in enumerate(table.joint_types):
        bounds = [None if np.isinf(x) else float(x) if kind == "prismatic" else angle(x) for x in table.limits[i]]
        out.append(
            {
                "name": table.joint_names[i],
                "type": kind,
                "alpha": angle(table.alpha[i]),
                "a": float(table.a[i]),
                "d": float(table.d[i]),
                "theta": angle(table.theta[i]),
                "lower": bounds[0],
                "upper": bounds[1],
            }
        )
    return out


def _from_csv(text: str) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    whole = {}
    for line in lines:
        if line.startswith("#") and ":" in line:
            key, _, value = line.lstrip("# ").partition(":")
            if key.strip() in KEYS:  # any other line is a remark
                whole[key.strip()] = value.strip()
    try:
        header, _, rows = csv_rows(text, "joint")
    except ValueError as error:
        raise table_error(f"the table{error}; {_ALL}") from None
    if not set(COLUMNS) <= set(header or ()):
        first = ",".join(header or rows[0])
        raise table_error(f"the first line must be a header, and {first!r} lacks some; {_ALL}")
    names, joints = header or [], []
    for i, row in enumerate(rows, start=1):
        if len(row) != len(names):
            raise table_error(f"{len(row)} columns given, the header has {len(names)}: {','.join(names)}", row=i)
        joints.append({key: cell for key, cell in zip(names, row, strict=True) if cell})
    return whole, joints


def _from_json(text: str) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    try:
        value = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise table_error(f"this is no JSON: {error}") from None
    whole = value if isinstance(value, dict) else {"joints": value}
    joints = whole.pop("joints", None)
    if not isinstance(joints, list) or not all(isinstance(joint, dict) for joint in joints):
        raise table_error(f"the JSON must have 'joints', a list with one object a joint; {_ALL}")
    return whole, [{key: cell for key, cell in joint.items() if cell is not None} for joint in joints]


def _columns(joints: list[dict[str, Any]]) -> dict[str, Any]:
    """Rows, types, names and limits; an ``offset`` is added to what the joint moves."""
    rows, kinds, names, limits = [], [], [], []
    for i, joint in enumerate(joints, start=1):
        for key in joint:
            if key not in (*COLUMNS, *OPTIONAL):
                raise table_error(f"unknown column; {_ALL}", row=i, column=key)
        kind = joint.get("type", "revolute")
        row = [_number(joint, key, i) for key in COLUMNS]
        row[2 if kind in ("prismatic", "P") else 3] += _number(joint, "offset", i, 0.0)
        rows.append(row)
        kinds.append(kind)
        names.append(joint.get("name", f"joint_{i}"))
        limits.append([_number(joint, "lower", i, -np.inf), _number(joint, "upper", i, np.inf)])
    return {"rows": rows, "joint_types": kinds, "joint_names": names, "limits": limits or np.empty((0, 2))}


def _step(joint: dict[str, Any], row: int, convention: str, degrees: bool) -> Array:
    """The transform (4, 4) of a fixed row."""
    alpha, a, d, theta = (_number(joint, key, row) for key in COLUMNS)
    if degrees:
        alpha, theta = np.deg2rad([alpha, theta])
    steps = [rotation_z(theta) @ slide_z(d), step_x(a, alpha)]
    return steps[0] @ steps[1] if convention == "standard" else steps[1] @ steps[0]


def _number(joint: dict[str, Any], key: str, row: int, default: float | None = None) -> float:
    if key not in joint and default is not None:
        return default
    try:
        if key in joint and not isinstance(joint[key], bool) and math.isfinite(number := float(joint[key])):
            return number
    except (TypeError, ValueError):
        pass
    problem = f"{joint[key]!r} is no finite number" if key in joint else "the value is missing"
    raise table_error(problem, row=row, column=key)


def _frame(value: Any, name: str, degrees: bool) -> Array:
    """A pose (4, 4) from x y z roll pitch yaw, or from a matrix; the identity for None."""
    if value is None:
        return np.eye(4)
    try:
        numbers = np.array(value.replace(",", " ").split() if isinstance(value, str) else value, dtype=np.float64)
    except (TypeError, ValueError):
        raise table_error(f"{name} transform: {value!r} are no numbers; {_FRAME_FORM}") from None
    if numbers.shape == (4, 4):
        return numbers
    if numbers.shape != (6,):
        raise table_error(f"{name} transform: {numbers.size} numbers given; {_FRAME_FORM}")
    try:
        return pose(numbers[:3], rpy=np.deg2rad(numbers[3:]) if degrees else numbers[3:])
    except PoseError as error:
        raise table_error(f"{name} transform: {error}") from None
