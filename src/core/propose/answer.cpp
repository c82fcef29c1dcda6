// Instances for arms of six joints, compiled once for every instruction set; see answer.hpp.
#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template Polished<double> polish_one<true>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
template Polished<Block> polish_block<true>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                            const MaskOf<Block>&);
template Polished<Block> polish_block<false>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                             const MaskOf<Block>&);
template Error<double> derivatives_at(const Written<6>&, const Goal<double>&, const double (&)[6], Rows<6, double> (&)[6]);
template double missed_by(const Written<6>&, const Goal<double>&, const double (&)[6]);
template bool is_new(const Written<6>&, const Goal<double>&, const Columns<6>&, const double (&)[6]);
template Weakest<6> weakest_at(const Written<6>&, const Goal<double>&, const double (&)[6]);

}  // namespace urdf_ik::URDF_IK_LEVEL
