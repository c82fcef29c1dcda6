"""Export an arm to one file: a header for C++ or C that solves it without a library, or a page that needs no server.

A header holds the arm's numbers and the solver that it needs, and nothing else. GCC 12, Clang 15 or later compile it,
also for controllers without an operating system. `urdf-ik compile` writes a file for the C++ library instead.

The page holds the solvers as WebAssembly and the arm's shapes. It works offline: a target to drag, every solution as a
ghost, sliders, poses as text.

Examples:
    urdf-ik export ur5 --cpp ur5.hpp
    urdf-ik export my_arm.urdf --tip tool0 --name left --c left.h
    urdf-ik export zyyzyz_6r --html arm.html
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from urdf_ik.cli.arm_options import ArmOptions

CppFile = Annotated[Path | None, typer.Option("--cpp", metavar="FILE", help="C++20 header, such as arm.hpp.")]
CFile = Annotated[Path | None, typer.Option("--c", metavar="FILE", help="Header for C, such as arm.h.")]
HtmlFile = Annotated[Path | None, typer.Option("--html", metavar="FILE", help="Page, such as arm.html.")]
Faces = Annotated[
    int | None, typer.Option("--faces", metavar="N", help="Triangles of the page's shapes at most. Default: 12000.")
]
Name = Annotated[
    str | None, typer.Option("--name", metavar="NAME", help="Namespace, or prefix in C. Default: the robot's name.")
]


def command(
    *,
    cpp: CppFile = None,
    c: CFile = None,
    html: HtmlFile = None,
    name: Name = None,
    faces: Faces = None,
    chosen: ArmOptions,
) -> None:
    """Write the files that are asked for."""
    from urdf_ik import export
    from urdf_ik.cli import console
    from urdf_ik.errors import ArgumentError
    from urdf_ik.support import files

    page = {} if faces is None else {"faces": faces}
    kinds = ((cpp, export.cpp, {"name": name}), (c, export.c, {"name": name}), (html, export.html, page))
    wanted = [(file, write, options) for file, write, options in kinds if file is not None]
    if not wanted:
        raise ArgumentError("give --cpp FILE, --c FILE or --html FILE")
    for file, _, _ in wanted:
        files.writable(file)
    arm = chosen.load()
    for file, write, options in wanted:
        files.write(file, write(arm, **options).encode())
        console.write(f"{arm.name}, {arm.base} to {arm.tip}, in {file}\n", None)
