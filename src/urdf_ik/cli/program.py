"""The program ``urdf-ik`` itself, and what is asked first: what to do, which robots there are, whether it works."""

from __future__ import annotations

import typer

from urdf_ik.cli import options
from urdf_ik.cli.errors import Commands, Status
from urdf_ik.cli.options import ReportFormat

app = typer.Typer(
    name="urdf-ik",
    cls=Commands,
    help="Every inverse-kinematics solution of an arm given as URDF, each one checked against Pinocchio.",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def help_text(what: str, *examples: str) -> str:
    """Help text; the marker before the examples keeps their lines as they are."""
    return what + "\n\n\b\nExamples:\n" + "\n".join(f"  {line}" for line in examples)


@app.callback(invoke_without_command=True)
def root(context: typer.Context, version: options.Version = False) -> None:
    """Take the options that stand before the command; without one, say what to do first."""
    if context.invoked_subcommand is None:
        from urdf_ik.cli.commands import first

        typer.echo(first.steps())


@app.command(
    help=help_text(
        "List the arms that have names, with the family and the joints of those that are here: bundled ones, those of "
        "example-robot-data, and those of robot_descriptions, which downloads a model when it is first asked for.",
        "urdf-ik robots",
        "urdf-ik robots ur --all",
    )
)
def robots(
    word: options.Word = "", everything: options.All = False, printed_as: options.TextFormat = ReportFormat.TABLE
) -> None:
    """Print the list."""
    from urdf_ik.cli import console
    from urdf_ik.cli.commands import robots as robots_command

    found = robots_command.listed(word, everything)
    write = robots_command.as_json if printed_as is ReportFormat.JSON else robots_command.as_text
    console.write(write(found), None)


@app.command(
    help=help_text(
        "Say what is installed and whether it works: versions, the processor's instruction set, optional packages, and "
        "a test of the solvers against Pinocchio. The status is 1 when the test fails.",
        "urdf-ik doctor",
        "urdf-ik doctor --format json",
    )
)
def doctor(printed_as: options.TextFormat = ReportFormat.TABLE) -> None:
    """Print the findings."""
    from urdf_ik.cli import console
    from urdf_ik.cli.commands import doctor as doctor_command

    found = doctor_command.examine()
    write = doctor_command.as_json if printed_as is ReportFormat.JSON else doctor_command.as_text
    console.write(write(found), None)
    if not found.passed:
        raise typer.Exit(Status.FAILED)
