"""Coal's geometry of the shapes of an arm and of a world, with their bounding balls, boxes and convex hulls."""

from __future__ import annotations

import weakref
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.cell.shapes import SPECK, Capsule, HalfSpace, Mesh, Points, Shape, Sphere, cloud, reason_of
from urdf_ik.cell.spatial_search import DistanceField, cell_codes
from urdf_ik.errors import UrdfError
from urdf_ik.model import meshes
from urdf_ik.model.urdf import UrdfModel, resolve_mesh
from urdf_ik.typing import Array

BALLS = 4
"""Balls by which each shape of an arm is covered."""

PIECE = 4096
"""Most points or triangles of a piece: coal's tree of a piece is built when a query first comes near it."""

LARGE_FILE = 2**22
"""Size of a mesh's file from which on it is cut into pieces [bytes]."""


def build(model: UrdfModel, pin_model: Any) -> Any:
    """Pinocchio's geometry model of every ``<collision>`` of a URDF.

    Mesh names are replaced by the paths that :func:`resolve_mesh` found, so Pinocchio opens no other file.

    Raises:
        UrdfError: there is no collision shape, or not all of them can be read: a check would call free what is not.
    """
    if broken := [warning.error for warning in model.warnings if warning.collides]:
        raise broken[0]
    tree = etree.fromstring(model.xml)
    for mesh in tree.iterfind("link/collision/geometry/mesh"):
        mesh.set("filename", str(resolve_mesh(model, mesh.get("filename"))))
    for visual in tree.findall("link/visual"):
        visual.getparent().remove(visual)
    try:
        geometry = pin.buildGeomFromUrdfString(pin_model, etree.tostring(tree).decode(), pin.GeometryType.COLLISION)
    except (ValueError, RuntimeError, MemoryError) as error:
        raise UrdfError(f"a collision shape cannot be read: {reason_of(error)}", source=model.source) from None
    if not geometry.ngeoms:
        raise UrdfError(
            "no link has a collision shape",
            source=model.source,
            hint="add <collision> to the links that must not touch",
        )
    for shape in geometry.geometryObjects:
        if isinstance(shape.geometry, coal.BVHModelBase):
            meshes.check_vertices(shape.geometry.vertices(), Path(shape.meshPath), model.source)
        if isinstance(shape.geometry, coal.Sphere):
            shape.geometry = Sphere(shape.geometry.radius).geometry()
    return geometry


def why_unreadable(model: UrdfModel) -> str:
    """Why :func:`build` refuses a URDF, in a few words, such as '6 meshes missing'."""
    tree = etree.fromstring(model.xml)
    missing = set()
    for mesh in tree.iterfind("link/collision/geometry/mesh"):
        try:
            resolve_mesh(model, mesh.get("filename"))
        except UrdfError:
            missing.add(mesh.get("filename"))
    if missing:
        return f"{len(missing)} mesh{'es' if len(missing) > 1 else ''} missing"
    bare = tree.find("link/collision") is None and not any(warning.collides for warning in model.warnings)
    return "no collision shapes" if bare else "a collision shape cannot be read"


def one_ball(geometry: Any) -> tuple[Array, float]:
    """A ball that holds a shape: its centre (3,) in the shape's frame and its radius [m]."""
    geometry.computeLocalAABB()
    return np.array(geometry.aabb_center), float(geometry.aabb_radius)


