// What Python holds of an arm: an opaque, immutable solver, made from named values, which are also what is pickled.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <type_traits>

#include "bindings/levels.hpp"
#include "bindings/values.hpp"

namespace urdf_ik {

class Solver {
public:
    virtual ~Solver() = default;
    // See SolveArm. Safe from any number of threads at once.
    virtual long solve(const Batch& batch) const = 0;
    // See DistancesOf.
    virtual void distances(const double*, double (&out)[4]) const {
        for (double& each : out) each = __builtin_nan("");
    }

    int joints = 6, branches = 8;
    int numbers = 16;    // a target's: a pose has sixteen
    int parameters = 0;  // values that are given with each target, for what it leaves free
};

// The solver that a Python object holds, for solvers that are built upon others: solver_in(values.at(name)).
std::shared_ptr<const Solver> solver_in(nb::handle object);

// Named values to a solver.
using Made = std::shared_ptr<const Solver>;
using Maker = std::function<Made(const Values&)>;

// A solver that is an arm's numbers and functions of this instruction set.
template <class Arm> class SolverOf : public Solver {
public:
    SolverOf(SolveArm<Arm> function, DistancesOf<Arm> distances_of) : function_(function), distances_of_(distances_of) {}
    Arm arm{};
    long solve(const Batch& batch) const override { return function_(arm, batch); }
    void distances(const double* seen, double (&out)[4]) const override {
        if (distances_of_) distances_of_(arm, seen, out);
        else Solver::distances(seen, out);
    }

private:
    const SolveArm<Arm> function_;
    const DistancesOf<Arm> distances_of_;
};

// Makes such solvers; read(values, arm) fills the arm's numbers in.
template <class Arm>
Maker maker(SolveArm<Arm> function, int joints, int branches, std::type_identity_t<DistancesOf<Arm>> distances = nullptr,
            int parameters = 0) {
    return [=](const Values& v) {
        auto made = std::make_shared<SolverOf<Arm>>(function, distances);
        read(v, made->arm);
        made->joints = joints, made->branches = branches, made->parameters = parameters;
        return made;
    };
}

// The steps of the solvers one by one, for tests.
void bind_steps(nb::module_& m);

// Every kind of solver by its name in Python.
using Makers = std::map<std::string, Maker>;
void add_closed_forms(Makers& makers);
void add_coupled(Makers& makers);
void add_one_given(Makers& makers);
void add_chain(nb::module_& m);
void add_images(nb::module_& m);
void add_tracker(nb::module_& m);
void add_path_graph(nb::module_& m);
void add_self_motion(nb::module_& m);
void add_elimination(Makers& makers);
void add_few_joints(Makers& makers);
void add_reversed(Makers& makers);
void add_srs(Makers& makers);

}  // namespace urdf_ik
