"""Solvers to judge that are named by a text: a Python function, or a process that exchanges lines of JSON."""

import importlib
import json
import runpy
import shlex
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.typing import Array

Solver = Callable[[Array], Any]
FORMS = "module:function, file.py:function, or process:COMMAND"
_PATIENCE = 1.0  # s for a process to end by itself when its input is closed


@contextmanager
def opened(spec: str) -> Iterator[Solver]:
    """The solver that a text names; a process ends at the end of the block.

    Args:
        spec: ``module:function`` or ``file.py:function``, which takes a pose (4, 4); or ``process:COMMAND``, which
            reads {"T": [[...], ...]} and answers {"q": [[...], ...]}, a line each, in the arm's order of joints, and
            {"error": text} where it cannot. "approximate" may flag joint vectors that are no claim.
    """
    place, _, name = spec.rpartition(":")
    if spec.startswith("process:"):
        with _process(shlex.split(spec.removeprefix("process:"))) as solve:
            yield solve
        return
    if not place:
        raise ArgumentError(f"no solver {spec!r}; give {FORMS}")
    try:
        found = runpy.run_path(place) if place.endswith(".py") else vars(importlib.import_module(place))
        solve = found[name]
    except Exception as error:  # a module of the user's may raise anything
        reason = f"{type(error).__name__}: {error}"
        raise ArgumentError(f"solver {spec!r} cannot be imported: {reason}; give {FORMS}") from None
    if not callable(solve):
        raise ArgumentError(f"{spec!r} is no function; give {FORMS}")
    yield solve


@contextmanager
def _process(command: list[str]) -> Iterator[Solver]:
    try:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
    except (OSError, ValueError, IndexError) as error:
        raise ArgumentError(f"the solver {' '.join(command)!r} cannot be started: {error}") from None
    stdin, stdout = process.stdin, process.stdout
    assert stdin is not None and stdout is not None

    def solve(T: Array) -> Any:
        try:
            stdin.write(json.dumps({"T": np.asarray(T).tolist()}) + "\n")
            line = stdout.readline()
        except OSError:
            line = ""
        if not line:
            raise ArgumentError(f"the process ended with status {process.wait()}")
        try:
            answer = json.loads(line)
            q = answer["q"]
        except (ValueError, TypeError, KeyError, RecursionError):
            raise ArgumentError(f"the process answered {line[:80]!r}; an object with 'q' is needed") from None
        return (q, np.array(answer["approximate"])) if "approximate" in answer else q

    try:
        yield solve
    finally:
        try:
            process.communicate(timeout=_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
