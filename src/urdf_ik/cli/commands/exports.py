"""The commands ``compile`` and ``export``, which take an arm out of Python."""

from pathlib import Path
from typing import Any

from urdf_ik import export as exporting
from urdf_ik.cli import console
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.errors import ArgumentError
from urdf_ik.support import files


def compile(*, output: Path, require_current: bool = False, chosen: ArmOptions) -> None:  # noqa: A001
    """Compile an arm: write the JSON file from which C++, C and `urdf_ik.load` solve it without analysing its URDF.

    The file is the same whatever processor writes it. With --require-current nothing is written: the command fails
    unless the file is what it would write, so that a URDF that changed since is noticed.

    Examples:
        urdf-ik compile ur5 -o ur5.json
        urdf-ik compile my_arm.urdf --tip tool0 -o my_arm.json
        urdf-ik compile my_arm.urdf --tip tool0 -o my_arm.json --require-current

    Options:
        output (-o FILE): The compiled arm's file, such as arm.json.
        require_current: Write nothing; fail unless the file is that of this arm now.
    """
    if require_current:
        exporting.require_current(output, chosen.load())
        console.write(f"{output} is up to date\n")
    else:
        _written(chosen, [(output, exporting.compile, {})])


def export(
    *,
    cpp: Path | None = None,
    c: Path | None = None,
    html: Path | None = None,
    name: str | None = None,
    faces: int | None = None,
    chosen: ArmOptions,
) -> None:
    """Export an arm to one file: a header for C++ or C that needs no library, or a page that needs no server.

    A header holds the arm's numbers and the solver that it needs, and nothing else. GCC 12, Clang 15 or later
    compile it, also for controllers without an operating system. `urdf-ik compile` writes a file for the C++
    library instead.

    The page holds the solvers as WebAssembly and the arm's shapes. It works offline: a target to drag, every
    solution as a ghost, sliders, poses as text.

    Examples:
        urdf-ik export ur5 --cpp ur5.hpp
        urdf-ik export my_arm.urdf --tip tool0 --name left --c left.h
        urdf-ik export zyyzyz_6r --html arm.html

    Options:
        cpp (FILE): C++20 header, such as arm.hpp.
        c (FILE): Header for C, such as arm.h.
        html (FILE): Page, such as arm.html.
        name (NAME): Namespace, or prefix in C. Default: the robot's name.
        faces (N): Triangles of the page's shapes at most. Default: 12000.
    """
    page = {} if faces is None else {"faces": faces}
    kinds = ((cpp, exporting.cpp, {"name": name}), (c, exporting.c, {"name": name}), (html, exporting.html, page))
    wanted = [kind for kind in kinds if kind[0] is not None]
    if not wanted:
        raise ArgumentError("give --cpp FILE, --c FILE or --html FILE")
    _written(chosen, wanted)


def _written(chosen: ArmOptions, wanted: list[Any]) -> None:
    """Write files, each with the function that makes its text and the options of that."""
    for file, _, _ in wanted:
        files.writable(file)
    arm = chosen.load()
    for file, write, settings in wanted:
        files.write(file, write(arm, **settings).encode())
        console.write(f"{arm.name}, {arm.base} to {arm.tip}, in {file}\n")
