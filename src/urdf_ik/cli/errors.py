"""How ``urdf-ik`` ends: its exit status, and errors as one message instead of a traceback."""

from __future__ import annotations

import os
import sys
from enum import IntEnum
from typing import Any

import typer
from typer.core import TyperGroup

from urdf_ik import errors
from urdf_ik.text import escaped


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


class Commands(TyperGroup):
    """Turns this package's errors into one message on stderr and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except errors.UrdfIkError as error:
            typer.echo(f"Error: {error}", err=True)
            raise typer.Exit(status_of(error)) from None
        except KeyboardInterrupt as error:
            # Long work says what is kept.
            if str(error):
                typer.echo(f"\n{error}", err=True)
            raise typer.Exit(Status.INTERRUPTED) from None
        except MemoryError:
            typer.echo("Error: not enough memory for that many poses; give fewer at a time", err=True)
            raise typer.Exit(Status.USAGE) from None
        except OSError as error:
            raise typer.Exit(unwritten(error)) from None


def unwritten(error: OSError) -> Status:
    """Exit status where standard output cannot be written, and the message that says so."""
    # Python would try again at exit and complain: let that go nowhere.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, BrokenPipeError):
        return Status.READER_GONE
    typer.echo(escaped(f"Error: {error}"), err=True)
    return Status.USAGE
