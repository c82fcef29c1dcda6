// Six joints without a structure to use, from named values.
#include <vector>

#include "elimination.hpp"

namespace urdf_ik {

// The v-th of an array's parts: (variants, ...) in Python, one struct a variant here.
template <class T> static void read_part(const Values& values, const char* name, int variants, int v, T& to) {
    using Each = std::remove_all_extents_t<T>;
    constexpr std::size_t count = sizeof(T) / sizeof(Each);
    values.numbers(name, count * variants, [&](const double* from) {
        Each* out = reinterpret_cast<Each*>(&to);
        for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<Each>(from[count * v + i]);
    });
}

static void read(const Values& values, int variants, int v, EliminationVariant& to) {
    read_part(values, "first", variants, v, to.first), read_part(values, "reversed", variants, v, to.reversed);
    read_part(values, "left", variants, v, to.left), read_part(values, "right", variants, v, to.right);
    read_part(values, "left_inverse", variants, v, to.left_inverse), read_part(values, "slides", variants, v, to.slides);
    read_part(values, "axes", variants, v, to.axes), read_part(values, "points", variants, v, to.points);
    read_part(values, "across", variants, v, to.across);
}

static void read_common(const Values& values, EliminationArm& to) {
    read(values.group("written"), to.written);
    read_motions(values, "home_inverse", &to.home_inverse, 1);
    values.read("centre", to.centre), values.read("scale", to.scale);
    to.any_slide = false;
    for (const bool slides : to.written.slides) to.any_slide |= slides;
}

void read(const Values& values, EliminationArm& to) {
    read_common(values, to);
    to.variants = values.get<int>("variants");
    if (to.variants < 1 || to.variants > EliminationArm::most) throw nb::value_error("one to five variants of the elimination");
    for (int v = 0; v < to.variants; ++v) read(values, to.variants, v, to.variant[v]);
}

void add_elimination(Makers& makers) { makers["general 6R"] = makers["general slides"] = maker(level().elimination->solve, 6, 16); }

using Targets = nb::ndarray<const double, nb::shape<-1, 4, 4>, nb::c_contig, nb::device::cpu>;
using Counts = nb::ndarray<long, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Doubts = nb::ndarray<std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// How many solutions each variant finds of each pose, and whether it is in doubt.
static void try_elimination(nb::dict dict, const Targets& T, const Counts& counts, const Doubts& doubts) {
    const Values values(dict, "elimination");
    const int variants = values.get<int>("variants");
    const std::size_t m = T.shape(0);
    if (variants < 1 || variants > EliminationTrial::most) throw nb::value_error("one to 24 variants of the elimination");
    if (counts.shape(0) != std::size_t(variants) || counts.shape(1) != m || doubts.shape(0) != counts.shape(0) ||
        doubts.shape(1) != m) {
        throw nb::value_error("arrays of poses and counts do not fit each other");
    }
    const auto arm = std::make_unique<EliminationArm>();
    std::vector<EliminationVariant> all(variants);
    read_common(values, *arm);
    for (int v = 0; v < variants; ++v) read(values, variants, v, all[v]);
    nb::gil_scoped_release release;
    level().elimination->trial(*arm, all.data(), variants, T.data(), long(m), {counts.data(), doubts.data()});
}

void add_elimination(nb::module_& m) {
    m.def("try_elimination", &try_elimination, nb::arg("values"), nb::arg("T").noconvert(), nb::arg("counts").noconvert(),
          nb::arg("doubts").noconvert());
}

}  // namespace urdf_ik
