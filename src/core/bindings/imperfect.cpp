// Arms near a family, from the family's named values and the elimination's.
#include "elimination.hpp"

namespace urdf_ik {

void read(const Values& v, ParallelShoulderArm& to);
void read(const Values& v, SphericalMiddleArm& to);
void read(const Values& v, SphericalWristArm& to);
void read(const Values& v, ThreeParallelArm& to);

template <class FamilyArm> std::shared_ptr<const Solver> make_near(const Values& v, SolveImperfect<FamilyArm> function) {
    auto made = std::make_shared<SolverOf<ImperfectArm<FamilyArm>>>();
    auto& arm = made->arm;
    read(v.group("family"), arm.family), read(v.group("elimination"), arm.elimination);
    arm.written = arm.both.written = arm.both.ideal = arm.family.written;
    read_motions(v, "inner_steps", arm.both.written.step, 7), read_motions(v, "ideal_steps", arm.both.ideal.step, 7);
    v.read("drift", arm.both.drift);
    arm.family.written.exact = false;
    arm.loose = arm.family;
    arm.family.written.beside = true;
    const double almost = ALMOST_FREE * arm.family.ideal.imperfection;
    arm.loose.written.tolerances.continuum = almost * almost;
    made->function = function;
    made->branches = 16;
    return made;
}

template <Shoulder kind> std::shared_ptr<const Solver> make(const Values& v) {
    return make_near(v, level().imperfect->spherical_wrist[int(kind)]);
}
template <Hand kind> std::shared_ptr<const Solver> make(const Values& v) {
    return make_near(v, level().imperfect->three_parallel[int(kind)]);
}
template <LastAxes kind> std::shared_ptr<const Solver> make(const Values& v) {
    return make_near(v, level().imperfect_too->parallel_shoulder[int(kind)]);
}
template <LastPair kind> std::shared_ptr<const Solver> make(const Values& v) {
    return make_near(v, level().imperfect_too->spherical_middle[int(kind)]);
}

void add_imperfect(Makers& makers) {
    makers["imperfect spherical wrist, 2||3"] = make<Shoulder::parallel_23>;
    makers["imperfect spherical wrist, 1x2"] = make<Shoulder::intersecting_12>;
    makers["imperfect spherical wrist, 1||2"] = make<Shoulder::parallel_12>;
    makers["imperfect spherical wrist, general shoulder"] = make<Shoulder::general>;
    makers["imperfect three parallel axes, 5x6"] = make<Hand::intersecting_56>;
    makers["imperfect three parallel axes, general hand"] = make<Hand::general>;
    makers["imperfect parallel shoulder, 5x6"] = make<LastAxes::intersecting_56>;
    makers["imperfect parallel shoulder, 5||6"] = make<LastAxes::parallel_56>;
    makers["imperfect parallel shoulder, 4x5"] = make<LastAxes::intersecting_45>;
    makers["imperfect parallel shoulder, 4||5"] = make<LastAxes::parallel_45>;
    makers["imperfect parallel shoulder, general wrist"] = make<LastAxes::general>;
    makers["imperfect spherical middle, 5x6"] = make<LastPair::intersecting>;
    makers["imperfect spherical middle, 5||6"] = make<LastPair::parallel>;
    makers["imperfect spherical middle, general wrist"] = make<LastPair::general>;
}

}  // namespace urdf_ik
