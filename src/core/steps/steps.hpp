// Single steps of the solvers, for tests: numbers in, numbers out, in the order of each step's arguments and results.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct Step {
    const char* name;
    int inputs, outputs;
    void (*one)(const double* in, double* out);             // one set of numbers
    void (*many)(const double* in, double* out, long sets);  // side by side, in blocks; null where there is no such step
};

struct Steps {
    const Step* all;
    int count;
    // Newton's method on an arm as written: q (6) is replaced by the best vector met, whose error is returned.
    double (*polish)(const Written<6>& arm, const double* T, double* q, bool damped, int rounds);
};

}  // namespace urdf_ik
