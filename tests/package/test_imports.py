"""Imports of the package and includes of its core: down the floors, without a circle; files and folders are short."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src"
PACKAGE = "urdf_ik"

# The rooms, floor by floor in the order in which a pose flows: a room imports from its own floor and from those below,
# also inside functions and for type checking.
FLOORS = (
    {"_core", "cmake", "errors", "support", "typing", "version"},
    {"model"},
    {"kinematics"},
    {"ik"},
    {"cell"},
    {"paths"},
    {"arm"},
    {"calibration", "export", "maps", "verify"},
    {"interop", "show"},
    {"cli"},
)
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
# The same of the compiled core: what computes knows nothing of Python, whose side the bindings are.
CORE_FLOORS = (
    "numbers", "arm", "certify", "propose", "referee", "families", "motion", "", "solvers", "library", "bindings",
    "steps",
)  # fmt: skip
MOST_LINES, MOST_FILES = 700, 25
SUFFIXES = {".py", ".pyi", ".cpp", ".hpp"}


def modules() -> dict[str, Path]:
    """Every module of the package by its full name, the compiled core by its stub."""
    named = {}
    for path in sorted([*SOURCE.glob(f"{PACKAGE}/**/*.py"), SOURCE / PACKAGE / "_core.pyi"]):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return named


def imports(name: str, path: Path, known: dict[str, Path]) -> Iterator[tuple[str, bool]]:
    """The package's modules that one imports, each with whether it does so when a function is called."""
    tree = ast.parse(path.read_text())
    late = {
        id(node) for function in ast.walk(tree) if isinstance(function, ast.FunctionDef) for node in ast.walk(function)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{name}: a relative import"
            whole = [f"{node.module}.{alias.name}" for alias in node.names]
            found = [full if full in known else str(node.module) for full in whole]
        else:
            continue
        for each in found:
            if each.split(".")[0] == PACKAGE:
                assert each in known, f"{name} imports {each}, which is no module"
                yield each, id(node) in late


def room(name: str) -> str:
    """The room that a module belongs to."""
    return name.split(".")[1]


KNOWN = modules()
# The package itself hands on the public names of every room.
EDGES = [
    (name, imported, late)
    for name, path in KNOWN.items()
    if name != PACKAGE
    for imported, late in imports(name, path, KNOWN)
]
STATIC = [(name, imported) for name, imported, _ in EDGES]


def test_imports_point_down() -> None:
    """Every room has a floor; no module imports from one above its own, nor the package's own list of public names."""
    assert {room(name) for name in KNOWN if name != PACKAGE} == set(FLOOR)
    upward = [
        f"{name} imports {imported}"
        for name, imported in STATIC
        if imported == PACKAGE or FLOOR[room(imported)] > FLOOR[room(name)]
    ]
    assert not upward, "\n".join(upward)


def test_no_room_is_part_of_a_circle() -> None:
    """Neither rooms nor modules import one another in a circle, also not for type checking."""
    for graph in ({(room(a), room(b)) for a, b in STATIC if PACKAGE not in (a, b)}, set(STATIC)):
        circle = find_circle({(a, b) for a, b in graph if a != b})
        assert not circle, " -> ".join(circle)


def find_circle(graph: set[tuple[str, str]]) -> list[str]:
    """One circle of a graph, [] where it has none."""
    left = {node: {b for a, b in graph if a == node} for edge in graph for node in edge}
    while leaves := [node for node, after in left.items() if not after & set(left)]:
        for node in leaves:
            del left[node]
    if not left:
        return []
    way = [min(left)]
    while way[-1] not in way[:-1]:
        way.append(min(left[way[-1]] & set(left)))
    return way[way.index(way[-1]) :]


CORE = SOURCE / "core"
UNITS = sorted(path.relative_to(CORE) for path in CORE.rglob("*.*") if path.suffix in {".cpp", ".hpp", ".h"})


def core_floor(path: Path) -> int:
    """The floor of a file of the core, by its uppermost folder."""
    return CORE_FLOORS.index(path.parts[0] if len(path.parts) > 1 else "")


def test_includes_of_the_core_point_down() -> None:
    """No file of the core includes one of a floor above its own, and none includes itself through others."""
    included = {
        (unit, Path(found)) for unit in UNITS for found in re.findall(r'#include "(.+?)"', (CORE / unit).read_text())
    }
    assert {found for _, found in included} <= set(UNITS)
    assert not [f"{a} includes {b}" for a, b in sorted(included) if core_floor(b) > core_floor(a)]
    assert not find_circle({(str(a), str(b)) for a, b in included})


def test_files_are_short_and_folders_hold_few() -> None:
    """A file is read in a sitting, a folder's list taken in at a glance; the stub is generated."""
    files = [*KNOWN.values(), *(CORE / unit for unit in UNITS)]
    lengths = {path.name: len(path.read_text().splitlines()) for path in files if path.suffix != ".pyi"}
    assert not {name: length for name, length in lengths.items() if length > MOST_LINES}
    folders = {path.parent for path in files}
    crowded = {folder: len([path for path in folder.iterdir() if path.suffix in SUFFIXES]) for folder in folders}
    assert not {folder: count for folder, count in crowded.items() if count > MOST_FILES}
