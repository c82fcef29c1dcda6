// Two or three parallel turning joints and at most one slide along them: planar 2R and 3R arms, and SCARA robots.
//
// In the plane a e(psi1) + b e(psi2) = (x, y), with psi the links' angles against the plane's first axis (law of cosines); the
// third joint gives the tip's orientation, the slide its height. Poses near the edge of reach, or with inexact rotations, are
// solved as for few joints. Columns: elbow left, elbow right.
#pragma once

#include "arm/subproblems.hpp"
#include "families/blocks.hpp"
#include "families/few_joints/few_joints.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// of_points: the targets are points in the plane, for two joints.
template <int N, bool of_points = false> struct Planar {
    using Arm = PlanarArm<N>;
    static constexpr int branches = 2;

    static STEP void fast(const Arm& arm, const Seen<Block>& seen, Found<2, N>& found) {
        const double *sign = arm.sign, size = arm.written.size;
        const double edge = arm.written.tolerances.edge, reach = arm.written.tolerances.reach;
        const Vec<Block>& p = seen.p;
        const Elbow<Block> at = elbow<Block>(p.x, p.y, arm.link[0], arm.link[1], 1.0, Block(1.0));
        // The other branch is the mirror image of the two links in the line to the point.
        const Block psi = angle(at.second), bend = angle(at.bend), mirrored = 2.0 * atan2(p.y, p.x) - psi;
        const Block first[2] = {mirrored, psi}, bends[2] = {-bend, bend};
        auto near = (abs(at.margin) <= Block(edge)) | (p.x * p.x + p.y * p.y <= Block(edge * size * size));
        auto lost = at.margin <= Block(0.0);
        Block turn = 0.0;
        if constexpr (!of_points) {
            const Rot<Block>& R = seen.R;
            const Block tilt = max(max(abs(R.z.x), abs(R.z.y)), max(abs(R.x.z), abs(R.y.z)));
            const double free_height = arm.joint[3] >= 0 ? __builtin_inf() : reach * size;
            lost = lost | (tilt > Block(reach)) | (R.z.z <= Block(0.0)) | (abs(p.z) > Block(free_height));
            near = near & (tilt <= Block(2.0 * reach));
            turn = atan2(R.x.y, R.x.x);
        }
        const double free_turn = of_points || arm.joint[2] >= 0 ? __builtin_inf() : reach;
        for (int b = 0; b < 2; ++b) {
            const Block rest = wrap(wrap(turn - (first[b] + bends[b]) + arm.angle[1]));
            Block q[N];
            q[arm.joint[0]] = shown(sign[0] * wrap(first[b] - arm.angle[0]));
            q[arm.joint[1]] = shown(sign[1] * (bends[b] - arm.bend));
            if (N > 2 && arm.joint[2] >= 0) q[arm.joint[2]] = shown(sign[2] * rest);
            if (N > 2 && arm.joint[3] >= 0) q[arm.joint[3]] = sign[3] * p.z;
            found.set(b, q, (lost | (abs(rest) > Block(free_turn))) & !near, near);
        }
    }

    // The angle, at most a turn off, wrapped to (-pi, pi], with -0 made 0.
    static STEP Block shown(const Block& q) { return wrap(q) + 0.0; }

    static PART void closely(const Arm& arm, const Goal<double>& goal, const Seen<double>&, const Reference<N>& reference,
                             const Columns<N>& columns, unsigned) {
        columns.clear();
        const Status status = FewJoints<N, 2>::find(arm, goal, reference, columns);
        // Order the columns by the bend of the elbow; a straight arm goes to the first column.
        const auto bend = [&](int b) { return wrap(arm.sign[1] * columns.row(b)[arm.joint[1]] + arm.bend); };
        if (columns.valid(0) && bend(0) > 0.0 && (!columns.valid(1) || bend(1) <= 0.0)) columns.swap(0, 1);
        for (int b = 0; b < 2; ++b) {
            if (columns.flags[b] & OTHER) columns.flags[b] = VALID | ELBOW;
        }
        set_status(columns.flags[0], status);
    }
};

// Points (x, y) m in the plane, along its frame's axes from the base's origin.
template <int N> struct PlanarPoints : Planar<N, true> {
    static constexpr int numbers = 2;

    static STEP void load(const PlanarArm<N>& arm, const double* from, Block (&t)[16]) {
        Block x, y;
        for (int i = 0; i < BLOCK; ++i) x.set(i, from[2 * i]), y.set(i, from[2 * i + 1]);
        const auto& B = arm.ideal.base_rotation;
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 3; ++j) t[4 * i + j] = i == j ? 1.0 : 0.0;
            t[4 * i + 3] = i < 3 ? B[0][i] * x + B[1][i] * y : Block(1.0);
        }
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
