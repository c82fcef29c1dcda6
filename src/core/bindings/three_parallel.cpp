// Arms with three parallel axes after the first, from named values.
#include "solver.hpp"

namespace urdf_ik {

void read(const Values& v, ThreeParallelArm& to) {
    read(v.group("ideal"), to.ideal), read(v.group("written"), to.written);
    v.read("along", to.along), v.read("turn_3", to.turn_3), v.read("turn_4", to.turn_4);
    v.read("cos_first", to.cos_first), v.read("sin_first", to.sin_first), v.read("square_wrist", to.square_wrist);
}

template <Hand kind> std::shared_ptr<const Solver> make_three_parallel(const Values& v) {
    auto made = std::make_shared<SolverOf<ThreeParallelArm>>();
    read(v, made->arm);
    made->function = level().three_parallel->solve[int(kind)];
    made->distances_of = level().three_parallel->distances[int(kind)];
    return made;
}

void add_three_parallel(Makers& makers) {
    makers["three parallel axes, 5x6"] = make_three_parallel<Hand::intersecting_56>;
    makers["three parallel axes, general hand"] = make_three_parallel<Hand::general>;
}

}  // namespace urdf_ik
