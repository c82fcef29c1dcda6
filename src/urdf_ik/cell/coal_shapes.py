"""Coal's geometry of the shapes of an arm and of a world, with their bounding balls, boxes and convex hulls."""

import weakref
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.cell.shapes import SPECK, Box, Capsule, Cylinder, HalfSpace, Mesh, Points, Shape, Sphere
from urdf_ik.errors import ArgumentError, UrdfError, printable
from urdf_ik.model import meshes
from urdf_ik.model.urdf import UrdfModel, resolve_mesh
from urdf_ik.support import read_only
from urdf_ik.typing import Array

BALLS = 4
"""Balls by which each shape of an arm is covered."""


def geometry(shape: Shape) -> Any:
    """Coal's ``CollisionGeometry`` of a shape, smaller on all sides by ``shape.inflation``."""
    match shape:
        case Box(size):
            return coal.Box(*size)
        case Sphere(radius):
            # Coal's sphere takes a triangle without area for one that it touches.
            return coal.Capsule(radius, 0.0)
        case Cylinder(radius, length):
            return coal.Cylinder(radius, length)
        case Capsule(radius, length):
            return coal.Capsule(radius, length)
        case HalfSpace(normal, offset):
            return coal.Halfspace(np.array(normal), offset)
        case Points(points):
            return _cloud(points)
        case Mesh():
            return _of_file(shape)
    raise ArgumentError(f"coal has no geometry of a {type(shape).__name__}")


def _of_file(shape: Mesh) -> Any:
    """Coal's model of a file's triangles."""
    path, name = str(shape.file()), repr(str(shape.file()))
    try:
        mesh = coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(path, np.array(shape.scale))
        meshes.check_vertices(mesh.vertices(), Path(path), "Mesh")
    except UrdfError as error:
        raise ArgumentError(f"Mesh {name}: {error.problem} ({error.hint})") from None
    except (ValueError, RuntimeError, MemoryError) as error:
        raise ArgumentError(f"Mesh {name} cannot be read: {_reason(error)}") from None
    if not mesh.num_tris:
        raise ArgumentError(f"Mesh {name} has no triangles")
    return mesh


def _reason(error: Exception) -> str:
    """What coal or Pinocchio has to say, without the place in their sources."""
    return printable(" ".join(str(error).partition("message:")[2].split()) or error or type(error).__name__, 300)


def build(model: UrdfModel, pin_model: Any) -> tuple[Any, list["Solid"]]:
    """Every ``<collision>`` of a URDF: Pinocchio's geometry model, which places them, and the shapes.

    Pinocchio opens no mesh: in its model a speck stands in for each.
    """
    if broken := [warning.error for warning in model.warnings if warning.collides]:
        raise broken[0]
    tree = etree.fromstring(model.xml)
    files: dict[str, tuple[Path, tuple[float, ...]]] = {}
    for link in tree.iterfind("link"):
        for i, geometry in enumerate(link.iterfind("collision/geometry")):
            if (mesh := geometry.find("mesh")) is not None:
                scale = tuple(float(x) for x in mesh.get("scale", "1 1 1").split())
                files[f"{link.get('name')}_{i}"] = resolve_mesh(model, mesh.get("filename")), scale
                geometry.replace(mesh, etree.Element("sphere", radius=str(SPECK)))
    for visual in tree.findall("link/visual"):
        visual.getparent().remove(visual)
    solids: dict[tuple[Path, tuple[float, ...]], Solid] = {}
    try:
        placed = pin.buildGeomFromUrdfString(pin_model, etree.tostring(tree).decode(), pin.GeometryType.COLLISION)
        for file in files.values():
            if file not in solids:
                solids[file] = _MeshFile(*file, model.source)
    except (OSError, ValueError, RuntimeError, MemoryError) as error:
        raise UrdfError(f"a collision shape cannot be read: {_reason(error)}", source=model.source) from None
    if not placed.ngeoms:
        raise UrdfError(
            "no link has a collision shape",
            source=model.source,
            hint="add <collision> to the links that must not touch",
        )
    shapes = []
    for body in placed.geometryObjects:
        exact = body.geometry
        if body.name in files:
            shapes.append(solids[files[body.name]])
        else:
            shapes.append(Solid(coal.Capsule(exact.radius, 0.0) if isinstance(exact, coal.Sphere) else exact))
    return placed, shapes


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


