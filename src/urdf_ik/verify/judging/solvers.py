"""Solvers outside Python: a process that exchanges JSON lines, and a shared library made by IKFast."""

from __future__ import annotations

import ctypes
import importlib
import importlib.util
import json
import os
import select
import shlex
import subprocess
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, printable
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array
from urdf_ik.verify.judging import peers
from urdf_ik.verify.judging.c_library import CLibrary

FORMS = (
    "module:function, file.py:function, process:COMMAND, ikfast:LIBRARY.so, library:LIBRARY.so,ARM.json, or the "
    "name of a peer: eaik, ik-geo, py-opw, ssik, ssik-built, ssik-prebuilt:VENDOR.ARM, frankik, "
    "roboticstoolbox:python, roboticstoolbox:c"
)
TIMEOUT = 60.0
"""Seconds that a process may take for a pose."""

# Names under which IKFast's functions are found: with IKFAST_CLIBRARY, and as C++ compilers call them.
_COMPUTE = ("ComputeIk", "_Z9ComputeIkPKdS0_S0_RN6ikfast18IkSolutionListBaseIdEE")
_JOINTS = ("GetNumJoints", "_Z12GetNumJointsv")
_FREE = ("GetNumFreeParameters", "_Z20GetNumFreeParametersv")


def solver_of(spec: str, arm: Arm) -> Callable[[Array], Any]:
    r"""The solver that a text names.

    Args:
        spec: ``module:function`` or ``file.py:function``, which takes a pose; ``process:COMMAND``, see
            :class:`SolverProcess`; ``ikfast:LIBRARY``, see :class:`IKFastLibrary`; ``library:LIBRARY,ARM.json``, see
            :class:`~urdf_ik.verify.judging.c_library.CLibrary`; or the name of a peer, see
            :mod:`urdf_ik.verify.judging.peers`.
        arm: the arm that it is to solve, which peers are built from.

    Raises:
        ArgumentError: there is no such solver; the message lists the forms.
        MissingPackage: a peer is not installed.

    Example:
        >>> import urdf_ik
        >>> _ = Path("mine.py").write_text("def solve(T):\n    return []\n")
        >>> solver_of("mine.py:solve", urdf_ik.load("puma_560"))([])
        []
    """
    kind, _, rest = spec.partition(":")
    if kind in peers.PEERS:
        return peers.PEERS[kind](arm, rest) if rest else peers.PEERS[kind](arm)
    if not rest:
        raise ArgumentError(f"no solver {quoted(spec)}; give {FORMS}")
    if kind == "process":
        return SolverProcess(shlex.split(rest))
    if kind == "ikfast":
        return IKFastLibrary(rest)
    if kind == "library":
        library, comma, compiled = rest.rpartition(",")
        if not comma:
            raise ArgumentError(f"solver {quoted(spec)} names no compiled arm: library:LIBRARY.so,ARM.json is needed")
        return CLibrary(library, compiled)
    place, _, name = spec.rpartition(":")
    try:
        module = _from_file(place) if place.endswith(".py") else importlib.import_module(place)
        found: Callable[[Array], Any] = getattr(module, name)
    except Exception as error:  # a module of the user's may raise anything
        reason = printable(f"{type(error).__name__}: {error}", 300)
        raise ArgumentError(f"solver {quoted(spec)} cannot be imported: {reason}; give {FORMS}") from None
    if not callable(found):
        raise ArgumentError(f"{quoted(spec)} is no function; give {FORMS}")
    return found


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

    Example:
        >>> import sys
        >>> code = "import sys\nfor line in sys.stdin: print('{\"q\": []}', flush=True)"
        >>> with SolverProcess([sys.executable, "-c", code]) as solver:
        ...     solver(np.eye(4))
        []
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
            raise ArgumentError(
                f"the solver {quoted(' '.join(command))} cannot be started: {printable(error)}"
            ) from None
        self._held = b""

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
            raise ArgumentError(f"the process answered {quoted(line)}; a line of JSON is needed") from None
        if not isinstance(answer, dict) or "q" not in answer:
            why = answer.get("error", answer) if isinstance(answer, dict) else answer
            raise ArgumentError(f"the process answered {quoted(why)}; an object with 'q' is needed")
        return (answer["q"], np.array(answer["approximate"])) if "approximate" in answer else answer["q"]

    def _line(self) -> bytes:
        stdout = self._process.stdout
        assert stdout is not None
        while b"\n" not in self._held:
            ready, _, _ = select.select([stdout], [], [], self._timeout)
            if not ready:
                self.close()
                raise ArgumentError(f"the process did not answer within {self._timeout:g} s, and was ended")
            part = os.read(stdout.fileno(), 1 << 16)
            if not part:
                raise ArgumentError(f"the process ended with status {self._process.wait()}")
            self._held += part
        line, _, self._held = self._held.partition(b"\n")
        return line

    def close(self) -> None:
        """End the process.

        Example:
            >>> import sys
            >>> SolverProcess([sys.executable, "-c", "pass"]).close()
        """
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


