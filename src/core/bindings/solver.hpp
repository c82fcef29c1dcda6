// What Python holds of an arm: an opaque, immutable solver, made from named values, which are also what is pickled.
#pragma once

#include <map>
#include <memory>

#include "levels.hpp"
#include "values.hpp"

namespace urdf_ik {

class Solver {
public:
    virtual ~Solver() = default;
    // All solutions of a batch. Returns the index of the first that is no pose, -1 where all are. Safe from any number
    // of threads at once.
    virtual long solve(const Batch& batch) const = 0;
    // For explanations: the distances [m] that a pose, as seen from the solver's frame 1 (4, 4), asks two axes to have;
    // up to four, NaN where there is none.
    virtual void distances(const double*, double (&out)[4]) const {
        for (double& each : out) each = __builtin_nan("");
    }

    int joints = 6, branches = 8;
    int numbers = 16;  // a target's: a pose has sixteen
};

// The solver that a Python object holds, for solvers that are built upon others: solver_in(values.at(name)).
std::shared_ptr<const Solver> solver_in(nb::handle object);

// A solver that is an arm's numbers and a function of this instruction set.
template <class Arm> class SolverOf : public Solver {
public:
    long (*function)(const Arm&, const Batch&) = nullptr;
    Arm arm{};
    void (*distances_of)(const Arm&, const double*, double (&)[4]) = nullptr;
    long solve(const Batch& batch) const override { return function(arm, batch); }
    void distances(const double* seen, double (&out)[4]) const override {
        if (distances_of) distances_of(arm, seen, out);
        else Solver::distances(seen, out);
    }
};

// The steps of the solvers one by one, for tests.
void bind_steps(nb::module_& m);

// Every kind of solver by its name in Python, with what makes it from named values.
using Maker = std::shared_ptr<const Solver> (*)(const Values&);
using Makers = std::map<std::string, Maker>;
void add_coupled(Makers& makers);
void add_one_given(Makers& makers);
void add_chain(nb::module_& m);
void add_parallel_shoulder(Makers& makers);
void add_elimination(Makers& makers);
void add_few_joints(Makers& makers);
void add_imperfect(Makers& makers);
void add_reversed(Makers& makers);
void add_spherical_middle(Makers& makers);
void add_spherical_wrist(Makers& makers);
void add_srs(Makers& makers);
void add_three_parallel(Makers& makers);

}  // namespace urdf_ik
