// See elimination.hpp.
#include "solvers/elimination.hpp"

#include "solvers/solver.hpp"

namespace urdf_ik {

// Read element `index` of an array with first dimension `parts`.
template <class T> static void read_part(const Values& values, const char* name, int parts, int index, T& to) {
    using Number = std::remove_all_extents_t<T>;
    constexpr std::size_t count = sizeof(T) / sizeof(Number);
    std::vector<double> all(count * parts);
    values.read(name, all.data(), all.size());
    Number* out = reinterpret_cast<Number*>(&to);
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<Number>(all[count * index + i]);
}

void read_variant(const Values& values, int variants, int index, EliminationVariant& to) {
    const auto part = [&](const char* name, auto& member) { read_part(values, name, variants, index, member); };
    part("first", to.first), part("reversed", to.reversed);
    part("left", to.left), part("right", to.right), part("left_inverse", to.left_inverse);
    part("slides", to.slides), part("axes", to.axes), part("points", to.points), part("across", to.across);
    part("inexact", to.inexact);
}

void read_common(const Values& values, EliminationArm& to) {
    read(*values.group("written"), to.written);
    read_motions(values, "home_inverse", &to.home_inverse, 1);
    values.read("centre", to.centre), values.read("scale", to.scale);
    to.any_slide = false;
    for (const bool slides : to.written.slides) to.any_slide |= slides;
    to.near = values.number("near") != 0.0;
}

void read(const Values& values, EliminationArm& to) {
    read_common(values, to);
    const auto rows = values.group("variant");
    to.variants = int(rows->array("first").size());
    if (to.variants < 1 || to.variants > 3) throw rows->error("first", "one to three variants are needed");
    for (int i = 0; i < to.variants; ++i) read_variant(*rows, to.variants, i, to.variant[i]);
    read_variant(*values.group("counter"), 1, 0, to.counter);
    const auto rest = values.group("counter_rest");
    rest->read("left", to.counter_rest.left), rest->read("right", to.counter_rest.right);
    rest->read("inexact", to.counter_rest.inexact);
}

namespace {

class EliminationSolver : public SolverOf<EliminationArm> {
public:
    EliminationSolver() : SolverOf(level().elimination->solve) { joints = 6, branches = 16; }
    bool prove(const double* T, Proof& out) const override { return level().elimination->prove(arm, T, out); }
};

}  // namespace

void add_elimination(Makers& makers) {
    makers["elimination"] = [](const Values& v) {
        auto made = std::make_shared<EliminationSolver>();
        read(v, made->arm);
        return made;
    };
}

}  // namespace urdf_ik
