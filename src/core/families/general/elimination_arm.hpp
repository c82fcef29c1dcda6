// An arm of six joints for the elimination.
#pragma once

#include "arm/arm.hpp"
#include "certify/proof.hpp"

namespace urdf_ik {

// One way to set the elimination up: the loop is cut so that joints a and a + 1 stand on one side and a + 3, a + 4, a + 5
// on the other (cyclically), and applied to the axis of joint a + 2. See hidden_joint.hpp for the equations, and
// ik/families/parts/elimination.py for how the matrices are made. Axes and points are those of the chain, or of the reversed chain,
// in the scaled frame: origin in the midst of the axes, mean distance one.
struct EliminationVariant {
    int first;      // a, 0 to 3
    bool reversed;  // whether this is the chain from tip to base
    // The 162 coefficients of the equations, in the order (equation, hidden, a + 4, a + 3), are a product: left (stored
    // transposed, padded with zeros), the loop's motion of lines, right. The loop's motion comes after 3 - a of the
    // joints a + 3 to a + 5, and right holds these: it has 1, 3, 9 or 27 columns, padded with zeros.
    double left[15][168], right[15][32];
    double left_inverse[9][15];       // from a line to the products of (1, cos, sin) of joints a and a + 1
    double axes[6][3], points[6][3];  // directions, and points on them
    double across[3];                 // a unit vector across axis a + 2
    bool slides[6];
    // A bound on the Frobenius norm of what separates the matrices from those of the arm as written: a polynomial in the length of
    // the loop's motion, scaled. Huge for slides.
    double inexact[3];
};

// What rounding leaves out of a variant's factors, for numbers of twice the digits; inexact: the bound with both.
struct PreciseFactors {
    double left[15][168], right[15][32], inexact[3];
};

struct EliminationArm {
    Written<6> written;
    Motion home_inverse;      // of the tip at zero, then moved to the midst of the axes
    double centre[3], scale;  // of the axes [m], and one over their mean distance from it
    bool any_slide;
    bool near;  // whether it is near a special arm: half of the complex solutions are then too far from real to be found
    int variants;
    EliminationVariant variant[3];  // with different cuts, which propose solutions one after the other
    EliminationVariant counter;     // whose determinant's zeros are counted
    PreciseFactors counter_rest;
};

// The number of solutions that each variant alone finds of each pose, and whether it is certain of them (1) and they are proven to
// be all by the zeros of its determinant (2): (variants, poses).
struct EliminationTrial {
    std::uint8_t *counts, *certain;
};

struct EliminationSolvers {
    long (*solve)(const EliminationArm&, const Batch&);
    // What is proven about the solutions of the pose T. Returns whether T is a rigid motion.
    bool (*prove)(const EliminationArm&, const double* T, Proof&);
};

// What preparing an arm needs.
struct EliminationPreparation {
    // Tries `variants` variants on m poses T.
    void (*trial)(const EliminationArm&, const EliminationVariant*, int variants, const double* T, long m, const EliminationTrial&);
};

}  // namespace urdf_ik
