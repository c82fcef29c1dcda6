// A solver of the chain from tip to base, made to solve the chain from base to tip.
#include "solver.hpp"

namespace urdf_ik {

class Reversed : public Solver {
public:
    explicit Reversed(std::shared_ptr<const Solver> inner) : inner_(std::move(inner)) {
        joints = inner_->joints, branches = inner_->branches, parameters = inner_->parameters;
        if (joints > MOST_JOINTS || inner_->numbers != 16) throw nb::value_error("only a solver of poses can be reversed");
    }

    long solve(const Batch& batch) const override {
        const ReversedSteps& steps = *level().reversed;
        double T[16 * BUFFER], reference[MOST_JOINTS];
        Batch part = batch;
        part.T = T, part.whole = 0;
        if (batch.q_ref) {
            for (int j = 0; j < joints; ++j) reference[j] = batch.q_ref[joints - 1 - j];
            part.q_ref = reference;
        }
        for (long start = 0; start < batch.m; start += BUFFER) {
            part.m = batch.m - start < BUFFER ? batch.m - start : BUFFER;
            part.q = batch.q + start * branches * joints, part.flags = batch.flags + start * branches;
            part.values = batch.values ? batch.values + parameters * start : nullptr;
            steps.invert_poses(batch.T + 16 * start, part.m, T);
            const long bad = inner_->solve(part);
            if (bad >= 0) return start + bad;
            steps.turn_round(part.m * branches, joints, part.q, part.flags);
        }
        return -1;
    }

private:
    // Poses that are solved in one go: their answers stay in the nearest cache until they are turned round. A multiple of
    // every block's lanes, so that a pose is solved by the same instructions wherever it stands.
    static constexpr long BUFFER = 32;
    static constexpr int MOST_JOINTS = 8;
    std::shared_ptr<const Solver> inner_;
};

static Made make_reversed(const Values& v) { return std::make_shared<Reversed>(solver_in(v.at("solver"))); }

void add_reversed(Makers& makers) { makers["reversed"] = make_reversed; }

}  // namespace urdf_ik
