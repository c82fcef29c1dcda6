// One cycle of following a pose. The joints stay on the branch of the last joint vector and move to its solution for the new
// pose, or as near to it as one cycle allows.
//
// All candidates start at the current joints: Newton's least-squares steps inside the cycle's bounds, each kept only if it
// reduces the error (a trust region; Nocedal and Wright, Numerical Optimization, chapters 4 and 10). The motion of a cycle is cut
// into pieces. Each piece is either proven to meet no singularity, or so short that a crossed fold is detected and undone.
#pragma once

#include <initializer_list>

#include "motion/stand.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A motion that is not proven regular is done in at most PIECES pieces of at most PIECE [rad, share of size].
inline constexpr double PIECE = 0.05;
inline constexpr int PIECES = 64;
// Most steps of Newton's method on a piece, refused ones included. A step is refused if it achieves less than ENOUGH_GAIN of the
// predicted reduction; the next one may go a quarter as far. Below FAINT [rad, share of size] the method stops.
inline constexpr int TRIALS = 14;
inline constexpr double ENOUGH_GAIN = 0.1;
// At a singularity, the change of the smallest singular value per rad along the self-motion direction, measured PIECE to
// either side. Above PASSABLE the singularity is a fold, beyond which lies another branch. Below (the wrist,
// the shoulder) the singularity persists along this motion, and the arm may pass to the other side. The derivative at the
// singularity is below 1e-12 for exact wrists and shoulders, 6e-5 for those of a calibrated UR, and 6e-4 to 0.2 for folds of
// general arms. Where two folds meet (a cusp) it is zero too, but the change grows with the distance.
inline constexpr double PASSABLE = 2e-4;
// The same derivative, at or beside a singularity, above which the reported reason is reach instead of singularity.
inline constexpr double BLUNT = 5e-3;
// A piece that crosses a fold is moved back to where the smallest singular value is this share of the value before, but not below
// LAST_GAIN: about 1e-10 of the arm's size before the edge of reach. Only a solution at its target may be closer to the fold.
inline constexpr double APPROACH = 0.25, LAST_GAIN = 1e-5;
// Smallest singular value below which the arm counts as exactly singular. If it would not move, it is pushed out.
inline constexpr double EXACTLY_SINGULAR = 1e-8;
// Damping of the estimate of the joint speeds needed, so that singular directions do not slow the arm down.
inline constexpr double SINGULAR_ASIDE = 0.1;
// An arm of seven joints moves away from limits closer than NEAR_LIMIT of the joint's range, or NEAR_LIMIT_AT_MOST [rad, share of
// size] if that is less.
inline constexpr double NEAR_LIMIT = 0.1, NEAR_LIMIT_AT_MOST = 0.2;
// The speeds allow a share of the twist. Singular directions count in it only if it is then more than REGULAR times the share
// without them.
inline constexpr double REGULAR = 0.5;
// Joint limits are the reason if the gains of the joints at their limits exceed this share of the remaining twist.
inline constexpr double FELT = 1e-2;

// The joints stopped at a bound, a bit each; whether a fold stopped the arm; a lower bound on the smallest singular value at the
// start.
struct Went {
    unsigned below, above;
    bool folded;
    double least;
};