class Solid:
    """A shape as coal has it. A mesh's convex hull is made when a query first needs it.

    Attributes:
        exact: coal's geometry of the shape.
    """

    def __init__(self, exact: Any) -> None:
        self.exact = exact

    @property
    def is_mesh(self) -> bool:
        """Whether the shape is a mesh or a cloud."""
        return isinstance(self.exact, coal.BVHModelBase)

    @property
    def corners(self) -> Array:
        """Corners (t, 3, 3) of the triangles of a mesh [m]."""
        return np.asarray(np.array(self.exact.vertices())[_triangles(self.exact)])

    @property
    def points(self) -> Array:
        """Vertices (v, 3) of a mesh [m]."""
        return np.array(self.exact.vertices())

    @cached_property
    def hull(self) -> Any:
        """The convex hull of a mesh as coal's ``Convex``; None for other shapes, and where the mesh is flat.

        Its queries take a hundredth of the time.
        """
        return convex(*hull_of(self.points)) if self.is_mesh else None

    def one_ball(self) -> tuple[Array, float]:
        """A ball that holds the shape: its centre (3,) in the shape's frame and its radius [m]."""
        if self.is_mesh:
            centre = 0.5 * np.sum(_box(self.points), axis=0)
            return centre, _farthest(self.points, centre)
        self.exact.computeLocalAABB()
        return np.array(self.exact.aabb_center), float(self.exact.aabb_radius)

    def covering_balls(self) -> tuple[Array, Array]:
        """Balls that together hold the shape: centres (BALLS, 3) in its frame and radii (BALLS,) [m].

        It is cut into slices across its longest side, and one ball holds a slice, of a mesh the slice's triangles.
        """
        centre, radius = Solid.one_ball(self)
        centres, radii = np.repeat(centre[None], BALLS, axis=0), np.full(BALLS, radius)
        if not self.is_mesh:
            box = self.exact.aabb_local
            half = 0.5 * (np.array(box.max_) - np.array(box.min_))
            side = int(np.argmax(half))
            slices = half.copy()
            slices[side] /= BALLS
            if np.isfinite(half).all() and (radius := float(np.linalg.norm(slices))) < radii[0]:
                centres[:, side] += (2.0 * np.arange(BALLS) - BALLS + 1.0) * slices[side]
                radii[:] = radius
            return centres, radii
        corners = self.corners
        low, high = _box(corners.reshape(-1, 3))
        side = int(np.argmax(high - low))
        middle = corners[:, :, side] @ np.full(3, 1.0 / 3.0)
        slices = np.clip(((middle - low[side]) / ((high - low)[side] or 1.0) * BALLS).astype(int), 0, BALLS - 1)
        for i in range(BALLS):
            slice_corners = corners[slices == i].reshape(-1, 3)
            if not len(slice_corners):
                centres[i], radii[i] = centres[0], radii[0]
                continue
            centres[i] = 0.5 * np.sum(_box(slice_corners), axis=0)
            radii[i] = _farthest(slice_corners, centres[i])
        return centres, radii


class _MeshFile(Solid):
    """A mesh's file. Coal reads it when a query first comes near it.

    Its hull and its balls are kept in the user's cache folder, by the content of the file.
    """

    is_mesh = True

    def __init__(self, path: Path, scale: tuple[float, ...], source: str) -> None:
        """Read the file."""
        self._path, self._scale = path, np.array(scale)
        content = path.read_bytes()
        self._stl = _stl_corners(content)

        def computed() -> dict[str, Array | NDArray[np.intp]]:
            meshes.check_vertices(self.points, path, source)
            corners, faces = hull_of(self.points)
            ball, balls = Solid.one_ball(self), Solid.covering_balls(self)
            return {"corners": corners, "faces": faces, "ball": np.append(*ball), "balls": np.column_stack(balls)}

        self._kept: Any = read_only.arrays(f"mesh{BALLS}", [content, self._scale.tobytes()], computed)

    @cached_property
    def exact(self) -> Any:
        """A ``coal.BVHModelOBBRSS`` of the file's triangles."""
        return coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(str(self._path), self._scale)

    @property
    def corners(self) -> Array:
        """Corners (t, 3, 3) of the triangles [m]."""
        return super().corners if self._stl is None else self._stl * self._scale

    @cached_property
    def points(self) -> Array:
        """Vertices (v, 3) [m]."""
        if self._stl is None:
            return super().points
        rows = self._stl.reshape(-1, 3).view("V12").ravel().tolist()
        vertices = np.frombuffer(b"".join(dict.fromkeys(rows)), np.float32).reshape(-1, 3)
        return np.asarray(vertices * self._scale)

    @cached_property
    def hull(self) -> Any:
        """The convex hull as coal's ``Convex``; None where the mesh is flat."""
        return convex(self._kept["corners"], self._kept["faces"])

    def one_ball(self) -> tuple[Array, float]:
        """A ball that holds the shape: its centre (3,) in the shape's frame and its radius [m]."""
        return self._kept["ball"][:3], float(self._kept["ball"][3])

    def covering_balls(self) -> tuple[Array, Array]:
        """Balls that together hold the shape: centres (BALLS, 3) in its frame and radii (BALLS,) [m]."""
        return self._kept["balls"][:, :3], self._kept["balls"][:, 3]


