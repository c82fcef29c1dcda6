// See steps.hpp. Compiled once for every instruction set.
#include "steps.hpp"

#include "arm/linked_angles.hpp"
#include "arm/subproblems.hpp"
#include "arm/target.hpp"
#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A step for a block: one set of inputs per lane.
template <int IN, int OUT, void (*step)(const Block*, Block*)> void side_by_side(const double* in, double* out, long sets) {
    for (long first = 0; first < sets; first += BLOCK) {
        Block x[IN], y[OUT];
        for (int i = 0; i < BLOCK; ++i) {
            const long set = first + i < sets ? first + i : sets - 1;
            for (int k = 0; k < IN; ++k) set_lane(x[k], i, in[IN * set + k]);
        }
        step(x, y);
        for (int i = 0; i < BLOCK && first + i < sets; ++i) {
            for (int k = 0; k < OUT; ++k) out[OUT * (first + i) + k] = lane(y[k], i);
        }
    }
}

template <class V> void do_atan2(const V* in, V* out) { out[0] = atan2(in[0], in[1]); }
template <class V> void do_wrap(const V* in, V* out) { out[0] = wrap(in[0]); }
template <class V> void do_cos_sin(const V* in, V* out) {
    const Turn<V> t = cos_sin(in[0]);
    out[0] = t.c, out[1] = t.s;
}
template <class V> void do_inverse(const V* in, V* out) {
    out[0] = inverse(in[0]), out[1] = inverse_sqrt(in[0]), out[2] = root(in[0]);
}
template <class V> void do_swing(const V* in, V* out) {
    const Swing<V> s = swing_to_offset(in[0], in[1], in[2], in[3]);
    out[0] = s.turn.c, out[1] = s.turn.s, out[2] = s.X, out[3] = s.margin;
}
template <class V> void do_elbow(const V* in, V* out) {
    // The side is a sign of the arm, the same in all lanes.
    const Elbow<V> e = elbow(in[0], in[1], in[2], in[3], lane(in[4], 0), in[5]);
    out[0] = e.second.c, out[1] = e.second.s, out[2] = e.bend.c, out[3] = e.bend.s, out[4] = e.margin;
}
void do_wrist_bend(const double* in, double* out) {
    const Bend<double> b = wrist_bend(Vec<double>{in[0], in[1], in[2]}, {in[3], in[4], in[5], in[6]}, in[7]);
    out[0] = b.turn.c, out[1] = b.turn.s, out[2] = b.margin;
}
// In: columns of the rotation, the bend, the twists, whether the first turn is held, the held turn.
void do_wrist_turns(const double* in, double* out) {
    const Rot<double> M = {{in[0], in[1], in[2]}, {in[3], in[4], in[5]}, {in[6], in[7], in[8]}};
    const WristTurns<double> t =
        wrist_turns(M, Turn<double>{in[9], in[10]}, {in[11], in[12], in[13], in[14]}, in[15] != 0.0, Turn<double>{in[16], in[17]});
    out[0] = t.first.c, out[1] = t.first.s, out[2] = t.last.c, out[3] = t.last.s, out[4] = t.fixed, out[5] = t.error;
}

// Out: the number of roots, then (cos, sin) of four.
void give(const Quartic& roots, double* out) {
    out[0] = roots.count;
    for (int k = 0; k < 4; ++k) out[1 + 2 * k] = roots.root[k].c, out[2 + 2 * k] = roots.root[k].s;
}
void do_trigonometric_roots(const double* in, double* out) { give(trigonometric_roots({in[0], in[1], in[2], in[3], in[4]}), out); }
void do_linked_roots(const double* in, double* out) { give(linked_roots({in[0], in[1], in[2]}, {in[3], in[4], in[5]}), out); }
// In: the extreme, the sine's affine function, the number of roots, four roots.
void do_sharpen_roots(const double* in, double* out) {
    Quartic roots = {};
    roots.count = int(in[8]);
    for (int k = 0; k < 4; ++k) roots.root[k] = {in[9 + 2 * k], in[10 + 2 * k]};
    sharpen_roots({{in[0], in[1]}, in[2], in[3], in[4]}, {in[5], in[6], in[7]}, roots);
    give(roots, out);
}
// In: real and imaginary parts of the coefficients, from the constant up. Out: those of the roots.
template <int N> void do_self_inversive_roots(const double* in, double* out) {
    Complex c[N + 1], z[N];
    for (int k = 0; k <= N; ++k) c[k] = {in[2 * k], in[2 * k + 1]};
    self_inversive_roots<N>(c, z);
    for (int k = 0; k < N; ++k) out[2 * k] = z[k].re, out[2 * k + 1] = z[k].im;
}
void do_project_rotation(const double* in, double* out) {
    double proper[16];
    project_rotation(in, proper);
    for (int k = 0; k < 16; ++k) out[k] = proper[k];
}
template <class V> void do_pose_defect(const V* in, V* out) {
    V t[16];
    for (int k = 0; k < 16; ++k) t[k] = in[k];
    out[0] = pose_defect(t);
}
// In: two poses (4, 4), goal and tip, and one over the arm's size. Out: the twist and its size.
void do_pose_error(const double* in, double* out) {
    const Error<double> e = pose_error(goal_of(in), goal_of(in + 16), in[32]);
    for (int k = 0; k < 6; ++k) out[k] = e.twist[k];
    out[6] = e.size;
}

