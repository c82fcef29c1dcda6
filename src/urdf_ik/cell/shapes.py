"""The shapes of obstacles and tools; ``coal_shapes`` makes coal's geometry of them.

Each shape is centred at the origin of its frame, cylinders and capsules along z, as in a URDF.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.model import meshes
from urdf_ik.support import inputs
from urdf_ik.support.read_only import Frozen
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

SPECK = 1e-8
"""Size of the triangle in place of each point of a cloud [m]: coal needs triangles with an area."""


class Shape:
    """Base class of the shapes."""

    @property
    def inflation(self) -> float:
        """Length [m] by which coal's geometry of the shape is smaller on all sides."""
        return 0.0


@dataclass(frozen=True)
class Box(Shape):
    """A box.

    Attributes:
        size: edge lengths along x, y and z [m]; one number: a cube.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.Box((1.0, 0.6, 0.1)), urdf_ik.Box(0.2).size
        (Box(size=(1.0, 0.6, 0.1)), (0.2, 0.2, 0.2))
    """

    size: tuple[float, float, float]

    def __init__(self, size: ArrayLike) -> None:
        object.__setattr__(self, "size", _lengths("Box", "size", size, 3))


@dataclass(frozen=True)
class Sphere(Shape):
    """A ball.

    Attributes:
        radius: m.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.Sphere(radius=0.05)
        Sphere(radius=0.05)
    """

    radius: float

    def __post_init__(self) -> None:
        _set_lengths(self, "radius")


@dataclass(frozen=True)
class Cylinder(Shape):
    """A cylinder along z.

    Attributes:
        radius: m.
        length: m, along z.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.Cylinder(radius=0.05, length=0.4)
        Cylinder(radius=0.05, length=0.4)
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        _set_lengths(self, "radius", "length")


@dataclass(frozen=True)
class Capsule(Shape):
    """A cylinder along z with half a ball at each end.

    Attributes:
        radius: m.
        length: m, of the cylinder alone: the whole is ``length + 2 radius`` long.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.Capsule(radius=0.05, length=0.4)
        Capsule(radius=0.05, length=0.4)
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        _set_lengths(self, "radius", "length")


@dataclass(frozen=True)
class HalfSpace(Shape):
    """Everything on one side of a plane: solid where ``normal . x <= offset``. A floor: ``HalfSpace((0, 0, 1), 0)``.

    Attributes:
        normal: direction out of the solid; of length 1, whatever length was given.
        offset: distance of the plane from the origin along ``normal`` [m].

    Example:
        >>> import urdf_ik
        >>> urdf_ik.HalfSpace((0, 0, 2), 0.1)
        HalfSpace(normal=(0.0, 0.0, 1.0), offset=0.1)
    """

    normal: tuple[float, float, float]
    offset: float = 0.0

    def __post_init__(self) -> None:
        normal = np.array(_numbers("HalfSpace", "normal", self.normal, 3))
        length = float(np.linalg.norm(normal))
        if not length:
            raise ArgumentError("HalfSpace: normal is (0, 0, 0); a direction that points out of the solid is needed")
        object.__setattr__(self, "normal", tuple(float(x) for x in normal / length))
        object.__setattr__(self, "offset", _numbers("HalfSpace", "offset", self.offset, 1)[0])


