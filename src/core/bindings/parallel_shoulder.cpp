// Arms whose first three axes are parallel, from named values.
#include "solver.hpp"

namespace urdf_ik {

void read(const Values& v, ParallelShoulderArm& to) { read(v.group("ideal"), to.ideal), read(v.group("written"), to.written); }

template <LastAxes kind> std::shared_ptr<const Solver> make_parallel_shoulder(const Values& v) {
    auto made = std::make_shared<SolverOf<ParallelShoulderArm>>();
    read(v, made->arm);
    made->function = level().parallel_shoulder->solve[int(kind)];
    made->distances_of = level().parallel_shoulder->distances[int(kind)];
    return made;
}

void add_parallel_shoulder(Makers& makers) {
    makers["parallel shoulder, 5x6"] = make_parallel_shoulder<LastAxes::intersecting_56>;
    makers["parallel shoulder, 5||6"] = make_parallel_shoulder<LastAxes::parallel_56>;
    makers["parallel shoulder, 4x5"] = make_parallel_shoulder<LastAxes::intersecting_45>;
    makers["parallel shoulder, 4||5"] = make_parallel_shoulder<LastAxes::parallel_45>;
    makers["parallel shoulder, general wrist"] = make_parallel_shoulder<LastAxes::general>;
}

}  // namespace urdf_ik