// A Jacobian's columns, one after the other.
template <int N, class V> void load_columns(const V* in, Six<V> (&J)[N]) {
    for (int j = 0; j < N; ++j) {
        for (int i = 0; i < 6; ++i) J[j][i] = in[6 * j + i];
    }
}
// In: the columns, the error, the damping. Out: the step and the bound on the smallest singular value.
template <int N, class V> void do_least_squares(const V* in, V* out) {
    Six<V> J[N], e;
    load_columns<N>(in, J);
    for (int i = 0; i < 6; ++i) e[i] = in[6 * N + i];
    const Solved<N, V> s = least_squares<true>(J, e, in[6 * N + 6]);
    for (int j = 0; j < N; ++j) out[j] = s.x[j];
    out[N] = s.least;
}
void do_weakest(const double* in, double* out) {
    Six<double> J[6];
    load_columns<6>(in, J);
    const Weakest<6> w = weakest(J);
    out[0] = w.value;
    for (int j = 0; j < 6; ++j) out[1 + j] = w.direction[j];
}

double do_polish(const Written<6>& arm, const double* T, double* q, bool damped, int rounds) {
    const Goal<double> goal = goal_of(T);
    double at[6];
    for (int j = 0; j < 6; ++j) at[j] = q[j];
    const Course course = {rounds, 0.0, LONG_PATIENCE};
    const double error = (damped ? polish_one<true>(arm, goal, at, course) : polish_one<false>(arm, goal, at, course)).error;
    for (int j = 0; j < 6; ++j) q[j] = at[j];
    return error;
}

#define URDF_IK_BOTH(name, in, out, step) {name, in, out, step<double>, side_by_side<in, out, step<Block>>}
static constexpr Step all[] = {
    URDF_IK_BOTH("atan2", 2, 1, do_atan2),
    URDF_IK_BOTH("wrap", 1, 1, do_wrap),
    URDF_IK_BOTH("cos_sin", 1, 2, do_cos_sin),
    URDF_IK_BOTH("inverse", 1, 3, do_inverse),
    URDF_IK_BOTH("swing_to_offset", 4, 4, do_swing),
    URDF_IK_BOTH("elbow", 6, 5, do_elbow),
    URDF_IK_BOTH("pose_defect", 16, 1, do_pose_defect),
    {"wrist_bend", 8, 3, do_wrist_bend, nullptr},
    {"wrist_turns", 18, 6, do_wrist_turns, nullptr},
    {"trigonometric_roots", 5, 9, do_trigonometric_roots, nullptr},
    {"linked_roots", 6, 9, do_linked_roots, nullptr},
    {"sharpen_roots", 17, 9, do_sharpen_roots, nullptr},
    {"self_inversive_roots_4", 10, 8, do_self_inversive_roots<4>, nullptr},
    {"self_inversive_roots_16", 34, 32, do_self_inversive_roots<16>, nullptr},
    {"project_rotation", 16, 16, do_project_rotation, nullptr},
    {"pose_error", 33, 7, do_pose_error, nullptr},
    {"least_squares_5", 37, 6, do_least_squares<5, double>, side_by_side<37, 6, do_least_squares<5, Block>>},
    {"least_squares_6", 43, 7, do_least_squares<6, double>, side_by_side<43, 7, do_least_squares<6, Block>>},
    {"least_squares_7", 49, 8, do_least_squares<7, double>, nullptr},
    {"weakest", 36, 7, do_weakest, nullptr},
};
#undef URDF_IK_BOTH

extern const Steps steps = {URDF_IK_TEXT(URDF_IK_LEVEL), all, int(sizeof all / sizeof all[0]), do_polish};

}  // namespace urdf_ik::URDF_IK_LEVEL
