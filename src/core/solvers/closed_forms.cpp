// Closed forms of arms with six joints, and arms near their families, from named values.
#include <cmath>

#include "numbers/thresholds.hpp"
#include "solvers/elimination.hpp"
#include "solvers/solver.hpp"

namespace urdf_ik {

constexpr const char* SHOULDERS[] = {"2||3", "1x2", "1||2", "general"};
constexpr const char* HANDS[] = {"5x6", "general"};
constexpr const char* LAST_AXES[] = {"5x6", "5||6", "4x5", "4||5", "general"};
constexpr const char* LAST_PAIRS[] = {"5x6", "5||6", "general"};

// The index of the word "variant" in a list in the order of the family's enum.
template <int count> int variant_of(const Values& v, const char* const (&names)[count]) {
    const std::string variant = v.word("variant");
    for (int k = 0; k < count; ++k) {
        if (variant == names[k]) return k;
    }
    throw v.error("variant", "no solver is called '" + variant + "'");
}

// Bounds of the errors of a closed form's margins and angles, for Clear: `first`, `links` and `wrist` are the greatest factors by
// which an arm's own numbers enlarge the errors of the step of joint 1, of a planar arm's law of cosines and of a wrist. The rest
// follows from the derivatives of each step for vectors no longer than the arm's size: 4 for a swing, 8 for the law of cosines, 10
// for a wrist that three turns precede; doubled, for terms of second order.
static double together(double first, double links, double wrist) {
    const double error = ROUNDING * (8.0 * first) * (16.0 * links) * (20.0 * wrist);
    return error * error;
}

void read(const Values& v, ParallelShoulderArm& to) {
    read(*v.group("ideal"), to.ideal), read(*v.group("written"), to.written);
    const double *a = to.ideal.a, *s = to.ideal.sin_alpha, size = to.ideal.size, swung = s[2] * s[2] * s[3];
    double first = 1.0, second = 1.0;  // of the steps of joints 4 and 6, the same for a tilt and for an offset
    switch (static_cast<LastAxes>(variant_of(v, LAST_AXES))) {
        case LastAxes::intersecting_56:
            first = size / (s[2] * std::hypot(a[3], to.ideal.d[3] * s[3])), second = 1.0 / s[4];
            break;
        case LastAxes::parallel_56:
            first = 1.0 / swung, second = size / a[4];
            break;
        case LastAxes::intersecting_45:
            first = size / std::hypot(a[4], to.ideal.d[3] * s[4]), second = 1.0 / swung;
            break;
        case LastAxes::parallel_45:
            first = 1.0 / s[4], second = size / (a[3] * s[2]);
            break;
        case LastAxes::general:
            break;
    }
    // Joint 5 adds up the errors of both, and the turn of joints 1 to 3 those of all three; 8 times an error of the second.
    to.ideal.together = together(first, size * size / (2.0 * a[0] * a[1]), 8.0 * second);
}

void read(const Values& v, SphericalMiddleArm& to) {
    read(*v.group("ideal"), to.ideal), read(*v.group("written"), to.written);
    v.read("centre", to.centre), v.read("centre_5", to.centre_5);
    const double *s = to.ideal.sin_alpha, *g = to.centre_5, size = to.ideal.size, wrist = 1.0 / (s[1] * s[2]);
    const double reach = std::hypot(g[0], g[1]), steep = size / std::hypot(to.centre[0], to.centre[1]);
    // Joints 5 and 6: of a planar arm, or of a circle about axis 5 seen along axis 6.
    const bool parallel = static_cast<LastPair>(variant_of(v, LAST_PAIRS)) == LastPair::parallel;
    const double links = parallel ? 2.0 * to.ideal.a[4] * reach : s[4] * reach * reach;
    to.ideal.together = together(steep, size * size / links, wrist * wrist);
}

void read(const Values& v, SphericalWristArm& to) {
    read(*v.group("ideal"), to.ideal), read(*v.group("written"), to.written);
    v.read("centre", to.centre), v.read("rho", to.rho), v.read("cos_phi", to.cos_phi), v.read("sin_phi", to.sin_phi);
    v.read("height", to.height), v.read("bend_offset", to.bend_offset), v.read("swing", to.swing);
    v.read("square_wrist", to.square_wrist);
    const double *s = to.ideal.sin_alpha, size = to.ideal.size, steep = 1.0 / std::fabs(s[0]), wrist = 1.0 / (s[3] * s[4]);
    const double links = size * size / (2.0 * to.ideal.a[1] * to.rho), swing = std::fabs(to.swing[0]) * size;
    switch (static_cast<Shoulder>(variant_of(v, SHOULDERS))) {
        case Shoulder::parallel_23:
            to.ideal.together = together(steep, links, wrist * wrist);
            break;
        case Shoulder::intersecting_12:
            to.ideal.together = together(swing * size, steep, wrist * wrist);
            break;
        case Shoulder::parallel_12:
            to.ideal.together = together(swing, size / (2.0 * to.ideal.a[0]), wrist * wrist);
            break;
        case Shoulder::general:
            break;
    }
}

void read(const Values& v, ThreeParallelArm& to) {
    read(*v.group("ideal"), to.ideal), read(*v.group("written"), to.written);
    v.read("along", to.along), v.read("turn_3", to.turn_3), v.read("turn_4", to.turn_4);
    v.read("cos_first", to.cos_first), v.read("sin_first", to.sin_first), v.read("square_wrist", to.square_wrist);
    const auto& ideal = to.ideal;
    const double wrist = 1.0 / (to.sin_first * ideal.sin_alpha[4]),
                 links = ideal.size * ideal.size / (2.0 * ideal.a[1] * ideal.a[2]);
    to.ideal.together = together(1.0 / std::fabs(ideal.sin_alpha[0]), links, wrist * wrist);
}

template <class Family> void read(const Values& v, ImperfectArm<Family>& arm) {
    read(*v.group("family"), arm.family), read(*v.group("elimination"), arm.elimination);
    arm.written = arm.both.written = arm.both.ideal = arm.family.written;
    read_motions(v, "inner_steps", arm.both.written.step, 7), read_motions(v, "ideal_steps", arm.both.ideal.step, 7);
    arm.family.written.exact = false;
}

// Add a family to `makers`, and the solvers of arms near it to `imperfect`.
template <class Arm, int count>
void add(Makers& makers, Makers& imperfect, const char* kind, const char* const (&names)[count],
         const FamilySolvers<Arm, count>& of) {
    makers[kind] = [&](const Values& v) { return maker(of.solve[variant_of(v, names)], 6, 8)(v); };
    imperfect[kind] = [&](const Values& v) { return maker(of.near[variant_of(*v.group("family"), names)], 6, 16)(v); };
}

void add_closed_forms(Makers& makers) {
    const LevelTable& of = level();
    Makers imperfect;
    add(makers, imperfect, "spherical wrist", SHOULDERS, *of.spherical_wrist);
    add(makers, imperfect, "three parallel axes", HANDS, *of.three_parallel);
    add(makers, imperfect, "parallel shoulder", LAST_AXES, *of.parallel_shoulder);
    add(makers, imperfect, "spherical middle", LAST_PAIRS, *of.spherical_middle);
    makers["imperfect"] = [imperfect](const Values& v) {
        const std::string kind = v.group("family")->word("kind");
        const auto found = imperfect.find(kind);
        if (found == imperfect.end()) throw v.error("family", "'" + kind + "' has no solver of arms near it");
        return found->second(v);
    };
}

}  // namespace urdf_ik
