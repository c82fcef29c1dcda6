// Curves that pass no value of the grid; see follower.hpp.
#include "self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// Whether the curve near q, with tangent t, passes through a point. Two curves may lie close together, on both sides of a nearly
// straight elbow. The joint that moves most is pinned to its value at the point; the other joints then decide.
bool Follower::meets(const double* q, const double* t, const CurveSample& point) const {
    int most = 0;
    for (int j = 1; j < 7; ++j) most = std::abs(t[j]) > std::abs(t[most]) ? j : most;
    CurveSample there;
    if (!settle(q, {Pin::joint, most, point.q[most]}, t, point.value, NEARLY_EXACT, there)) return true;
    return apart(there.q, point.q) < SAME;
}

// Whether a point lies on a followed curve.
bool Follower::known(const CurveSample& at) const {
    for (const Part& part : parts_) {
        const double low = part.samples.front().value, high = part.samples.back().value;
        const double value = turns_ ? low + (wrapped(at.value - low - PI) + PI) : at.value;
        // A value just below the beginning is wrapped to the far end, so it is tried one turn lower too.
        for (const double there : {value, turns_ ? value - TURN : value}) {
            if (there < low - NEARLY_SAME || there > high + NEARLY_SAME) continue;
            for (std::size_t i = 1; i < part.samples.size(); ++i) {
                const CurveSample &a = part.samples[i - 1], &b = part.samples[i];
                if (there > b.value + NEARLY_SAME || there < a.value - NEARLY_SAME) continue;
                if (apart(at.q, a.q) > 1.1 * b.arc + NEARLY_SAME) continue;
                double along = 0.0;
                for (int j = 0; j < 7; ++j) along += gap(j, at.q[j], a.q[j]) * a.along[j];
                double u = std::clamp(along / (b.arc + 1e-300), 0.0, 1.0), q[7], t[7];
                for (int round = 0; round < 3; ++round) {
                    between(a, b, u, q, t);
                    double off = 0.0, square = 1e-300;
                    for (int j = 0; j < 7; ++j) off += gap(j, at.q[j], q[j]) * t[j], square += t[j] * t[j];
                    u = std::clamp(u + off / square, 0.0, 1.0);
                }
                between(a, b, u, q);
                if (apart(q, at.q) < NEARLY_SAME && meets(q, t, at)) return true;
            }
        }
    }
    return false;
}

// Follow a curve without a known solution at a value of the grid, from a point found on it.
void Follower::add_loop(const CurveSample& at) {
    long cell = 0;
    double value = at.value;
    if (turns_ && given_.round) value = given_.grid[0] + (wrapped(value - given_.grid[0] - PI) + PI);
    while (cell + 1 < cells_ && value >= high_of(cell)) ++cell;
    if (value < low_of(cell) || value > high_of(cell)) return;
    CurveSample from = at;
    from.value = value;
    if (from.rate < 0.0) flip(from);
    if (from.rate < STANDS) return;
    std::vector<CurveSample> way;
    std::vector<long> folds;
    Stop stop = travel(from, low_of(cell), high_of(cell), way, folds);
    if (stop == Stop::lost) {
        straight_ = true, folds.clear();
        stop = travel(from, low_of(cell), high_of(cell), way, folds);
        straight_ = false;
    }
    if (stop == Stop::closed) {
        // Rotate the samples so that the loop begins and ends at a fold.
        if (folds.size() < 2) return;
        std::vector<CurveSample> turned(way.begin() + folds[0], way.end());
        for (long i = 1; i <= folds[0]; ++i) turned.push_back(way[i]);
        std::vector<long> cuts;
        for (std::size_t i = 1; i < folds.size(); ++i) cuts.push_back(folds[i] - folds[0]);
        add_parts(cell, turned, cuts, -1, -1, true, Stop::closed);
        return;
    }
    if (stop == Stop::lost) return;
    // The curve leaves the cell at a solution that was not given. It becomes a node.
    const long k = stop == Stop::high ? next(cell) : cell;
    if (node_at(k, way.back()) >= 0) return;
    CurveSample node = way.back();
    node.value = given_.grid[k];
    if (node.rate < 0.0) flip(node);
    add_node(k, node, -1);
    follow_cells();
}

// Add starts for the search: the points of the closed form's branches beyond their ends at which the pose error has a minimum or
// which are next to an end, and their neighbours.
void Follower::add_nearest(std::vector<double>& starts) const {
    if (!given_.beyond) return;
    const long fine = given_.fine, branches = given_.branches;
    std::vector<double> errors(fine * branches);
    core_.errors(arm_, given_.T, given_.beyond, fine * branches, errors.data());
    const auto error = [&](long k, long b) {
        if (k < 0 || k >= fine) {
            if (!given_.round) return INFINITY;
            k = (k + fine) % fine;
        }
        return float(errors[k * branches + b]);
    };
    std::vector<bool> wanted(fine);
    for (long b = 0; b < branches; ++b) {
        std::fill(wanted.begin(), wanted.end(), false);
        for (long k = 0; k < fine; ++k) {
            const float here = error(k, b), before = error(k - 1, b), after = error(k + 1, b);
            if (!(here > given_.off && here < FAR_FROM)) continue;
            const bool nearest = !(before < here) && !(after < here), at_end = before <= given_.off || after <= given_.off;
            if (!nearest && !at_end) continue;
            // Another loop may lie beside the nearest one.
            for (long near = k - BESIDE; near <= k + BESIDE; ++near) {
                if (given_.round || (near >= 0 && near < fine)) wanted[(near + fine) % fine] = true;
            }
        }
        for (long k = 0; k < fine; ++k) {
            const float here = error(k, b);
            if (!wanted[k] || !(here > given_.off && here < FAR_FROM)) continue;
            const double* q = given_.beyond + 7 * (k * branches + b);
            starts.insert(starts.end(), q, q + 7);
        }
    }
}

void Follower::look_for_loops() {
    std::vector<double> starts(given_.starts, given_.starts + 7 * given_.count);
    add_nearest(starts);
    const int count = int(starts.size() / 7);
    std::vector<double> found(starts.size());
    const int many = count ? core_.search(arm_, given_.T, starts.data(), count, found.data()) : 0;
    for (int i = 0; i < many && !has_enough(); ++i) {
        const double* q = &found[7 * i];
        CurveSample at;
        std::copy_n(q, 7, at.q);
        at.value = arm_.given >= 0 ? q[arm_.given] : core_.settle(arm_, given_.T, q, {Pin::nothing, 0, 0.0}, 0, 0.0).value;
        if (known(at)) continue;
        const double along[7] = {};
        if (!settle(q, {Pin::nothing, 0, 0.0}, along, 0.0, EXACT, at)) continue;
        if (!given_.round && (at.value < given_.grid[0] || at.value > given_.grid[given_.values - 1])) continue;
        if (std::abs(at.rate) < STANDS || known(at)) continue;
        add_loop(at);
    }
}

}  // namespace urdf_ik::self_motion
