"""The optional packages: what an extra of this distribution asks for, and what to type where one is missing."""

import re

from urdf_ik.errors import MissingPackage

_DISTRIBUTION = "urdf-ik"
_FOR_DEVELOPERS = {"bench", "dev", "docs"}


def for_users() -> list[str]:
    """The extras, without those that only work on this package needs."""
    from importlib import metadata  # 10 ms that ``import urdf_ik`` need not pay

    offered = metadata.metadata(_DISTRIBUTION).get_all("Provides-Extra") or ()
    return [name for name in offered if name not in _FOR_DEVELOPERS]


def requirements(extra: str) -> list[str]:
    """What an extra asks pip for, such as ``matplotlib>=3.9``; an extra that it includes is replaced by its own."""
    from importlib import metadata

    found = []
    for line in metadata.requires(_DISTRIBUTION) or ():
        requirement, _, marker = line.partition(";")
        if re.search(rf"extra == ['\"]{extra}['\"]", marker):
            included = re.fullmatch(rf"{_DISTRIBUTION}\[(.+)\]", requirement.strip())
            found += (
                [each for part in included[1].split(",") for each in requirements(part)]
                if included
                else [requirement.strip()]
            )
    return found


def command(extra: str) -> str:
    """The command that installs an extra beside this copy.

    pip knows a copy from an index by its name. Beside a wheel file, a checkout or an archive the packages are named.
    """
    from importlib import metadata

    try:
        from_index = metadata.distribution(_DISTRIBUTION).read_text("direct_url.json") is None
    except metadata.PackageNotFoundError:  # run from a folder
        from_index = True
    named = [f"{_DISTRIBUTION}[{extra}]"] if from_index else requirements(extra)
    return f"pip install {' '.join(repr(each) for each in named)}"


def missing(what: str, extra: str) -> MissingPackage:
    """The error that says what needs which packages, and the command that installs them."""
    return MissingPackage(f"{what}: {command(extra)}")
