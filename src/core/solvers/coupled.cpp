// Arms in which joints mimic others, from named values.
#include "families/mimics/hollow_wrist_arm.hpp"
#include "solvers/solver.hpp"

namespace urdf_ik {

void read(const Values& v, SphericalWristArm& to);

template <int N> void read(const Values& v, Coupled<N>& to) {
    to.axes = v.integer("axes");
    if (to.axes < 1 || to.axes > MOST_AXES) throw v.error("axes", "too many");
    read_motions(v, "steps", to.step, to.axes + 1);
    v.read("slides", to.slides, to.axes), v.read("gain", &to.gain[0][0], std::size_t(N) * to.axes);
    v.read("unit", to.unit), v.read("period", to.period), v.read("size", to.size);
    read(*v.group("tolerances"), to.tolerances);
}

template <int N> class CoupledSolver : public Solver {
public:
    CoupledArm<N> arm{};
    std::string_view image() const override { return image_of(arm); }
    long solve(const Batch& batch) const override {
        // Allocated once per batch. Uninitialised: pages that the search does not touch cost nothing.
        const std::unique_ptr<double[]> scratch(new double[N * SCRATCH]);
        return level().coupled->solve<N>()(arm, batch, scratch.get());
    }
};

template <int N> SolverPointer make_coupled(const Values& v) {
    auto made = std::make_shared<CoupledSolver<N>>();
    CoupledArm<N>& to = made->arm;
    read(*v.group("written"), to.written);
    v.read("middle", to.middle), v.read("half", to.half);
    v.read("rates", &to.rates[0][0], std::size_t(N) * to.written.axes);
    to.columns = v.integer("columns");
    if (to.columns < 1 || to.columns > MOST_COLUMNS) throw v.error("columns", "too many");
    made->joints = N, made->branches = to.columns;
    return made;
}

static void read(const Values& v, HollowWristArm& to) {
    read(*v.group("written"), to.written), read(*v.group("position"), to.position);
    to.samples = v.integer("samples");
    if (to.samples < 2 || to.samples > MOST_SAMPLES) throw v.error("samples", "too many");
    v.read("value", to.value, to.samples), v.read("cosine", to.cosine, to.samples);
    v.read("along_4", to.along_4, to.samples), v.read("along_7", to.along_7, to.samples);
    v.read("flange", to.flange), v.read("direction", to.direction);
}

void add_coupled(Makers& makers) {
    makers["coupled"] =
        chosen_by("joints", {{1, make_coupled<1>}, {2, make_coupled<2>}, {3, make_coupled<3>}, {4, make_coupled<4>}});
    makers["hollow wrist"] = maker(level().coupled->hollow_wrist, 6, 32);
}

}  // namespace urdf_ik
