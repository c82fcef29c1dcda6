"""Pictures of an arm and the viewer in the browser."""

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