// Newton's method from `s` towards a goal, inside the box, while the error falls. drift: the secondary motion of seven joints,
// applied to the first step only.
template <int N>
PART Went approach(const Written<N>& arm, const Goal<double>& goal, const Box<N>& box, const double (&drift)[N], Stand<N>& s) {
    face(arm, goal, s);
    Went went = {0, 0, false, 0.0};
    if constexpr (N > 6) went.least = least_gain(s.J);
    double trust = __builtin_inf();
    bool first = N > 6;
    for (int trial = 0; trial < TRIALS && s.size > CONVERGED && trust > FAINT; ++trial) {
        double low[N], high[N], own[N] = {};
        Six<double> e = s.twist;
        for (int k = 0; k < N; ++k) {
            const double unit = unit_of(arm, k);
            if (first) own[k] = drift[k], e = less(e, own[k], s.J[k]);
            low[k] = max((box.low[k] - s.q[k]) / unit, -trust) - own[k],
            high[k] = min((box.high[k] - s.q[k]) / unit, trust) - own[k];
        }
        BoundedStep<N> step = bounded_step(s.J, e, FAINT, low, high);
        if (N <= 6 && trial == 0) went.least = step.least;
        for (int k = 0; k < N; ++k) step.x[k] += own[k];
        Stand<N> next = moved(arm, s, step.x);
        for (int k = 0; k < N; ++k) next.q[k] = min(max(next.q[k], box.low[k]), box.high[k]);
        face(arm, goal, next);
        if (!(s.square - next.square > ENOUGH_GAIN * (s.square - step.left))) {
            if (s.size < arm.tolerances.reach) break;  // rounding
            trust = 0.25 * longest(step.x), first = false;
            continue;
        }
        went.below = went.above = 0;
        for (int k = 0; k < N; ++k) {
            if (next.q[k] <= box.low[k]) went.below |= (step.below & 1u << k);
            if (next.q[k] >= box.high[k]) went.above |= (step.above & 1u << k);
        }
        first = false, trust *= 2.0;
        s = next;
    }
    return went;
}

// Whether the straight joint motion from a to b meets no singularity: by Weyl's inequality there is none if the Jacobian changes
// by less than its smallest singular value at a. The change is at most the change from a to b plus an eighth of a bound on the
// second derivative along the motion. For each column that bound is twice its length times |x|_1^2.
template <int N> PART bool regular_between(const Written<N>& arm, const Stand<N>& a, const Stand<N>& b, double least) {
    double square = 0.0, along = 0.0, lengths = 0.0;
    for (int k = 0; k < N; ++k) {
        const Six<double> change = less(b.J[k], 1.0, a.J[k]);
        square += dot(change, change), lengths += 1.0 + dot(b.J[k], b.J[k]), along += abs(b.q[k] - a.q[k]) / unit_of(arm, k);
    }
    return sqrt(square) + 0.25 * sqrt(lengths) * along * along < least;
}

// The weakest direction: smallest singular value (gain), joint motion, and the unit twist that this motion causes.
template <int N> struct Weak {
    double gain, motion[N];
    Six<double> twist;
};
template <int N> PART Weak<N> weak_at(const Stand<N>& s) {
    Weak<N> out = {0.0, {}, {}};
    if constexpr (N <= 6) {
        Six<double> A[N];
        for (int k = 0; k < N; ++k) A[k] = s.J[k];
        const Weakest<N> w = weakest(A);
        out.gain = w.value;
        for (int k = 0; k < N; ++k) out.motion[k] = w.direction[k], out.twist = less(out.twist, -w.direction[k], s.J[k]);
        out.twist = times(out.twist, 1.0 / sqrt(dot(out.twist, out.twist) + TINY));
    } else {
        Rows<N, double> A[6];
        transpose(s.J, A);
        const Weakest<6> w = weakest(A);
        out.gain = w.value;
        for (int i = 0; i < 6; ++i) out.twist[i] = w.direction[i];
        double square = TINY;
        for (int k = 0; k < N; ++k) out.motion[k] = dot(s.J[k], out.twist), square += out.motion[k] * out.motion[k];
        for (double& each : out.motion) each /= sqrt(square);
    }
    return out;
}
// The gain of this motion and this twist at another joint vector.
template <int N> STEP double gain_at(const Weak<N>& weak, const Stand<N>& s) {
    double sum = 0.0;
    for (int k = 0; k < N; ++k) sum += weak.motion[k] * dot(weak.twist, s.J[k]);
    return sum;
}
// The gain of the weakest direction at another joint vector. It is negative if a motion of like sense gives the opposite twist.
template <int N> STEP double signed_gain(const Weak<N>& weak, const Stand<N>& s) {
    const Weak<N> there = weak_at(s);
    double along = 0.0;
    for (int k = 0; k < N; ++k) along += weak.motion[k] * there.motion[k];
    return copysign(there.gain, along * dot(weak.twist, there.twist));
}
// The derivative of the gain along the weak motion, by a central difference.
template <int N> PART double gain_rate(const Written<N>& arm, const Weak<N>& weak, const Stand<N>& s) {
    constexpr double step = 1e-4;
    double change = 0.0;
    for (int k = 0; k < 2; ++k) {
        const double side = k ? -1.0 : 1.0;
        double x[N];
        for (int j = 0; j < N; ++j) x[j] = side * step * weak.motion[j];
        Stand<N> beside = moved(arm, s, x);
        change += side * gain_at(weak, beside);
    }
    return change / (2.0 * step);
}
// Whether the arm stays singular along the self-motion direction at the point between a and b where the gain is zero (see
// PASSABLE). The point is interpolated from the gains at a and b; if the gain has not changed sign, it is b.
template <int N>
PART bool passes(const Written<N>& arm, const Stand<N>& a, const Stand<N>& b, double gain, double gain_at_b) {
    const double share = gain_at_b < 0.0 ? gain / (gain - gain_at_b) : 1.0;
    double x[N];
    for (int k = 0; k < N; ++k) x[k] = share * (b.q[k] - a.q[k]) / unit_of(arm, k);
    Stand<N> there = moved(arm, a, x);
    const Weak<N> weak = weak_at(there);
    for (const double side : {PIECE, -PIECE}) {
        for (int k = 0; k < N; ++k) x[k] = side * weak.motion[k];
        Stand<N> beside = moved(arm, there, x);
        if (abs(weak_at(beside).gain - weak.gain) > PASSABLE * abs(side)) return false;
    }
    return true;
}

