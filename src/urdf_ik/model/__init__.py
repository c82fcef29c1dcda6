"""Robot descriptions (URDF, xacro, MJCF, SRDF, meshes), the catalogue of robot names, and poses."""

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
