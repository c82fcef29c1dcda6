// S-R-S arms, from named values.
#include "solver.hpp"

namespace urdf_ik {

static void read(const Values& v, MeetingAxes& to) {
    v.read("cos_alpha", to.cos_alpha), v.read("sin_alpha", to.sin_alpha), v.read("cos_beta", to.cos_beta);
    v.read("sin_beta", to.sin_beta), v.read("shift", to.shift), v.read("square", to.square);
}

static void read(const Values& v, SrsArm& to) {
    read(v.group("ideal"), to.ideal), read(v.group("written"), to.written);
    read(v.group("shoulder"), to.shoulder), read(v.group("wrist"), to.wrist);
    v.read("to_frame_3", to.to_frame_3), v.read("from_frame_5", to.from_frame_5);
    v.read("upper", to.upper), v.read("fore", to.fore), v.read("along", to.along), v.read("zero_4", to.zero_4);
    v.read("clamp", to.clamp), v.read("imperfection", to.imperfection), v.read("value", to.value);
}

void add_srs(Makers& makers) {
    makers["S-R-S"] = maker(level().srs->exact, 7, 8, nullptr, 1);
    makers["S-R-S, nearly"] = maker(level().srs->near, 7, 16, nullptr, 1);
}

}  // namespace urdf_ik
