// S-R-S arms, from named values.
#include <algorithm>

#include "solvers/solver.hpp"

namespace urdf_ik {

static void read(const Values& v, MeetingAxes& to) {
    v.read("cos_alpha", to.cos_alpha), v.read("sin_alpha", to.sin_alpha), v.read("cos_beta", to.cos_beta);
    v.read("sin_beta", to.sin_beta), v.read("shift", to.shift), v.read("square", to.square);
}

static void read(const Values& v, SrsArm& to) {
    read(*v.group("ideal"), to.ideal), read(*v.group("written"), to.written);
    read(*v.group("shoulder"), to.shoulder), read(*v.group("wrist"), to.wrist);
    v.read("to_frame_3", to.to_frame_3), v.read("from_frame_5", to.from_frame_5);
    v.read("upper", to.upper), v.read("fore", to.fore), v.read("along", to.along), v.read("zero_4", to.zero_4);
    v.read("clamp", to.clamp), v.read("imperfection", to.imperfection), v.read("off", to.off), v.read("value", to.value);
}

// See together() in closed_forms.cpp: here the place of the wrist, the law of cosines, and a wrist behind it; the arm's own numbers
// are exact to `exact_structure`.
static void bound_margins(SrsArm& to) {
    const MeetingAxes &s = to.shoulder, &w = to.wrist;
    const double steep = std::min(std::fabs(s.sin_alpha * s.sin_beta), std::fabs(w.sin_alpha * w.sin_beta)), size = to.written.size,
                 links = size * size / (2.0 * to.upper * to.fore);
    const double error = to.written.tolerances.exact_structure * 8.0 * (16.0 * links) * (20.0 / (steep * steep));
    to.together = error * error;
}

class SrsSolver : public SolverOf<SrsArm> {
public:
    using SolverOf::SolverOf;
    void redundancy_of(const double* q, const double*, const double*, double* values) const override {
        double at[7];
        for (int j = 0; j < 7; ++j) at[j] = q[j];
        values[0] = level().srs->swivel_of(arm, at);
    }
};

void add_srs(Makers& makers) {
    makers["S-R-S"] = [](const Values& v) {
        const bool near = v.number("imperfection") > 0.0;
        auto made = std::make_shared<SrsSolver>(near ? level().srs->near : level().srs->exact);
        read(v, made->arm);
        bound_margins(made->arm);
        made->joints = 7, made->branches = near ? 16 : 8, made->parameters = 1;
        return made;
    };
}

}  // namespace urdf_ik
