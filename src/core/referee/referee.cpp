// See referee.hpp. Compiled once for every instruction set.
#include "referee/referee.hpp"

#include "certify/account.hpp"
#include "certify/precise.hpp"
#include "referee/determinant.hpp"
#include "referee/on_curve.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Axes moved by 1e-16, 115 digits decide every pose of 30 arms that was tried, and 77 nearly all.
inline constexpr int FEW_LIMBS = 4, MANY_LIMBS = 6;
// Where the chain is cut, and whether it is reversed.
struct Cut {
    int first;
    bool back;
    // The joint whose angle is hidden is the sixth.
    STEP int joint(int k) const { return back ? 5 - (first + k) % 6 : (first + k) % 6; }
};
// Those that leave the fewest poses open come first.
inline constexpr Cut CUTS[] = {{3, true}, {1, true}, {0, false}, {2, false}, {0, true}, {1, false}, {2, true}, {3, false}};
inline constexpr int ALL_CUTS = 8;
// A cut is of no use where the joint vector of a zero near real misses the pose by this or more [rad, share of size].
inline constexpr double MISREAD = 1e-6;
// A solution at a pair of zeros that are not real is singular: the pair's distance from real is at most NEAR_REAL. It counts where
// its joint vector reaches the pose: a change of the pose by what it misses makes the pair real.
inline constexpr double AT_A_PAIR = 0.1;
// Newton's method stays this near to a zero [rad].
inline constexpr double STAYS = 0.05;
// Newton's steps before a certificate, and the size of one [rad] that is not worth taking.
inline constexpr int CERTIFYING_ROUNDS = 5;
inline constexpr double SETTLED_ZERO = 1e-20;
// The square of the share of the step before that a step of Newton's method may have.
inline constexpr double CONVERGES = 0.0625;
// Hidden angles of a zero and of a certified solution that are this near to each other, and to no other, are the same [rad].
inline constexpr double SAME_ANGLE = 1e-10, OTHER_ANGLE = 1e-8;

struct CircleZero {
    double q[6], solution[6], least;  // least: smallest singular value at the solution
    double own, error;                // at the zero's joint vector, and at the solution
    bool real, certified;
};
// What one cut tells: its zeros on the circle and near it, and the others.
template <int L> struct CircleZeros {
    WideEquations<L> equations;
    HalfTangent<L> p;
    WideRoot<L> root[ROOTS];
    CircleZero at[ROOTS];
    int many = 0;
    Cut cut;
};

// Columns whose solutions have certificates.
PART unsigned certified_columns(const Loop& loop, const Columns<6>& columns) {
    unsigned out = 0;
    for (int from = 0; from < columns.many; from += BLOCK) {
        Block q[6];
        const unsigned lanes = solutions_in(columns, from, q);
        if (lanes) out |= (bits(certify_real(loop, q).holds) & lanes) << from;
    }
    return out;
}

// The certified column that a zero on the circle belongs to; -1 if angles do not tell.
template <int L> PART int column_of_zero(const CircleZeros<L>& zeros, int i, const Columns<6>& columns, unsigned certified) {
    const auto angle_at = [&](const WideRoot<L>& root) {
        return angle(Turn<double>{zeros.p.centre.c.leading(), zeros.p.centre.s.leading()}) + 2.0 * atan2(root.x.re.leading(), 1.0);
    };
    const double own = angle_at(zeros.root[i]);
    int found = -1;
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        const double apart = abs(wrap(wrap(columns.row(b)[zeros.cut.joint(5)] - own)));
        if (apart < SAME_ANGLE && found < 0 && certified >> b & 1) found = b;
        else if (apart < OTHER_ANGLE) return -1;
    }
    for (int k = 0; k < ROOTS; ++k) {
        if (k != i && zeros.root[k].least < OTHER_ANGLE && abs(wrap(angle_at(zeros.root[k]) - own)) < OTHER_ANGLE) return -1;
    }
    return found;
}

