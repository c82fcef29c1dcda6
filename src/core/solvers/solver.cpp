// All kinds of solvers, by name.
#include "solvers/solver.hpp"

namespace urdf_ik {

static const Makers& makers() {
    static const Makers all = [] {
        Makers m;
        add_closed_forms(m);
        add_coupled(m);
        add_elimination(m);
        add_few_joints(m);
        add_one_given(m);
        add_reversed(m);
        add_srs(m);
        return m;
    }();
    return all;
}

SolverPointer make_solver(const Values& values) {
    const std::string kind = values.word("kind");
    const auto found = makers().find(kind);
    if (found == makers().end()) throw values.error("kind", "no solver is called '" + kind + "'");
    return found->second(values);
}

}  // namespace urdf_ik
