"""The conversion of xacro and MJCF to URDF; a xacro is expanded by the package xacro."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from urdf_ik.errors import MissingPackage, UrdfError
from urdf_ik.model import mjcf, ros_packages
from urdf_ik.model.xml import Source, prolog_end
from urdf_ik.support import forks

_XACRO_NAME = re.compile(r"\.xacro$", re.IGNORECASE)
_MUJOCO = re.compile(r"<mujoco[\s/>]")


def as_urdf(
    source: Source, roots: Sequence[Path], xacro_args: Mapping[str, object] | None
) -> tuple[Source, tuple[UrdfError, ...]]:
    """The source as URDF text.

    Args:
        source: the opened file or text.
        roots: folders that are searched first for ROS packages.
        xacro_args: values of a xacro's arguments; not None makes any source a xacro.

    Returns:
        The URDF, and an error for each shape that a URDF cannot hold.

    Raises:
        UrdfError: the xacro or the MJCF cannot be read.
        MissingPackage: the package that reads it is not installed.
    """
    if xacro_args is not None or _XACRO_NAME.search(source.name):
        return expanded(source, roots, xacro_args or {}), ()
    if _MUJOCO.match(source.text, prolog_end(source.text)):
        return mjcf.as_urdf(source)
    return source, ()


INSTALL = "pip install 'urdf-ik[xacro]'"

# The package xacro keeps its arguments, its file stack and its package search in module globals.
_ONE_AT_A_TIME = forks.lock()


class _NoPackage(Exception):
    """A ROS package was not found."""


class _Arguments(dict[str, str]):
    """Arguments, with a record of the names that the xacro has looked up."""

    def __init__(self, given: Mapping[str, object]) -> None:
        super().__init__({name: str(value) for name, value in given.items()})
        self.known: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.known.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.known.add(name)
        return super().__getitem__(name)


def expanded(source: Source, roots: Sequence[Path], given: Mapping[str, object]) -> Source:
    """Expand a xacro to a URDF.

    Args:
        source: the xacro; the search for included files starts in its folder.
        roots: folders that ``$(find package)`` searches first; the xacro's own ROS package, AMENT_PREFIX_PATH and
            ROS_PACKAGE_PATH follow.
        given: values of its arguments by name.

    Raises:
        UrdfError: it cannot be expanded, or has no such argument.
        MissingPackage: the package xacro is not installed.
    """
    try:
        import xacro
        from xacro import substitution_args
    except ImportError:
        raise MissingPackage(f"{source.name}: xacro is not installed: {INSTALL}") from None
    own = None if source.path is None else ros_packages.own_package(source.path)
    searched = [*roots, *([] if own is None else [own])]

    def folder(package: str) -> str:
        found = ros_packages.find(package, searched)
        if found is None:
            raise _NoPackage(f"there is no ROS package {package!r}")
        return str(found.absolute())

    arguments = _Arguments(given)
    with _ONE_AT_A_TIME, _finding(substitution_args, folder):
        try:
            xacro.init_stacks(None if source.path is None else str(source.path))
            document = xacro.parse(source.text)
            xacro.process_doc(document, mappings=arguments)
        except Exception as error:  # its errors have no root of their own: those of Python expressions come as they are
            raise _refused(source, error, arguments) from None
    if unknown := sorted(set(arguments) & set(given) - arguments.known):
        raise UrdfError(
            f"it has no argument {unknown[0]!r}", source=source.name, element="<xacro:arg>", hint=_has(arguments)
        )
    return Source(document.toprettyxml(indent="  "), f"{source.name} (expanded)", source.path)


@contextmanager
def _finding(module: Any, folder: Callable[[str], str]) -> Iterator[None]:
    """Let ``$(find package)`` ask ``folder`` instead of an installation of ROS 2."""
    before = module._eval_find, module._eval_dict["find"]
    module._eval_find = module._eval_dict["find"] = folder
    try:
        yield
    finally:
        module._eval_find, module._eval_dict["find"] = before


def _refused(source: Source, error: Exception, arguments: _Arguments) -> UrdfError:
    from xacro import substitution_args

    cause = getattr(error, "exc", None) or error
    text = " ".join(str(error).split()) or type(error).__name__
    hint = "the command `xacro` says where"
    if isinstance(cause, _NoPackage):
        text = str(cause)
        hint = "give the folder that holds it in mesh_roots (--mesh-root), AMENT_PREFIX_PATH or ROS_PACKAGE_PATH"
    elif isinstance(cause, substitution_args.ArgException) or "Undefined substitution argument" in text:
        hint = f"give it with xacro_args (--xacro-arg NAME:=VALUE); {_has(arguments)}"
    return UrdfError(f"xacro cannot expand it: {text}", source=source.name, hint=hint)


def _has(arguments: _Arguments) -> str:
    known = sorted(arguments.known)
    return f"its arguments: {', '.join(known)}" if known else "it has no arguments"
