// Bindings of the tracker: its state and the result of a cycle. They use NumPy's C-API; see answer.cpp.
#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

#include "bindings/module.hpp"
#include "bindings/numpy_api.hpp"
#include "bindings/python_values.hpp"
#include "solvers/common.hpp"

namespace urdf_ik {

namespace {

constexpr int MOST_TRACKED = 7;

nb::object array_of(const double* from, npy_intp count) {
    double* to;
    nb::object made = new_array(1, &count, NPY_DOUBLE, to);
    std::copy_n(from, count, to);
    return made;
}

// The result of one cycle; its arrays are made when they are first read.
struct Cycle {
    Tracked tracked;
    int joints;
    double q[MOST_TRACKED], v[MOST_TRACKED];
};

// A tracker of any number of joints.
class AnyTracker {
public:
    virtual ~AnyTracker() = default;
    virtual bool step(const double* T, Cycle& to) = 0;
    virtual Cycle back(Because why) = 0;
    virtual void reset(const double* q, const double* v) = 0;
};

template <int N> class TrackerOf : public AnyTracker {
public:
    TrackedArm<N> arm{};

    bool step(const double* T, Cycle& to) override {
        before_ = state_;
        last_ = std::get<N - 1>(*level().tracker)(arm, state_, T);
        to.tracked = last_;
        write(to);
        return last_.is_pose;
    }
    // Undo the last step: the joints are held where they were before it.
    Cycle back(Because why) override {
        state_ = before_;
        for (int k = 0; k < N; ++k) state_.v[k] = 0.0, state_.goal[k] = state_.q[k];
        const double d = last_.distance_before, a = last_.angle_before;
        Cycle to = {{true, Tracking::held, why, d, a, d, a}, N, {}, {}};
        write(to);
        return to;
    }
    void reset(const double* q, const double* v) override {
        for (int k = 0; k < N; ++k) state_.q[k] = state_.goal[k] = q[k], state_.v[k] = v[k];
        state_.exact = true;
        before_ = state_;
    }

private:
    void write(Cycle& to) const {
        to.joints = N;
        std::copy_n(state_.q, N, to.q), std::copy_n(state_.v, N, to.v);
    }

    TrackedState<N> state_{}, before_{};
    Tracked last_{};
};

template <int N> std::unique_ptr<AnyTracker> made(const Values& v) {
    auto tracker = std::make_unique<TrackerOf<N>>();
    TrackedArm<N>& arm = tracker->arm;
    read(*v.group("written"), arm.written);
    v.read("lower", arm.lower), v.read("upper", arm.upper);
    v.read("velocity", arm.velocity), v.read("acceleration", arm.acceleration);
    v.read("dt", arm.dt), v.read("recentring", arm.recentring);
    return tracker;
}

struct PyTracker {
    std::unique_ptr<AnyTracker> tracker;
    int joints;

    explicit PyTracker(nb::object tracked) {
        const PythonValues values(std::move(tracked), "tracker");
        joints = values.integer("joints");
        using Make = std::unique_ptr<AnyTracker> (*)(const Values&);
        constexpr Make makers[MOST_TRACKED] = {made<1>, made<2>, made<3>, made<4>, made<5>, made<6>, made<7>};
        if (joints < 1 || joints > MOST_TRACKED) throw nb::value_error("a tracker has one to seven joints");
        tracker = makers[joints - 1](values);
    }
    PyTracker(const PyTracker&) = delete;

