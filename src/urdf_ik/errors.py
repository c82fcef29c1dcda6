"""Every error that this package raises on purpose."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from urdf_ik.text import listed, message, printable

_MOST_OF_A_PATH, _MOST_CANDIDATES = 200, 100


class UrdfIkError(Exception):
    """Root of every error that this package raises on purpose.

    Example:
        >>> import urdf_ik
        >>> try:
        ...     urdf_ik.load("puma_650")
        ... except UrdfIkError as error:
        ...     print(type(error).__name__)
        CatalogueError
    """

    def __init__(self, *arguments: object) -> None:
        # Names in files of unknown origin are no orders to the terminal that shows the message.
        super().__init__(*(message(each) if isinstance(each, str) else each for each in arguments))

    def __reduce__(self) -> tuple[Callable[..., UrdfIkError], tuple[object, ...]]:
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[UrdfIkError], arguments: tuple[object, ...], fields: dict[str, object]) -> UrdfIkError:
    """An error as it was before it was pickled or copied: each kind is made from other arguments."""
    error: UrdfIkError = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__dict__.update(fields)
    return error


class ArgumentError(UrdfIkError, ValueError):
    """An argument that is out of its range, such as a negative tolerance or ``threads=0``."""


class PlaceError(UrdfIkError, IndexError, ValueError):
    """An index that leads out of a batch or a sequence, or that is none."""


class BatchError(UrdfIkError, TypeError, ValueError):
    """What has a meaning for a single pose was asked of the answers to a batch, or the other way round.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> try:
        ...     len(arm.ik(arm.fk([[0.1, 0.2], [0.3, 0.4]])))
        ... except BatchError as error:
        ...     print(str(error)[:61])
        len() needs a single pose, and these are the solutions of a b
    """


class UrdfError(UrdfIkError, ValueError):
    """A URDF that is broken: where, and what to change.

    Attributes:
        source: the file's path, or ``<text>`` for XML that was given as a string or stream.
        line: line number in the source, or None where the defect has no line.
        element: the XML element at fault, such as ``<joint name="j2">``, or None.
        hint: what would be valid.

    Example:
        >>> import urdf_ik
        >>> try:
        ...     urdf_ik.load('<robot name="arm"><link name="base"/><link name="base"/></robot>')
        ... except UrdfError as error:
        ...     print(error.source, error.line, error.element)
        <text> 1 <link name="base">
    """

    def __init__(
        self,
        problem: str,
        *,
        source: str,
        line: int | None = None,
        element: str | None = None,
        hint: str | None = None,
    ) -> None:
        self.problem, self.source, self.line, self.element, self.hint = problem, source, line, element, hint
        shown = printable(source, _MOST_OF_A_PATH)
        where = shown if line is None else f"{shown}:{line}"
        parts = [where, *([element] if element else []), problem]
        super().__init__(": ".join(parts) + (f" ({hint})" if hint else ""))


class ChainError(UrdfIkError, ValueError):
    """The chain from base to tip is unknown or ambiguous; ``candidates`` lists the valid names.

    Example:
        >>> import urdf_ik
        >>> try:
        ...     urdf_ik.load("planar_2r", tip="gripper")
        ... except ChainError as error:
        ...     print(error.candidates)
        ('base_link', 'link_1', 'link_2', 'tool0')
    """

    def __init__(self, problem: str, candidates: Iterable[str] = ()) -> None:
        self.candidates = tuple(candidates)
        there = f"; candidates: {listed(self.candidates, _MOST_CANDIDATES)}" if self.candidates else ""
        super().__init__(problem + there)


class PoseError(UrdfIkError, ValueError):
    """An invalid pose or target; ``index`` is the place of the first bad one in a batch, else None.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> try:
        ...     urdf_ik.load("puma_560").ik(np.stack([np.eye(4), np.full((4, 4), np.nan)]))
        ... except PoseError as error:
        ...     print(error.index)
        (1,)
    """

    def __init__(self, problem: str, index: tuple[int, ...] | None = None) -> None:
        self.index = index
        super().__init__(problem if index is None else f"pose {list(index)}: {problem}")


class TaskError(UrdfIkError, ValueError):
    """A task that does not exist, or that the arm's joints do not control."""


class JointVectorError(UrdfIkError, ValueError):
    """A joint vector of the wrong shape or with values that are not finite."""


class DHError(UrdfIkError, ValueError):
    """An invalid Denavit-Hartenberg table; ``row`` counts from 1, ``column`` is its name, where there is one.

    ``source`` is the file that it was read from; None for a table that came from no file.

    Example:
        >>> import urdf_ik
        >>> try:
        ...     urdf_ik.DHTable.from_array([[0.0, 0.3, 0.0, 0.0], [0.0, float("nan"), 0.0, 0.0]], "standard")
        ... except DHError as error:
        ...     print(error.row, error.column)
        2 a
    """

    def __init__(
        self, problem: str, *, row: int | None = None, column: str | None = None, source: str | None = None
    ) -> None:
        self.problem, self.row, self.column, self.source = problem, row, column, source
        where = ", ".join([f"row {row}"] * (row is not None) + [f"column {column!r}"] * (column is not None))
        super().__init__(": ".join(part for part in (source, where, problem) if part))


class VelocityError(UrdfIkError, ValueError):
    """An invalid twist, damping, weight, velocity limit or length."""


class PathError(UrdfIkError, ValueError):
    """Waypoints, a start or a setting of a path that make no sense or do not fit the arm."""


class WorldError(UrdfIkError, ValueError):
    """A shape or an obstacle that cannot be: a size of zero, a mesh that is missing, a name that is taken."""


class WorkspaceError(UrdfIkError, ValueError):
    """A grid, a question about a workspace, or a file of a map that makes no sense or does not fit."""


class StoreError(UrdfIkError, ValueError):
    """A store on the disk that is in use, is damaged, holds something else or cannot be written."""


class ClusterError(UrdfIkError, RuntimeError):
    """A scheduler that does not answer, or workers that cannot do the work."""


class PlotError(UrdfIkError, ValueError):
    """A picture that cannot be drawn, written or shown; the message says what would be valid."""


class UnsupportedArm(UrdfIkError, ValueError):
    """The arm was read, but no solver of this package can solve it completely."""


class CatalogueError(UrdfIkError, ValueError):
    """A name that the catalogue does not hold, or whose package is not installed."""


class MissingPackage(UrdfIkError, ImportError):
    """An optional package is not installed; the message holds the command that installs it."""
