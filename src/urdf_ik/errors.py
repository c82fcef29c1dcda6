"""The exception classes of this package, and the functions that make text safe to print in their messages."""

import re
from collections.abc import Callable, Iterable

MOST_OF_A_NAME = 80
"""Greatest length of a name or value in a message [characters]."""
_LONG_WORD = re.compile(rf"[^\s/]{{{MOST_OF_A_NAME + 1},}}")
_MOST_OF_A_PATH, _MOST_CANDIDATES = 200, 100


class UrdfIkError(Exception):
    """Root of every error that this package raises on purpose.

    Example:
        >>> import urdf_ik
        >>> try:
        ...     urdf_ik.load("puma_650")
        ... except UrdfIkError as error:
        ...     print(type(error).__name__)
        ArgumentError
    """

    def __init__(self, *arguments: object) -> None:
        # Names in files of unknown origin may hold control sequences, which a terminal would carry out.
        super().__init__(*(message(each) if isinstance(each, str) else each for each in arguments))

    def __reduce__(self) -> tuple[Callable[..., "UrdfIkError"], tuple[object, ...]]:
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[UrdfIkError], arguments: tuple[object, ...], fields: dict[str, object]) -> UrdfIkError:
    """Rebuild a pickled or copied error without ``__init__``, whose parameters differ between the classes."""
    error: UrdfIkError = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__dict__.update(fields)
    return error


class ArgumentError(UrdfIkError, ValueError, IndexError):
    """An invalid argument: a joint vector, a task, a setting, an index, a name that the catalogue lacks.

    It is a ``ValueError``, and also an ``IndexError`` because an index may be the invalid argument.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> try:
        ...     arm.fk([0.1, 0.2, 0.3])
        ... except ArgumentError as error:
        ...     print(str(error)[:40])
        joint vectors of shape (3,) given; the c
    """


class UrdfError(UrdfIkError, ValueError):
    """A defective URDF, or a defective table that is converted to one: the place, and the correction.

    Attributes:
        source: the file's path, ``<text>`` for XML from a string or stream, '' for a table without a file.
        line: line number in the source, or None if the defect has no line.
        element: the XML element at fault, such as ``<joint name="j2">``, or the table's 'row 2, column a', or None.
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
        source: str = "",
        line: int | None = None,
        element: str | None = None,
        hint: str | None = None,
    ) -> None:
        self.problem, self.source, self.line, self.element, self.hint = problem, source, line, element, hint
        shown = printable(source, _MOST_OF_A_PATH)
        where = shown if line is None else f"{shown}:{line}"
        super().__init__(": ".join(part for part in (where, element, problem) if part) + (f" ({hint})" if hint else ""))


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
    """An invalid pose or target; ``index`` is the index of the first invalid one in a batch, else None.

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


class UnsupportedArm(UrdfIkError, ValueError):
    """No solver of this package finds all solutions of the arm."""


class JobError(UrdfIkError, RuntimeError):
    """A long run cannot go on: its store is in use or damaged, or its scheduler or workers do not answer."""


class MissingPackage(UrdfIkError, ImportError):
    """An optional package is not installed; the message holds the command that installs it."""


def escaped(text: str) -> str:
    """``text`` with every unprintable character except the line end as an escape.

    Names in files may hold control characters and marks that reverse the direction of writing.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text)


def printable(text: object, most: int = MOST_OF_A_NAME) -> str:
    """``text`` as one line without control characters, cut after ``most`` characters.

    Args:
        text: a name, or anything with a ``str``.
        most: greatest number of characters; longer text is cut and ends with '...'.
    """
    line = escaped(str(text)).replace("\n", "\\n")
    return line if len(line) <= most else line[: most - 3] + "..."


def message(text: str) -> str:
    """A message that is safe to show in a terminal: :func:`escaped`, with every word longer than a name cut."""
    return _LONG_WORD.sub(lambda word: printable(word[0]), escaped(text))


def listed(names: Iterable[object], most: int = 20) -> str:
    """The first ``most`` names, separated by commas, each :func:`printable`; longer lists end with the total."""
    every = list(names)
    shown = [printable(name) for name in every[:most]]
    return ", ".join(shown if len(every) <= most else [*shown, f"... ({len(every)})"])
