"""How arms are solved: one file a family, and a registry of them in the order of cost."""

from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.registry import choose, every, of_six

__all__ = ["Family", "FamilyMember", "choose", "every", "of_six"]
