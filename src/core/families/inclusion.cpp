// See inclusion.hpp. Compiled once for every instruction set.
#include "families/inclusion.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The boxes that hold a joint vector, given by the points of its joints' angles (offsets included) on the circle, or are so near to
// it that what they hold stands as one with it.
STEP unsigned inside(const Boxes& boxes, const Turn<double> (&at)[6]) {
    unsigned out = 0;
    for (int first = 0; first < 8; first += BLOCK) {
        Block beyond = -1.0;
        for (int j = 0; j < 6; ++j) {
            const Block c = load<Block>(boxes.c[j] + first) - at[j].c, s = load<Block>(boxes.s[j] + first) - at[j].s;
            beyond = max(beyond, root(c * c + s * s) - load<Block>(boxes.chord[j] + first));
        }
        out |= bits(beyond <= Block(NEARER_THAN_ROUNDING)) << first;
    }
    return out;
}

// The boxes that hold the solution in a column; see inside().
STEP unsigned held_by(const IdealFrames& ideal, const Boxes& boxes, const double* q) {
    Row<8> angles = 0.0;
    for (int j = 0; j < 6; ++j) angles.set(j, q[j] + ideal.offset[j]);
    const Turn<Row<8>> points = cos_sin_of_any(angles);
    Turn<double> at[6];
    for (int j = 0; j < 6; ++j) at[j] = {points.c[j], points.s[j]};
    return inside(boxes, at) & ~boxes.empty & 255u;
}

Filled filled_by(const IdealFrames& ideal, const Boxes& boxes, const Columns<6>& columns) {
    Filled out;
    for (int k = 0; k < columns.many; ++k) {
        if (!columns.valid(k)) continue;
        const unsigned in = held_by(ideal, boxes, columns.row(k));
        out.in[k] = in, out.all = out.all && in;
        out.met |= in;
        // One column owns one box: a sure one rather than another.
        unsigned alone = in & ~boxes.free & ~out.owned;
        if (alone & boxes.sure()) alone &= boxes.sure();
        out.owned |= alone & -alone;
    }
    return out;
}

Status decided(const IdealFrames& ideal, const Boxes& boxes, const Filled& filled, unsigned counted) {
    if (!filled.all) return Status::incomplete;
    const unsigned there = ~boxes.empty & 255u, owned = filled.owned;
    // A solution on the curve of a box that leaves a joint free decides the status, whatever is open elsewhere.
    if (boxes.free & there & ~owned & filled.met) return Status::continuum;
    Status status = owned & ~boxes.sure() || counted & there ? Status::clustered : Status::complete;
    for (int b = 0; b < 8; ++b) {
        const unsigned bit = 1u << b;
        if (!(there & ~owned & ~counted & bit)) continue;
        if (boxes.free & bit) return Status::incomplete;
        unsigned twins = 0;
        if (boxes.wide(b)) return Status::incomplete;
        for (int k = 0; k < 3; ++k) {
            if (boxes.open[k] & ~boxes.tiny[k] & bit) return Status::incomplete;
        }
        for (int c = 0; c < 8; ++c) {
            bool near = true;
            for (int k = 0; k < 3; ++k) near = near && (boxes.tiny[k] & bit || ideal.signs[k][b] == ideal.signs[k][c]);
            for (int j = 0; j < 6; ++j) {
                near = near && abs(boxes.c[j][b] - boxes.c[j][c]) + abs(boxes.s[j][b] - boxes.s[j][c]) <= NEAR;
            }
            twins |= unsigned(near) << c;
        }
        if (!(twins & owned)) return Status::incomplete;
        status = Status::clustered;
    }
    return status;
}

bool is_settled(const Written<6>& arm, const Goal<double>& goal, const Boxes& boxes, const Filled& filled,
                const Columns<6>& columns) {
    unsigned settled = (boxes.empty | filled.owned) & 255u;
    if ((settled | (filled.met & boxes.free)) != 255u) return false;
    for (int k = 0; k < columns.many; ++k) {
        unsigned rest = filled.in[k] & boxes.free & ~settled;
        if (!rest) continue;
        Six<double> J[6];
        derivatives_at(arm, goal, columns.row(k), J);
        for (; rest; rest &= rest - 1) {
            const int b = __builtin_ctz(rest);
            int first = -1;
            double apart = 0.0;
            for (int j = 0; j < 6; ++j) {
                if (boxes.chord[j][b] <= NEARER_THAN_ROUNDING) continue;
                if (first < 0) first = j;
                const Six<double>&a = J[first], &c = J[j];
                const double same = a[3] * c[3] + a[4] * c[4] + a[5] * c[5] < 0.0 ? -1.0 : 1.0;
                for (int i = 0; i < 6; ++i) apart = max(apart, abs(a[i] - same * c[i]));
            }
            if (apart <= NEARER_THAN_ROUNDING) settled |= 1u << b;
        }
    }
    return settled == 255u;
}

unsigned boxes_with_folds(const Written<6>& arm, const IdealFrames& ideal, const Goal<double>& goal, const Boxes& boxes,
                          const Boxes& folds, const Columns<6>& columns) {
    const auto &open = boxes.open, &tiny = folds.tiny;
    const unsigned merged = ~((open[0] & ~tiny[0]) | (open[1] & ~tiny[1]) | (open[2] & ~tiny[2]));
    const unsigned several = (open[0] & open[1]) | (open[0] & open[2]) | (open[1] & open[2]);
    unsigned narrow = ~(boxes.empty | boxes.free | boxes.sure() | folds.empty | folds.free) & 255u;
    for (int j = 0; j < 6; ++j) {
        for (int b = 0; b < 8; ++b) narrow &= ~(unsigned(!(folds.chord[j][b] <= NEARER_THAN_ROUNDING)) << b);
    }
    Filled filled = filled_by(ideal, boxes, columns);
    unsigned kept = 0;
    for (unsigned rest = narrow & ~filled.owned; rest; rest &= rest - 1) {
        const int b = __builtin_ctz(rest);
        double middle[6];
        for (int j = 0; j < 6; ++j) middle[j] = wrap(atan2(folds.s[j][b], folds.c[j][b]) - ideal.offset[j]);
        const double error = missed_by(arm, goal, middle);
        kept |= unsigned(error <= FINISHED) << b;
        if ((filled.met | ~merged) >> b & 1u || !(error <= arm.tolerances.reach) || !is_new(arm, goal, columns, middle)) continue;
        keep(columns, b, middle, singular_marks(arm, goal, middle, 0));
    }
    filled = filled_by(ideal, boxes, columns);
    unsigned out = 0;
    for (int k = 0; k < columns.many; ++k) {
        if (!columns.valid(k)) continue;
        const unsigned at = held_by(ideal, folds, columns.row(k)) & narrow & ~filled.owned;
        out |= at & (merged | (kept & ~several));
        if (!(at & ~several & ~out) || !(missed_by(arm, goal, columns.row(k)) <= FINISHED)) continue;
        for (int b = 0; b < 8; ++b) {
            unsigned twins = 255u;
            for (int i = 0; i < 3; ++i) {
                for (int c = 0; c < 8 && !(open[i] >> b & 1u); ++c) {
                    twins &= ~(unsigned(ideal.signs[i][b] != ideal.signs[i][c]) << c);
                }
            }
            if (!(filled.in[k] & ~twins)) out |= at & ~several & 1u << b;
        }
    }
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