def covering_balls(geometry: Any) -> tuple[Array, Array]:
    """Balls that together hold a shape: centres (BALLS, 3) in its frame and radii (BALLS,) [m].

    It is cut into slices across its longest side, and one ball holds a slice, of a mesh the slice's triangles.
    """
    centre, radius = one_ball(geometry)
    centres, radii = np.repeat(centre[None], BALLS, axis=0), np.full(BALLS, radius)
    if not isinstance(geometry, coal.BVHModelBase):
        half = 0.5 * (np.array(geometry.aabb_local.max_) - np.array(geometry.aabb_local.min_))
        side = int(np.argmax(half))
        slices = half.copy()
        slices[side] /= BALLS
        if np.isfinite(half).all() and (radius := float(np.linalg.norm(slices))) < radii[0]:
            centres[:, side] += (2.0 * np.arange(BALLS) - BALLS + 1.0) * slices[side]
            radii[:] = radius
        return centres, radii
    vertices = np.array(geometry.vertices())
    corners = vertices[_triangles(geometry)]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    side = int(np.argmax(high - low))
    middle = corners.mean(axis=1)[:, side]
    slices = np.clip(((middle - low[side]) / ((high - low)[side] or 1.0) * BALLS).astype(int), 0, BALLS - 1)
    for i in range(BALLS):
        slice_corners = corners[slices == i].reshape(-1, 3)
        if not len(slice_corners):
            centres[i], radii[i] = centres[0], radii[0]
            continue
        centres[i] = 0.5 * (slice_corners.min(axis=0) + slice_corners.max(axis=0))
        radii[i] = np.linalg.norm(slice_corners - centres[i], axis=1).max()
    return centres, radii


def hull(geometry: Any) -> Any:
    """The convex hull of a mesh as coal's ``Convex``; None for other shapes, and where the mesh is flat."""
    if not isinstance(geometry, coal.BVHModelBase):
        return None
    from scipy import spatial  # slow to import, and only meshes need it

    vertices = np.array(geometry.vertices())
    try:
        convex = spatial.ConvexHull(vertices, qhull_options="Qt Pp")
    except spatial.QhullError:
        return None
    corners = vertices[convex.vertices]
    place = np.zeros(len(vertices), dtype=np.intp)
    place[convex.vertices] = np.arange(len(corners))
    faces = place[convex.simplices]
    a, b, c = (corners[faces[:, i]] for i in range(3))
    inwards = np.einsum("ti,ti->t", np.cross(b - a, c - a), convex.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards, ::-1]
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for corner in corners:
        points.append(corner)
    for face in faces.tolist():
        triangles.append(coal.Triangle(*face))
    return coal.Convex(points, triangles)


class Solid(NamedTuple):
    """A shape as coal has it.

    Attributes:
        exact: the shape.
        hull: its convex hull, whose queries take a hundredth of the time; None without a hull.
    """

    exact: Any
    hull: Any


def solid(exact: Any) -> Solid:
    """A shape with its hull."""
    return Solid(exact, hull(exact))


class _RoundedBox(NamedTuple):
    """All points within ``radius`` of a box, which may be infinite on some sides: holds a shape, closely or exactly.

    Attributes:
        frame: (4, 4) of the box in the shape's frame.
        low: (3,) m, its least coordinates.
        high: (3,) m, its greatest ones.
        radius: m.
    """

    frame: Array
    low: Array
    high: Array
    radius: float


def rounded_box(shape: Shape, geometry: Any) -> _RoundedBox:
    """The rounded box that encloses a shape: exact for boxes, spheres, capsules and half-spaces."""
    match shape:
        case Sphere(radius):
            return _RoundedBox(np.eye(4), np.zeros(3), np.zeros(3), radius)
        case Capsule(radius, length):
            end = np.array([0.0, 0.0, 0.5 * length])
            return _RoundedBox(np.eye(4), -end, end, radius)
        case HalfSpace(normal, offset):
            frame = np.eye(4)
            # Any orthonormal axes whose z is the normal.
            frame[:3, :3] = np.roll(np.linalg.svd(np.array(normal)[:, None])[0], -1, axis=1)
            frame[:3, 2] = normal
            infinite = np.full(3, np.inf)
            return _RoundedBox(frame, -infinite, np.array([np.inf, np.inf, offset]), 0.0)
    geometry.computeLocalAABB()
    box = geometry.aabb_local
    return _RoundedBox(np.eye(4), np.array(box.min_), np.array(box.max_), shape.inflation)


