// See elimination.hpp.
#include "arms/elimination.hpp"

#include "arms/solver.hpp"

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

static void read(const Values& values, Continuation& to) {
    to.solutions = values.integer("solutions"), to.poses = values.integer("poses");
    if (to.poses < 0 || to.poses > Continuation::most) throw values.error("poses", "at most 16 known poses");
    if (to.solutions < 0 || to.solutions > KnownPose::most) throw values.error("solutions", "at most 16 of a known pose");
    for (int i = 0; i < to.poses; ++i) {
        const auto part = [&](const char* name, auto& member) { read_part(values, name, to.poses, i, member); };
        part("turn", to.known[i].turn), part("point", to.known[i].point);
        part("solution", reinterpret_cast<double (&)[KnownPose::most][6][2]>(to.known[i].solution));
    }
}

void read_common(const Values& values, EliminationArm& to) {
    read(*values.group("written"), to.written);
    read_motions(values, "home_inverse", &to.home_inverse, 1);
    values.read("centre", to.centre), values.read("scale", to.scale);
    to.any_slide = false;
    for (const bool slides : to.written.slides) to.any_slide |= slides;
    read(*values.group("known"), to.paths);
}

void read(const Values& values, EliminationArm& to) {
    read_common(values, to);
    read_variant(*values.group("variant"), 1, 0, to.variant);
    read_variant(*values.group("counter"), 1, 0, to.counter);
    const auto rest = values.group("counter_rest");
    rest->read("left", to.counter_rest.left), rest->read("right", to.counter_rest.right);
    rest->read("inexact", to.counter_rest.inexact);
    to.counter_apart = to.counter.first != to.variant.first || to.counter.reversed != to.variant.reversed ||
                       to.counter.inexact[0] != to.variant.inexact[0];
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
