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
    long solve(const Batch& batch) const override { return function(arm, batch); }
};

// Every kind of solver by its name in Python, with what makes it from named values.
using Maker = std::shared_ptr<const Solver> (*)(const Values&);
using Makers = std::map<std::string, Maker>;
void add_spherical_wrist(Makers& makers);
void add_srs(Makers& makers);

}  // namespace urdf_ik
