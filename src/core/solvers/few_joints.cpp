// Arms with few joints and arms with slides, from named values.
#include "solvers/solver.hpp"
#include "solvers/wrapped.hpp"

namespace urdf_ik {

static void read(const Values& v, PositionStep& to) {
    v.read("slides", to.slides), v.read("directions", to.direction), v.read("points", to.point), v.read("X", to.X);
}

static void read(const Values& v, FewJointsWay& to) {
    read(*v.group("step"), to.step);
    v.read("reversed", to.reversed), v.read("turns", to.turns), v.read("axes", to.axis), v.read("joints", to.joint);
    v.read("home", to.home), v.read("in_tip", to.in_tip);
}

template <int N> static void read(const Values& v, FewJointsArm<N>& to) {
    read(*v.group("written"), to.written);
    read(*v.group("way"), to.way[0]);
    to.ways = v.has("spare") ? 2 : 1;
    if (to.ways > 1) read(*v.group("spare"), to.way[1]);
}

template <int N> static void read(const Values& v, PlanarArm<N>& to) {
    read(v, static_cast<FewJointsArm<N>&>(to));
    read(*v.group("ideal"), to.ideal);
    v.read("links", to.link), v.read("angles", to.angle), v.read("bend", to.bend);
    v.read("signs", to.sign), v.read("joints", to.joint);
}

static void read(const Values& v, SlidesArm& to) {
    read(*v.group("written"), to.written);
    to.by_wrist = v.has("step");
    if (to.by_wrist) read(*v.group("step"), to.step), v.read("in_tip", to.in_tip);
    v.read("turns", to.turn), v.read("first", to.first), v.read("last", to.last), v.read("home", to.home);
    v.read("ca", to.ca), v.read("sa", to.sa), v.read("cb", to.cb), v.read("sb", to.sb), v.read("bend", to.bend);
    v.read("clamp", to.clamp), v.read("imperfection", to.imperfection);
}

static void read(const Values& v, SampledArm& to) { read(*v.group("written"), to.written); }

static void read(const Values& v, SampledHeldArm& to) {
    read(*v.group("written"), to.written);
    v.read("held", to.held), v.read("value", to.value);
    if (to.held < 0 || to.held > 6) throw v.error("held", "one of seven joints is held");
}

class SampledHeld : public SolverOf<SampledHeldArm> {
public:
    using SolverOf::SolverOf;
    void redundancy_of(const double* q, const double*, const double*, double* values) const override {
        values[0] = principal_value(q[arm.held], !arm.written.slides[arm.held]);
    }
};

static SolverPointer make_sampled_held(const Values& v) {
    auto made = std::make_shared<SampledHeld>(level().few_joints->sampled_held);
    read(v, made->arm);
    made->joints = 7, made->branches = 16, made->parameters = 1;
    return made;
}

static SolverPointer make_planar_points(const Values& v) {
    auto made = std::make_shared<SolverOf<PlanarArm<2>>>(level().few_joints->planar_points);
    read(v, made->arm);
    made->joints = made->branches = made->numbers = 2;
    return made;
}

// An arm of five joints, solved as an arm of six.
class Completed : public Solver {
public:
    std::shared_ptr<const Solver> six;
    CompletedArm arm{};
    std::string_view image() const override { return image_of(arm); }

    long solve(const Batch& batch) const override {
        return solve_completed(
            arm, {6, six->branches, 0}, [this](const Batch& part) { return six->solve(part); }, *level().few_joints, batch);
    }
};

static SolverPointer make_completed(const Values& v) {
    auto made = std::make_shared<Completed>();
    made->six = make_solver(*v.group("six"));
    read(*v.group("written"), made->arm.written);
    v.read("at", made->arm.at), v.read("columns", made->arm.columns);
    made->joints = 5, made->branches = made->arm.columns;
    if (made->six->joints != 6 || made->six->branches > MOST_COLUMNS_OF_SIX)
        throw v.error("six", "a solver of six joints is needed");
    return made;
}

void add_few_joints(Makers& makers) {
    const FewJointsSolvers& of = *level().few_joints;
    const Maker three = chosen_by("columns", {{2, maker(of.three_in_plane, 3, 2)}, {4, maker(of.three, 3, 4)}});
    makers["few joints"] = chosen_by(
        "joints",
        {{1, maker(of.one, 1, 1)}, {2, maker(of.two, 2, 2)}, {3, three}, {4, maker(of.four, 4, 4)}, {5, maker(of.five, 5, 8)}});
    makers["planar"] =
        chosen_by("number", {{2, maker(of.planar_2, 2, 2)}, {3, maker(of.planar_3, 3, 2)}, {4, maker(of.planar_4, 4, 2)}});
    makers["planar points"] = make_planar_points;
    makers["slides"] =
        chosen_by("columns", {{2, maker(of.slides_2, 6, 2)}, {4, maker(of.slides_4, 6, 4)}, {8, maker(of.slides_8, 6, 8)}});
    makers["sampled"] = maker(of.sampled, 6, 16);
    makers["sampled with one held"] = make_sampled_held;
    makers["completed"] = make_completed;
}

}  // namespace urdf_ik
