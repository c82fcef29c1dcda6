// Bindings of a chain's forward kinematics. They use NumPy's C-API; see answer.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include "bindings/module.hpp"
#include "bindings/numpy_api.hpp"
#include "bindings/signals.hpp"
#include "preparation.hpp"

namespace urdf_ik {

namespace {

using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Kinds = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// A frame whose z axis is the unit vector z. Its x axis is orthogonal to z and to the coordinate axis most nearly orthogonal to z.
Motion frame_on(const double* z, const double* origin) {
    int least = 0;
    for (int i = 1; i < 3; ++i) least = std::fabs(z[i]) < std::fabs(z[least]) ? i : least;
    double x[3] = {}, y[3], length = 0.0;
    // x = z cross e: for e_1 this is (0, z3, -z2), and cyclically for e_2 and e_3.
    x[(least + 1) % 3] = z[(least + 2) % 3], x[(least + 2) % 3] = -z[(least + 1) % 3];
    for (const double each : x) length += each * each;
    for (double& each : x) each /= std::sqrt(length);
    for (int i = 0; i < 3; ++i) y[i] = z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3];
    Motion frame;
    for (int i = 0; i < 3; ++i) frame.R[i][0] = x[i], frame.R[i][1] = y[i], frame.R[i][2] = z[i], frame.t[i] = origin[i];
    return frame;
}

// The motion from frame a to frame b, in frame a.
Motion between(const Motion& a, const Motion& b) {
    Motion step = {};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            for (int j = 0; j < 3; ++j) step.R[i][j] += a.R[k][i] * b.R[k][j];
            step.t[i] += a.R[k][i] * (b.t[k] - a.t[k]);
        }
    }
    return step;
}

}  // namespace

// Whether this thread prepares an arm: then forward kinematics is computed alike on every processor.
static thread_local bool preparing = false;

static const ChainFunctions& chain_functions() { return preparing ? plain::chain_functions : *level().chain; }

static nb::object prepared(nb::handle call) {
    struct Preparing {
        const bool before = preparing;
        Preparing() { preparing = true; }
        ~Preparing() { preparing = before; }
    } const now;
    return nb::borrow<nb::callable>(call)();
}

// Directions H (n, 3) of the axes; steps P (n + 1, 3) from the base through a point on each axis to the tip; rotation R_tip (3, 3)
// of the tip: all at q = 0 and in the base. slides (n).
struct PyChain {
    nb::tuple made_from;
    std::vector<Motion> step;
    std::vector<std::uint8_t> slides;
    ChainArm arm;

