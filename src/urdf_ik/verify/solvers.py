"""Solvers to judge that are named by a text: a Python function, or a process that exchanges lines of JSON."""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import select
import shlex
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, printable
from urdf_ik.typing import Array

FORMS = "module:function, file.py:function, or process:COMMAND"
TIMEOUT = 60.0
"""Seconds that a process may take for a pose."""


def solver_of(spec: str) -> Callable[[Array], Any]:
    """The solver that a text names.

    Args:
        spec: ``module:function`` or ``file.py:function``, which takes a pose; or ``process:COMMAND``, see
            :class:`SolverProcess`.

    Raises:
        ArgumentError: there is no such solver; the message lists the forms.
    """
    place, _, name = spec.rpartition(":")
    if spec.startswith("process:"):
        return SolverProcess(shlex.split(spec.removeprefix("process:")))
    if not place:
        raise ArgumentError(f"no solver {spec!r}; give {FORMS}")
    try:
        module = _from_file(place) if place.endswith(".py") else importlib.import_module(place)
        solve: Callable[[Array], Any] = getattr(module, name)
    except Exception as error:  # a module of the user's may raise anything
        reason = f"{type(error).__name__}: {error}"
        raise ArgumentError(f"solver {spec!r} cannot be imported: {reason}; give {FORMS}") from None
    if not callable(solve):
        raise ArgumentError(f"{spec!r} is no function; give {FORMS}")
    return solve


def _from_file(place: str) -> Any:
    path = Path(place)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{place} is no Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class SolverProcess:
    r"""A process that reads poses and writes joint vectors, a line of JSON each.

    It reads ``{"T": [[...], [...], [...], [...]]}`` and answers ``{"q": [[...], ...]}``, or ``{"error": "why"}``, in
    one line, and flushes it. ``"approximate": [false, ...]`` beside ``"q"`` says which of them only come near. Its
    standard input ends when there are no more poses.
    """

    def __init__(self, command: list[str], timeout: float = TIMEOUT) -> None:
        """Start it.

        Raises:
            ArgumentError: it cannot be started.
        """
        self.name = Path(command[0]).name if command else ""
        self._timeout = timeout
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        except (OSError, ValueError, IndexError) as error:
            raise ArgumentError(f"the solver {' '.join(command)!r} cannot be started: {printable(error)}") from None
        self._received = b""

    def __call__(self, T: Array) -> Any:
        """Joint vectors of a pose.

        Raises:
            ArgumentError: it ended, took too long, said so, or answered something else.
        """
        stdin = self._process.stdin
        assert stdin is not None
        try:
            stdin.write(json.dumps({"T": np.asarray(T).tolist()}).encode() + b"\n")
            stdin.flush()
        except OSError:
            raise ArgumentError(f"the process ended with status {self._process.wait()}") from None
        line = self._line()
        try:
            answer = json.loads(line)
        except (ValueError, RecursionError):
            raise ArgumentError(f"the process answered {line!r}; a line of JSON is needed") from None
        if not isinstance(answer, dict) or "q" not in answer:
            why = answer.get("error", answer) if isinstance(answer, dict) else answer
            raise ArgumentError(f"the process answered {why!r}; an object with 'q' is needed")
        return (answer["q"], np.array(answer["approximate"])) if "approximate" in answer else answer["q"]

    def _line(self) -> bytes:
        stdout = self._process.stdout
        assert stdout is not None
        while b"\n" not in self._received:
            ready, _, _ = select.select([stdout], [], [], self._timeout)
            if not ready:
                self.close()
                raise ArgumentError(f"the process did not answer within {self._timeout:g} s, and was ended")
            part = os.read(stdout.fileno(), 1 << 16)
            if not part:
                raise ArgumentError(f"the process ended with status {self._process.wait()}")
            self._received += part
        line, _, self._received = self._received.partition(b"\n")
        return line

    def close(self) -> None:
        """End the process."""
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


@contextmanager
def opened(spec: str) -> Iterator[Callable[[Array], Any]]:
    """The solver of :func:`solver_of`; a process ends at the end of the block."""
    solve = solver_of(spec)
    try:
        yield solve
    finally:
        if isinstance(solve, SolverProcess):
            solve.close()
