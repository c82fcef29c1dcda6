// What every family of six joints does with its candidates, compiled once for every instruction set; see answer.hpp.
#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template Polished<double> polish_one<true>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
template Polished<double> polish_one<false>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
template bool is_new(const Written<6>&, const Goal<double>&, const Columns<6>&, const double (&)[6]);
template Weakest<6> weakest_at(const Written<6>&, const Goal<double>&, const double (&)[6]);
template void accept(const Written<6>&, const Goal<double>&, double (&)[6], int, int, bool, const Columns<6>&);

}  // namespace urdf_ik::URDF_IK_LEVEL
