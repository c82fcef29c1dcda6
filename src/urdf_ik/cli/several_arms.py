"""Several arms for one command: each option of an arm is for all of them, or for one by its letter."""

from __future__ import annotations

import re
import string
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, get_args, get_origin

from typer import Argument

from urdf_ik.cli import console
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.options import ForEach, hinted_fields
from urdf_ik.support.text import quoted

_LETTERS = string.ascii_uppercase
_FOR_ONE = re.compile(r"([A-Z])=(.*)", re.DOTALL)


@dataclass(frozen=True)
class SeveralArms:
    """The arms A, B, ... and their options as typed: ``--tip tool0`` for all, ``--tip B=flange`` for the second."""

    GROUP: ClassVar[str] = ArmOptions.GROUP
    options: Annotated[Mapping[str, Any], ForEach(ArmOptions)]
    robots: Annotated[
        list[str],
        Argument(
            metavar="A B", help="Files, names that `urdf-ik robots` lists, or - for stdin. The first is the reference."
        ),
    ]

    def each(self, most: int = len(_LETTERS)) -> list[ArmOptions]:
        """Each arm with its options.

        Args:
            most: greatest number of arms.

        Raises:
            typer.BadParameter: too few or too many arms, a letter without an arm, or an option twice for one arm.
        """
        count = len(self.robots)
        if not 2 <= count <= most:
            raise console.usage(f"{count} arm{'s' * (count != 1)} given; {_numbers(most)} can be compared", "A B")
        if self.robots.count("-") > 1:
            raise console.usage("only one arm can be read from standard input", "A B")
        typed = {name: self._of_each(name, hint) for name, hint, _, _ in hinted_fields(ArmOptions) if name != "robot"}
        return [ArmOptions(robot, **{name: values[k] for name, values in typed.items()})
                for k, robot in enumerate(self.robots)]  # fmt: skip

    def _of_each(self, name: str, hint: Any) -> list[Any]:
        """The value of an option for each arm."""
        values, option, count = self.options[name], f"--{name.replace('_', '-')}", len(self.robots)
        if values is None or isinstance(values, bool):
            return [values] * count
        everyone: list[str] = []
        own: list[list[str]] = [[] for _ in self.robots]
        for value in values:
            found = _FOR_ONE.fullmatch(value)
            if found is None:
                everyone.append(value)
            elif _LETTERS.index(found[1]) < count:
                own[_LETTERS.index(found[1])].append(found[2])
            else:
                last = _LETTERS[count - 1]
                raise console.usage(f"{quoted(value)}: there is no arm {found[1]}, the last one is {last}", option)
        repeated = any(get_origin(kind) is list for kind in get_args(get_args(hint)[0]))
        taken = [[*everyone, *mine] if repeated else mine or everyone for mine in own]
        for letter, mine in zip(_LETTERS, taken, strict=False):
            if not repeated and len(mine) > 1:
                raise console.usage(f"given {len(mine)} times for arm {letter}; once is enough", option)
        read = [[_value(each, hint, option) for each in mine] for mine in taken]
        return [(mine if repeated else mine[0]) if mine else None for mine in read]


def _value(typed: str, hint: Any, option: str) -> str | Path:
    """A value as the option of one arm reads it: a file or a folder must exist."""
    declared = get_args(hint)[1]
    if not declared.exists:
        return typed
    path = Path(typed)
    if not (path.is_file() if declared.file_okay else path.is_dir()):
        kind = "file" if declared.file_okay else "folder"
        raise console.usage(f"there is no {kind} {quoted(typed)}", option)
    return path


def _numbers(most: int) -> str:
    return "two" if most == 2 else f"two to {most}"