// If the short motion from a to b has crossed a fold, move b back along the weak direction, which hardly moves the tip. With joints
// at their limits, no singularity may be crossed, not even a passable one. Returns whether b was changed.
template <int N> PART bool keep_side(const Written<N>& arm, const Goal<double>& goal, const Box<N>& box, const Stand<N>& a,
                                     bool at_limit, Stand<N>& b) {
    const Weak<N> weak = weak_at(a);
    if (weak.gain < EXACTLY_SINGULAR) return false;
    const double gain = signed_gain(weak, b);
    if (gain > (b.size <= arm.tolerances.reach ? 0.0 : LAST_GAIN)) return false;
    const double rate = gain_rate(arm, weak, a);
    const bool passable = passes(arm, a, b, weak.gain, gain);
    if (passable && !(at_limit && gain <= 0.0)) return false;
    const double wanted = max(APPROACH * weak.gain, LAST_GAIN), back = (wanted - gain) / rate;
    const Stand<N> crossed = b;
    b = a;
    if (!passable && abs(back) < 2.0 * PIECE) {
        for (int k = 0; k < N; ++k) {
            b.q[k] = min(max(crossed.q[k] + unit_of(arm, k) * back * weak.motion[k], box.low[k]), box.high[k]);
        }
        place_at(arm, b);
    }
    // At a passable singularity, or if b is still not on the side of a, the motion from a ends before the singularity.
    if (passable || !(signed_gain(weak, b) > 0.0)) {
        const double share = max(weak.gain - wanted, 0.0) / (weak.gain - gain);
        for (int k = 0; k < N; ++k) b.q[k] = a.q[k] + share * (crossed.q[k] - a.q[k]);
        place_at(arm, b);
    }
    face(arm, goal, b);
    return true;
}

// Move the tip straight along a share of the twist to the goal.
template <int N>
PART Went march(const Written<N>& arm, const Goal<double>& goal, const Six<double>& twist, double share, const Box<N>& box,
                const double (&drift)[N], Stand<N>& s) {
    const Frame<double> from = s.at.tip;
    Went went = {};
    bool folded = false;
    double done = 0.0, piece = 1.0;
    for (int k = 0; k < PIECES && done < 1.0; ++k) {
        const double to = share * (done + piece);
        const Goal<double> next_goal = to < 1.0 ? between(from, twist, to, arm.size) : goal;
        Stand<N> next = s;
        const Went now = approach(arm, next_goal, box, drift, next);
        if (!regular_between(arm, s, next, now.least)) {
            if (apart(arm, s, next) > PIECE) {
                piece *= 0.5;
                continue;
            }
            const bool at_limit = (now.below & box.limit_below) | (now.above & box.limit_above);
            if (keep_side(arm, next_goal, box, s, at_limit, next)) {
                folded = true;
                // From here Newton's method may reach a solution on this side of the fold.
                Stand<N> again = next;
                approach(arm, next_goal, box, drift, again);
                if (!keep_side(arm, next_goal, box, s, at_limit, again)) next = again;
            }
        }
        s = next, went = now, done += piece, piece = min(2.0 * piece, 1.0 - done);
    }
    went.folded = folded;
    face(arm, goal, s);
    return went;
}

