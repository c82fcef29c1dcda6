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

static void read(const Values& v, SampledArm& to) { read(v.group("written"), to.written); }

static void read(const Values& v, SampledHeldArm& to) {
    read(v.group("written"), to.written);
    v.read("held", to.held), v.read("value", to.value);
    if (to.held < 0 || to.held > 6) throw nb::value_error("the joint that is held is one of seven");
}

// The maker of many that a value chooses.
static Maker by(const char* name, std::map<int, Maker> choices) {
    return [=](const Values& v) {
        const auto chosen = choices.find(v.get<int>(name));
        if (chosen == choices.end()) throw nb::value_error((std::string("no solver has such ") + name).c_str());
        return chosen->second(v);
    };
}

static Made make_planar_points(const Values& v) {
    auto made = std::make_shared<SolverOf<PlanarArm<2>>>(level().few_joints->planar_points, nullptr);
    read(v, made->arm);
    made->joints = made->branches = made->numbers = 2;
    return made;
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

static Made make_completed(const Values& v) {
    auto made = std::make_shared<Completed>();
    made->six = solver_in(v.at("six"));
    read(v.group("written"), made->arm.written);
    v.read("at", made->arm.at), v.read("columns", made->arm.columns);
    made->joints = 5, made->branches = made->arm.columns;
    if (made->six->joints != 6 || made->six->branches > Completed::MOST) throw nb::value_error("a solver of six joints is needed");
    return made;
}

void add_few_joints(Makers& makers) {
    const FewJointsSolvers& of = *level().few_joints;
    const Maker three = by("columns", {{2, maker(of.three_in_plane, 3, 2)}, {4, maker(of.three, 3, 4)}});
    makers["few joints"] =
        by("joints",
           {{1, maker(of.one, 1, 1)}, {2, maker(of.two, 2, 2)}, {3, three}, {4, maker(of.four, 4, 4)}, {5, maker(of.five, 5, 8)}});
    makers["planar"] = by("number", {{2, maker(of.planar_2, 2, 2)}, {3, maker(of.planar_3, 3, 2)}, {4, maker(of.planar_4, 4, 2)}});
    makers["planar points"] = make_planar_points;
    makers["slides"] = by("columns", {{2, maker(of.slides_2, 6, 2)}, {4, maker(of.slides_4, 6, 4)}, {8, maker(of.slides_8, 6, 8)}});
    makers["sampled"] = maker(of.sampled, 6, 16);
    makers["sampled, one held"] = maker(of.sampled_held, 7, 16, nullptr, 1);
    makers["completed"] = make_completed;
}

}  // namespace urdf_ik
