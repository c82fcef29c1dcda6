// The steps of the solvers one by one, for tests; see steps.hpp.
#include "steps.hpp"

#include <cstring>

#include "bindings/levels.hpp"
#include "bindings/values.hpp"

namespace urdf_ik {

using Sets = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Results = nb::ndarray<nb::numpy, double, nb::ndim<2>>;
using Pose = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Vector = nb::ndarray<double, nb::shape<6>, nb::c_contig, nb::device::cpu>;

static Results step(const std::string& name, const Sets& x, bool side_by_side) {
    const Steps& steps = *level().steps;
    for (int k = 0; k < steps.count; ++k) {
        const Step& each = steps.all[k];
        if (name != each.name) continue;
        if (x.shape(1) != std::size_t(each.inputs) || (side_by_side && !each.many))
            throw nb::value_error("these numbers do not fit that step");
        const std::size_t sets = x.shape(0), outputs = each.outputs;
        auto* out = new double[sets * outputs]();
        nb::capsule owner(out, [](void* p) noexcept { delete[] static_cast<double*>(p); });
        if (side_by_side) each.many(x.data(), out, long(sets));
        else
            for (std::size_t i = 0; i < sets; ++i) each.one(x.data() + each.inputs * i, out + outputs * i);
        return Results(out, {sets, outputs}, owner);
    }
    throw nb::value_error(("no step is called '" + name + "'").c_str());
}

static double polish(const nb::dict& written, const Pose& T, const Vector& q, bool damped, int rounds) {
    Written<6> arm{};
    read(Values(written, "written"), arm);
    return level().steps->polish(arm, T.data(), q.data(), damped, rounds);
}

void bind_steps(nb::module_& m) {
    m.def("step", &step, nb::arg("name"), nb::arg("x").noconvert(), nb::arg("side_by_side") = false,
          "One step of the solvers, for tests: sets of its inputs (m, k) to sets of its results, one by one or in blocks.");
    m.def("polish", &polish, nb::arg("written"), nb::arg("T").noconvert(), nb::arg("q").noconvert(), nb::arg("damped"),
          nb::arg("rounds"), "Newton's method on an arm as written, for tests: q (6,) is replaced; returns its error.");
}

}  // namespace urdf_ik
