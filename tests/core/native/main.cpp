// Tests of the solvers' steps, without Python. The exit status is 0 if every fact holds.
#include "facts.hpp"

int main() {
    test_doubled();
    test_trig();
    test_polynomials();
    test_subproblems();
    test_balls();
    test_circle();
    test_wide();
    std::printf("%d facts, %d wrong\n", facts, wrong);
    return wrong != 0;
}
