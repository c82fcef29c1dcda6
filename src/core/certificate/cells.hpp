// Cells of two numbers, and what is found in them; see on_surface.hpp.
#pragma once

#include "certificate/along_valley.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Rounding of a cell's middle [rad]: of a few sums of numbers below LARGEST_SURFACE.
inline constexpr double ROUNDED_CELL = 1e-16;

// The points with |x| <= h_0, |y| <= h_1, where t_axis = c_axis + x + slant y, and the other number is that of c and y: a cell may
// be slanted along a curve that it holds a piece of.
struct Cell {
    double c[2], h[2], slant = 0.0;
    int axis = 0;

    STEP double reach(int i) const { return i == axis ? h[0] + abs(slant) * h[1] : h[1]; }
    STEP void move(double x, double y) { c[axis] += x + slant * y, c[1 - axis] += y; }
    // x and y of a point.
    STEP void place(const double (&t)[2], double (&to)[2]) const {
        to[1] = t[1 - axis] - c[1 - axis], to[0] = t[axis] - c[axis] - slant * to[1];
    }
    // Squares about 0 up to this do not meet it.
    STEP double nearest() const { return max(abs(c[0]) - reach(0), abs(c[1]) - reach(1)); }
};

// Whether a cell meets another (side = -1), or lies within it (side = 1), by bounds on its x and y there.
STEP bool is_in(const Cell& a, const Cell& other, double side) {
    double at[2], half[2];
    other.place(a.c, at);
    if (a.axis == other.axis) half[0] = a.h[0] + abs(a.slant - other.slant) * a.h[1], half[1] = a.h[1];
    else half[0] = abs(other.slant) * a.h[0] + abs(1.0 - a.slant * other.slant) * a.h[1], half[1] = a.h[0] + abs(a.slant) * a.h[1];
    return abs(at[0]) + side * half[0] <= other.h[0] && abs(at[1]) + side * half[1] <= other.h[1];
}
STEP bool meets(const Cell& a, const Cell& other) { return is_in(a, other, -1.0); }
STEP bool is_within(const Cell& a, const Cell& other) { return is_in(a, other, 1.0); }
STEP Cell square_of(double half) { return {{0.0, 0.0}, {half, half}}; }

// A zero of F in `in`, the only one in `alone`; or an area that one joint vector stands for.
struct Zero {
    Cell in, alone;
    bool single;
    double t[2], value;  // the zero, or where |F| is least among what was seen of an area, and |F| there
    bool crosses = false;  // whether an area goes on beyond the side of the whole
    // Whether a point is this one, if F is zero there.
    STEP bool holds(const double (&at)[2]) const {
        double x[2];
        alone.place(at, x);
        return abs(x[0]) <= alone.h[0] && abs(x[1]) <= alone.h[1];
    }
};

struct Zeros {
    static constexpr int most = 16;
    Zero at[most];
    int many = 0;
    double along;  // these are all with |t_1|, |t_2| <= along
};

// Areas that stand for others at most.
inline constexpr int MOST_JOINED = 16;
// Cells; those that touch are one.
struct Joined {
    Zero at[MOST_JOINED];
    int many = 0;

    // value: |F| in the middle. Returns whether there is room.
    bool add(const Cell& cell, double value) {
        const Cell around = {{cell.c[0], cell.c[1]}, {cell.reach(0), cell.reach(1)}};
        Zero all = {around, around, false, {cell.c[0], cell.c[1]}, value};
        for (int k = 0; k < many;) {
            const Zero& each = at[k];
            Cell wider = all.in;
            for (double& h : wider.h) h += LEAST_PIECE;
            if (!meets(each.in, wider)) {
                ++k;
                continue;
            }
            for (int j = 0; j < 2; ++j) {
                const double low = min(all.in.c[j] - all.in.h[j], each.in.c[j] - each.in.h[j]);
                const double high = max(all.in.c[j] + all.in.h[j], each.in.c[j] + each.in.h[j]);
                all.in.c[j] = 0.5 * (low + high), all.in.h[j] = 0.5 * (high - low) + ROUNDED_CELL;
                if (each.value < all.value) all.t[j] = each.t[j];
            }
            all.value = min(all.value, each.value), all.alone = all.in;
            // The grown one may touch others.
            at[k] = at[--many], k = 0;
        }
        if (many == MOST_JOINED) return false;
        at[many++] = all;
        return true;
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
