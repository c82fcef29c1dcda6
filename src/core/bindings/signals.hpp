// Long work ends at Ctrl-C: it polls at intervals, and Python's signal handlers run.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <type_traits>

#include "motion/stop.hpp"

namespace urdf_ik {

namespace nb = nanobind;

// Of the thread that Python called, while it does not hold the GIL.
class Signals {
public:
    // Whether the work is to end. Python's error is set then.
    bool asked() {
        if (raised_) return true;
        const auto now = Clock::now();
        if (now - last_ < PERIOD) return false;
        nb::gil_scoped_acquire held;
        raised_ = PyErr_CheckSignals() != 0;
        last_ = Clock::now();
        return raised_;
    }
    Stop stop() {
        return {[](void* self) { return static_cast<Signals*>(self)->asked(); }, this};
    }
    // Throws what a handler raised; with the GIL.
    void raise() const {
        if (raised_) throw nb::python_error();
    }

    using Clock = std::chrono::steady_clock;
    static constexpr auto PERIOD = std::chrono::milliseconds(50);

private:
    Clock::time_point last_ = Clock::now();
    bool raised_ = false;
};

// work(stop) without the GIL, and then what Python's signal handlers raised meanwhile.
template <class Work> auto without_gil(const Work& work) {
    Signals signals;
    if constexpr (std::is_void_v<decltype(work(signals.stop()))>) {
        {
            nb::gil_scoped_release release;
            work(signals.stop());
        }
        signals.raise();
    } else {
        const auto out = [&] {
            nb::gil_scoped_release release;
            return work(signals.stop());
        }();
        signals.raise();
        return out;
    }
}

}  // namespace urdf_ik