// Whether the goal is no farther than the tip would move if all joints moved to their bounds and their effects added up.
template <int N> STEP bool within_a_cycle(const Written<N>& arm, const Stand<N>& s, const Box<N>& box) {
    double furthest = 0.0;
    for (int k = 0; k < N; ++k) {
        const double room = max(box.high[k] - s.q[k], s.q[k] - box.low[k]) / unit_of(arm, k);
        if (room > 0.0) furthest += room * sqrt(dot(s.J[k], s.J[k]));
    }
    return s.square <= furthest * furthest;
}

// The share of the twist to the goal that the joint speeds allow. Joints at their limits do not count.
template <int N> PART double affordable(const TrackedArm<N>& arm, const Stand<N>& s, const Box<N>& box, double damping) {
    double low[N], high[N];
    for (int k = 0; k < N; ++k) {
        const double unit = unit_of(arm.written, k);
        low[k] = (arm.lower[k] - s.q[k]) / unit, high[k] = (arm.upper[k] - s.q[k]) / unit;
    }
    const BoundedStep<N> step = bounded_step(s.J, s.twist, damping, low, high);
    double share = 1.0;
    for (int k = 0; k < N; ++k) {
        if ((step.below | step.above) >> k & 1) continue;
        const double x = unit_of(arm.written, k) * step.x[k], room = x > 0.0 ? box.high[k] - s.q[k] : s.q[k] - box.low[k];
        const bool is_limit = (x > 0.0 ? box.limit_above : box.limit_below) >> k & 1;
        if (!is_limit && room < share * abs(x)) share = room / abs(x);
    }
    return share;
}

// Push the arm out of an exactly singular joint vector from which no step reduces the error: along the weakest direction, to the
// side from which Newton's method comes nearer to the goal. Returns whether the error fell.
template <int N>
PART bool push(const Written<N>& arm, const Goal<double>& goal, const Box<N>& box, const double (&drift)[N], Stand<N>& s) {
    Six<double> A[N];
    for (int k = 0; k < N; ++k) A[k] = s.J[k];
    const Weakest<N> idle = weakest(A);
    if (least_gain(s.J) > 2.0 * EXACTLY_SINGULAR) return false;
    const Stand<N> before = s;
    for (int try_both = 0; try_both < 2; ++try_both) {
        const double side = try_both ? -PIECE : PIECE;
        Stand<N> next = before;
        double share = 1.0;
        for (int k = 0; k < N; ++k) {
            const double x = unit_of(arm, k) * side * idle.direction[k],
                         room = x > 0.0 ? box.high[k] - s.q[k] : s.q[k] - box.low[k];
            if (room < share * abs(x)) share = room / abs(x);
        }
        for (int k = 0; k < N; ++k) next.q[k] += share * unit_of(arm, k) * side * idle.direction[k];
        place_at(arm, next);
        approach(arm, goal, box, drift, next);
        if (next.square < s.square * (1.0 - SAME)) s = next;
    }
    return s.square < before.square;
}

// The greatest speed from which a joint can stop within a distance [rad, m]. The cycle that begins runs at this speed; then the
// speed falls by acceleration * dt per cycle.
STEP double stopping_speed(double distance, double acceleration, double dt) {
    const double decrement = acceleration * dt, D = max(distance, 0.0) / (decrement * dt);
    const double whole = __builtin_floor(0.5 * (sqrt(1.0 + 8.0 * D) - 1.0));
    return decrement * (whole * 0.5 + D / (whole + 1.0));
}

