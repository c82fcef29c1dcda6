// Facts that a test states. One that does not hold is printed, and counted; the program goes on with the next.
#pragma once

#include <cmath>
#include <cstdio>
#include <initializer_list>

inline int facts = 0, wrong = 0;

#define HOLDS(fact)                                                               \
    do {                                                                          \
        ++facts;                                                                  \
        if (!(fact)) {                                                            \
            ++wrong;                                                              \
            std::printf("%s:%d: does not hold: %s\n", __FILE__, __LINE__, #fact); \
        }                                                                         \
    } while (false)

// Numbers that differ by at most `within`; two NaN never do.
inline bool near(double a, double b, double within) { return std::fabs(a - b) <= within; }

void test_trig();
void test_polynomials();
void test_subproblems();
