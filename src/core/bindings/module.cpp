// urdf_ik._core: the Python module of the compiled solvers.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "bindings/answer.hpp"
#include "bindings/module.hpp"
#include "bindings/sharing.hpp"

namespace urdf_ik {

using Numbers = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Targets = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Answers = nb::ndarray<double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

using Seen = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;

static long solve(const PySolver& self, const Targets& T, const std::optional<Numbers>& q_ref, const Answers& q, const Flags& flags,
                  const std::optional<Numbers>& values, int threads, bool beyond) {
    const Solver& solver = *self.solver;
    const std::size_t m = T.ndim() ? T.shape(0) : 0, branches = solver.branches, joints = solver.joints;
    if (T.size() != m * solver.numbers || q.shape(0) != m || q.shape(1) != branches || q.shape(2) != joints ||
        flags.shape(0) != m || flags.shape(1) != branches || (q_ref && q_ref->shape(0) != joints) ||
        (values && values->shape(0) != m * solver.parameters)) {
        throw nb::value_error("arrays of poses and answers do not fit each other");
    }
    const Batch batch = {T.data(),     long(m), q_ref ? q_ref->data() : nullptr, values ? values->data() : nullptr, q.data(),
                         flags.data(), beyond};
    return without_gil([&](const Stop& stop) { return solve_shared(solver, batch, threads, stop); });
}

// The fields of Proof in Python; complex numbers as pairs.
static nb::object prove(const PySolver& self, const Seen& T) {
    const auto proof = std::make_unique<Proof>();
    if (!self.solver->prove(T.data(), *proof)) return nb::none();
    const auto array = [](const double* from, std::initializer_list<std::size_t> shape) {
        std::size_t size = 1;
        for (const std::size_t each : shape) size *= each;
        auto* copy = new double[size];
        std::copy(from, from + size, copy);
        const nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<double*>(p); });
        return nb::cast(nb::ndarray<nb::numpy, double>(copy, shape, owner));
    };
    const std::size_t roots = proof->roots;
    nb::list real;
    for (std::size_t i = 0; i < roots; ++i) real.append(proof->real[i]);
    nb::dict out;
    out["expected"] = proof->expected.many, out["why"] = int(proof->expected.why), out["status"] = int(proof->status);
    out["roots"] = array(&proof->root[0][0][0], {roots, 6, 2}), out["real"] = real;
    out["inner"] = array(proof->inner, {roots}), out["outer"] = array(proof->outer, {roots});
    return out;
}

}  // namespace urdf_ik

NB_MODULE(_core, m) {
    using namespace urdf_ik;
    m.doc() = "The compiled solvers.";
    // A caller may still hold arms when Python ends. nanobind would print a warning for each.
    nb::set_leak_warnings(false);
    level();  // throws if URDF_IK_ISA names an instruction set that was not built or that this processor does not run
    m.def("isa", [] { return std::string(level().name); }, "The instruction set in use.");
    m.def("levels", &levels_built, "The instruction sets that were built and that this processor runs.");
    bind_elimination(m);
    bind_answer(m);
    bind_chain(m);
    bind_images(m);
    bind_tracker(m);
    bind_path_graph(m);
    bind_self_motion(m);
    nb::class_<PySolver>(m, "Solver", "An arm, ready to be solved; immutable.")
        .def(nb::init<nb::object>(), nb::arg("arm"))
        .def_ro("arm", &PySolver::arm, "The dataclass that it was made from.")
        .def_prop_ro("joints", [](const PySolver& s) { return s.solver->joints; })
        .def_prop_ro("branches", [](const PySolver& s) { return s.solver->branches; })
        .def_prop_ro(
            "numbers", [](const PySolver& s) { return s.solver->numbers; }, "How many numbers a target has.")
        .def_prop_ro(
            "parameters", [](const PySolver& s) { return s.solver->parameters; },
            "How many redundancy parameters are given with each target.")
        .def("__reduce__",
             [](nb::handle self) {
                 const auto& s = nb::cast<const PySolver&>(self);
                 return nb::make_tuple(nb::type<PySolver>(), nb::make_tuple(s.arm));
             })
        // nanobind's fastest call takes arguments without names and without None.
        .def("one",
             [](const PySolver& s, nb::handle kind, nb::handle arm, nb::handle branches, nb::handle T) {
                 nb::object made = solve_one(s, kind, arm, branches, T, nb::none());
                 return made.is_none() ? solve_many(s, kind, arm, branches, T, nb::none(), nb::none(), 1, nb::none()) : made;
             })
        .def("one_near", &solve_one)
        .def("many", &solve_many, nb::arg("kind"), nb::arg("arm"), nb::arg("branches"), nb::arg("T"), nb::arg("q_ref").none(),
             nb::arg("values").none(), nb::arg("threads"), nb::arg("out").none())
        .def(
            "image", [](const PySolver& s) { return nb::bytes(s.solver->image().data(), s.solver->image().size()); },
            "The bytes of the struct with the arm's numbers.")
        .def("prove", &prove, nb::arg("T").noconvert(), "What is proven about a pose's solutions; None: nothing.")
        .def("solve", &solve, nb::arg("T").noconvert(), nb::arg("q_ref").noconvert().none(), nb::arg("q").noconvert(),
             nb::arg("flags").noconvert(), nb::arg("values").noconvert().none() = nb::none(), nb::arg("threads") = 1,
             nb::arg("beyond") = false);
}
