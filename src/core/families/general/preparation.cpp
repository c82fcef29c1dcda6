// The preparation of arms of six joints for the elimination, compiled once; see ../../preparation.hpp.
#include "families/general/gathering.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// See EliminationPreparation.
static void try_variants(const EliminationArm& arm, const EliminationVariant* variants, int many, const double* T, long m,
                         const EliminationTrial& out) {
    for (long i = 0; i < m; ++i) {
        const Goal<double> goal = goal_of(T + 16 * i);
        for (int v = 0; v < many; ++v) {
            double q[6 * 16];
            std::uint8_t flags[16];
            const Columns<6> columns = {q, flags, 16};
            columns.clear();
            SearchState search = search_state(arm, goal, columns, CONVERGED);
            Eliminant of;
            eliminate(arm, variants[v], goal, of);
            const bool certain = gather(arm, variants[v], goal, of, search);
            out.certain[m * v + i] =
                std::uint8_t(certain | (counts(variants[v]) && count_zeros(arm, variants[v], on_circle(of), search)) << 1);
            out.counts[m * v + i] = std::uint8_t(columns.count());
        }
    }
}

extern const EliminationPreparation elimination_preparation = {try_variants};

}  // namespace urdf_ik::URDF_IK_LEVEL