class _SingleSolution(ctypes.Structure):
    """IKFast's ``IkSingleDOFSolutionBase<double>``."""

    _fields_ = (
        ("fmul", ctypes.c_double), ("foffset", ctypes.c_double), ("freeind", ctypes.c_byte),
        ("jointtype", ctypes.c_ubyte), ("maxsolutions", ctypes.c_ubyte), ("indices", ctypes.c_ubyte * 5),
    )  # fmt: skip


class _Vector(ctypes.Structure):
    """``std::vector`` of libstdc++ and libc++."""

    _fields_ = (("begin", ctypes.c_void_p), ("end", ctypes.c_void_p), ("room", ctypes.c_void_p))


_ADD = ctypes.CFUNCTYPE(ctypes.c_size_t, ctypes.c_void_p, ctypes.POINTER(_Vector), ctypes.POINTER(_Vector))
_OTHER = ctypes.CFUNCTYPE(ctypes.c_size_t, ctypes.c_void_p)


class IKFastLibrary:
    """A shared library that IKFast generated, of the type Transform6D, with ``ComputeIk`` on doubles.

    Compile it with ``g++ -O2 -shared -fPIC -DIKFAST_NO_MAIN -DIKFAST_CLIBRARY``. The list of solutions that
    ``ComputeIk`` fills is handed over as a C++ object by the rules that GCC and Clang share on Linux and macOS.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Load it.

        Raises:
            ArgumentError: it cannot be loaded, or has no ``ComputeIk``.
        """
        self.name = Path(path).name
        try:
            library = ctypes.CDLL(os.path.abspath(path))
        except OSError as error:
            raise ArgumentError(f"the library {printable(path)} cannot be loaded: {printable(error)}") from None
        functions = []
        for names in (_COMPUTE, _JOINTS, _FREE):
            found = next((getattr(library, name) for name in names if hasattr(library, name)), None)
            if found is None:
                raise ArgumentError(f"the library {printable(path)} has no function {names[0]}; IKFast's are needed")
            functions.append(found)
        self._compute, joints, free = functions
        self.joints, self.free = int(joints()), int(free())
        pointer = ctypes.POINTER(ctypes.c_double)
        self._compute.restype = ctypes.c_bool
        self._compute.argtypes = (pointer, pointer, pointer, ctypes.c_void_p)
        self._found: list[list[float]] = []
        # An object with virtual functions begins with a pointer to a table of them: two destructors, AddSolution,
        # GetSolution, GetNumSolutions and Clear, in the order of ikfast.h.
        add, number, clear = _ADD(self._add), _OTHER(lambda _: len(self._found)), _OTHER(self._clear)
        nothing = _OTHER(lambda _: 0)
        self._kept = (add, number, clear, nothing)
        order = (nothing, nothing, add, nothing, number, clear)
        self._table = (ctypes.c_void_p * len(order))(*(ctypes.cast(each, ctypes.c_void_p).value for each in order))
        self._list = (ctypes.c_void_p * 1)(ctypes.addressof(self._table))

    def __call__(self, T: Array) -> Array:
        """Joint vectors (k, joints) of a pose (4, 4), free joints at zero."""
        T = np.asarray(T, dtype=np.float64)
        number = ctypes.c_double
        place, turn = (number * 3)(*T[:3, 3]), (number * 9)(*T[:3, :3].reshape(-1))
        self._found = []
        self._compute(place, turn, (number * max(1, self.free))(), ctypes.addressof(self._list))
        return np.array(self._found, dtype=np.float64).reshape(-1, self.joints)

    def _add(self, _: Any, rows: Any, __: Any) -> int:
        begin, end = rows.contents.begin or 0, rows.contents.end or 0
        count = (end - begin) // ctypes.sizeof(_SingleSolution)
        # A joint that follows a free one has it as offset; the free ones stand at zero.
        self._found.append([_SingleSolution.from_address(begin + k * ctypes.sizeof(_SingleSolution)).foffset
                            for k in range(count)])  # fmt: skip
        return len(self._found) - 1

    def _clear(self, _: Any) -> int:
        self._found = []
        return 0
