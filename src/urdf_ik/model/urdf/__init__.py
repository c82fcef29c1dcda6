"""The URDF reader: hardened XML in, a checked kinematic tree out; every error names line and element."""

from urdf_ik.model.urdf.chains import Candidate
from urdf_ik.model.urdf.checks import MOVABLE, Joint, UrdfWarning
from urdf_ik.model.urdf.reader import read
from urdf_ik.model.urdf.urdf_model import UrdfModel, resolve_mesh

__all__ = ["MOVABLE", "Candidate", "Joint", "UrdfModel", "UrdfWarning", "read", "resolve_mesh"]