    // None unless the target is a C-ordered float64 array (4, 4) that is a pose.
    nb::object step(nb::handle T) {
        PyArrayObject* array = doubles(T);
        if (!array || PyArray_NDIM(array) != 2 || PyArray_DIM(array, 0) != 4 || PyArray_DIM(array, 1) != 4) return nb::none();
        Cycle to;
        if (!tracker->step((const double*)PyArray_DATA(array), to)) return nb::none();
        return nb::cast(to);
    }
    void reset(nb::handle q, nb::handle v) {
        PyArrayObject *from = doubles(q), *speed = doubles(v);
        if (!from || !speed || PyArray_SIZE(from) != joints || PyArray_SIZE(speed) != joints)
            throw nb::value_error("arrays do not fit the tracker");
        tracker->reset((const double*)PyArray_DATA(from), (const double*)PyArray_DATA(speed));
    }
};

// The words for Tracking and Because, in the enums' order; null: None.
constexpr const char* const STATUS[] = {"ok", "limited", "held"};
constexpr const char* const WHY[] = {nullptr, "velocity", "acceleration", "limit", "reach", "singularity", "collision"};

nb::object word(const char* text) { return text ? nb::steal(PyUnicode_InternFromString(text)) : nb::none(); }

}  // namespace

void bind_tracker(nb::module_& m) {
    nb::class_<Cycle>(m, "Step", "What one cycle of a tracker answers.")
        .def_prop_ro(
            "q", [](const Cycle& s) { return array_of(s.q, s.joints); },
            nb::for_getter(nb::sig("def q(self) -> NDArray[numpy.float64]")),
            "(n,) rad or m, where the joints are to be; angles of any size, continuous with the last; a new array.")
        .def_prop_ro(
            "velocity", [](const Cycle& s) { return array_of(s.v, s.joints); },
            nb::for_getter(nb::sig("def velocity(self) -> NDArray[numpy.float64]")),
            "(n,) rad/s or m/s, of the way there from the last joint vector.")
        .def_prop_ro(
            "status", [](const Cycle& s) { return word(STATUS[int(s.tracked.status)]); },
            nb::for_getter(nb::sig("def status(self) -> str")), "'ok', 'limited' or 'held'.")
        .def_prop_ro(
            "why", [](const Cycle& s) { return word(WHY[int(s.tracked.why)]); },
            nb::for_getter(nb::sig("def why(self) -> str | None")),
            "What keeps the joints from the target: 'velocity', 'acceleration', 'limit', 'reach', 'singularity', 'collision'; "
            "None where they are at it.")
        .def_prop_ro(
            "distance", [](const Cycle& s) { return s.tracked.distance; }, "From the tip to the target [m].")
        .def_prop_ro(
            "angle", [](const Cycle& s) { return s.tracked.angle; }, "Between the tip and the target [rad].")
        .def("__getstate__", [](const Cycle& s) { return nb::make_tuple(nb::bytes((const char*)&s, sizeof s)); })
        .def("__setstate__",
             [](Cycle& s, const nb::tuple& state) {
                 const nb::bytes numbers = nb::cast<nb::bytes>(state[0]);
                 Cycle from{};
                 if (numbers.size() != sizeof from) throw nb::value_error("no step of this version");
                 std::memcpy(&from, numbers.c_str(), sizeof from);
                 if (from.joints < 0 || from.joints > MOST_TRACKED || int(from.tracked.status) > 2 || int(from.tracked.why) > 6)
                     throw nb::value_error("no step of this version");
                 new (&s) Cycle(from);
             })
        .def("__repr__", [](const Cycle& s) {
            const char* why = WHY[int(s.tracked.why)];
            return std::string("<Step ") + STATUS[int(s.tracked.status)] + (why ? std::string(": ") + why : "") + ">";
        });
    nb::class_<PyTracker>(m, "Tracker", "An arm that follows poses, one a cycle.")
        .def(nb::init<nb::object>(), nb::arg("arm"))
        .def("step", &PyTracker::step, nb::sig("def step(self, T: object, /) -> Step | None"))
        .def("reset", &PyTracker::reset)
        .def("back", [](PyTracker& self, const std::string& why) {
            for (int k = 1; k < int(sizeof WHY / sizeof WHY[0]); ++k) {
                if (why == WHY[k]) return self.tracker->back(Because(k));
            }
            throw nb::value_error("no such reason");
        });
}

}  // namespace urdf_ik
