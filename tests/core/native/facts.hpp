// HOLDS(fact) checks a fact. A false one is printed and counted; the program goes on.
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

// Whether two numbers differ by at most `within`; false if one is NaN.
inline bool near(double a, double b, double within) { return std::fabs(a - b) <= within; }

void test_doubled();
void test_trig();
void test_polynomials();
void test_subproblems();
void test_balls();
void test_circle();
void test_wide();
