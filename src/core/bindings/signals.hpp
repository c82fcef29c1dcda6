// Ctrl-C ends long work: the work polls, and at intervals the poll runs Python's signal handlers.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <type_traits>

#include "motion/stop.hpp"

namespace urdf_ik {

namespace nb = nanobind;

// The signals of the thread that Python called. Used while this thread does not hold the GIL.
class Signals {
public:
    // Whether a signal handler has raised an error. Python's error is then set.
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
    // Throws the error that a handler raised. The caller holds the GIL.
    void raise() const {
        if (raised_) throw nb::python_error();
    }

    using Clock = std::chrono::steady_clock;
    static constexpr auto PERIOD = std::chrono::milliseconds(50);

private:
    Clock::time_point last_ = Clock::now();
    bool raised_ = false;
};

// Runs work(stop) without the GIL, then throws the error that a Python signal handler raised meanwhile.
template <class Work> auto without_gil(const Work& work) {
    Signals signals;
    const auto run = [&] {
        nb::gil_scoped_release release;
        return work(signals.stop());
    };
    if constexpr (std::is_void_v<decltype(run())>) {
        run(), signals.raise();
    } else {
        const auto out = run();
        signals.raise();
        return out;
    }
}

// Calls work(first, many) for all of `count` joint vectors, a part between two polls for signals. Of few vectors, releasing the GIL
// costs more than it gains.
template <class Work> void in_parts(long count, const Work& work) {
    constexpr long AT_ONCE = 4096, FEW = 100;
    if (count < FEW) return work(0, count);
    without_gil([&](const Stop& stop) {
        for (long i = 0; i < count && !stop.asked(); i += AT_ONCE) work(i, count - i < AT_ONCE ? count - i : AT_ONCE);
    });
}

}  // namespace urdf_ik
