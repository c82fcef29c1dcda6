// Bindings of single solver steps for tests. They are in no wheel; see steps.hpp.
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include "bindings/python_values.hpp"
#include "processor.hpp"
#include "solvers/common.hpp"
#include "steps.hpp"

namespace urdf_ik {

namespace v2 { extern const Steps steps; }
namespace v3 { extern const Steps steps; }
namespace v4 { extern const Steps steps; }
namespace arm64 { extern const Steps steps; }

// As in levels.cpp.
static constexpr const Steps* ALL[] = {
#if defined(URDF_IK_BUILT_V2)
    &v2::steps,
#endif
#if defined(URDF_IK_BUILT_V3)
    &v3::steps,
#endif
#if defined(URDF_IK_BUILT_V4)
    &v4::steps,
#endif
#if defined(URDF_IK_BUILT_ARM64)
    &arm64::steps,
#endif
};

using Sets = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Results = nb::ndarray<nb::numpy, double, nb::ndim<2>>;
using Pose = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Vector = nb::ndarray<double, nb::shape<6>, nb::c_contig, nb::device::cpu>;

static Results step(const std::string& name, const Sets& x, bool side_by_side) {
    const Steps& steps = in_use(ALL);
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

static double polish(nb::object written, const Pose& T, const Vector& q, bool damped, int rounds) {
    Written<6> arm{};
    read(PythonValues(written, "written"), arm);
    return in_use(ALL).polish(arm, T.data(), q.data(), damped, rounds);
}

}  // namespace urdf_ik

NB_MODULE(_core_steps, m) {
    using namespace urdf_ik;
    m.doc() = "Steps of the compiled solvers, for tests.";
    m.def("step", &step, nb::arg("name"), nb::arg("x").noconvert(), nb::arg("side_by_side") = false,
          "One step: sets of its inputs (m, k) to sets of its results, one by one or in blocks.");
    m.def("polish", &polish, nb::arg("written"), nb::arg("T").noconvert(), nb::arg("q").noconvert(), nb::arg("damped"),
          nb::arg("rounds"), "Newton's method on an arm as written: q (6,) is replaced; returns its error.");
}
