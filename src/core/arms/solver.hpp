// The solver of one arm: its numbers, and the functions for this processor's instruction set.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <type_traits>

#include "arms/common.hpp"
#include "certificate/proof.hpp"
#include "levels.hpp"

namespace urdf_ik {

// Immutable; safe from any number of threads at once.
class Solver {
public:
    virtual ~Solver() = default;
    // See SolveArm.
    virtual long solve(const Batch& batch) const = 0;
    // See DistancesOf.
    virtual void distances(const double*, double (&out)[4]) const {
        for (double& each : out) each = __builtin_nan("");
    }

    // What is proven about the solutions of a pose T; false if the solver proves nothing, or T is no rigid motion.
    virtual bool prove(const double*, Proof&) const { return false; }

    int joints = 6, branches = 8;
    int numbers = 16;    // of a target; a pose has sixteen
    int parameters = 0;  // redundancy parameters of each target
};

using SolverPointer = std::shared_ptr<const Solver>;

// The solver of an arm; its value "kind" names the kind. Throws std::invalid_argument.
SolverPointer make_solver(const Values& values);

// Makes the solvers of one kind.
using Maker = std::function<SolverPointer(const Values&)>;
using Makers = std::map<std::string, Maker>;

// A solver made of an arm's numbers and two functions.
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

// The maker of a SolverOf; read(values, arm) fills in the arm's numbers.
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

// A maker that chooses another one by an integer among the values.
inline Maker chosen_by(const char* name, std::map<int, Maker> choices) {
    return [=](const Values& v) {
        const auto chosen = choices.find(v.integer(name));
        if (chosen == choices.end()) throw v.error(name, "no solver has this number");
        return chosen->second(v);
    };
}

// Each function adds the kinds of its file.
void add_closed_forms(Makers& makers);
void add_coupled(Makers& makers);
void add_elimination(Makers& makers);
void add_few_joints(Makers& makers);
void add_one_given(Makers& makers);
void add_reversed(Makers& makers);
void add_srs(Makers& makers);

}  // namespace urdf_ik