def hull_of(points: Array) -> tuple[Array, NDArray[np.intp]]:
    """Corners (k, 3) and faces (f, 3), outward, of the convex hull of points (v, 3); none where they are flat."""
    from scipy import spatial  # slow to import, and only meshes need it

    try:
        hull = spatial.ConvexHull(points, qhull_options="Qt Pp")
    except (spatial.QhullError, ValueError):
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.intp)
    corners = points[hull.vertices]
    place = np.zeros(len(points), dtype=np.intp)
    place[hull.vertices] = np.arange(len(corners))
    faces = place[hull.simplices]
    a, b, c = (corners[faces[:, i]] for i in range(3))
    inwards = np.einsum("ti,ti->t", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards, ::-1]
    return corners, faces


def convex(corners: Array, faces: NDArray[np.intp]) -> Any:
    """A ``coal.Convex``; None without faces."""
    if not len(faces):
        return None
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(corners)
    triangles.extend(coal.Triangle(*face) for face in faces.tolist())
    return coal.Convex(points, triangles)


_STL_HEADER = 84
_STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def _stl_corners(content: bytes) -> NDArray[np.float32] | None:
    """Corners (t, 3, 3) of the triangles of a binary STL; None for any other content."""
    count = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    if not count or len(content) != _STL_HEADER + _STL.itemsize * count:
        return None
    return np.ascontiguousarray(np.frombuffer(content, _STL, offset=_STL_HEADER)["corners"])


def _box(points: Array) -> tuple[Array, Array]:
    """Least and greatest coordinates (3,) of points (k, 3): NumPy is ten times slower along the first axis."""
    return np.array([column.min() for column in points.T]), np.array([column.max() for column in points.T])


def _farthest(points: Array, centre: Array) -> float:
    """Greatest distance of points (k, 3) from a centre (3,) [m]."""
    away = points - centre
    return float(np.sqrt(np.einsum("ki,ki->k", away, away).max()))


class _Bounded(NamedTuple):
    """A shape of a world as coal has it, within a rounded box: exact for boxes, spheres, capsules and half-spaces.

    Attributes:
        solid: the shape.
        frame: (4, 4) of the box in the shape's frame.
        box: its least and its greatest coordinates (3,) [m], infinite on some sides of a half-space.
        radius: m, by which the box is rounded.
        cloud: the k-d tree of a cloud of points.
    """

    solid: Solid
    frame: Array
    box: tuple[Array, Array]
    radius: float
    cloud: Any = None


def _bounded(shape: Shape) -> _Bounded:
    solid = Solid(geometry(shape))
    match shape:
        case Sphere(radius):
            return _Bounded(solid, np.eye(4), (np.zeros(3), np.zeros(3)), radius)
        case Capsule(radius, length):
            end = np.array([0.0, 0.0, 0.5 * length])
            return _Bounded(solid, np.eye(4), (-end, end), radius)
        case HalfSpace(normal, offset):
            frame = np.eye(4)
            # Any orthonormal axes whose z is the normal.
            frame[:3, :3] = np.roll(np.linalg.svd(np.array(normal)[:, None])[0], -1, axis=1)
            frame[:3, 2] = normal
            return _Bounded(solid, frame, (np.full(3, -np.inf), np.array([np.inf, np.inf, offset])), 0.0)
    solid.exact.computeLocalAABB()
    box = solid.exact.aabb_local
    cloud = None
    if isinstance(shape, Points):
        from scipy.spatial import cKDTree  # slow to import, and only clouds need it

        cloud = cKDTree(shape.points)
    return _Bounded(solid, np.eye(4), (np.array(box.min_), np.array(box.max_)), shape.inflation, cloud)


_BOUNDED: dict[int, tuple[weakref.ref[Shape], _Bounded]] = {}


def bounded(shape: Shape) -> _Bounded:
    """A shape as coal has it, made once and kept as long as the shape is."""
    key = id(shape)
    if key not in _BOUNDED:
        _BOUNDED[key] = weakref.ref(shape, lambda _: _BOUNDED.pop(key, None)), _bounded(shape)
    return _BOUNDED[key][1]


def _cloud(points: Array) -> Any:
    """Points (k, 3), each a triangle within ``SPECK`` of it: an octree would have cubes as large as its cells."""
    corners = (points[:, None] + SPECK * np.eye(3)).reshape(-1, 3)
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(points), len(corners))
    mesh.addVertices(corners)
    mesh.addTriangles(np.arange(len(corners)).reshape(-1, 3))
    mesh.endModel()
    return mesh


def _triangles(mesh: Any) -> NDArray[np.intp]:
    """(t, 3) vertices of the triangles of a mesh of coal's."""
    numbers = (triangle[corner] for triangle in map(mesh.tri_indices, range(mesh.num_tris)) for corner in range(3))
    return np.fromiter(numbers, np.intp, 3 * mesh.num_tris).reshape(-1, 3)