// The bounds of the joints in this cycle. With a limit on the acceleration, they include the distance to stop from full speed.
template <int N> STEP Box<N> box_of(const TrackedArm<N>& arm, const TrackedState<N>& state) {
    Box<N> box = {{}, {}, 0, 0};
    for (int k = 0; k < N; ++k) {
        const double v = arm.velocity[k], a = arm.acceleration[k];
        const double far = v * arm.dt + (a < __builtin_inf() && v < __builtin_inf() ? 0.5 * v * v / a : 0.0);
        box.low[k] = max(state.q[k] - far, arm.lower[k]), box.high[k] = min(state.q[k] + far, arm.upper[k]);
        if (box.low[k] == arm.lower[k]) box.limit_below |= 1u << k;
        if (box.high[k] == arm.upper[k]) box.limit_above |= 1u << k;
    }
    return box;
}

// The secondary motion of seven joints: away from nearby limits.
template <int N> STEP void own_motion(const TrackedArm<N>& arm, const Stand<N>& s, double (&drift)[N]) {
    for (int k = 0; k < N; ++k) {
        const double unit = unit_of(arm.written, k), range = arm.upper[k] - arm.lower[k];
        const double margin = min(NEAR_LIMIT * range, NEAR_LIMIT_AT_MOST * unit), share = min(arm.recentring * arm.dt, 0.5);
        const double over = max(s.q[k] - (arm.upper[k] - margin), 0.0) + min(s.q[k] - (arm.lower[k] + margin), 0.0);
        const double most = 0.5 * arm.velocity[k] * arm.dt;
        drift[k] = margin > 0.0 ? -min(max(share * over, -most), most) / unit : 0.0;
    }
}

// Move the joints towards a goal within their limits of speed and acceleration. After two exact goals in a row the goal's own
// velocity is known and is added. Relative to it, joints go no faster than they can brake. All joints cover the same share of
// their distances, as far as their accelerations allow.
template <int N>
PART void go_after(const TrackedArm<N>& arm, TrackedState<N>& state, const double (&goal)[N], bool exact, double (&q)[N]) {
    double speed[N], share = 1.0;
    const bool known = exact && state.exact;
    state.exact = exact;
    for (int k = 0; k < N; ++k) {
        speed[k] = !known ? 0.0 : min(max((goal[k] - state.goal[k]) / arm.dt, -arm.velocity[k]), arm.velocity[k]);
        const double missing = abs(goal[k] - state.q[k] - speed[k] * arm.dt);
        const double most =
            min(arm.acceleration[k] < __builtin_inf() ? stopping_speed(missing, arm.acceleration[k], arm.dt) : __builtin_inf(),
                arm.velocity[k]);
        if (missing > most * arm.dt) share = min(share, most * arm.dt / missing);
    }
    for (int k = 0; k < N; ++k) {
        const double a = arm.acceleration[k], missing = goal[k] - state.q[k] - speed[k] * arm.dt;
        double v = speed[k] + share * missing / arm.dt;
        v = min(max(v, state.v[k] - a * arm.dt), state.v[k] + a * arm.dt);
        v = min(max(v, -arm.velocity[k]), arm.velocity[k]);
        if (a < __builtin_inf()) {
            v = min(v, stopping_speed(arm.upper[k] - state.q[k], a, arm.dt));
            v = max(v, -stopping_speed(state.q[k] - arm.lower[k], a, arm.dt));
        }
        q[k] = state.q[k] + v * arm.dt;
        if (abs(q[k] - goal[k]) < 1e-15 * (1.0 + abs(goal[k]))) q[k] = goal[k];
        q[k] = min(max(q[k], arm.lower[k]), arm.upper[k]);
        state.goal[k] = goal[k];
    }
}