@dataclass(frozen=True)
class Mesh(Shape):
    """The surface of a mesh file, of any format that coal reads: STL, OBJ, DAE and others.

    A surface has no inside: a body that lies wholly inside a closed mesh touches nothing.

    Attributes:
        path: a path, or an address with ``package://`` or ``file://``, which is sought in ``package_dirs`` as a URDF's
            meshes are. With ``package_dirs`` a path is sought in them, too.
        scale: of the file's numbers to metres; one number, or one each for x, y and z.
        package_dirs: folders that the file may come from.

    Example:
        >>> from pathlib import Path
        >>> import urdf_ik
        >>> Path("part.stl").touch()
        >>> world = urdf_ik.World()
        >>> world.add("part", urdf_ik.Mesh("part.stl", scale=0.001))
        >>> world
        World(part: Mesh)
    """

    path: str
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    package_dirs: tuple[str, ...] = ()

    def __init__(
        self,
        path: str | os.PathLike[str],
        scale: ArrayLike = 1.0,
        package_dirs: Sequence[str | os.PathLike[str]] | str | os.PathLike[str] = (),
    ) -> None:
        name, factors = str(path), _numbers("Mesh", "scale", scale, 3)
        if 0.0 in factors:
            raise ArgumentError(f"Mesh {name!r}: scale is {scale!r}; numbers other than zero are needed")
        folders = [package_dirs] if isinstance(package_dirs, str | os.PathLike) else package_dirs
        object.__setattr__(self, "path", name)
        object.__setattr__(self, "scale", factors)
        object.__setattr__(self, "package_dirs", tuple(str(folder) for folder in folders))

    def file(self) -> Path:
        """The mesh's file, absolute, with symbolic links followed.

        Raises:
            ArgumentError: it is not there.
        """
        if not self.package_dirs and "://" not in self.path:
            file = Path(self.path).expanduser().resolve()
            if not file.is_file():
                raise ArgumentError(f"Mesh: there is no file {str(file)!r}; give its path, or package_dirs")
            return file
        try:
            return meshes.resolve(self.path, [Path(folder) for folder in self.package_dirs], "Mesh")
        except UrdfError as error:
            hint = "give the folder that holds it, or its package, in package_dirs"
            raise ArgumentError(f"Mesh {quoted(self.path)}: {error.problem} ({hint})") from None


@dataclass(frozen=True, eq=False)
class Points(Frozen, Shape):
    """A cloud of points, each of them the centre of a ball: the solid is the union of the balls.

    What is found is exact to ``2 SPECK``, 0.02 micrometres, and never farther apart than the balls are.

    Attributes:
        points: (k, 3) m, read-only.
        radius: m, of every ball.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> world = urdf_ik.World()
        >>> world.add("scan", urdf_ik.Points(np.array([[0.5, 0.0, 0.2], [0.5, 0.1, 0.2]]), radius=0.01))
        >>> world
        World(scan: Points)
    """

    points: Array
    radius: float

    def __post_init__(self) -> None:
        points = inputs.array(self.points, "Points: points", (None, 3), unit="m").copy()
        if not len(points):
            raise ArgumentError("Points: points of shape (0, 3) given; one point or more is needed")
        points.setflags(write=False)
        object.__setattr__(self, "points", points)
        _set_lengths(self, "radius")

    def __repr__(self) -> str:
        return f"Points({len(self.points)} points, radius={self.radius:g})"

    @property
    def inflation(self) -> float:
        """The balls' radius, and the size of the triangles that coal has for their centres."""
        return self.radius + SPECK


def _numbers(shape: str, name: str, value: ArrayLike, count: int) -> tuple[float, ...]:
    """``count`` finite numbers, from as many or from one."""
    one = np.ndim(value) == 0
    numbers = inputs.array(value, f"{shape}: {name}", () if one else (count,))
    return (float(numbers),) * count if one else tuple(float(x) for x in numbers)


def _lengths(shape: str, name: str, value: ArrayLike, count: int) -> tuple[float, ...]:
    numbers = _numbers(shape, name, value, count)
    if min(numbers) <= 0.0:
        raise ArgumentError(f"{shape}: {name} is {value!r}; lengths above zero are needed, in m")
    return numbers


def _set_lengths(shape: Shape, *names: str) -> None:
    """Check that these fields are lengths, and keep them as floats."""
    for name in names:
        (length,) = _lengths(type(shape).__name__, name, getattr(shape, name), 1)
        object.__setattr__(shape, name, length)
