"""Arms and solutions in other programs: ROS messages and pink; derivatives in torch and jax."""

from urdf_ik.support.lazy import attributes

_PUBLIC = ("from_joint_state", "pink_configuration", "to_joint_state")

__all__ = [*_PUBLIC]  # noqa: PLE0604

__getattr__ = attributes(__name__, dict.fromkeys(_PUBLIC, "other_programs"))
