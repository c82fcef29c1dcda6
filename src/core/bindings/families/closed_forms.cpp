// Closed forms of arms with six joints, and arms near their families, from named values.
#include "bindings/families/elimination.hpp"

namespace urdf_ik {

void read(const Values& v, ParallelShoulderArm& to) { read(v.group("ideal"), to.ideal), read(v.group("written"), to.written); }

void read(const Values& v, SphericalMiddleArm& to) {
    read(v.group("ideal"), to.ideal), read(v.group("written"), to.written);
    v.read("centre", to.centre), v.read("centre_5", to.centre_5);
}

void read(const Values& v, SphericalWristArm& to) {
    read(v.group("ideal"), to.ideal), read(v.group("written"), to.written);
    v.read("centre", to.centre), v.read("rho", to.rho), v.read("cos_phi", to.cos_phi), v.read("sin_phi", to.sin_phi);
    v.read("height", to.height), v.read("bend_offset", to.bend_offset), v.read("swing", to.swing);
    v.read("square_wrist", to.square_wrist);
}

void read(const Values& v, ThreeParallelArm& to) {
    read(v.group("ideal"), to.ideal), read(v.group("written"), to.written);
    v.read("along", to.along), v.read("turn_3", to.turn_3), v.read("turn_4", to.turn_4);
    v.read("cos_first", to.cos_first), v.read("sin_first", to.sin_first), v.read("square_wrist", to.square_wrist);
}

template <class Family> void read(const Values& v, ImperfectArm<Family>& arm) {
    read(v.group("family"), arm.family), read(v.group("elimination"), arm.elimination);
    arm.written = arm.both.written = arm.both.ideal = arm.family.written;
    read_motions(v, "inner_steps", arm.both.written.step, 7), read_motions(v, "ideal_steps", arm.both.ideal.step, 7);
    v.read("drift", arm.both.drift);
    arm.family.written.exact = false;
    arm.loose = arm.family;
    arm.family.written.beside = true;
    const double almost = ALMOST_FREE * arm.family.ideal.imperfection;
    arm.loose.written.tolerances.continuum = almost * almost;
}

// Kinds of a family in the order of its enum: their names, their solvers as they are and near them, and what explains them.
template <class Arm, int kinds>
void add(Makers& makers, const char* const (&names)[kinds], const SolveArm<Arm> (&solve)[kinds],
         const SolveArm<ImperfectArm<Arm>> (&near)[kinds], const DistancesOf<Arm>* distances = nullptr) {
    for (int k = 0; k < kinds; ++k) {
        makers[names[k]] = maker(solve[k], 6, 8, distances ? distances[k] : nullptr);
        makers[std::string("imperfect ") + names[k]] = maker(near[k], 6, 16);
    }
}

void add_closed_forms(Makers& makers) {
    const LevelTable& of = level();
    const ImperfectSolvers& near = *of.imperfect;
    const ImperfectSolversToo& near_too = *of.imperfect_too;
    add(makers, {"spherical wrist, 2||3", "spherical wrist, 1x2", "spherical wrist, 1||2", "spherical wrist, general shoulder"},
        of.spherical_wrist->solve, near.spherical_wrist);
    add(makers, {"three parallel axes, 5x6", "three parallel axes, general hand"}, of.three_parallel->solve, near.three_parallel,
        of.three_parallel->distances);
    add(makers,
        {"parallel shoulder, 5x6", "parallel shoulder, 5||6", "parallel shoulder, 4x5", "parallel shoulder, 4||5",
         "parallel shoulder, general wrist"},
        of.parallel_shoulder->solve, near_too.parallel_shoulder, of.parallel_shoulder->distances);
    add(makers, {"spherical middle, 5x6", "spherical middle, 5||6", "spherical middle, general wrist"}, of.spherical_middle->solve,
        near_too.spherical_middle);
}

}  // namespace urdf_ik
