"""The commands ``robots`` and ``doctor``: what is here, and whether it works."""

import platform
import re
import sys
import time
from importlib import import_module, metadata
from typing import Any

import numpy as np
import typer

from urdf_ik.cell import missing_pinocchio
from urdf_ik.cli import console, tables
from urdf_ik.cli.console import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.errors import ChainError, UrdfIkError, printable
from urdf_ik.model import catalogue, downloads
from urdf_ik.support import extras
from urdf_ik.version import __version__

_WIDTH, _LEAST_WORDS = 79, 12
_SHORT = {"example-robot-data": "robot-data", "robot_descriptions": "descriptions"}
NEEDED = ("numpy", "pin", "coal", "yourdfpy", "lxml", "trimesh", "scipy")
_CHECKING = ("pin", "coal")
"""What only checks need; solving and drawing do without."""
_ARMS = ("zyyzyz_6r", "scara_rrpr", "stanford_rrprrr", "srs_7r")
_POSES = 50
_EXACT = 1e-9


def robots(*, word: str = "", everything: bool = False, printed_as: ReportFormat = ReportFormat.TABLE) -> None:
    """List the arms that have names, with the family and the joints of those that are here.

    There are bundled arms, those of example-robot-data, and those of robot_descriptions, which downloads a model at its
    first use.

    Examples:
        urdf-ik robots
        urdf-ik robots ur --all

    Positional:
        word ([WORD]): Only names that contain this.

    Options:
        everything (--all): Also the arms of robot_descriptions that are not downloaded.
    """
    more = [name for name in downloads.names() if everything or downloads.is_here(name)]
    found = [_robot(name) for name in (*catalogue.names(), *more) if word in name]
    console.emit(printed_as, {"robots": found}, lambda: _table(found))


def _table(found: list[dict[str, Any]]) -> str:
    """A table, and how to get more."""
    rows = [
        {"name": each["name"], "joints": each["joints"], "family": each["family"] or each["note"]}
        | {"here": each["here"], "from": _SHORT.get(each["source"], each["source"])}
        for each in found
    ]
    taken = sum(max((len(row[name]) for row in rows), default=0) for name in ("name", "from")) + 18
    rows = [row | {"family": printable(row["family"], max(_WIDTH - taken, _LEAST_WORDS))} for row in rows]
    more = len(downloads.names())
    rest = f"robot_descriptions has {more} arms: --all lists them" if more else f"more: {extras.command('robots')}"
    return tables.render(tables.outline({"robots": rows}) or "no robot has such a name", "", rest)


def _robot(name: str) -> dict[str, Any]:
    """An arm that has a name."""
    source = "bundled" if name in catalogue.BUNDLED else "example-robot-data"
    source = source if name in catalogue.names() else "robot_descriptions"
    foreign = source == "robot_descriptions"
    found = {"name": name, "source": source, "here": catalogue.is_here(name), "joints": None, "family": ""}
    note = catalogue.BUNDLED.get(name, "") or (downloads.describe(name) if foreign else "")
    if not found["here"]:
        return found | {"joints": downloads.joints_of(name) if foreign else None, "note": note}
    from urdf_ik.arm import load

    try:
        arm = load(name)
    except UrdfIkError as error:
        several = isinstance(error, ChainError)
        return found | {"note": "several chains: urdf-ik info --chains" if several else str(error)}
    return found | {"joints": arm.dof, "family": arm.structure.family, "note": note}


def doctor(*, printed_as: ReportFormat = ReportFormat.TABLE) -> None:
    """Say what is installed and whether it works.

    It prints versions, the processor's instruction set and optional packages, and tests the solvers against
    Pinocchio. The status is 1 when the test fails.

    Examples:
        urdf-ik doctor
        urdf-ik doctor --format json
    """
    found = examine()
    console.emit(printed_as, found, lambda: _findings(found))
    if not found["passed"]:
        raise typer.Exit(Status.FAILED)