// The zeros of one cut. Returns whether all are resolved.
template <int L>
PART bool list_zeros(const WidePose<L>& pose, const Cut& cut, const Written<6>& arm, const Goal<double>& goal,
                     const Columns<6>& columns, unsigned certified, CircleZeros<L>& out) {
    out.cut = cut, out.many = 0;
    set_equations(pose, cut.first, out.equations);
    if (!half_tangent_polynomial(out.equations, out.p)) return false;
    roots_of(out.p, out.root);
    for (int i = 0; i < ROOTS; ++i) {
        WideRoot<L>& each = out.root[i];
        if (each.least > NEAR_REAL) continue;
        if (each.together > 1 || !(each.radius < 1e-8)) return false;
        const bool real = abs(each.x.im.leading()) <= each.radius;
        if (!real && each.x.im.negative) continue;
        const int known = real ? column_of_zero(out, i, columns, certified) : -1;
        if (known >= 0) {
            CircleZero& to = out.at[out.many++];
            for (int j = 0; j < 6; ++j) to.q[j] = to.solution[j] = columns.row(known)[j];
            to.real = to.certified = true, to.own = to.error = 0.0;
            to.least = weakest_at(arm, goal, to.q).value;
            continue;
        }
        if (real) each.x.im = 0.0;
        refine(out.p, each.x);
        Complex z[6];
        if (!joints_at(out.equations, out.p.centre, each.x, z)) return false;
        CircleZero& to = out.at[out.many++];
        for (int k = 0; k < 6; ++k) to.q[out.cut.joint(k)] = wrap(atan2(z[k].im, z[k].re));
        to.real = real, to.certified = false;
        to.own = error_at<6, double>(arm, goal, to.q).size;
        if (real && !(to.own < MISREAD)) return false;
    }
    return true;
}

// ---- certificates --------------------------------------------------------------------------------------------------------

// Certificates take fewer digits: only the error of the loop is computed in them.
inline constexpr int CERTIFYING_LIMBS = 2;
using Certifying = Wide<CERTIFYING_LIMBS>;
using WideTurn = Turn<Certifying>;
STEP WideTurn wide_turn(double q) {
    const Turn<double> t = cos_sin(q);
    const Certifying c = t.c, s = t.s, over = inverse_root(c * c + s * s);
    return {over * c, over * s};
}
// Turned on by 2 atan(step / 2).
STEP WideTurn turned_on(const WideTurn& t, double step) {
    const Certifying h = 0.5 * step, one = 1.0, over = inverse(one + h * h), c = (one - h * h) * over, s = (h + h) * over;
    return {t.c * c - t.s * s, t.s * c + t.c * s};
}

// Newton's method on the arm as written, in many digits with the Jacobian of doubles, and certificates of a block of solutions.
PART void certify_zeros(const LoopOf<WideMotion<CERTIFYING_LIMBS>>& loop, CircleZero* const (&zero)[BLOCK], int many) {
    WideTurn turn[BLOCK][6];
    LoopAt<Block> at;
    Orthogonal<Block> f;
    for (int l = 0; l < many; ++l) {
        for (int k = 0; k < 6; ++k) turn[l][k] = wide_turn(zero[l]->solution[k]);
    }
    LoopAt<Certifying> here;
    Block last = __builtin_inf();
    for (int round = 0;; ++round) {
        for (int l = 0; l < BLOCK; ++l) {
            if (l < many) here = loop_at(loop, turn[l]);
            for (int i = 0; i < 6; ++i) {
                for (int k = 0; k < 6; ++k) at.twist[k][i].set(l, here.twist[k][i].leading());
                at.error[i].set(l, here.error[i].leading());
            }
            at.off.set(l, here.off.leading());
        }
        make_orthogonal(at.twist, f);
        const Six<Block> step = newton_step(f, at.error);
        // At a double root each step is half of the one before.
        const Block size = square_of(step);
        if (round == CERTIFYING_ROUNDS || !any((size > Block(SETTLED_ZERO * SETTLED_ZERO)) & (size < CONVERGES * last))) break;
        last = size;
        for (int l = 0; l < many; ++l) {
            for (int k = 0; k < 6; ++k) turn[l][k] = turned_on(turn[l][k], max(min(step[k][l], 0.1), -0.1));
        }
    }
    Block longest = 0.0, S = 0.0;
    for (const Six<Block>& each : at.twist) {
        longest = max(longest, square_of(each));
        S += 1.4143 * sqrt(square_of(each));
    }
    const double small = ROUNDINGS * FIXED_UNIT<CERTIFYING_LIMBS>;
    const Certificate c =
        certify(at, f, Rounding{small, small * (1.0 + longest), 2.0 * UNIT * sqrt(longest)}, 0.9 * LARGEST_BALL / S);
    for (int l = 0; l < many; ++l) {
        double q[6], from_zero = 0.0;
        for (int k = 0; k < 6; ++k) {
            q[k] = wrap(angle(Turn<double>{turn[l][k].c.leading(), turn[l][k].s.leading()}));
            from_zero = max(from_zero, abs(wrap(q[k] - zero[l]->q[k])));
        }
        zero[l]->certified = (bits(c.holds) >> l & 1) && from_zero + c.inner[l] < c.outer[l];
        if (!zero[l]->certified) continue;
        for (int k = 0; k < 6; ++k) zero[l]->solution[k] = q[k];
    }
}

