"""Solutions as differentiable functions of torch and of jax."""

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
