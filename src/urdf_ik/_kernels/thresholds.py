"""Where the kernels change their method. What decides whether a solution is right is in ``tolerances`` instead.

All are dimensionless: lengths count as shares of the arm's size, angles in rad.
"""

# A squared quantity of order one arrives at the families with this much rounding: 32 units in the last place.
ROUNDING = 7e-15
# After the root of a quartic, with this much at worst.
ROUGH = 1e-7
# Squared sine or arm below which a joint is so nearly free that rounding moves its angle about.
ALMOST_ALIGNED = 1e-12
# Two roots of a quartic whose squared distance on the unit circle is below this may lead to one solution.
ROOTS_CROWDED = 1e-4
# Rounding of what is left after a step whose own margin is m: this much over m.
ROUGH_BY_MARGIN = 1e-13
# Newton's method is done when an error falls to what forward kinematics of six joints rounds to.
FINISHED, CONVERGED = 1.8e-15, 2e-14
# A damped iteration that has not gained a third in this many rounds has come to rest, from a start that may be no
# solution's; from one that should be, it may be in a long valley.
PATIENCE, LONG_PATIENCE = 7, 60
# Damping of the last steps; error below which a root that does not converge may be a double one, and the damping that
# holds the direction in which it is singular.
LEAST_DAMPING, NEARLY, HELD = 1e-12, 1e-7, 1e-6
# Error to which a candidate must fall that lies a little beyond its family's edge.
DOUBTFUL = 1e-12

# Squared sines below which a pose counts as near a singularity; an imperfect arm's count from further away,
# its squared sines in proportion to its imperfection, its squared arms in proportion to the square of it.
NEAR, NEAR_BY_SINE, NEAR_BY_ARM = 1e-3, 5.0, 10.0
# Up to this multiple of its imperfection an arm that swings freely on the ideal arm does so almost.
ALMOST_FREE = 5.0
# Newton's method, moved by less than this share of the Jacobian's smallest singular value, has found the one solution
# there: with J's Lipschitz constant at most 1, Kantorovich's theorem asks for a half.
KANTOROVICH = 0.5
# An arm (a sine, or a share of the size) this short is not trusted to fix an angle of an imperfect arm: a multiple of
# what the correction changes by per rad.
SHORT_BY_DRIFT = 4.0
# A shoulder's squared margin times this, up to 1, is what a small turn of the later joints hangs on.
LEVER = 10.0
# How often an imperfect arm's target is corrected before the elimination is asked, and the last change of a joint
# [rad] after which another correction tells no more.
CORRECTIONS, SETTLED = 4, 1e-5
# Places on the circle from which an almost free joint is tried.
AROUND = 12
# Imperfection up to which starts beside candidates help, because the elimination has not come into its element yet,
# and from which the ideal arm's candidates add nothing to it.
CLOSE_BY, FAR_OFF = 1e-4, 1e-3

# A root this close to the unit circle (of its logarithm) may be real: a moved axis, and rounding, push double roots
# off it by half their digits; this close, it should be.
NEAR_CIRCLE, ON_CIRCLE = 0.1, 0.02
# An error from which Newton's method, slow at a double root, may still arrive.
CLOSE = 1e-4
# Three roots closer together than this may be taken for each other.
CROWDED = 0.04
# Noise of a determinant's harmonics that it is no longer trusted with.
LARGEST_NOISE = 1e-7
# Below this smallest singular value of the Jacobian a second solution may be next door.
NEAR_FOLD = 5e-3
# Above this distance [rad] the two solutions of a fold do not hide each other.
WIDE_FOLD = 0.3
# Least squared cosine of the angle between the difference of the two solutions of a simple fold and the direction that
# the Jacobian all but loses.
ALONG_FOLD = 0.9
# Sine of the angle below which the wrist of an S-R-S arm counts as lying on axis 1.
ON_AXIS = 1e-7

# Three joints that place a point: below this a coefficient of their equations is zero to rounding; below this squared
# distance from an axis its joint may be free, or be badly determined; below this an equation that all but loses its
# unknown is solved without it too.
VANISHING, FREE, WEAK = 1e-12, 1e-10, 1e-3
