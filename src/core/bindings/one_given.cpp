// A solver with one value more to be given: of the first or the last joint beside those that it solves, or of a rotation
// about an axis of the tip, which belongs to no joint. The value moves the target; the joints solved stay the same arm.
#include "solver.hpp"

namespace urdf_ik {

class OneGiven : public Solver {
public:
    GivenJoint given;
    bool inserted;  // whether the value is a joint's, and stands in the joint vectors
    std::shared_ptr<const Solver> others;

    static constexpr int MOST = 128, ROWS = 1024;  // poses, and solutions, of a part
    static constexpr int MOST_JOINTS = 9, MOST_PARAMETERS = 4;

    // Part by part, so that what is moved and inserted stays in the cache.
    long solve(const Batch& batch) const override {
        if (!inserted && !batch.values) return others->solve(batch);
        double T[16 * (MOST + MOST_LANES)], values[MOST], rest[MOST * MOST_PARAMETERS], q[MOST_JOINTS * ROWS];
        const OneGivenSolvers& step = *level().one_given;
        double near[MOST_JOINTS];
        const int skipped = !inserted || given.last ? others->joints : given.before < 0 ? 0 : given.before;
        for (int j = 0; batch.q_ref && j < others->joints; ++j) near[j] = batch.q_ref[j + (j >= skipped)];
        const long at_once = ROWS / branches < MOST ? ROWS / branches : MOST;
        for (long start = 0; start < batch.m; start += at_once) {
            Batch part = batch;
            part.m = batch.m - start < at_once ? batch.m - start : at_once;
            part.T += 16 * start, part.flags += branches * start, part.q += long(joints) * branches * start;
            if (part.values) {
                const double* from = batch.values + parameters * start;
                for (long i = 0; i < part.m; ++i, from += parameters) {
                    values[i] = from[0];
                    for (int k = 1; k < parameters; ++k) rest[(parameters - 1) * i + k - 1] = from[k];
                }
                part.values = values;
            }
            step.move(given, part, T, values);
            const double* reference = part.q_ref ? near : nullptr;
            const double* theirs = batch.values && others->parameters ? rest : nullptr;
            const long bad = others->solve({T, part.m, reference, theirs, inserted ? q : part.q, part.flags, batch.beyond});
            if (bad >= 0) return start + bad;
            if (inserted) step.insert(given, part, q, values, others->joints, branches);
        }
        return -1;
    }
};

static Made make(const Values& v, bool inserted) {
    auto made = std::make_shared<OneGiven>();
    made->others = solver_in(v.at("solver"));
    const Solver& others = *made->others;
    made->joints = others.joints + inserted, made->branches = others.branches, made->parameters = others.parameters + 1;
    if (others.numbers != 16 || others.branches > 64 || others.joints > OneGiven::MOST_JOINTS ||
        made->parameters > OneGiven::MOST_PARAMETERS) {
        throw nb::value_error("a solver of poses with fewer joints or parameters is needed");
    }
    v.read("motion", made->given.motion), v.read("turns", made->given.turns), v.read("last", made->given.last);
    made->given.before = -1, made->given.opposite = false;
    if (v.has("before")) v.read("before", made->given.before), v.read("opposite", made->given.opposite);
    if (made->given.before >= others.joints) throw nb::value_error("the joint that is given stands before another one");
    v.read("value", made->given.value);
    made->inserted = inserted;
    return made;
}

void add_one_given(Makers& makers) {
    makers["one joint given"] = [](const Values& v) { return make(v, true); };
    makers["axis free"] = [](const Values& v) { return make(v, false); };
}

}  // namespace urdf_ik
