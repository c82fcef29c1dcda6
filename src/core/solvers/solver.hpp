// The solver of one arm: its numbers, and the functions for this processor's instruction set.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string_view>
#include <type_traits>

#include "certify/proof.hpp"
#include "levels.hpp"
#include "numbers/angles.hpp"
#include "solvers/common.hpp"

namespace urdf_ik {

// Immutable; safe from any number of threads at once.
class Solver {
public:
    virtual ~Solver() = default;
    // See SolveArm.
    virtual long solve(const Batch& batch) const = 0;
    // The values (parameters) of the redundancy parameters for which solve() gives the joint vector q for the pose T; `reached` is
    // the tip's pose at q. Poses are row by row.
    virtual void redundancy_of(const double* /*q*/, const double* /*T*/, const double* /*reached*/, double* /*values*/) const {}

    // The bytes of the struct with the arm's numbers, as they are in memory; of an arm that is solved by another solver, of its own
    // numbers alone.
    virtual std::string_view image() const { return {}; }

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

// See Solver::image.
template <class Arm> std::string_view image_of(const Arm& arm) {
    static_assert(std::is_trivially_copyable_v<Arm>);
    return {reinterpret_cast<const char*>(&arm), sizeof arm};
}

// A solver made of an arm's numbers and a function.
template <class Arm> class SolverOf : public Solver {
public:
    explicit SolverOf(SolveArm<Arm> function) : function_(function) {}
    Arm arm{};
    long solve(const Batch& batch) const override { return function_(arm, batch); }
    std::string_view image() const override { return image_of(arm); }

private:
    const SolveArm<Arm> function_;
};

// The maker of a SolverOf; read(values, arm) fills in the arm's numbers.
template <class Arm> Maker maker(SolveArm<Arm> function, int joints, int branches) {
    return [=](const Values& v) {
        auto made = std::make_shared<SolverOf<Arm>>(function);
        read(v, made->arm);
        made->joints = joints, made->branches = branches;
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