template <int L> PART void certify_all_zeros(const Written<6>& arm, const Goal<double>& goal, CircleZeros<L>& zeros) {
    bool any = false;
    for (int i = 0; i < zeros.many; ++i) any |= zeros.at[i].real && !zeros.at[i].certified;
    if (!any) return;
    WideMotion<CERTIFYING_LIMBS> step[7];
    for (int k = 0; k < 7; ++k) step[k] = wide_motion<CERTIFYING_LIMBS>(arm.step[k], 1.0 / arm.size);
    const auto loop = loop_of_steps(step, wide_motion<CERTIFYING_LIMBS>(motion_of(goal), 1.0 / arm.size));
    CircleZero* waiting[BLOCK];
    int many = 0;
    for (int i = 0; i < zeros.many; ++i) {
        if (zeros.at[i].real && !zeros.at[i].certified) waiting[many++] = zeros.at + i;
        if (many == BLOCK) certify_zeros(loop, waiting, many), many = 0;
    }
    if (many) certify_zeros(loop, waiting, many);
}

// ---- the answer ------------------------------------------------------------------------------------------------------------

// Newton's method in doubles from each zero.
template <int L> PART void follow_zeros(const Written<6>& arm, const Goal<double>& goal, CircleZeros<L>& zeros) {
    for (int i = 0; i < zeros.many; ++i) {
        CircleZero& zero = zeros.at[i];
        if (zero.certified) continue;
        for (int j = 0; j < 6; ++j) zero.solution[j] = zero.q[j];
        zero.error = polish_one<true>(arm, goal, zero.solution, {40, FINISHED, LONG_PATIENCE}).error;
        if (zero.real && (!(zero.error <= CONVERGED) || distance(arm, zero.solution, zero.q) > STAYS)) {
            // On a curve, or in a valley, it may lead away; the zero itself keeps the pose.
            if (zero.own <= arm.tolerances.reach) {
                for (int j = 0; j < 6; ++j) zero.solution[j] = zero.q[j];
                zero.error = zero.own;
            }
        }
        zero.least = weakest_at(arm, goal, zero.solution).value;
    }
}

// A column for a new solution: a free one, or that of a singular one at which no zero is; -1 if there is none.
STEP int free_column(const Columns<6>& columns, unsigned owned) {
    const int vacant = columns.vacant();
    if (vacant >= 0) return vacant;
    for (int b = 0; b < columns.many; ++b) {
        if (columns.flags[b] & SINGULAR && !(owned >> b & 1)) return b;
    }
    return -1;
}

// Returns whether all zeros that are not near real belong to regular complex solutions of the arm as written. Others may belong to
// a curve of solutions: what Newton's method finds from their real parts becomes a solution. status: clustered if there is one,
// incomplete if no column is free for it.
template <int L>
PART bool settle_far_zeros(const Written<6>& arm, const Goal<double>& goal, const CircleZeros<L>& zeros, const Columns<6>& columns,
                           Status& status) {
    const Loop loop = loop_of(arm, goal);
    bool all = true;
    CBlock z[6];
    int many = 0;
    const auto certify_block = [&] {
        if (!many) return;
        const unsigned lanes = (1u << many) - 1;
        CBlock start[6];
        double q[6];
        for (int k = 0; k < 6; ++k) start[k] = z[k];
        Growth growth;
        unsigned certified = bits(certify_complex(loop, z, lanes, 3, growth).holds);
        if (lanes & ~certified)
            certified |= bits(certify_precisely(loop, precise_loop(arm, goal), z, lanes & ~certified, growth).holds);
        for (int l = 0; l < many; ++l) {
            if (certified >> l & 1) continue;
            all = false;
            for (int j = 0; j < 6; ++j) q[j] = wrap(atan2(start[j].im[l], start[j].re[l]));
            if (!(polish_one<true>(arm, goal, q, {60, FINISHED, LONG_PATIENCE}).error <= CONVERGED)) continue;
            if (!is_new(arm, goal, columns, q)) continue;
            const int b = columns.vacant();
            if (b >= 0) keep(columns, b, q, singular_marks(arm, goal, q, 0));
            // A regular solution has a zero of its own near real: this cut has lost it.
            const bool lost = b < 0 || weakest_at(arm, goal, q).value > LOST_RANK;
            status = lost || status == Status::incomplete ? Status::incomplete : Status::clustered;
        }
        many = 0;
    };
    for (const WideRoot<L>& each : zeros.root) {
        if (!(each.least > NEAR_REAL) || each.x.im.negative) continue;
        Complex at[6];
        if (!joints_at(zeros.equations, zeros.p.centre, each.x, at)) {
            all = false;
            continue;
        }
        for (int l = many; l < BLOCK; ++l) {
            for (int k = 0; k < 6; ++k) z[zeros.cut.joint(k)].re.set(l, at[k].re), z[zeros.cut.joint(k)].im.set(l, at[k].im);
        }
        if (++many == BLOCK) certify_block();
    }
    certify_block();
    return all;
}

