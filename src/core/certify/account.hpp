// The certified roots of one pose, counted against the number that there can be.
//
// If an arm has at most N isolated roots at every pose, N distinct regular ones are all, and there is no continuum beside them:
// regular roots persist at all poses near by, and another root, isolated or not, has regular joint vectors near it, whose poses
// would have N + 1 roots.
#pragma once

#include "certify/circle.hpp"
#include "certify/proof.hpp"
#include "certify/single.hpp"
#include "certify/status.hpp"
#include "numbers/thresholds.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A certified real root: joint values, radius of existence and of uniqueness, and a lower bound on its Jacobian's smallest
// singular value.
struct RealRoot {
    double q[6], inner, outer, least;
};
// A certified root that is not real, as z = e^(i angle). Its conjugate is another one.
struct PairOfRoots {
    double z[6][2], inner, outer;
};

struct Account {
    static constexpr int most = 16;
    Expected expected = {most, Why::theorem};
    RealRoot real[most];
    PairOfRoots pair[most / 2];
    int reals = 0, pairs = 0;

    STEP bool all() const { return reals + 2 * pairs == expected.many && expected.why != Why::unproven; }
};

// A lower bound on the greatest |difference| of two joints, whole turns aside: for x = |e^(i d) - 1| it is |d| >= x / (1 + x). The
// rounding of a conjugate is at most 4 u.
STEP double apart_at_least(const double (&a)[6][2], const double (&b)[6][2]) {
    double most = 0.0;
    for (int k = 0; k < 6; ++k) {
        const double re = a[k][0] - b[k][0], im = a[k][1] - b[k][1];
        const double share = (re * re + im * im) / (b[k][0] * b[k][0] + b[k][1] * b[k][1]);
        most = max(most, share);
    }
    const double x = sqrt(most);
    return x / (1.0 + x) * (1.0 - 1e-12) - 1e-15;
}
// The conjugate angle has one over the conjugate of e^(i angle).
STEP void conjugate(const double (&z)[6][2], double (&out)[6][2]) {
    for (int k = 0; k < 6; ++k) {
        const double w = 1.0 / (z[k][0] * z[k][0] + z[k][1] * z[k][1]);
        out[k][0] = w * z[k][0], out[k][1] = w * z[k][1];
    }
}

// Adds a root unless its ball meets that of a known one: then they may be the same.
STEP bool add_real(Account& account, const RealRoot& root) {
    if (account.reals == Account::most) return false;
    for (int i = 0; i < account.reals; ++i) {
        double most = 0.0;
        for (int j = 0; j < 6; ++j) most = max(most, abs(wrap(root.q[j] - account.real[i].q[j])));
        if (!(most - 1e-15 > root.inner + account.real[i].inner)) return false;
    }
    account.real[account.reals++] = root;
    return true;
}
// The same for a root that is not real: the imaginary part of a joint exceeds its ball. A pair nearer to real than 8 % of OVERLAP,
// which circle.hpp counts, is left to the referee; |z|^2 - 1 is about twice the imaginary part.
STEP bool add_pair(Account& account, const PairOfRoots& root) {
    if (account.pairs == Account::most / 2) return false;
    double conjugated[6][2], far = 0.0;
    conjugate(root.z, conjugated);
    for (int k = 0; k < 6; ++k) far = max(far, abs(root.z[k][0] * root.z[k][0] + root.z[k][1] * root.z[k][1] - 1.0));
    if (far < 0.16 * OVERLAP) return false;
    for (int i = 0; i < account.pairs; ++i) {
        const PairOfRoots& other = account.pair[i];
        const double sum = root.inner + other.inner;
        if (!(apart_at_least(root.z, other.z) > sum) || !(apart_at_least(conjugated, other.z) > sum)) return false;
    }
    account.pair[account.pairs++] = root;
    return true;
}

// The certificates of a block of real joint vectors.
PART Certificate certify_real(const Loop& loop, const Block (&q)[6]) {
    LoopAt<Block> at;
    Orthogonal<Block> f;
    linearise(loop, q, at, f);
    return certify(loop, at, f, growth_of(q));
}

// Newton's method from a block of complex joints, until no lane in use moves by more than half of the digits or for `rounds`
// rounds, and the certificates there.
PART Certificate certify_complex(const Loop& loop, CBlock (&z)[6], unsigned lanes, int rounds, Growth& growth) {
    LoopAt<CBlock> at;
    Orthogonal<CBlock> f;
    converge(z, lanes, rounds, HALF_OF_THE_DIGITS, at, f, [&] { linearise(loop, z, at, f); });
    growth = growth_of(z);
    return certify(loop, at, f, growth);
}

// The account as data: joint values instead of z, both of each pair.
PART void as_data(const Account& account, Proof& out) {
    out.expected = account.expected, out.roots = 0;
    for (int i = 0; i < account.reals; ++i) {
        const RealRoot& each = account.real[i];
        const int to = out.roots++;
        for (int k = 0; k < 6; ++k) out.root[to][k][0] = each.q[k], out.root[to][k][1] = 0.0;
        out.inner[to] = each.inner, out.outer[to] = each.outer, out.real[to] = true;
    }
    for (int i = 0; i < account.pairs; ++i) {
        const PairOfRoots& each = account.pair[i];
        for (int sign = -1; sign <= 1; sign += 2) {
            const int to = out.roots++;
            for (int k = 0; k < 6; ++k) {
                const double square = each.z[k][0] * each.z[k][0] + each.z[k][1] * each.z[k][1];
                out.root[to][k][0] = atan2(each.z[k][1], each.z[k][0]);
                out.root[to][k][1] = sign * 0.5 * logarithm(square);
            }
            // Rounding of the logarithm and the angle, in units of one.
            out.inner[to] = each.inner + 8.0 * UNIT, out.outer[to] = each.outer - 8.0 * UNIT, out.real[to] = false;
        }
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
