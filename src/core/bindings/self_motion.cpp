// The curves of joint vectors that hold a pose, as Python calls them: arrays in, arrays out.
#include <cstring>
#include <optional>
#include <vector>

#include <nanobind/stl/optional.h>

#include "../self_motion/curves.hpp"
#include "numpy_api.hpp"
#include "solver.hpp"

namespace urdf_ik {

namespace {

using Doubles = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<const std::uint8_t, nb::c_contig, nb::device::cpu>;

nb::object array_of(const std::vector<double>& from, npy_intp columns) {
    npy_intp shape[2] = {npy_intp(from.size()) / columns, columns};
    nb::object made = nb::steal(PyArray_SimpleNew(2, shape, NPY_DOUBLE));
    if (!made.is_valid()) throw nb::python_error();
    if (!from.empty()) std::memcpy(PyArray_DATA((PyArrayObject*)made.ptr()), from.data(), from.size() * sizeof(double));
    return made;
}

struct PySelfMotion {
    FreeArm arm{};

    explicit PySelfMotion(nb::dict values) {
        const Values v(std::move(values), "self-motion");
        read(v.group("written"), arm.written);
        v.read("given", arm.given);
        if (arm.given >= 7) throw nb::value_error("one of seven joints is given");
        if (arm.given < 0) read(v.group("ends"), arm.ends);
        for (int j = 0; j < 8; ++j) {
            const bool slides = j < 7 && arm.written.slides[j];
            arm.slides[j] = slides ? 1.0 : 0.0, arm.unit[j] = slides ? arm.written.size : 1.0;
        }
    }

    // T (m, 4, 4), grid (v) ascending, q and beyond (m, v, branches, 7), flags (m, v, branches), limits (7, 2), starts (k, 7).
    nb::tuple intervals(const Doubles& T, const Doubles& grid, bool round, const Doubles& q, const Bytes& flags,
                        const Doubles& limits, const std::optional<Doubles>& beyond, const Doubles& starts) const {
        const long m = long(T.size() / 16), values = long(grid.size());
        const int branches = int(flags.ndim() ? flags.shape(flags.ndim() - 1) : 0);
        if (values < 3 || long(flags.size()) != m * values * branches || q.size() != 7 * flags.size() || limits.size() != 14 ||
            starts.size() % 7 != 0 || (beyond && beyond->size() != q.size())) {
            throw nb::value_error("arrays of poses and solutions do not fit each other");
        }
        double lower[7], upper[7];
        for (int j = 0; j < 7; ++j) lower[j] = limits.data()[2 * j], upper[j] = limits.data()[2 * j + 1];
        Intervals all;
        {
            nb::gil_scoped_release release;
            for (long i = 0; i < m; ++i) {
                const long solutions = i * values * branches;
                const GridOfSolutions given = {T.data() + 16 * i, grid.data(), values, round, q.data() + 7 * solutions,
                                               flags.data() + solutions, branches, lower, upper, beyond ? beyond->data() + 7 * solutions : nullptr,
                                               starts.data(), int(starts.size() / 7)};
                follow_curves(arm, *level().self_motion, given, i, all);
            }
        }
        std::vector<double> samples, found;
        samples.reserve(17 * all.samples.size());
        for (const CurveSample& s : all.samples) {
            samples.push_back(s.value), samples.push_back(s.rate), samples.push_back(s.arc);
            samples.insert(samples.end(), s.q, s.q + 7);
            samples.insert(samples.end(), s.along, s.along + 7);
        }
        for (const Interval& f : all.found) {
            for (const long each : {f.pose, f.first, f.count, long(f.column), long(f.why[0]), long(f.why[1]), long(f.joint[0]),
                                    long(f.joint[1])}) {
                found.push_back(double(each));
            }
        }
        std::vector<double> unseen;
        for (const auto& [pose, value] : all.unseen) unseen.push_back(double(pose)), unseen.push_back(value);
        return nb::make_tuple(array_of(samples, 17), array_of(found, 8), array_of(unseen, 2));
    }

    // Joint vectors at given values, from starts near them: T (m, 4, 4), q (m, 7), values (m) -> (m, 7), NaN where there is none.
    nb::object at(const Doubles& T, const Doubles& q, const Doubles& values) const {
        const std::size_t m = values.size();
        if (T.size() != 16 * m || q.size() != 7 * m) throw nb::value_error("arrays of poses and joint vectors do not fit each other");
        std::vector<double> out(7 * m);
        {
            nb::gil_scoped_release release;
            for (std::size_t i = 0; i < m; ++i) {
                const OnCurve point = level().self_motion->settle(arm, T.data() + 16 * i, q.data() + 7 * i,
                                                                  {Pin::parameter, 0, values.data()[i]}, 20, 1e-14);
                for (int j = 0; j < 7; ++j) out[7 * i + j] = point.left <= 1e-10 ? point.q[j] : __builtin_nan("");
            }
        }
        return array_of(out, 7);
    }
};

}  // namespace

void add_self_motion(nb::module_& m) {
    nb::class_<PySelfMotion>(m, "SelfMotion", "The curves of joint vectors that hold a pose, of an arm with seven joints.")
        .def(nb::init<nb::dict>(), nb::arg("values"))
        .def("intervals", &PySelfMotion::intervals, nb::arg("T"), nb::arg("grid"), nb::arg("round"), nb::arg("q"), nb::arg("flags"),
             nb::arg("limits"), nb::arg("beyond").none(), nb::arg("starts"))
        .def("at", &PySelfMotion::at, nb::arg("T"), nb::arg("q"), nb::arg("values"));
}

}  // namespace urdf_ik
