// Six joints without a structure to use, from named values.
#include <vector>

#include "bindings/families/elimination.hpp"

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

// Arrays with one entry a pose.
static void read(const Values& values, Continuation& to) {
    to.solutions = values.get<int>("solutions"), to.poses = values.get<int>("poses");
    if (to.poses < 0 || to.poses > Continuation::most) throw nb::value_error("at most 16 known poses");
    if (to.solutions < 0 || to.solutions > KnownPose::most) throw nb::value_error("at most 16 solutions of a known pose");
    for (int i = 0; i < to.poses; ++i) {
        read_part(values, "turn", to.poses, i, to.known[i].turn), read_part(values, "point", to.poses, i, to.known[i].point);
        read_part(values, "solution", to.poses, i, reinterpret_cast<double (&)[KnownPose::most][6][2]>(to.known[i].solution));
    }
}

static void read_common(const Values& values, EliminationArm& to) {
    read(values.group("written"), to.written);
    read_motions(values, "home_inverse", &to.home_inverse, 1);
    values.read("centre", to.centre), values.read("scale", to.scale);
    to.any_slide = false;
    for (const bool slides : to.written.slides) to.any_slide |= slides;
    read(values.group("known"), to.paths);
}

void read(const Values& values, EliminationArm& to) {
    read_common(values, to);
    read(values, 1, 0, to.variant);
}

void add_elimination(Makers& makers) { makers["general 6R"] = makers["general slides"] = maker(level().elimination->solve, 6, 16); }

using Targets = nb::ndarray<const double, nb::shape<-1, 4, 4>, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using JointVectors = nb::ndarray<const double, nb::shape<-1, 6>, nb::c_contig, nb::device::cpu>;

// How many solutions each variant alone finds of each pose, and whether it is certain of them.
static void try_elimination(nb::dict dict, const Targets& T, const Bytes& counts, const Bytes& certain) {
    const Values values(dict, "elimination");
    const int variants = int(certain.shape(0));
    if (certain.shape(1) != T.shape(0) || counts.shape(0) != certain.shape(0) || counts.shape(1) != certain.shape(1)) {
        throw nb::value_error("arrays of poses and answers do not fit each other");
    }
    const auto arm = std::make_unique<EliminationArm>();
    std::vector<EliminationVariant> all(variants);
    read_common(values, *arm);
    for (int v = 0; v < variants; ++v) read(values, variants, v, all[v]);
    nb::gil_scoped_release release;
    level().elimination->trial(*arm, all.data(), variants, T.data(), long(T.shape(0)), {counts.data(), certain.data()});
}

// A copy of numbers as an array that Python owns.
static nb::object owned(const std::vector<double>& from, std::initializer_list<std::size_t> shape) {
    auto* copy = new double[from.size()];
    std::copy(from.begin(), from.end(), copy);
    const nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, double>(copy, shape, owner));
}

// Poses of which all solutions are known, as the group "known" of an elimination's values.
static nb::dict known_poses(nb::dict written, const JointVectors& q, bool near) {
    if (q.shape(0) < 2) throw nb::value_error("two joint vectors at least");
    Written<6> arm;
    read(Values(written, "written"), arm);
    const auto found = std::make_unique<Continuation>();
    {
        nb::gil_scoped_release release;
        level().elimination->find_known_poses(arm, reinterpret_cast<const double (*)[6]>(q.data()), int(q.shape(0)), near, *found);
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

void add_elimination(nb::module_& m) {
    m.def("try_elimination", &try_elimination, nb::arg("values"), nb::arg("T").noconvert(), nb::arg("counts").noconvert(),
          nb::arg("certain").noconvert());
    m.def("known_poses", &known_poses, nb::arg("written"), nb::arg("q").noconvert(), nb::arg("near"));
}

}  // namespace urdf_ik
