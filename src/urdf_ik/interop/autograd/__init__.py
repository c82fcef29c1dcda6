"""Every branch of ``ik`` as a differentiable function of torch and of jax, which are imported when they are used."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