template <int L>
PART Status status_of_zeros(const Written<6>& arm, const Goal<double>& goal, const CircleZeros<L>& zeros,
                            const Columns<6>& columns) {
    unsigned owned = 0, regular = 0;
    bool clustered = false;
    for (int pass = 0; pass < 3; ++pass) {
        for (int i = 0; i < zeros.many; ++i) {
            const CircleZero& zero = zeros.at[i];
            if (pass != (zero.certified ? 0 : zero.real ? 1 : 2)) continue;
            if (!zero.real && (!(zero.error <= arm.tolerances.reach) || zero.least > AT_A_PAIR)) continue;
            if (zero.real && !(zero.error <= arm.tolerances.reach)) return Status::incomplete;
            int b = nearest_column(arm, columns, zero.solution);
            const bool known = b >= 0 && !is_new(arm, goal, columns, zero.solution);
            // A solution takes the place of what keeps the pose less well.
            if (!known || (!(owned >> b & 1) && zero.error <= CONVERGED && missed_by(arm, goal, columns.row(b)) > CONVERGED)) {
                if (!known) b = free_column(columns, owned);
                if (b < 0) return Status::incomplete;
                columns.clear(b);
                keep(columns, b, zero.solution, zero.least < NEAR_FOLD ? singular_marks(arm, goal, zero.solution, 0) : 0);
            } else if (!zero.real && zero.own > CONVERGED && regular >> b & 1) {
                // Newton's method went on to the solution of another zero.
                continue;
            }
            if (!zero.certified || owned >> b & 1) {
                clustered = true;
                // A representative of several solutions is singular to rounding.
                if (zero.least < HALF_OF_THE_DIGITS && !(columns.flags[b] & SINGULAR)) columns.flags[b] |= OTHER;
            }
            owned |= 1u << b, regular |= unsigned(zero.certified) << b;
        }
    }
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b) || owned >> b & 1) continue;
        // Members of groups and of curves may be known without a zero of their own; a regular solution has one.
        if (weakest_at(arm, goal, columns.row(b)).value > LOST_RANK) return Status::incomplete;
        clustered = true;
    }
    Status status = clustered ? Status::clustered : Status::complete;
    // Where no zero is real, rounding of the pose may have made a curve's members complex: the other zeros lead to them.
    bool real = false;
    for (int i = 0; i < zeros.many; ++i) real |= zeros.at[i].real;
    if (!(clustered && real) && settle_far_zeros(arm, goal, zeros, columns, status) && !clustered) return Status::complete;
    return any_is_on_curve(arm, goal, columns) ? Status::continuum : status;
}

// How many of the solutions share one angle of the joint, at most.
PART int sharing(const Columns<6>& columns, int joint) {
    int out = 0;
    for (int b = 0; b < columns.many; ++b) {
        int own = 0;
        for (int c = 0; c < columns.many; ++c) {
            own += columns.valid(b) && columns.valid(c) && abs(wrap(columns.row(b)[joint] - columns.row(c)[joint])) < OTHER_ANGLE;
        }
        out = larger(out, own);
    }
    return out;
}

template <int L>
PART Status refer_with(const Written<6>& arm, const Goal<double>& goal, const Columns<6>& columns, const Cut* cuts, int many) {
    const WidePose<L> pose = wide_pose<L>(arm, goal), back = reversed(pose);
    CircleZeros<L> zeros;
    Status status = Status::incomplete;
    for (int i = 0; i < many && status == Status::incomplete; ++i) {
        const unsigned certified = certified_columns(loop_of(arm, goal), columns);
        if (!list_zeros(cuts[i].back ? back : pose, cuts[i], arm, goal, columns, certified, zeros)) continue;
        follow_zeros(arm, goal, zeros);
        certify_all_zeros(arm, goal, zeros);
        status = status_of_zeros(arm, goal, zeros, columns);
    }
    return status;
}

Status refer(const Written<6>& arm, const Goal<double>& goal, const Columns<6>& columns) {
    for (const bool slides : arm.slides) {
        if (slides) return Status::incomplete;
    }
    // Hidden angles that the fewest solutions share come first: the zeros of solutions that share one are about NUDGE from each
    // other.
    int shared[6], many = 0;
    for (int j = 0; j < 6; ++j) shared[j] = sharing(columns, j);
    Cut cuts[ALL_CUTS];
    for (int most = 0; many < ALL_CUTS; ++most) {
        for (const Cut& each : CUTS) {
            if (shared[each.joint(5)] == most) cuts[many++] = each;
        }
    }
    Status status = refer_with<FEW_LIMBS>(arm, goal, columns, cuts, 1);
    if (status == Status::incomplete) status = refer_with<MANY_LIMBS>(arm, goal, columns, cuts, ALL_CUTS);
    return status == Status::incomplete && any_is_on_curve(arm, goal, columns) ? Status::continuum : status;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
