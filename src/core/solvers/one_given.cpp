// A solver with one more redundancy parameter: the value of a joint that the inner solver does not have, or a rotation about an
// axis of the tip. The value moves the target; the inner solver solves the other joints.
#include "solvers/solver.hpp"
#include "solvers/wrapped.hpp"

namespace urdf_ik {

class OneGiven : public Solver {
public:
    GivenJoint given{};
    bool inserted;  // whether the value is a joint's and is inserted into the joint vectors
    std::shared_ptr<const Solver> others;

    // Parts of which the moved targets and the solutions stay in the cache.
    static constexpr int MOST = 128, ROWS = 1024;

    Inner inner() const { return {others->joints, others->branches, others->parameters}; }
    long solve(const Batch& batch) const override {
        return solve_one_given<MOST, ROWS>(
            given, inserted, inner(), [this](const Batch& part) { return others->solve(part); }, *level().one_given, batch);
    }

    std::string_view image() const override { return image_of(given); }

    void redundancy_of(const double* q, const double* T, const double* reached, double* values) const override {
        double rest[MOST_JOINTS_BESIDE];
        without_given(given, inserted, inner(), q, rest);
        values[0] = inserted ? principal_value(q[place_of(given, inner())], given.turns) : angle_between(T, reached);
        // A joint that is given moves the target; the rotation about a free axis has moved it to the pose that is reached.
        others->redundancy_of(rest, inserted ? T : reached, reached, values + 1);
    }

private:
    // The angle of the rotation about the free axis that leads from the pose T to `reached`, or nearest to it: the rotation is
    // R = d d^T + (1 - d d^T) cos + [d] sin, and motion[2] holds [d].
    double angle_between(const double* T, const double* reached) const {
        const auto& cross = given.motion[2];
        const double d[3] = {cross[2][1], cross[0][2], cross[1][0]};
        double R[3][3] = {}, sine = 0.0, trace = 0.0, along = 0.0;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                for (int k = 0; k < 3; ++k) R[i][j] += T[4 * k + i] * reached[4 * k + j];
                along += d[i] * R[i][j] * d[j];
            }
            trace += R[i][i];
        }
        for (int i = 0; i < 3; ++i) sine += d[i] * (R[(i + 2) % 3][(i + 1) % 3] - R[(i + 1) % 3][(i + 2) % 3]);
        return std::atan2(sine, trace - along);
    }
};

static SolverPointer make(const Values& v, bool inserted) {
    auto made = std::make_shared<OneGiven>();
    made->others = make_solver(*v.group("solver"));
    const Solver& others = *made->others;
    made->joints = others.joints + inserted, made->branches = others.branches, made->parameters = others.parameters + 1;
    if (others.numbers != 16 || others.branches > 64 || others.joints > MOST_JOINTS_BESIDE || made->parameters > MOST_PARAMETERS) {
        throw v.error("solver", "a solver of poses with fewer joints or parameters is needed");
    }
    v.read("motion", made->given.motion), v.read("turns", made->given.turns), v.read("last", made->given.last);
    made->given.before = -1, made->given.opposite = false;
    if (v.has("before")) v.read("before", made->given.before), v.read("opposite", made->given.opposite);
    if (made->given.before >= others.joints) throw v.error("before", "no such joint");
    v.read("value", made->given.value);
    made->inserted = inserted;
    return made;
}

void add_one_given(Makers& makers) {
    makers["one joint given"] = [](const Values& v) { return make(v, true); };
    makers["axis free"] = [](const Values& v) { return make(v, false); };
}

}  // namespace urdf_ik
