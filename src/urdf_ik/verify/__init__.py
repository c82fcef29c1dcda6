"""Checks of an arm, a changed URDF or another solver against a reference: correct, complete and unchanged answers.

One vocabulary: a *reference* is Pinocchio, a second solver, a lock file or another arm; a *report* has a verdict, the
*properties* that hold and do not, and the *pose to replay*.
"""

from urdf_ik.support.lazy import attributes

__all__ = ["Lock", "ProofCheck", "Verification", "check_proof", "compare", "compare_many", "freeze", "judge"]

__getattr__ = attributes(
    __name__,
    {
        "Lock": "baselines",
        "ProofCheck": "proof",
        "Verification": "baselines",
        "check_proof": "proof",
        "compare": "comparison",
        "compare_many": "many_arms",
        "freeze": "baselines",
        "judge": "judging",
    },
)
