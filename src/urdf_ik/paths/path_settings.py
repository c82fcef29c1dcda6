"""The declaration of the settings of a path, and the check of values per joint."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import Field, dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solver import Solver
from urdf_ik.support import inputs
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik.cell import World  # brings lxml and the obstacles

COSTS = ("l1", "l2", "max", "time")

Kind = Literal["joint vector", "number", "per joint", "length and angle", "choice", "flag", "contacts", "world"]
"""Form of a setting's value as an option of the command."""
_Function = TypeVar("_Function", bound=Callable[..., Any])


def _setting(default: Any, kind: Kind, text: str, unit: str = "") -> Any:
    """A field with what its documentation and its option need: a sentence, and the unit of its value."""
    return field(default=default, metadata={"kind": kind, "help": text, "unit": unit})


@dataclass(frozen=True)
class PathSettings:
    """Settings of a path: the keyword arguments of :meth:`urdf_ik.Arm.follow`, and the options of ``urdf-ik path``."""

    start: Any = _setting(
        None, "joint vector", "Joint vector at the first waypoint; by default the best one.", "rad or m"
    )
    end: Any = _setting(None, "joint vector", "Joint vector at the last waypoint; by default the best one.", "rad or m")
    world: World | None = _setting(None, "world", "Obstacles.")
    margin: float = _setting(0.0, "number", "Distance that bodies must keep from each other and from obstacles.", "m")
    collisions: bool | str = _setting(
        True,
        "contacts",
        "Whether contacts are checked, at the waypoints and all the way between them; by default where the collision "
        "shapes can be read. 'require': an error where they cannot be.",
    )
    cost: str = _setting(
        "l2",
        "choice",
        "Cost of a step: the sum of abs(dq) (l1), of dq^2 (l2), the largest (max), or its time (time).",
    )
    weights: Any = _setting(None, "per joint", "Factor on abs(dq) of each joint, on dq^2 for l2; by default 1.")
    limit_cost: float = _setting(
        0.0,
        "number",
        "Weight of the squared nearness to the nearest limit, 0 in the middle of the range and 1 at the limit.",
    )
    max_step: Any = _setting(None, "per joint", "Largest step of a joint between two waypoints.", "rad or m")
    tolerance: Any = _setting(
        None,
        "length and angle",
        "Largest distance of the tip from the straight segments; by default 0.001 m and 0.02 rad, or four times these "
        "where no plan keeps to them.",
        "m, rad",
    )
    reconfigure: bool = _setting(
        False, "flag", "Whether the branch may change, as seldom as possible, where no motion leads all the way."
    )
    time_limit: float | None = _setting(None, "number", "Longest search; then the best plan so far.", "s")
    progress: Callable[[str], object] | None = field(
        default=None, metadata={"help": "Called with a description of the next step of the search."}
    )


def options() -> dict[str, Field[Any]]:
    """The settings that are options of the command, by name."""
    return {setting.name: setting for setting in fields(PathSettings) if "kind" in setting.metadata}


def takes_settings(function: _Function) -> _Function:
    """Show the settings in the signature and the docstring of a function that takes them as ``**settings``."""
    signature = inspect.signature(function)
    own = [parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
    keyword = inspect.Parameter.KEYWORD_ONLY
    shown = [inspect.Parameter(f.name, keyword, default=f.default, annotation=f.type) for f in fields(PathSettings)]
    function.__signature__ = signature.replace(parameters=[*own, *shown])  # type: ignore[attr-defined]
    indent = " " * 12
    lines = "\n".join(f"{indent}{line}" for line in described().splitlines())
    function.__doc__ = (function.__doc__ or "").replace(f"{indent}**settings: see PathSettings.", lines)
    return function


def described() -> str:
    """A line a setting: its name, a sentence, the unit."""
    lines = []
    for setting in fields(PathSettings):
        unit = f" [{setting.metadata['unit']}]" if setting.metadata.get("unit") else ""
        lines.append(f"{setting.name}: {setting.metadata['help'].removesuffix('.')}{unit}.")
    return "\n".join(lines)


PathSettings.__doc__ = f"{PathSettings.__doc__}\n\nAttributes:\n    " + described().replace("\n", "\n    ")


def velocities(solver: Solver) -> Array:
    """(n,) rad/s or m/s, the velocity limits of the URDF."""
    limits = solver.velocity_limits
    if missing := [name for name, limit in zip(solver.joint_names, limits, strict=True) if np.isinf(limit)]:
        raise ArgumentError(
            f"{solver.name} has no velocity limit for {', '.join(missing)}: give them, or write "
            '<limit velocity="..."/> in the URDF'
        )
    return limits


def per_joint(name: str, value: Any, names: tuple[str, ...], *, zero: bool = False) -> Array:
    """Numbers (n,), one for each joint, from one number or from n.

    They lie between 1e-15 and 1e15, so that their squares and inverses neither overflow nor vanish; or they are
    infinite, or with ``zero`` zero instead.
    """
    numbers = inputs.real(value, name, f"a number, or one for each of {', '.join(names)}")
    fits = numbers.shape in ((), (1,), (len(names),))
    numbers = np.broadcast_to(numbers if fits else np.nan, (len(names),)).copy()
    if not (inputs.usable(numbers) | (numbers == (0.0 if zero else np.inf))).all():
        valid = f"{'zero, or ' if zero else ''}a number {inputs.USABLE}"
        raise ArgumentError(f"{name} is {value!r}; {valid} is needed, or one for each of {', '.join(names)}")
    return numbers