    PyChain(nb::object directions, nb::object steps, nb::object home, nb::object kinds)
        : made_from(nb::make_tuple(directions, steps, home, kinds)) {
        const auto H = nb::cast<Rows>(directions), P = nb::cast<Rows>(steps), R_tip = nb::cast<Rows>(home);
        const auto sliding = nb::cast<Kinds>(kinds);
        const std::size_t n = sliding.size();
        slides.assign(sliding.data(), sliding.data() + n);
        if (H.shape(0) != n || P.shape(0) != n + 1 || H.shape(1) != 3 || P.shape(1) != 3 || R_tip.size() != 9) {
            throw nb::value_error("arrays of a chain do not fit each other");
        }
        Motion before = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, {}};
        double point[3] = {};
        for (std::size_t k = 0; k <= n; ++k) {
            for (int i = 0; i < 3; ++i) point[i] += P.data()[3 * k + i];
            Motion next = frame_on(k < n ? H.data() + 3 * k : R_tip.data(), point);
            if (k == n) std::memcpy(next.R, R_tip.data(), sizeof next.R);
            step.push_back(between(before, next));
            before = next;
        }
        arm = {int(n), step.data(), reinterpret_cast<const bool*>(slides.data())};
    }
    PyChain(const PyChain&) = delete;

    // Apply a function to joint vectors (..., n): an array (..., rows, columns). None unless q is a C-ordered float64 array with
    // numbers in range, or any numbers if `all`.
    template <class Fill> nb::object of(nb::handle q, const Fill& fill, npy_intp rows, npy_intp columns, bool all = false) const {
        PyArrayObject* from = doubles(q);
        const int dimensions = from ? PyArray_NDIM(from) : 0;
        if (!dimensions || dimensions + 1 > NPY_MAXDIMS || PyArray_DIM(from, dimensions - 1) != arm.joints) return nb::none();
        const double* Q = (const double*)PyArray_DATA(from);
        if (!all && !all_in_range(Q, PyArray_SIZE(from))) return nb::none();
        npy_intp shape[NPY_MAXDIMS];
        long m = 1;
        for (int i = 0; i + 1 < dimensions; ++i) m *= shape[i] = PyArray_DIM(from, i);
        shape[dimensions - 1] = rows, shape[dimensions] = columns;
        double* to;
        nb::object made = new_array(dimensions + 1, shape, NPY_DOUBLE, to);
        in_parts(m, [&](long first, long many) { fill(arm, Q + first * arm.joints, many, to + first * rows * columns); });
        return made;
    }

    // Least-squares inverses of the Jacobians at joint vectors (..., n), which may be NaN: an array (..., n, 6), or (..., 7, 7)
    // with the derivative by the parameter that seven joints hold.
    // held: the joint; negative: the swivel angle, measured from the vectors in `swivel`.
    nb::object inverse(nb::handle q, double size, double singular, int held, const std::array<double, 9>& swivel) const {
        const int n = arm.joints;
        if (held >= n) throw nb::value_error("there is no such joint to hold");
        InverseScale scale = {size, singular, held, {}};
        std::memcpy(&scale.swivel, swivel.data(), sizeof scale.swivel);
        const auto fill = [&](const ChainArm& chain, const double* Q, long m, double* X) {
            level().inverse->inverses(chain, Q, scale, m, X);
        };
        nb::object made = n >= 1 && n <= 7 ? of(q, fill, n, n == 7 ? 7 : 6, true) : nb::none();
        if (made.is_none()) throw nb::value_error("joint vectors (..., n) of one to seven joints are needed, float64 in C order");
        return made;
    }

    nb::object steps() const {
        const npy_intp shape[3] = {arm.joints + 1, 3, 4};
        double* to;
        nb::object made = new_array(3, shape, NPY_DOUBLE, to);
        for (const Motion& each : step) {
            for (int i = 0; i < 3; ++i, to += 4) std::copy_n(each.R[i], 3, to), to[3] = each.t[i];
        }
        return made;
    }
};

void bind_chain(nb::module_& m) {
    m.def("prepared", &prepared, nb::arg("call"),
          "What a function without arguments returns. Meanwhile this thread computes forward kinematics alike on every processor.");
    nb::class_<PyChain>(m, "Chain", "Forward kinematics of a chain of joints; immutable. Angles may be of any size.")
        .def(nb::init<nb::object, nb::object, nb::object, nb::object>())
        .def_prop_ro("steps", &PyChain::steps)
        .def("__reduce__",
             [](nb::handle self) { return nb::make_tuple(nb::type<PyChain>(), nb::cast<const PyChain&>(self).made_from); })
        .def(
            "fk", [](const PyChain& self, nb::handle q) { return self.of(q, chain_functions().poses, 4, 4); }, nb::arg().none())
        .def(
            "jacobian",
            [](const PyChain& self, nb::handle q) { return self.of(q, chain_functions().jacobians, 6, self.arm.joints); },
            nb::arg().none())
        .def("axes", [](const PyChain& self, nb::handle q) { return self.of(q, chain_functions().axes, 6, self.arm.joints); })
        .def("inverse", &PyChain::inverse, nb::arg("q"), nb::arg("size"), nb::arg("singular"), nb::arg("held") = -1,
             nb::arg("swivel") = std::array<double, 9>());
}

}  // namespace urdf_ik
