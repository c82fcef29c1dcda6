"""Compile an arm: write the JSON file from which C++, C and `urdf_ik.load` solve it without analysing its URDF.

The file is the same whatever processor writes it. With --require-current nothing is written: the command fails unless
the file is what it would write, so that a URDF that changed since is noticed.

Examples:
    urdf-ik compile ur5 -o ur5.json
    urdf-ik compile my_arm.urdf --tip tool0 -o my_arm.json
    urdf-ik compile my_arm.urdf --tip tool0 -o my_arm.json --require-current
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from urdf_ik.cli.arm_options import ArmOptions

CompiledFile = Annotated[
    Path, typer.Option("--output", "-o", metavar="FILE", help="The compiled arm's file, such as arm.json.")
]
OnlyCompare = Annotated[
    bool, typer.Option("--require-current", help="Write nothing; fail unless the file is that of this arm now.")
]


def command(*, output: CompiledFile, require_current: OnlyCompare = False, chosen: ArmOptions) -> None:
    """Write the compiled arm, or compare it with the arm."""
    from urdf_ik import export
    from urdf_ik.cli import console
    from urdf_ik.support import files

    if require_current:
        export.require_current(output, chosen.load())
        console.write(f"{output} is up to date\n", None)
        return
    files.writable(output)
    arm = chosen.load()
    files.write(output, export.compile(arm).encode())
    console.write(f"{arm.name}, {arm.base} to {arm.tip}, in {output}\n", None)
