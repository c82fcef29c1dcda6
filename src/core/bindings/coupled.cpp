// Arms in which joints mimic others, from named values.
#include <algorithm>

#include "../families/hollow_wrist_arm.hpp"
#include "solver.hpp"

namespace urdf_ik {

void read(const Values& v, SphericalWristArm& to);

template <int N> void read(const Values& v, Coupled<N>& to) {
    to.axes = v.get<int>("axes");
    if (to.axes < 1 || to.axes > MOST_AXES) throw nb::value_error("too many axes");
    read_motions(v, "steps", to.step, to.axes + 1);
    v.numbers("slides", to.axes, [&](const double* from) {
        for (int k = 0; k < to.axes; ++k) to.slides[k] = from[k] != 0.0;
    });
    v.numbers("gain", std::size_t(N) * to.axes, [&](const double* from) { std::copy_n(from, N * to.axes, &to.gain[0][0]); });
    v.read("unit", to.unit), v.read("period", to.period), v.read("size", to.size);
    read(v.group("tolerances"), to.tolerances);
}

template <int N> class CoupledSolver : public Solver {
public:
    CoupledArm<N> arm{};
    long solve(const Batch& batch) const override {
        // One piece for the whole batch; what the search does not touch costs nothing.
        const std::unique_ptr<double[]> scratch(new double[N * SCRATCH]);
        return level().coupled->solve<N>()(arm, batch, scratch.get());
    }
};

template <int N> Made make_coupled(const Values& v) {
    auto made = std::make_shared<CoupledSolver<N>>();
    CoupledArm<N>& to = made->arm;
    read(v.group("written"), to.written);
    v.read("middle", to.middle), v.read("half", to.half);
    v.numbers("rates", std::size_t(N) * to.written.axes,
              [&](const double* from) { std::copy_n(from, N * to.written.axes, &to.rates[0][0]); });
    to.columns = v.get<int>("columns");
    if (to.columns < 1 || to.columns > MOST_COLUMNS) throw nb::value_error("too many columns");
    made->joints = N, made->branches = to.columns;
    return made;
}

static void read(const Values& v, HollowWristArm& to) {
    read(v.group("written"), to.written), read(v.group("position"), to.position);
    to.samples = v.get<int>("samples");
    if (to.samples < 2 || to.samples > MOST_SAMPLES) throw nb::value_error("too many samples");
    const auto table = [&](const char* name, double* out) {
        v.numbers(name, to.samples, [&](const double* from) { std::copy_n(from, to.samples, out); });
    };
    table("value", to.value), table("cosine", to.cosine), table("along_4", to.along_4), table("along_7", to.along_7);
    v.read("round", to.round), v.read("flange", to.flange), v.read("direction", to.direction);
}

void add_coupled(Makers& makers) {
    makers["coupled, 1"] = make_coupled<1>;
    makers["coupled, 2"] = make_coupled<2>;
    makers["coupled, 3"] = make_coupled<3>;
    makers["coupled, 4"] = make_coupled<4>;
    makers["hollow wrist"] = maker(level().coupled->hollow_wrist, 6, 32);
}

}  // namespace urdf_ik
