// Solves the chain from base to tip with a solver of the chain from tip to base.
#include "solvers/solver.hpp"
#include "solvers/wrapped.hpp"

namespace urdf_ik {

class Reversed : public Solver {
public:
    explicit Reversed(std::shared_ptr<const Solver> inner) : inner_(std::move(inner)) {
        joints = inner_->joints, branches = inner_->branches, parameters = inner_->parameters;
        if (joints > MOST_REVERSED_JOINTS || inner_->numbers != 16)
            throw std::invalid_argument("only a solver of poses can be reversed");
    }

    long solve(const Batch& batch) const override {
        return solve_reversed(
            {joints, branches, parameters}, [this](const Batch& part) { return inner_->solve(part); }, *level().reversed, batch);
    }

private:
    std::shared_ptr<const Solver> inner_;
};

static SolverPointer make_reversed(const Values& v) { return std::make_shared<Reversed>(make_solver(*v.group("solver"))); }

void add_reversed(Makers& makers) { makers["reversed"] = make_reversed; }

}  // namespace urdf_ik
