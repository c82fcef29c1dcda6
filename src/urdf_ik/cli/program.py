"""The program ``urdf-ik``: its list of commands, whose files are imported when they are used, and its errors."""

import functools
import inspect
import os
import re
import sys
import warnings
from collections.abc import Collection, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from urdf_ik import errors
from urdf_ik.cell import missing_pinocchio
from urdf_ik.cli import options
from urdf_ik.cli.commands import COMMANDS, GROUPS
from urdf_ik.cli.console import Status, say
from urdf_ik.errors import message
from urdf_ik.version import __version__

_STYLE: dict[str, Any] = {"rich_markup_mode": None, "pretty_exceptions_enable": False}
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_NUMBERS = re.compile(rf"(?:[A-Z]=)?,?[\[(]?{_NUMBER}(?:,{_NUMBER})*[\])]?,?")
_NAME_COLUMNS = 24
"""Columns for the names of options; a longer one stands on a line of its own."""
_STEPS = """urdf-ik {version}: every inverse-kinematics solution of a robot arm, from its URDF

  urdf-ik ik zyyzyz_6r        all solutions of a bundled arm, verified
  urdf-ik robots              arms that have names
  urdf-ik info {file}   how your arm is built and solved
  urdf-ik ik {file}     all solutions of an example pose of it
  urdf-ik ik {file} --xyz 0.4,0,0.3 --rpy 0,1.57,0
                              of a pose of yours
  urdf-ik check {file}  the arm against Pinocchio
  urdf-ik view {file}   the arm in the browser, with a target to drag
  urdf-ik doctor              what is installed, and whether it works

urdf-ik --help lists every command, urdf-ik COMMAND --help its options."""


class _GroupedCommand(TyperCommand):
    """A command whose options stand in named groups, and whose lists of numbers may be typed with spaces."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, ``--xyz 0.4 0 0.3`` as ``--xyz 0.4,0,0.3``."""
        lists = {name for each in self.get_params(ctx) if "," in (each.metavar or "") for name in each.opts}
        return super().parse_args(ctx, with_commas(args, lists))

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then the options by their groups, in the order in which these first occur."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for each in self.get_params(ctx):
            record = each.get_help_record(ctx)
            if record is not None:
                name = "Arguments" if each.param_type_name == "argument" else getattr(each, "rich_help_panel", None)
                groups.setdefault(name or "Options", []).append(record)
        for name, records in groups.items():
            with formatter.section(name):
                formatter.write_dl(records, col_max=_NAME_COLUMNS)


def with_commas(args: Sequence[str], lists: Collection[str]) -> list[str]:
    """Arguments with the numbers that follow an option of ``lists`` joined to one argument by commas."""
    out: list[str] = []
    joining = False
    for k, arg in enumerate(args):
        if arg == "--":
            return [*out, *args[k:]]
        name, sign, value = arg.partition("=")
        if name in lists:
            joining = bool(sign and _NUMBERS.fullmatch(value))
            out.append(arg)
        elif k and args[k - 1] in lists:
            joining = bool(_NUMBERS.fullmatch(arg))
            out.append(arg)
        elif joining and _NUMBERS.fullmatch(arg):
            out[-1] = f"{out[-1].rstrip(',')},{arg.strip(',')}"
        else:
            joining = False
            out.append(arg)
    return out


@functools.cache
def _command(name: str, file: str) -> Any:
    function = getattr(import_module(f"urdf_ik.cli.commands.{file}"), name)
    one = typer.Typer(add_completion=False, **_STYLE)
    one.command(name, cls=_GroupedCommand, help=_help(function.__doc__))(options.expanded(function))
    return typer.main.get_command(one)


def _help(docstring: str) -> str:
    r"""A command's docstring as help text; ``\b`` keeps the lines of its examples as they are."""
    text, _, rest = inspect.cleandoc(docstring).partition("\n\nExamples:\n")
    examples = rest.partition("\n\n")[0].replace("    urdf-ik", "  urdf-ik")
    return f"{text}\n\n\b\nExamples:\n{examples}"


class _Commands(TyperGroup):
    """The group of all commands; an error of this package becomes one message on stderr and an exit status."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes | {"commands": dict.fromkeys(COMMANDS)})

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of a name; its file is imported."""
        return _command(cmd_name, COMMANDS[cmd_name][0]) if cmd_name in COMMANDS else None

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands, in the order of the help; no file is imported for them."""
        return list(COMMANDS)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands by groups, with a line on each; no file is imported for them."""
        for group, commands in GROUPS.items():
            with formatter.section(group):
                formatter.write_dl([(name, summary) for name, (_, summary) in commands.items()])

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            with warnings.catch_warnings():
                warnings.showwarning = lambda text, *_: say(f"warning: {text}")
                return super().invoke(ctx)
        except KeyboardInterrupt as error:
            if str(error):  # long work says how much of it is kept
                typer.echo(f"\n{error}", err=True)
            raise typer.Exit(Status.INTERRUPTED) from None
        except MemoryError:
            status, text = Status.USAGE, "not enough memory for that many poses; give fewer at a time"
        except errors.UrdfIkError as error:
            status, text = status_of(error), str(error)
        except ImportError as error:
            status, text = Status.USAGE, _not_loaded(error)
        except OSError as error:
            raise typer.Exit(_not_written(error)) from None
        typer.echo(f"Error: {text}", err=True)
        raise typer.Exit(status)


def status_of(error: errors.UrdfIkError) -> Status:
    """Exit status for an error of this package."""
    if isinstance(error, errors.UrdfError | errors.ChainError):
        return Status.URDF
    return Status.UNSUPPORTED if isinstance(error, errors.UnsupportedArm) else Status.USAGE


def _not_loaded(error: ImportError) -> str:
    """Message for a package that is installed and cannot be loaded: pin's wheels need a library of the system."""
    if isinstance(error, ModuleNotFoundError) and error.name in missing_pinocchio.PACKAGES:
        return str(missing_pinocchio.needed("checks"))
    hint = "; on Debian and Ubuntu: apt install libgomp1" if "libgomp" in str(error) else ""
    return f"a package that urdf-ik needs cannot be loaded: {error}{hint}"


def _not_written(error: OSError) -> Status:
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


app = typer.Typer(
    name="urdf-ik",
    cls=_Commands,
    help="Every inverse-kinematics solution of an arm given as URDF, each one checked against Pinocchio.",
    context_settings={"help_option_names": ["-h", "--help"]},
    **_STYLE,
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"urdf-ik {__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """Print the first steps where no command is given."""
    if context.invoked_subcommand is None:
        here = sorted(path.name for path in Path().glob("*.urdf") if " " not in path.name)
        typer.echo(_STEPS.format(version=__version__, file=here[0] if here else "my_arm.urdf"))


def run() -> None:
    """Run the command that ``sys.argv`` holds, and end the process."""
    try:
        try:
            app()
        finally:  # help and version are printed before any command runs
            if sys.stdout is not None and not sys.stdout.closed:
                sys.stdout.flush()
    except OSError as error:
        sys.exit(_not_written(error))
