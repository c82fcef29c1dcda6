"""Arms and solutions in other programs: ROS messages, pink, viser and rerun; derivatives in torch and jax."""

from urdf_ik.support.lazy import attributes

_PUBLIC = (
    "ShownArm", "add_to_rerun", "add_to_viser", "from_joint_state", "pink_configuration", "to_joint_state"
)  # fmt: skip

__all__ = [*_PUBLIC]  # noqa: PLE0604

__getattr__ = attributes(__name__, dict.fromkeys(_PUBLIC, "other_programs"))
