"""An independent check of the solver's proofs, in ball arithmetic, from the URDF's screw axes alone."""

from urdf_ik.verify.proof.check import ProofCheck, check_proof

__all__ = ["ProofCheck", "check_proof"]
