// Bindings for choosing an arm's elimination when the arm is loaded.
#include <memory>
#include <vector>

#include "bindings/module.hpp"
#include "bindings/python_values.hpp"
#include "preparation.hpp"
#include "solvers/elimination.hpp"

namespace urdf_ik {

using PoseStack = nb::ndarray<const double, nb::shape<-1, 4, 4>, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// For each variant and pose: the number of solutions found by this variant alone, and whether it is certain of them.
static void try_elimination(nb::object object, nb::object variants_object, const PoseStack& T, const Bytes& counts,
                            const Bytes& certain) {
    const PythonValues values(object, "elimination"), rows(variants_object, "variants");
    const int variants = int(certain.shape(0));
    if (certain.shape(1) != T.shape(0) || counts.shape(0) != certain.shape(0) || counts.shape(1) != certain.shape(1)) {
        throw nb::value_error("arrays of poses and answers do not fit each other");
    }
    const auto arm = std::make_unique<EliminationArm>();
    std::vector<EliminationVariant> all(variants);
    read_common(values, *arm);
    for (int v = 0; v < variants; ++v) read_variant(rows, variants, v, all[v]);
    nb::gil_scoped_release release;
    plain::elimination_preparation.trial(*arm, all.data(), variants, T.data(), long(T.shape(0)), {counts.data(), certain.data()});
}

void bind_elimination(nb::module_& m) {
    m.def("try_elimination", &try_elimination, nb::arg("setup"), nb::arg("variants"), nb::arg("T").noconvert(),
          nb::arg("counts").noconvert(), nb::arg("certain").noconvert());
}

}  // namespace urdf_ik
