// Arms whose axes 2, 3 and 4 meet, from named values.
#include "solver.hpp"

namespace urdf_ik {

void read(const Values& v, SphericalMiddleArm& to) {
    read(v.group("ideal"), to.ideal), read(v.group("written"), to.written);
    v.read("centre", to.centre), v.read("centre_5", to.centre_5);
}

template <LastPair kind> std::shared_ptr<const Solver> make_spherical_middle(const Values& v) {
    auto made = std::make_shared<SolverOf<SphericalMiddleArm>>();
    read(v, made->arm);
    made->function = level().spherical_middle->solve[int(kind)];
    return made;
}

void add_spherical_middle(Makers& makers) {
    makers["spherical middle, 5x6"] = make_spherical_middle<LastPair::intersecting>;
    makers["spherical middle, 5||6"] = make_spherical_middle<LastPair::parallel>;
    makers["spherical middle, general wrist"] = make_spherical_middle<LastPair::general>;
}

}  // namespace urdf_ik