// The reason why an arm that no bound stops is not at its target. The target is out of reach at a fold, or if the error does not
// point mostly in the weakest direction of a nearly singular arm. At any other singularity the reason is the singularity.
template <int N> PART Because because_of(const Written<N>& arm, const Stand<N>& s, const Went& went) {
    if (went.folded) return Because::reach;
    const Weak<N> weak = weak_at(s);
    const double along = dot(weak.twist, s.twist);
    if (weak.gain > PIECE || 2.0 * along * along < s.square) return Because::reach;
    return abs(gain_rate(arm, weak, s)) > BLUNT ? Because::reach : Because::singularity;
}

// Whether joints at their limits would have to move beyond them to reduce the error.
template <int N> STEP bool against_limits(const TrackedArm<N>& arm, const Stand<N>& s) {
    double square = 0.0;
    for (int k = 0; k < N; ++k) {
        const double gain = dot(s.J[k], s.twist);
        if ((gain > 0.0 && s.q[k] >= arm.upper[k]) || (gain < 0.0 && s.q[k] <= arm.lower[k])) square += gain * gain;
    }
    return square > FELT * FELT * s.square;
}

template <int N> Tracked track(const TrackedArm<N>& arm, TrackedState<N>& state, const double* T) {
    const Tolerances& t = arm.written.tolerances;
    double target[16], proper[16];
    for (int i = 0; i < 16; ++i) target[i] = T[i];
    const double defect = pose_defect(target);
    if (!(defect <= t.rotation)) return {};
    if (defect > t.exact_rotation) project_rotation(target, proper);
    const Goal<double> goal = goal_of(defect > t.exact_rotation ? proper : target);

    Stand<N> start;
    for (int k = 0; k < N; ++k) start.q[k] = state.q[k];
    place_at(arm.written, start);
    face(arm.written, goal, start);
    const Box<N> box = box_of(arm, state);
    double drift[N];
    if constexpr (N > 6) own_motion(arm, start, drift);

    const auto too_fast = [&](const Went& w) { return bool((w.below & ~box.limit_below) | (w.above & ~box.limit_above)); };
    Stand<N> s = start;
    Went went = {};
    const bool far = !within_a_cycle(arm.written, start, box);
    if (!far) went = march(arm.written, goal, start.twist, 1.0, box, drift, s);
    bool hurried = far || (s.size > t.reach && too_fast(went));
    if (hurried) {
        const double aside = affordable(arm, start, box, SINGULAR_ASIDE), strict = affordable(arm, start, box, FAINT);
        const double share = strict > REGULAR * aside ? strict : aside;
        if (far || share < 1.0) s = start, went = march(arm.written, goal, start.twist, share, box, drift, s);
        hurried = share < 1.0 || too_fast(went);
    }
    if (s.size > t.reach && !hurried && apart(arm.written, start, s) < SAME) push(arm.written, goal, box, drift, s);
    Because why = Because::nothing;
    if (s.size > t.reach) {
        why = against_limits(arm, s) ? Because::limit : hurried ? Because::velocity : because_of(arm.written, s, went);
    }
    bool accelerates = false;
    for (const double each : arm.acceleration) accelerates |= each < __builtin_inf();
    if (accelerates) {
        double goal_q[N];
        for (int k = 0; k < N; ++k) goal_q[k] = s.q[k];
        go_after(arm, state, goal_q, s.size <= t.reach, s.q);
        place_at(arm.written, s);
        face(arm.written, goal, s);
        if (why == Because::nothing && s.size > t.reach) why = Because::acceleration;
    }
    Tracked out = {true, Tracking::ok, why, 0.0, 0.0, 0.0, 0.0};
    if (s.size > t.reach) {
        bool still = why != Because::velocity && why != Because::acceleration && apart(arm.written, start, s) < SAME;
        for (int k = 0; k < N; ++k) still &= abs(state.v[k]) <= arm.acceleration[k] * arm.dt;
        if (still) s = start;
        out.status = still ? Tracking::held : Tracking::limited;
    }
    for (int k = 0; k < N; ++k) state.v[k] = (s.q[k] - state.q[k]) / arm.dt, state.q[k] = s.q[k];
    out.distance = arm.written.size * length(s.twist, 0), out.angle = length(s.twist, 3);
    out.distance_before = arm.written.size * length(start.twist, 0), out.angle_before = length(start.twist, 3);
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
