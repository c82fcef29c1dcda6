"""Exit statuses of ``urdf-ik``, and errors as one message instead of a traceback."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from enum import IntEnum

import typer

from urdf_ik import errors
from urdf_ik.cell import missing_pinocchio as without_pinocchio
from urdf_ik.errors import MOST_OF_A_NAME, message, printable

_QUOTE = re.compile(rf"'[^']{{{MOST_OF_A_NAME + 1},}}'")
_MOST = 1000  # characters of a message about the arguments: a list of all that would be valid has some hundred


class Status(IntEnum):
    """Exit status."""

    DONE = 0
    FAILED = 1
    USAGE = 2
    URDF = 3
    UNSUPPORTED = 4
    INTERRUPTED = 130
    READER_GONE = 141  # as the shell reports a program that SIGPIPE ended


def status_of(error: errors.UrdfIkError) -> Status:
    """Exit status for an error of this package."""
    if isinstance(error, errors.UrdfError | errors.ChainError):
        return Status.URDF
    return Status.UNSUPPORTED if isinstance(error, errors.UnsupportedArm) else Status.USAGE


def unloaded(error: ImportError) -> str:
    """Message for a package that is installed and cannot be loaded: pin's wheels need a library of the system."""
    if isinstance(error, ModuleNotFoundError) and error.name in without_pinocchio.PACKAGES:
        return str(without_pinocchio.needed("checks"))
    hint = "; on Debian and Ubuntu: apt install libgomp1" if "libgomp" in str(error) else ""
    return f"a package that urdf-ik needs cannot be loaded: {printable(str(error))}{hint}"


@contextmanager
def quoting_little() -> Iterator[None]:
    """Shorten the arguments that Typer's own errors quote, and escape control characters in them."""
    try:
        yield
    except Exception as error:
        text = getattr(error, "message", None)
        if hasattr(error, "format_message") and isinstance(text, str):
            text = message(_QUOTE.sub(lambda quote: printable(quote[0]) + quote[0][0], text))
            error.message = text if len(text) <= _MOST else text[: _MOST - 3] + "..."  # type: ignore[attr-defined]
        raise


def unwritten(error: OSError) -> Status:
    """Exit status where standard output cannot be written, and the message that says so."""
    # Python would try again at exit and complain: let that go nowhere.
    with suppress(OSError):  # a stream without a descriptor
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, BrokenPipeError):
        return Status.READER_GONE
    problem = error if error.filename is not None else f"cannot write standard output: {error.strerror or error}"
    with suppress(OSError):  # standard error cannot be written, either
        typer.echo(message(f"Error: {problem}"), err=True)
    return Status.USAGE
