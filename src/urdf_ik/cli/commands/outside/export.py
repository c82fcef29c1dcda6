"""Export an arm to one file: a C++ header, or a header for C, that solves it without a library or heap.

The file holds the arm's numbers and the solver that it needs, and nothing else. GCC 12, Clang 15 or later compile it,
also for controllers without an operating system. `urdf-ik compile` writes a file for the C++ library instead.

Examples:
    urdf-ik export ur5 --cpp ur5.hpp
    urdf-ik export my_arm.urdf --tip tool0 --name left --c left.h
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from urdf_ik.cli.arm_options import ArmOptions

CppFile = Annotated[Path | None, typer.Option("--cpp", metavar="FILE", help="C++20 header, such as arm.hpp.")]
CFile = Annotated[Path | None, typer.Option("--c", metavar="FILE", help="Header for C, such as arm.h.")]
Name = Annotated[
    str | None, typer.Option("--name", metavar="NAME", help="Namespace, or prefix in C. Default: the robot's name.")
]


def command(*, cpp: CppFile = None, c: CFile = None, name: Name = None, chosen: ArmOptions) -> None:
    """Write the files that are asked for."""
    from urdf_ik import export
    from urdf_ik.cli import console
    from urdf_ik.errors import ArgumentError
    from urdf_ik.support import files

    wanted = [(file, write) for file, write in ((cpp, export.cpp), (c, export.c)) if file is not None]
    if not wanted:
        raise ArgumentError("give --cpp FILE or --c FILE")
    for file, _ in wanted:
        files.writable(file)
    arm = chosen.load()
    for file, write in wanted:
        files.write(file, write(arm, name).encode())
        console.write(f"{arm.name}, {arm.base} to {arm.tip}, in {file}\n", None)
