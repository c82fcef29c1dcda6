// See inclusion.hpp. Compiled once for every instruction set.
#include "answers/inclusion.hpp"

#include "certificate/cluster.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

unsigned boxes_in_clusters(const Written<6>& arm, const Goal<double>& goal, const double (&offset)[6], const Columns<6>& columns,
                           const Boxes& boxes) {
    const Loop loop = loop_of(arm, goal);
    Account account;
    for (int k = 0; k < columns.many; ++k) {
        if (!columns.valid(k) || !(columns.flags[k] & SINGULAR)) continue;
        Number q[6];
        for (int j = 0; j < 6; ++j) q[j] = columns.row(k)[j];
        add_cluster_near(loop, account, q);
    }
    unsigned out = 0;
    for (int i = 0; i < account.clusters; ++i) {
        if (!account.cluster[i].blurred || account.cluster[i].apart) continue;
        for (int b = 0; b < 8; ++b) {
            Number middle[6];
            double wide[6];
            for (int j = 0; j < 6; ++j) {
                middle[j] = atan2(boxes.s[j][b], boxes.c[j][b]) - offset[j];
                wide[j] = half_angle(boxes.chord[j][b]) + 1e-14;
            }
            if (is_inside_larger(account.cluster[i], middle, wide)) out |= 1u << b;
        }
    }
    return out & ~boxes.empty & ~boxes.free;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
