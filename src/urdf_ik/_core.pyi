"""The compiled solvers."""

from collections.abc import Sequence
import types
from typing import Annotated

import numpy
from numpy.typing import NDArray


def isa() -> str:
    """The instruction set in use."""

def levels() -> list[str]:
    """The instruction sets that were built and that this processor runs."""

def try_elimination(setup: object, variants: object, T: Annotated[NDArray[numpy.float64], dict(shape=(None, 4, 4), order='C', device='cpu', writable=False)], counts: Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu')], certain: Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu')]) -> None: ...

class Answer:
    """The numbers of solutions; arrays are made when they are asked for."""

    solver: types.MemberDescriptorType = ...

    step: types.MemberDescriptorType = ...

def prepared(call: object) -> object:
    """
    What a function without arguments returns. Meanwhile this thread computes forward kinematics alike on every processor.
    """

class Chain:
    """
    Forward kinematics of a chain of joints; immutable. Angles may be of any size.
    """

    def __init__(self, arg0: object, arg1: object, arg2: object, arg3: object, /) -> None: ...

    @property
    def steps(self) -> object: ...

    def __reduce__(self) -> tuple: ...

    def fk(self, arg: object | None, /) -> object: ...

    def jacobian(self, arg: object | None, /) -> object: ...

    def axes(self, arg: object, /) -> object: ...

    def inverse(self, q: object, size: float, singular: float, held: int = -1, swivel: Sequence[float] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]) -> object: ...

def image_range(q: object, bounds: object, turns: object) -> tuple:
    """
    Turns to the first and the last image inside the bounds: two arrays like q (..., n).
    """

def nearest_image(q: object, bounds: object, turns: object) -> tuple:
    """
    Images (..., n) inside the bounds, fewest turns away, and which (...) there are.
    """

def image_near(q: object, q_ref: object, bounds: object, turns: object) -> tuple:
    """
    Images (..., n) inside the bounds, nearest to q_ref (n,) or (..., n), and which (...) there are.
    """

def has_image(q: object, among: object, bounds: object, turns: object) -> object:
    """
    Which (...) of the joint vectors (..., n) among those that are asked about have an image inside the bounds.
    """

class Step:
    """What one cycle of a tracker answers."""

    @property
    def q(self) -> NDArray[numpy.float64]:
        """
        (n,) rad or m, where the joints are to be; angles of any size, continuous with the last; a new array.
        """

    @property
    def velocity(self) -> NDArray[numpy.float64]:
        """(n,) rad/s or m/s, of the way there from the last joint vector."""

    @property
    def status(self) -> str:
        """'ok', 'limited' or 'held'."""

    @property
    def why(self) -> str | None:
        """
        What keeps the joints from the target: 'velocity', 'acceleration', 'limit', 'reach', 'singularity', 'collision'; None where they are at it.
        """

    @property
    def distance(self) -> float:
        """From the tip to the target [m]."""

    @property
    def angle(self) -> float:
        """Between the tip and the target [rad]."""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple, /) -> None: ...

    def __repr__(self) -> str: ...

class Tracker:
    """An arm that follows poses, one a cycle."""

    def __init__(self, arm: object) -> None: ...

    def step(self, T: object, /) -> Step | None: ...

    def reset(self, arg0: object, arg1: object, /) -> None: ...

    def back(self, arg: str, /) -> Step: ...

class PathGraph:
    """
    Joint vectors along a path and the motions between them; see paths/planner/graph.py.
    """

    def __init__(self, lower: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], upper: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], turn: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], counted: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def choose(self, q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], flags: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)], centres: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)] | None, near: float, outside: bool, kept: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu')], lowest: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu')], counts: Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu')]) -> int: ...

    def connect(self, first: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)], q: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], jacobians: Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), order='C', device='cpu', writable=False)], twists: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], mismatch: tuple[float, float], window: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], cost: int, weights: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], scale: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], edge_first: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu')], end: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu')], costs: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu')]) -> int: ...

class StateGraph:
    """The states of a path's graph, and the edges between them."""

    def __init__(self, joints: PathGraph, arrays: tuple[Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu')], Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu')], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu')], Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu', writable=False)], Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)], Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu', writable=False)]]) -> None: ...

    def cheapest(self, node: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu')], changes: Annotated[NDArray[numpy.int32], dict(shape=(None, None), order='C', device='cpu')] | None, edge: Annotated[NDArray[numpy.int32], dict(shape=(None, None), order='C', device='cpu')], jump: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu')]) -> None: ...

    def way(self, edge: Annotated[NDArray[numpy.int32], dict(shape=(None, None), order='C', device='cpu')], jump: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu')], state: int, passed: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu')], taken: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu')]) -> None: ...

    def spread(self, node: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], marks: Annotated[NDArray[numpy.uint64], dict(shape=(None, None), order='C', device='cpu')]) -> None: ...

class SelfMotion:
    """
    The curves of joint vectors that hold a pose, of an arm with seven joints.
    """

    def __init__(self, arm: object) -> None: ...

    def intervals(self, T: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], round: bool, q: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], flags: Annotated[NDArray[numpy.uint8], dict(order='C', device='cpu', writable=False)], limits: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], beyond: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)] | None, off: float, starts: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> tuple: ...

    def between(self, T: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], after: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], shares: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> object: ...

class Solver:
    """An arm, ready to be solved; immutable."""

    def __init__(self, arm: object) -> None: ...

    @property
    def arm(self) -> object:
        """The dataclass that it was made from."""

    @property
    def joints(self) -> int: ...

    @property
    def branches(self) -> int: ...

    @property
    def numbers(self) -> int:
        """How many numbers a target has."""

    @property
    def parameters(self) -> int:
        """How many redundancy parameters are given with each target."""

    def __reduce__(self) -> tuple: ...

    def one(self, arg0: object, arg1: object, arg2: object, arg3: object, /) -> object: ...

    def one_near(self, arg0: object, arg1: object, arg2: object, arg3: object, arg4: object, /) -> object: ...

    def many(self, kind: object, arm: object, branches: object, T: object, q_ref: object | None, values: object | None, threads: int, out: object | None) -> object: ...

    def image(self) -> bytes:
        """The bytes of the struct with the arm's numbers."""

    def prove(self, T: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='C', device='cpu', writable=False)]) -> object:
        """What is proven about a pose's solutions; None: nothing."""

    def solve(self, T: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], q_ref: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None, q: Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), order='C', device='cpu')], flags: Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu')], values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, threads: int = 1, beyond: bool = False) -> int: ...
