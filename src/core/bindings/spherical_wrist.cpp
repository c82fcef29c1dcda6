// Arms with a spherical wrist, from named values.
#include "solver.hpp"

namespace urdf_ik {

void read(const Values& v, SphericalWristArm& to) {
    read(v.group("ideal"), to.ideal), read(v.group("written"), to.written);
    v.read("centre", to.centre), v.read("rho", to.rho), v.read("cos_phi", to.cos_phi), v.read("sin_phi", to.sin_phi);
    v.read("height", to.height), v.read("bend_offset", to.bend_offset), v.read("swing", to.swing);
    v.read("square_wrist", to.square_wrist);
}

template <Shoulder kind> std::shared_ptr<const Solver> make_spherical_wrist(const Values& v) {
    auto made = std::make_shared<SolverOf<SphericalWristArm>>();
    read(v, made->arm);
    made->function = level().spherical_wrist->solve[int(kind)];
    return made;
}

void add_spherical_wrist(Makers& makers) {
    makers["spherical wrist, 2||3"] = make_spherical_wrist<Shoulder::parallel_23>;
    makers["spherical wrist, 1x2"] = make_spherical_wrist<Shoulder::intersecting_12>;
    makers["spherical wrist, 1||2"] = make_spherical_wrist<Shoulder::parallel_12>;
    makers["spherical wrist, general shoulder"] = make_spherical_wrist<Shoulder::general>;
}

}  // namespace urdf_ik
