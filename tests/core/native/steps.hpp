// Single steps of the solvers, for tests: numbers in, numbers out, in the order of each step's arguments and results.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

struct Step {
    const char* name;
    int inputs, outputs;
    void (*one)(const double* in, double* out);             // one set of numbers
    void (*many)(const double* in, double* out, long sets);  // in blocks, one set per lane; null if there is no such version
};

struct Steps {
    const char* name;  // of the instruction set
    const Step* all;
    int count;
    // Newton's method on an arm as written. Replaces q (6) by the best vector found, and returns its error.
    double (*polish)(const Written<6>& arm, const double* T, double* q, bool damped, int rounds);
};

}  // namespace urdf_ik
