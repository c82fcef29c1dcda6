"""World: named shapes around the arm, placed in its base link's frame. Only a check imports coal."""

import hashlib
import itertools
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import IO, Any

import numpy as np
from lxml import etree

from urdf_ik.cell.obstacles import Obstacle, Obstacles
from urdf_ik.cell.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from urdf_ik.errors import ArgumentError, PoseError, UrdfError, listed
from urdf_ik.model import poses, urdf
from urdf_ik.model.xml import floats, origin_of
from urdf_ik.support import files, forks
from urdf_ik.support.read_only import frozen
from urdf_ik.support.text import nearest, quoted
from urdf_ik.typing import Array

SHOWN = 8
"""The ``repr`` of a world names at most so many obstacles."""

ORTHOGONAL = 4e-16
"""A rotation stays unchanged if no entry of ``|R^T R - I|`` exceeds this: a few roundings."""


class World:
    """The obstacles around an arm: named shapes, each at a pose in the arm's base link.

    A query uses the world's present state: a moved obstacle counts at its new pose at once. Several threads may change
    and query one world.

    Example:
        >>> world = World()
        >>> world.add("table", Box((1.0, 1.0, 0.1)), poses.pose([0.5, 0.0, -0.05]))
        >>> world.add("post", Cylinder(0.05, 1.0), poses.pose([0.4, 0.4, 0.5]))
        >>> world
        World(table: Box, post: Cylinder)
        >>> world.move("post", poses.pose([0.4, -0.4, 0.5]))
        >>> world.remove("post")
        >>> world.names
        ('table',)
    """

    def __init__(self) -> None:
        self._standing: dict[str, Obstacle] = {}
        self._version = 0
        self._snapshot: Obstacles | None = None
        self._lock = forks.lock()

    @classmethod
    def from_urdf(
        cls,
        source: str | os.PathLike[str] | IO[Any],
        package_dirs: Sequence[str | os.PathLike[str]] = (),
    ) -> "World":
        """The collision shapes of a URDF of fixed links as obstacles.

        An obstacle has the name of its link; from the link's second shape on, '/1', '/2' and so on follow. The root
        link's frame coincides with the arm's base link.

        Args:
            source: a path, XML text, or an open file.
            package_dirs: folders that meshes may come from, besides the URDF's own.

        Raises:
            UrdfError: the URDF or one of its shapes is defective, or a mesh is not found.
            ArgumentError: a joint can move, a shape has no extent, or there is no collision shape.

        Example:
            >>> shape = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
            >>> world = World.from_urdf(f'<robot name="cell"><link name="ball">{shape}</link></robot>')
            >>> world.names
            ('ball',)
        """
        model = urdf.read(source, mesh_roots=package_dirs)
        if moving := [joint for joint in model.joints if joint.type != "fixed"]:
            listed = ", ".join(f"{quoted(joint.name)} ({joint.type})" for joint in moving[:5])
            raise ArgumentError(
                f"{model.source}: a world stands still, and {len(moving)} of its joints can move: {listed}; "
                'write type="fixed", or add the moving part\'s shapes with World.add and move them with World.move'
            )
        world, shapes = cls(), Counter[str]()
        for link, shape, placed in placed_shapes(model):
            names = (f"{link}/{number}" if number else link for number in itertools.count(shapes[link]))
            name = next(name for name in names if name not in world)
            shapes[link] += 1
            try:
                world.add(name, shape, placed)
            except ArgumentError as error:
                raise ArgumentError(f"{model.source}: link {quoted(link)}: {error}") from None
        return world

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the obstacles, in the order in which they were added."""
        return tuple(self._standing)

    def __len__(self) -> int:
        return len(self._standing)

    def __iter__(self) -> Iterator[Obstacle]:
        return iter(tuple(self._standing.values()))

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._standing

    def __getitem__(self, name: str) -> Obstacle:
        return Obstacle(*self._standing[self._known(name)][:3])

    def __repr__(self) -> str:
        shown = [f"{obstacle.name}: {type(obstacle.shape).__name__}" for obstacle in self][:SHOWN]
        more = [f"and {len(self) - SHOWN} more"] if len(self) > SHOWN else []
        return f"World({', '.join(shown + more)})"

    def add(self, name: str, shape: Shape, pose: Any = None) -> None:
        """Put a shape into the world.

        Args:
            name: not in use here, and not the name of a link of the arm.
            shape: Box, Sphere, Cylinder, Capsule, HalfSpace, Mesh or Points.
            pose: (4, 4) of the shape in the arm's base link [m], or a ``pinocchio.SE3``; default: the identity.

        Raises:
            ArgumentError: the name is empty or taken, ``shape`` is no shape, or its mesh is not there.
            PoseError: ``pose`` is no pose.

        Example:
            >>> import urdf_ik
            >>> world = urdf_ik.World()
            >>> world.add("table", urdf_ik.Box((1.0, 1.0, 0.1)), urdf_ik.pose([0.5, 0.0, -0.05]))
            >>> world.names
            ('table',)
        """
        if not name:
            raise ArgumentError("an obstacle needs a name")
        if not isinstance(shape, Shape):
            kinds = "Box, Sphere, Cylinder, Capsule, HalfSpace, Mesh or Points"
            raise ArgumentError(f"obstacle {quoted(name)}: a shape is needed ({kinds}), not {type(shape).__name__}")
        placed = _pose(np.eye(4) if pose is None else pose)
        if isinstance(shape, Mesh):
            shape.file()
        with self._lock:
            if name in self._standing:
                there = f"there is an obstacle {quoted(name)} already"
                raise ArgumentError(f"{there}; World.move moves it, World.remove removes it")
            self._put(Obstacle(name, shape, placed))

    def move(self, name: str, pose: Any) -> None:
        """Put an obstacle elsewhere.

        Args:
            name: of an obstacle.
            pose: (4, 4) of its shape in the arm's base link [m], or a ``pinocchio.SE3``.

        Raises:
            ArgumentError: there is no such obstacle.
            PoseError: ``pose`` is no pose.
        """
        placed = _pose(pose)
        with self._lock:
            self._put(self._standing[self._known(name)]._replace(pose=placed))

    def remove(self, name: str) -> None:
        """Take an obstacle out of the world.

        Raises:
            ArgumentError: there is no such obstacle.
        """
        with self._lock:
            del self._standing[self._known(name)]
            self._change()

    @property
    def version(self) -> int:
        """A number that every change of this world raises."""
        return self._version

    def digest(self) -> str:
        """A hash of all shapes, with the bytes of mesh files, and of where they are: equal worlds have the same one.

        Raises:
            ArgumentError: a mesh's file is no longer there.
        """
        digest = hashlib.sha256()
        for name, shape, pose in self:
            digest.update(f"{name}\0{type(shape).__name__}\0".encode())
            if isinstance(shape, Mesh):
                digest.update(files.read(shape.file()) + repr(shape.scale).encode())
            else:
                for field in fields(shape):  # type: ignore[arg-type]
                    value = getattr(shape, field.name)
                    digest.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
            digest.update(pose.tobytes())
        return digest.hexdigest()

    def snapshot(self) -> tuple[int, Obstacles]:
        """The world as it is now: its version, and its obstacles. Later changes do not change these.

        Raises:
            ArgumentError: a mesh cannot be read.
        """
        with self._lock:
            if self._snapshot is None:
                self._snapshot = Obstacles(self._standing.values())
            return self._version, self._snapshot

    def __getstate__(self) -> dict[str, Any]:
        with self._lock:
            return {"obstacles": tuple(self), "version": self._version}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__()  # type: ignore[misc]
        for obstacle in state["obstacles"]:
            self._standing[obstacle.name] = obstacle._replace(pose=frozen(obstacle.pose))
        self._version = state["version"]

    def _put(self, obstacle: Obstacle) -> None:
        """Store an obstacle; the caller holds the lock."""
        self._standing[obstacle.name] = obstacle
        self._change()

    def _change(self) -> None:
        """The obstacles are others now; the caller holds the lock."""
        self._snapshot = None
        self._version += 1

    def _known(self, name: str) -> str:
        if name not in self:
            close = nearest(str(name), self._standing)
            hint = (
                f"did you mean {' or '.join(map(quoted, close))}?"
                if close
                else f"there are: {listed(self.names) or 'no'}"
            )
            raise ArgumentError(f"there is no obstacle {quoted(name)} in this world; {hint}")
        return name


def placed_shapes(model: urdf.UrdfModel) -> list[tuple[str, Shape, Array]]:
    """The collision shapes of a URDF: link, shape and pose (4, 4) in the root link, all joints at zero.

    Raises:
        UrdfError: a shape is defective, or a mesh is not found.
        ArgumentError: there is no collision shape, or one has no extent.
    """
    if broken := [warning.error for warning in model.warnings if warning.collides]:
        raise broken[0]
    links = _link_poses(model)
    out: list[tuple[str, Shape, Array]] = []
    for body in etree.fromstring(model.xml).iterfind("link/collision"):
        link = body.getparent().get("name")
        try:
            out.append((link, _shape(body.find("geometry")[0], model), links[link] @ origin_of(body)))
        except ArgumentError as error:
            raise ArgumentError(f"{model.source}: link {quoted(link)}: {error}") from None
    if not out:
        raise ArgumentError(f"{model.source}: no link has a collision shape; add <collision> to the links")
    return out


def _pose(pose: Any) -> Array:
    checked = poses.check_poses(pose)
    if checked.ndim != 2:
        raise PoseError(f"an array of shape {checked.shape} given; an obstacle has a single pose (4, 4)")
    rotation = checked[:3, :3]
    # A rotation that is off by rounding would shear the shape.
    is_exact = np.abs(rotation.T @ rotation - np.eye(3)).max() <= ORTHOGONAL
    return frozen(checked.copy() if is_exact else poses.project_rotation(checked))


def _link_poses(model: urdf.UrdfModel) -> dict[str, Array]:
    """Pose of every link in the root link, all joints at zero."""
    placed = {model.root: np.eye(4)}
    waiting = [model.root]
    while waiting:
        link = waiting.pop()
        for joint in model.children(link):
            placed[joint.child] = placed[link] @ joint.origin
            waiting.append(joint.child)
    return placed


def _shape(element: Any, model: urdf.UrdfModel) -> Shape:
    """The shape that a URDF's ``<geometry>`` holds."""
    match element.tag:
        case "box":
            return Box(floats(element, "size"))
        case "sphere":
            return Sphere(float(element.get("radius")))
        case "cylinder":
            return Cylinder(float(element.get("radius")), float(element.get("length")))
        case "capsule":
            return Capsule(float(element.get("radius")), float(element.get("length")))
        case "mesh":
            return Mesh(urdf.resolve_mesh(model, element.get("filename")), floats(element, "scale", (1.0, 1.0, 1.0)))
    raise UrdfError(f"unknown shape <{element.tag}>", source=model.source)
