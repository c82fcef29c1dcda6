// Seven joints, one of which is given, around the solver of the six others.
#include "solver.hpp"

namespace urdf_ik {

class OneGiven : public Solver {
public:
    GivenJoint given;
    std::shared_ptr<const Solver> six;

    // Part by part, so that what is moved and inserted stays in the cache.
    long solve(const Batch& batch) const override {
        constexpr int MOST = 128, ROWS = 1024;  // poses, and solutions, of a part
        double T[16 * (MOST + MOST_LANES)], values[MOST], q[6 * ROWS];
        const OneGivenSolvers& step = *level().one_given;
        double reference[6];
        for (int j = 0; batch.q_ref && j < 6; ++j) reference[j] = batch.q_ref[j + (j >= given.at)];
        const long at_once = ROWS / branches < MOST ? ROWS / branches : MOST;
        for (long start = 0; start < batch.m; start += at_once) {
            Batch part = batch;
            part.m = batch.m - start < at_once ? batch.m - start : at_once;
            part.T += 16 * start, part.flags += branches * start, part.q += 7L * branches * start;
            if (part.values) part.values += start;
            step.move(given, part, T, values);
            const long bad = six->solve({T, part.m, batch.q_ref ? reference : nullptr, nullptr, q, part.flags});
            if (bad >= 0) return start + bad;
            step.insert(given, part, q, values, branches);
        }
        return -1;
    }
};

static Made make_one_given(const Values& v) {
    auto made = std::make_shared<OneGiven>();
    made->six = solver_in(v.at("solver"));
    if (made->six->joints != 6 || made->six->branches > 64) throw nb::value_error("a solver of six joints is needed");
    v.read("motion", made->given.motion), v.read("turns", made->given.turns), v.read("last", made->given.last);
    v.read("at", made->given.at), v.read("partner", made->given.partner), v.read("opposite", made->given.opposite);
    if (made->given.at < 0 || made->given.at > 6 || made->given.partner > 6) throw nb::value_error("one of seven joints is given");
    v.read("value", made->given.value);
    made->joints = 7, made->branches = made->six->branches;
    return made;
}

void add_one_given(Makers& makers) { makers["one joint given"] = make_one_given; }

}  // namespace urdf_ik
