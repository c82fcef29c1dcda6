"""The program ``urdf-ik``: the list of its commands, each in a file of its own that is imported when it is used."""

from __future__ import annotations

import functools
import inspect
import sys
import warnings
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from urdf_ik import errors
from urdf_ik.cli import interrupts, options
from urdf_ik.cli.commands import COMMANDS, GROUPS
from urdf_ik.cli.errors import Status, quoting_little, status_of, unloaded, unwritten
from urdf_ik.cli.prompt.grouped_command import GroupedCommand

_STYLE: dict[str, Any] = {"rich_markup_mode": None, "pretty_exceptions_enable": False}


class _CommandFiles(Mapping[str, Any]):
    """The commands by name; reading one imports its file."""

    def __getitem__(self, name: str) -> Any:
        return _command(name, COMMANDS[name])

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)


@functools.cache
def _command(name: str, file: str) -> Any:
    module = import_module(f"urdf_ik.cli.commands.{file}")
    one = typer.Typer(add_completion=False, **_STYLE)
    one.command(name, cls=GroupedCommand, help=_help(module.__doc__ or ""))(options.expanded(module.command))
    return typer.main.get_command(one)


def _summary(file: str) -> str:
    """The first line of a command's docstring, which is the first line of its file."""
    with Path(__file__).parent.joinpath("commands", *file.split(".")).with_suffix(".py").open(encoding="utf-8") as text:
        return text.readline().strip().strip('"').removesuffix(".")


def _help(docstring: str) -> str:
    r"""A module's docstring as help text; ``\b`` keeps the lines of its examples as they are."""
    text, _, examples = inspect.cleandoc(docstring).partition("\nExamples:\n")
    return f"{text}\n\b\nExamples:\n{examples.replace('    urdf-ik', '  urdf-ik')}"


class Commands(TyperGroup):
    """The group of all commands; an error of this package becomes one message on stderr and an exit status."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes | {"commands": _CommandFiles()})

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands, in the order of the help; no file is imported for them."""
        return list(COMMANDS)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands by groups, with the first line of each file; no file is imported for them."""
        for group, files in GROUPS.items():
            with formatter.section(group):
                formatter.write_dl([(name, _summary(file)) for name, file in files.items()])

    def make_context(self, *args: Any, **kwargs: Any) -> Any:
        """Read the options before the command."""
        with quoting_little():
            return super().make_context(*args, **kwargs)

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            with quoting_little(), warnings.catch_warnings():
                warnings.showwarning = _warn  # type: ignore[assignment]
                return super().invoke(ctx)
        except KeyboardInterrupt as error:
            if str(error):  # long work says how much of it is kept
                typer.echo(f"\n{error}", err=True)
            raise typer.Exit(Status.INTERRUPTED) from None
        except Exception as error:
            if interrupts.came():  # whatever went wrong is a consequence
                raise typer.Exit(Status.INTERRUPTED) from None
            if isinstance(error, errors.UrdfIkError):
                status, text = status_of(error), str(error)
            elif isinstance(error, MemoryError):
                status, text = Status.USAGE, "not enough memory for that many poses; give fewer at a time"
            elif isinstance(error, ImportError):
                status, text = Status.USAGE, unloaded(error)
            elif isinstance(error, OSError):
                raise typer.Exit(unwritten(error)) from None
            else:
                raise
            typer.echo(f"Error: {text}", err=True)
            raise typer.Exit(status) from None


def _warn(message: Warning | str, *_: Any) -> None:
    """Say a warning in a line, without the place in the source that it came from."""
    typer.echo(errors.escaped(f"warning: {message}"), err=True)


app = typer.Typer(
    name="urdf-ik",
    cls=Commands,
    help="Every inverse-kinematics solution of an arm given as URDF, each one checked against Pinocchio.",
    context_settings={"help_option_names": ["-h", "--help"]},
    **_STYLE,
)


@app.callback(invoke_without_command=True)
def root(context: typer.Context, version: options.Version = False) -> None:
    """Print the first steps where no command is given."""
    if context.invoked_subcommand is None:
        from urdf_ik.cli.prompt.first_steps import steps

        typer.echo(steps())


def run() -> None:
    """Run the command that ``sys.argv`` holds, and end the process.

    Raises:
        SystemExit: with the command's status.
    """
    try:
        try:
            app()
        finally:  # help and version are printed before any command runs
            if sys.stdout is not None and not sys.stdout.closed:
                sys.stdout.flush()
    except OSError as error:
        sys.exit(unwritten(error))
