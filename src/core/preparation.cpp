// See preparation.hpp.
#include "preparation.hpp"

namespace urdf_ik {

namespace plain {
extern const ChainFunctions chain_functions;
extern const EliminationPreparation elimination_preparation;
}  // namespace plain

const PreparationTable& preparation() {
    static constexpr PreparationTable table = {&plain::chain_functions, &plain::elimination_preparation};
    return table;
}

}  // namespace urdf_ik