def examine() -> dict[str, Any]:
    """Look at the installation, and test the solvers.

    ``versions`` are of this package, Python and the required packages, ``extras`` of each extra's packages, '' for a
    missing one. ``loading`` are the seconds that imports took, which the first command of all waits for, ``seconds``
    those of the tests after that.
    """
    from urdf_ik import _core

    versions = {"urdf-ik": __version__, "python": platform.python_version()}
    versions |= {name: _version(name) for name in NEEDED}
    begun = time.perf_counter()
    checks = ("urdf_ik.cell.pinocchio_reference",) if missing_pinocchio.installed() else ()
    for package in (*checks, "urdf_ik.arm", "yourdfpy"):
        import_module(package)
    loaded = time.perf_counter()
    tests = [_test(name) for name in _ARMS]
    needed = all(version for name, version in versions.items() if name not in _CHECKING)
    return {
        "versions": versions,
        "machine": f"{platform.system()} {platform.machine()}",
        "instruction_sets": {"used": _core.isa(), "built": tuple(_core.levels())},
        "extras": {extra: {name: _version(name) for name in _packages(extra)} for extra in extras.for_users()},
        "tests": tests,
        "loading": loaded - begun,
        "seconds": time.perf_counter() - loaded,
        "passed": needed and all(_passed(test) for test in tests),
        "executable": sys.executable,
    }


def _passed(test: dict[str, Any]) -> bool:
    """Whether nothing was missed and nothing is off."""
    return not test["missed"] and (test["error"] is None or test["error"] <= _EXACT)


def _findings(found: dict[str, Any]) -> str:
    """Lines and a table."""
    sets = found["instruction_sets"]
    about: dict[str, Any] = {name: version or "missing" for name, version in found["versions"].items()}
    about["machine"] = f"{found['machine']}, instruction set {sets['used']} of {', '.join(sets['built'])}"
    optional: dict[str, Any] = {}
    for extra, packages in found["extras"].items():
        missing = ", ".join(name for name, version in packages.items() if not version)
        words = [f"{name} {version}" for name, version in packages.items() if version]
        words += [f"without {missing}: {extras.command(extra)}"] if missing else []
        optional[extra] = "; ".join(words)
    tests = {"tests": [test | {"passed": "yes" if _passed(test) else "FAIL"} for test in found["tests"]]}
    verdict = "all is well" if found["passed"] else "something is wrong: see above"
    if found["passed"] and not missing_pinocchio.installed():
        verdict = f"solving works; errors and contacts were not checked: {missing_pinocchio.UNCHECKED}"
    times = f"loading the packages took {found['loading']:.1f} s, the test {found['seconds']:.1f} s"
    return tables.render(tables.outline(about), "", tables.outline(optional | tests), "", f"{verdict}; {times}")


def _test(name: str) -> dict[str, Any]:
    """Solve poses of random joint vectors, look for these among the answers, and have Pinocchio measure all."""
    from urdf_ik.arm import load
    from urdf_ik.ik.solutions import limits
    from urdf_ik.support import angles

    arm = load(name)
    pinocchio = arm.cell.reference if missing_pinocchio.installed() else None
    low, high = limits.drawn(arm.limits, ~np.asarray(arm.chain.prismatic)).T
    Q = np.random.default_rng(0).uniform(low, high, (_POSES, arm.dof))
    T = arm.fk(Q) if pinocchio is None else pinocchio.pose(Q)
    answer = arm.ik(T, redundancy=None if arm.redundancy is None else arm.redundancy_of(Q))
    near = np.abs(angles.difference(answer.nearest(Q).q[:, 0], Q, arm.chain.prismatic)).max(axis=-1)
    error = None
    if pinocchio is not None:
        error = float(np.nanmax(pinocchio.errors(answer.q, T[:, None])))
    counts = {"poses": _POSES, "solutions": int(answer.valid.sum()), "missed": _POSES - int((near <= 1e-6).sum())}
    return {"arm": name, **counts, "error": error}


def _packages(extra: str) -> list[str]:
    return [re.split(r"[\[<>=~!]", requirement)[0] for requirement in extras.requirements(extra)]


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""
