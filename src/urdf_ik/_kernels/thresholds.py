"""Where the kernels change their method. What decides whether a solution is right is in ``tolerances`` instead.

All are dimensionless: lengths count as shares of the arm's size, angles in rad.
"""

# A squared quantity of order one arrives at the families with this much rounding: 32 units in the last place.
ROUNDING = 7e-15
# After the root of a quartic, with this much at worst.
ROUGH = 1e-7
# Newton's method is done when an error falls to what forward kinematics of six joints rounds to.
FINISHED, CONVERGED = 1.8e-15, 2e-14

# Squared sines below which a pose counts as near a singularity; an imperfect arm's count from further away,
# its squared sines in proportion to its imperfection, its squared arms in proportion to the square of it.
NEAR, NEAR_BY_SINE, NEAR_BY_ARM = 1e-3, 5.0, 10.0
# Up to this multiple of its imperfection an arm that swings freely on the ideal arm does so almost.
ALMOST_FREE = 5.0
# Places on the circle from which an almost free joint is tried; imperfection up to which starts beside candidates
# help, because the elimination has not come into its element yet.
AROUND, FAR_OFF = 12, 1e-4

# A root this close to the unit circle (of its logarithm) may be real, rounding moves double roots off it by half
# their digits; this close, it should be.
NEAR_CIRCLE, ON_CIRCLE = 0.03, 0.02
# Three roots closer together than this may be taken for each other.
CROWDED = 0.04
# Noise of a determinant's harmonics that it is no longer trusted with.
LARGEST_NOISE = 1e-7
# Below this smallest singular value of the Jacobian a second solution may be next door.
NEAR_FOLD = 5e-3

# Three joints that place a point: below this a coefficient of their equations is zero to rounding; below this squared
# distance from an axis its joint may be free, or be badly determined; below this an equation that all but loses its
# unknown is solved without it too.
VANISHING, FREE, WEAK = 1e-12, 1e-10, 1e-3
