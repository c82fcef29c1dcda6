"""Compiled arms: the JSON text of an arm, which C++ and Python solve from.

The text holds what the compiled solver is made from, the chain, its limits and names, and the part of the URDF that the
chain uses. ``docs/_static/compiled-arm.schema.json`` describes it, and ``urdf_ik.export`` writes it.
"""

import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.arm.arm import Arm, assemble
from urdf_ik.errors import UrdfError, printable
from urdf_ik.kinematics.chain import from_urdf
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.model import urdf
from urdf_ik.model.xml import TEXT
from urdf_ik.support import files

FORMAT, VERSION = "urdf-ik compiled arm", 1
_AGAIN = "urdf-ik compile writes one"


def is_compiled(source: object) -> bool:
    """Whether a source is a compiled arm: the path of a ``.json`` file, or its text."""
    if isinstance(source, os.PathLike):
        return Path(source).suffix.lower() == ".json"
    return isinstance(source, str) and (source.lstrip()[:1] == "{" or source.lower().endswith(".json"))


def load_compiled(source: str | os.PathLike[str]) -> Arm:
    """The arm of a file or text that :func:`urdf_ik.compile` made, with all its settings.

    It solves with the numbers of the file. Its URDF is the part that the chain uses, without shapes.

    Raises:
        UrdfError: it cannot be read, is no compiled arm, or one of another version.

    Example:
        >>> import urdf_ik
        >>> text = urdf_ik.compile(urdf_ik.load("planar_2r"))
        >>> urdf_ik.load_compiled(text)
        <Arm 'planar_2r': base_link to tool0, ...>
    """
    if isinstance(source, str) and source.lstrip()[:1] == "{":
        return _arm_of(document_of(source, TEXT), TEXT)
    return _arm_of(read(source), files.name_of(source))


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The values of a compiled arm's file.

    Raises:
        UrdfError: it cannot be read, is no compiled arm, or one of another version.
    """
    data = files.read(path, lambda problem: UrdfError(problem, hint=_AGAIN))
    return document_of(data.decode("utf-8", "replace"), files.name_of(path))


def document_of(text: str, source: str) -> dict[str, Any]:
    """The values of a compiled arm's text.

    Raises:
        UrdfError: it is no JSON, no compiled arm, or one of another version.
    """
    return files.document(text, FORMAT, VERSION, lambda problem: UrdfError(problem, source=source, hint=_AGAIN))


def _arm_of(data: dict[str, Any], source: str) -> Arm:
    """The arm of a compiled arm's values, which messages call ``source``."""
    try:
        arm = _assembled(data, source)
        core = Solver(_namespace(data["solver"]))
        if (core.joints, core.branches) != (arm.dof, len(data["branches"])):
            raise ValueError(f"solver: {core.joints} joints and {core.branches} branches")
        for each in data["checks"]:
            off = np.abs(arm.fk(each["q"]) - np.array(each["T"], dtype=np.float64)).max()
            if not off <= 1e-9 * max(1.0, arm.chain.size):
                raise ValueError(f"checks: the chain leads {off:g} elsewhere")
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        missing = f"{error.args[0]} is missing" if isinstance(error, KeyError) else str(error)
        raise UrdfError(f"a damaged compiled arm: {printable(missing, 200)}", source=source, hint=_AGAIN) from None
    solver = arm.solver
    member = replace(solver.require_member(), solver=core)
    return replace(arm, solver=replace(solver, member=member, core=core, single=core))


def _assembled(data: dict[str, Any], source: str) -> Arm:
    """The arm of the file's part of a URDF."""
    model = urdf.read(str(data["urdf"]["chain"]))
    model = replace(model, source=source, sha256=str(data["urdf"]["sha256"]))
    chain = from_urdf(model, data["base"], data["tip"]).lock(data["locked"])
    axis = data["free_axis"]
    free = None if axis is None else FreeAxis(_three(axis["direction"]), _three(axis["at"]))
    return assemble(model, chain, free_axis=free, chosen=tuple(data["given"]))


def _three(numbers: Any) -> tuple[float, float, float]:
    x, y, z = (float(each) for each in numbers)
    return x, y, z


def _namespace(value: Any) -> Any:
    """Values of a JSON text as the compiled core reads them: groups with attributes, lists of numbers as arrays."""
    if isinstance(value, dict):
        return SimpleNamespace(**{name: _namespace(each) for name, each in value.items()})
    return np.array(value, dtype=np.float64) if isinstance(value, list) else value
