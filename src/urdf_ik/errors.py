"""Every error that this package raises on purpose."""

from __future__ import annotations

from collections.abc import Iterable


class UrdfIkError(Exception):
    """Root of every error that this package raises on purpose."""


class ArgumentError(UrdfIkError, ValueError):
    """An argument that is out of its range, such as a negative tolerance or ``threads=0``."""


class UrdfError(UrdfIkError, ValueError):
    """A URDF that is broken: where, and what to change.

    Attributes:
        source: the file's path, or ``<text>`` for XML that was given as a string or stream.
        line: line number in the source, or None where the defect has no line.
        element: the XML element at fault, such as ``<joint name="j2">``, or None.
        hint: what would be valid.
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
        where = source if line is None else f"{source}:{line}"
        parts = [where, *([element] if element else []), problem]
        super().__init__(": ".join(parts) + (f" ({hint})" if hint else ""))


class ChainError(UrdfIkError, ValueError):
    """The chain from base to tip is unknown or ambiguous; ``candidates`` lists the valid names."""

    def __init__(self, problem: str, candidates: Iterable[str] = ()) -> None:
        self.candidates = tuple(candidates)
        listed = f"; candidates: {', '.join(self.candidates)}" if self.candidates else ""
        super().__init__(problem + listed)


class PoseError(UrdfIkError, ValueError):
    """An invalid pose or target; ``index`` is the place of the first bad one in a batch, else None."""

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


class PlotError(UrdfIkError, ValueError):
    """A picture that cannot be drawn, written or shown; the message says what would be valid."""


class UnsupportedArm(UrdfIkError, ValueError):
    """The arm was read, but no solver of this package can solve it completely."""


class CatalogueError(UrdfIkError, ValueError):
    """A name that the catalogue does not hold, or whose package is not installed."""


class MissingPackage(UrdfIkError, ImportError):
    """An optional package is not installed; the message holds the command that installs it."""
