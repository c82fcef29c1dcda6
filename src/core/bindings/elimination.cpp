// Bindings for choosing an arm's elimination when the arm is loaded.
#include <algorithm>
#include <memory>
#include <vector>

#include "arms/elimination.hpp"
#include "bindings/module.hpp"
#include "bindings/python_values.hpp"
#include "preparation.hpp"

namespace urdf_ik {

using PoseStack = nb::ndarray<const double, nb::shape<-1, 4, 4>, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using JointVectors = nb::ndarray<const double, nb::shape<-1, 6>, nb::c_contig, nb::device::cpu>;

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
    preparation().elimination->trial(*arm, all.data(), variants, T.data(), long(T.shape(0)), {counts.data(), certain.data()});
}

// A copy of the numbers in an array owned by Python.
static nb::object owned(const std::vector<double>& from, std::initializer_list<std::size_t> shape) {
    auto* copy = new double[from.size()];
    std::copy(from.begin(), from.end(), copy);
    const nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, double>(copy, shape, owner));
}

// Poses with all their solutions: the fields of KnownPoses in Python.
static nb::dict known_poses(nb::object written, const JointVectors& q, bool near) {
    if (q.shape(0) < 2) throw nb::value_error("two joint vectors at least");
    Written<6> arm;
    read(PythonValues(written, "written"), arm);
    const auto found = std::make_unique<Continuation>();
    {
        nb::gil_scoped_release release;
        preparation().elimination->find_known_poses(arm, reinterpret_cast<const double (*)[6]>(q.data()), int(q.shape(0)), near,
                                                    *found);
    }
    std::vector<double> turn, point, solution;
    for (int i = 0; i < found->poses; ++i) {
        const KnownPose& each = found->known[i];
        turn.insert(turn.end(), each.turn, each.turn + 4), point.insert(point.end(), each.point, each.point + 3);
        const double* first = &each.solution[0].z[0][0];
        solution.insert(solution.end(), first, first + KnownPose::most * 12);
    }
    const std::size_t poses = found->poses;
    nb::dict out;
    out["solutions"] = found->solutions, out["poses"] = found->poses;
    out["turn"] = owned(turn, {poses, 4}), out["point"] = owned(point, {poses, 3});
    out["solution"] = owned(solution, {poses, KnownPose::most, 6, 2});
    return out;
}

void bind_elimination(nb::module_& m) {
    m.def("try_elimination", &try_elimination, nb::arg("setup"), nb::arg("variants"), nb::arg("T").noconvert(),
          nb::arg("counts").noconvert(), nb::arg("certain").noconvert());
    m.def("known_poses", &known_poses, nb::arg("written"), nb::arg("q").noconvert(), nb::arg("near"));
}

}  // namespace urdf_ik
