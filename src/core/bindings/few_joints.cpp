// Arms with few joints and arms with slides, from named values.
#include <algorithm>

#include "solver.hpp"

namespace urdf_ik {

static void read(const Values& v, PositionStep& to) {
    v.read("slides", to.slides), v.read("directions", to.direction), v.read("points", to.point), v.read("X", to.X);
}

static void read(const Values& v, FewJointsWay& to) {
    read(v.group("step"), to.step);
    v.read("reversed", to.reversed), v.read("turns", to.turns), v.read("axes", to.axis), v.read("joints", to.joint);
    v.read("home", to.home), v.read("in_tip", to.in_tip);
}

template <int N> static void read(const Values& v, FewJointsArm<N>& to) {
    read(v.group("written"), to.written);
    read(v.group("way"), to.way[0]);
    to.ways = v.has("spare") ? 2 : 1;
    if (to.ways > 1) read(v.group("spare"), to.way[1]);
}

template <int N> static void read(const Values& v, PlanarArm<N>& to) {
    read(v, static_cast<FewJointsArm<N>&>(to));
    read(v.group("ideal"), to.ideal);
    v.read("links", to.link), v.read("angles", to.angle), v.read("bend", to.bend);
    v.read("signs", to.sign), v.read("joints", to.joint);
}

static void read(const Values& v, SlidesArm& to) {
    read(v.group("written"), to.written);
    to.by_wrist = v.has("step");
    if (to.by_wrist) read(v.group("step"), to.step), v.read("in_tip", to.in_tip);
    v.read("turns", to.turn), v.read("first", to.first), v.read("last", to.last), v.read("home", to.home);
    v.read("ca", to.ca), v.read("sa", to.sa), v.read("cb", to.cb), v.read("sb", to.sb), v.read("bend", to.bend);
    v.read("clamp", to.clamp), v.read("imperfection", to.imperfection);
}

template <class Arm> static std::shared_ptr<SolverOf<Arm>> made(const Values& v, SolveArm<Arm> function, int joints, int branches) {
    auto solver = std::make_shared<SolverOf<Arm>>();
    read(v, solver->arm);
    solver->function = function, solver->joints = joints, solver->branches = branches;
    return solver;
}

static std::shared_ptr<const Solver> make_few_joints(const Values& v) {
    const FewJointsSolvers& solvers = *level().few_joints;
    switch (v.get<int>("joints")) {
        case 1:
            return made(v, solvers.one, 1, 1);
        case 2:
            return made(v, solvers.two, 2, 2);
        case 3:
            return v.get<int>("columns") == 2 ? made(v, solvers.three_in_plane, 3, 2) : made(v, solvers.three, 3, 4);
        case 4:
            return made(v, solvers.four, 4, 4);
        case 5:
            return made(v, solvers.five, 5, 8);
        default:
            throw nb::value_error("few joints are one to five");
    }
}

static std::shared_ptr<const Solver> make_planar(const Values& v) {
    const FewJointsSolvers& solvers = *level().few_joints;
    switch (v.get<int>("number")) {
        case 2:
            return made(v, solvers.planar_2, 2, 2);
        case 3:
            return made(v, solvers.planar_3, 3, 2);
        case 4:
            return made(v, solvers.planar_4, 4, 2);
        default:
            throw nb::value_error("planar arms have two to four joints");
    }
}

static std::shared_ptr<const Solver> make_planar_points(const Values& v) {
    auto solver = made(v, level().few_joints->planar_points, 2, 2);
    solver->numbers = 2;
    return solver;
}

static std::shared_ptr<const Solver> make_slides(const Values& v) {
    const FewJointsSolvers& solvers = *level().few_joints;
    switch (v.get<int>("columns")) {
        case 2:
            return made(v, solvers.slides_2, 6, 2);
        case 4:
            return made(v, solvers.slides_4, 6, 4);
        case 8:
            return made(v, solvers.slides_8, 6, 8);
        default:
            throw nb::value_error("arms with slides have two, four or eight columns");
    }
}

// An arm of five joints by way of the solver of six: a number of poses at a time.
class Completed : public Solver {
public:
    std::shared_ptr<const Solver> six;
    CompletedArm arm{};

    long solve(const Batch& batch) const override {
        double q_ref[6] = {}, q[SHARE * MOST * 6];
        std::uint8_t flags[SHARE * MOST];
        for (int k = 0; batch.q_ref && k < 5; ++k) q_ref[arm.at + k] = batch.q_ref[k];
        for (long start = 0; start < batch.m; start += SHARE) {
            Batch part = {batch.T + 16 * start, std::min(SHARE, batch.m - start), batch.q_ref ? q_ref : nullptr, nullptr, q, flags};
            const long bad = six->solve(part);
            if (bad >= 0) return start + bad;
            part.q = batch.q + 5 * branches * start, part.flags = batch.flags + branches * start, part.q_ref = batch.q_ref;
            level().few_joints->completed(arm, part, {q, flags, six->branches});
        }
        return -1;
    }
    static constexpr long SHARE = 32;
    static constexpr int MOST = 32;  // columns of the arm of six
};

static std::shared_ptr<const Solver> make_completed(const Values& v) {
    auto solver = std::make_shared<Completed>();
    solver->six = solver_in(v.at("six"));
    read(v.group("written"), solver->arm.written);
    v.read("at", solver->arm.at), v.read("columns", solver->arm.columns);
    solver->joints = 5, solver->branches = solver->arm.columns;
    if (solver->six->joints != 6 || solver->six->branches > Completed::MOST) {
        throw nb::value_error("a solver of six joints is needed");
    }
    return solver;
}

void add_few_joints(Makers& makers) {
    makers["few joints"] = make_few_joints;
    makers["planar"] = make_planar;
    makers["planar points"] = make_planar_points;
    makers["slides"] = make_slides;
    makers["completed"] = make_completed;
}

}  // namespace urdf_ik