class _Pieces:
    """A shape of a world, cut into pieces where it is a large cloud or mesh. Coal's trees are made when needed.

    Attributes:
        frame: (4, 4) of the pieces' boxes in the shape's frame.
        low: (n, 3) m, the least coordinates of the boxes.
        high: (n, 3) m, their greatest ones.
        radius: m, by which the boxes are rounded.
    """

    def __init__(self, shape: Shape) -> None:
        """Cut a shape.

        Raises:
            ArgumentError: a mesh is not there, or cannot be read.
        """
        self._solids: dict[int, Solid] = {}
        self._points, self._triangles = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.intp)
        self.frame, self.radius = np.eye(4), shape.inflation
        if isinstance(shape, Points) and len(shape.points) > PIECE:
            self._points = shape.points[np.argsort(cell_codes(shape.points), kind="stable")]
            starts = np.arange(0, len(self._points), PIECE)
            self.low = np.minimum.reduceat(self._points, starts)
            self.high = np.maximum.reduceat(self._points, starts) + SPECK
            return
        if isinstance(shape, Mesh) and shape.file().stat().st_size > LARGE_FILE:
            # Boxes that are parallel to the axes take a fifth of the memory of coal's usual volumes.
            mesh = shape._loaded(coal.NODE_TYPE.BV_AABB)
            self._points, triangles = np.array(mesh.vertices()), _triangles(mesh)
            corners = self._points[triangles]
            order = np.argsort(cell_codes(corners.mean(axis=1)), kind="stable")
            self._triangles, starts = triangles[order], np.arange(0, len(order), PIECE)
            self.low = np.minimum.reduceat(corners.min(axis=1)[order], starts)
            self.high = np.maximum.reduceat(corners.max(axis=1)[order], starts)
            return
        exact = shape.geometry()
        self._solids[0] = solid(exact)
        self.frame, low, high, self.radius = rounded_box(shape, exact)
        self.low, self.high = low[None], high[None]

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.low)

    @cached_property
    def field(self) -> DistanceField | None:
        """Lower bounds on the distance to a cloud that is cut into pieces; None of other shapes."""
        return DistanceField(self._points) if len(self._points) and not len(self._triangles) else None

    def solid(self, piece: int) -> Solid:
        """Coal's geometry of a piece, in the shape's frame."""
        if piece not in self._solids:
            part = slice(piece * PIECE, (piece + 1) * PIECE)
            exact = surface(self._points, self._triangles[part]) if len(self._triangles) else cloud(self._points[part])
            self._solids.setdefault(piece, solid(exact))
        return self._solids[piece]


def surface(vertices: Array, triangles: NDArray[np.intp]) -> Any:
    """A ``coal.BVHModelOBBRSS`` of some triangles (t, 3) of a mesh with these vertices (v, 3) [m]."""
    used, corners = np.unique(triangles, return_inverse=True)
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(triangles), len(used))
    mesh.addVertices(vertices[used])
    mesh.addTriangles(corners.reshape(-1, 3))
    mesh.endModel()
    return mesh


def _triangles(mesh: Any) -> NDArray[np.intp]:
    """(t, 3) vertices of the triangles of a mesh of coal's."""
    numbers = (triangle[corner] for triangle in map(mesh.tri_indices, range(mesh.num_tris)) for corner in range(3))
    return np.fromiter(numbers, np.intp, 3 * mesh.num_tris).reshape(-1, 3)


_PIECES: dict[int, tuple[weakref.ref[Shape], _Pieces]] = {}


def pieces_of(shape: Shape) -> _Pieces:
    """The pieces of a shape, made once and kept as long as the shape is.

    Raises:
        ArgumentError: a mesh is not there, or cannot be read.
    """
    key = id(shape)
    if key not in _PIECES:
        pieces = _Pieces(shape)
        _PIECES[key] = weakref.ref(shape, lambda _: _PIECES.pop(key, None)), pieces
        return pieces
    return _PIECES[key][1]
