// Divides the boxes of an arm near a family until each is decided.
#pragma once

#include "families/imperfect/certified.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// What the boxes of one pose are decided with.
struct Division {
    const Written<6>& written;
    const BothArms& both;
    const IdealFrames& ideal;
    const Goal<double>& goal;
    const Goal<Block>& target;  // in frame 1
    const Loop& loop;
    const Inclusion& family;
};

// A box is an arc for each joint and a branch. It is slanted along one joint: the arcs move with this joint's value. The next arcs
// are those of the ideal arm's closed form on slanted numbers (arithmetic/slanted.hpp), for the displacements of the joint vectors
// in the box. A turn that the closed form leaves wide is taken from its own arc; the equation that should give it must then hold,
// and empties or shortens the box. A box is decided where
//   it is empty
//   Newton's method from its middle leads to a certified root, alone in a ball that holds the box
//   it lies in a region along a valley whose roots are counted and known (certificate/along_valley.hpp)
// A box that no longer shrinks is halved along the joint that moves the displacement most. open: the branches whose boxes are not
// decided. Adds the roots, and sets the status if every box is decided.
void divide(const Division& of, const Boxes& boxes, unsigned open, Certified& out);

}  // namespace urdf_ik::URDF_IK_LEVEL
