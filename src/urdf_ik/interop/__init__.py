"""Arms and solutions in other programs: ROS messages; derivatives in torch and jax."""

from urdf_ik.support.lazy import attributes

_PUBLIC = ("from_joint_state", "to_joint_state")

__all__ = [*_PUBLIC]  # noqa: PLE0604

__getattr__ = attributes(__name__, dict.fromkeys(_PUBLIC, "other_programs"))
