// Bindings for self-motions: arrays in, arrays out.
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include <nanobind/stl/optional.h>

#include "bindings/module.hpp"
#include "bindings/numpy_api.hpp"
#include "bindings/python_values.hpp"
#include "bindings/signals.hpp"
#include "motion/self_motion/curves.hpp"
#include "numbers/thresholds.hpp"
#include "solvers/common.hpp"

namespace urdf_ik {

namespace {

using Doubles = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<const std::uint8_t, nb::c_contig, nb::device::cpu>;

// Points are settled in at most this many rounds of Newton's method.
constexpr int ROUNDS = 20;

constexpr std::size_t SAMPLE = 17;  // numbers of a CurveSample: all but its sense

nb::object array_of(const std::vector<double>& from, npy_intp columns) {
    const npy_intp shape[2] = {npy_intp(from.size()) / columns, columns};
    double* to;
    nb::object made = new_array(2, shape, NPY_DOUBLE, to);
    std::copy(from.begin(), from.end(), to);
    return made;
}

struct PySelfMotion {
    FreeArm arm{};

    explicit PySelfMotion(nb::object free_arm) {
        const PythonValues v(std::move(free_arm), "self-motion");
        read(*v.group("written"), arm.written);
        v.read("given", arm.given);
        if (arm.given >= 7) throw nb::value_error("one of seven joints is given");
        if (arm.given < 0) read(*v.group("ends"), arm.ends);
        for (int j = 0; j < 8; ++j) {
            const bool slides = j < 7 && arm.written.slides[j];
            arm.slides[j] = slides ? 1.0 : 0.0, arm.unit[j] = slides ? arm.written.size : 1.0;
        }
    }

    // T (m, 4, 4), grid (v) ascending, q (m, v, branches, 7), flags (m, v, branches), limits (7, 2), beyond (m, fine, branches, 7)
    // with the error up to which these count as solutions, starts (k, 7).
    nb::tuple intervals(const Doubles& T, const Doubles& grid, bool round, const Doubles& q, const Bytes& flags,
                        const Doubles& limits, const std::optional<Doubles>& beyond, double off, const Doubles& starts) const {
        const long m = long(T.size() / 16), values = long(grid.size());
        const int branches = int(flags.ndim() ? flags.shape(flags.ndim() - 1) : 0);
        if (values < 3 || long(flags.size()) != m * values * branches || q.size() != 7 * flags.size() || limits.size() != 14 ||
            starts.size() % 7 != 0 || (beyond && beyond->size() && (!m || !branches || beyond->size() % (7 * m * branches)))) {
            throw nb::value_error("arrays of poses and solutions do not fit each other");
        }
        const long fine = beyond && beyond->size() ? long(beyond->size()) / (7 * m * branches) : 0;
        double lower[7], upper[7];
        for (int j = 0; j < 7; ++j) lower[j] = limits.data()[2 * j], upper[j] = limits.data()[2 * j + 1];
        Intervals all;
        without_gil([&](const Stop& stop) {
            for (long i = 0; i < m && !stop.asked(); ++i) {
                const long solutions = i * values * branches;
                const GridOfSolutions given = {T.data() + 16 * i,
                                               grid.data(),
                                               values,
                                               round,
                                               q.data() + 7 * solutions,
                                               flags.data() + solutions,
                                               branches,
                                               lower,
                                               upper,
                                               beyond ? beyond->data() + 7 * fine * branches * i : nullptr,
                                               fine,
                                               off,
                                               starts.data(),
                                               int(starts.size() / 7)};
                follow_curves(arm, *level().self_motion, given, i, all);
            }
        });
        std::vector<double> samples(SAMPLE * all.samples.size()), found;
        for (std::size_t i = 0; i < all.samples.size(); ++i)
            std::memcpy(&samples[SAMPLE * i], &all.samples[i], sizeof(double) * SAMPLE);
        for (const Interval& f : all.found) {
            for (const long each :
                 {f.pose, f.first, f.count, long(f.column), long(f.why[0]), long(f.why[1]), long(f.joint[0]), long(f.joint[1])}) {
                found.push_back(double(each));
            }
        }
        std::vector<double> unseen;
        for (const auto& [pose, value] : all.unseen) unseen.push_back(double(pose)), unseen.push_back(value);
        return nb::make_tuple(array_of(samples, SAMPLE), array_of(found, 8), array_of(unseen, 2));
    }

    // Points on curves between neighbouring samples (m, 17), at shares (m) of the way: (m, 8) value and joint vector. NaN if
    // Newton's method does not converge.
    nb::object between(const Doubles& T, const Doubles& before, const Doubles& after, const Doubles& shares) const {
        const std::size_t m = shares.size();
        if (T.size() != 16 * m || before.size() != SAMPLE * m || after.size() != SAMPLE * m) {
            throw nb::value_error("arrays of poses and samples do not fit each other");
        }
        std::vector<double> out(8 * m);
        {
            nb::gil_scoped_release release;
            std::vector<Start> starts(m, {nullptr, {}, {Pin::nothing, 0, 0.0}, ROUNDS, CONVERGED});
            for (std::size_t i = 0; i < m; ++i) {
                CurveSample ends[2];
                std::memcpy(&ends[0], before.data() + SAMPLE * i, sizeof(double) * SAMPLE);
                std::memcpy(&ends[1], after.data() + SAMPLE * i, sizeof(double) * SAMPLE);
                starts[i].T = T.data() + 16 * i;
                interpolate(arm, ends[0], ends[1], shares.data()[i], starts[i].q);
            }
            std::vector<OnCurve> points(m);
            level().self_motion->settle(arm, starts.data(), int(m), points.data());
            for (std::size_t i = 0; i < m; ++i) {
                const bool found = points[i].left <= arm.written.tolerances.reach;
                out[8 * i] = found ? points[i].value : __builtin_nan("");
                for (int j = 0; j < 7; ++j) out[8 * i + 1 + j] = found ? points[i].q[j] : __builtin_nan("");
            }
        }
        return array_of(out, 8);
    }
};

}  // namespace

void bind_self_motion(nb::module_& m) {
    nb::class_<PySelfMotion>(m, "SelfMotion", "The curves of joint vectors that hold a pose, of an arm with seven joints.")
        .def(nb::init<nb::object>(), nb::arg("arm"))
        .def("intervals", &PySelfMotion::intervals, nb::arg("T"), nb::arg("grid"), nb::arg("round"), nb::arg("q"), nb::arg("flags"),
             nb::arg("limits"), nb::arg("beyond").none(), nb::arg("off"), nb::arg("starts"))
        .def("between", &PySelfMotion::between, nb::arg("T"), nb::arg("before"), nb::arg("after"), nb::arg("shares"));
}

}  // namespace urdf_ik
