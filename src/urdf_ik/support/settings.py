"""Settings of a function, each declared once: signature, documentation and command-line option come from it."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field, fields
from enum import Enum, auto
from typing import Any, TypeVar

_Record = TypeVar("_Record", bound=type)


class Form(Enum):
    """Form of a setting's value."""

    JOINT_VECTOR = auto()
    NUMBER = auto()
    EACH_JOINT = auto()
    """One number for all joints, or one for each."""
    LENGTH_AND_ANGLE = auto()
    CHOICE = auto()
    FLAG = auto()
    CHECK = auto()
    """True, False or 'require'."""
    WORLD = auto()


@dataclass(frozen=True)
class Setting:
    """One setting.

    Attributes:
        help: a sentence on what it sets.
        form: form of its value.
        unit: unit of its value, '' where it has none.
        choices: the valid values of a choice.
    """

    help: str
    form: Form
    unit: str = ""
    choices: tuple[str, ...] = ()


def setting(default: Any, help: str, form: Form, unit: str = "", choices: tuple[str, ...] = ()) -> Any:  # noqa: A002
    """A field of a dataclass that is a setting."""
    return field(default=default, metadata={"setting": Setting(help, form, unit, choices)})


def settings_of(record: Any) -> dict[str, Setting]:
    """The settings of a record by name."""
    return {each.name: each.metadata["setting"] for each in fields(record) if "setting" in each.metadata}


def documented(record: _Record) -> _Record:
    """A class decorator that adds the settings to the docstring."""
    lines = [f"{(record.__doc__ or '').rstrip()}\n\nAttributes:"]
    for each in fields(record):
        if found := each.metadata.get("setting"):
            unit = f" [{found.unit}]" if found.unit else ""
            default = "" if each.default in (None, MISSING) else f" Default: {each.default}."
            require = " 'require': an error where they cannot be." if found.form is Form.CHECK else ""
            lines.append(f"    {each.name}: {found.help.removesuffix('.')}{unit}.{require}{default}")
    record.__doc__ = "\n".join(lines)
    return record
