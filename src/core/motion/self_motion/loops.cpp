// Curves that pass no value of the grid; see follower.hpp.
#include "motion/self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// The places on followed curves near a point, from which drop_known() decides. Two curves may lie close together, on both sides of
// a nearly straight elbow. The joint that moves most is pinned to its value at the point; the other joints then decide.
void Follower::places_near(const CurveSample& at, const std::vector<std::vector<int>>& by_cell, std::vector<Start>& to) const {
    // A point this close to the end of a cell may lie on a part of its neighbour.
    const long first = cell_of(at.value - NEARLY_SAME), last = cell_of(at.value + NEARLY_SAME);
    for (long cell = first;; cell = last) {
        for (const int part : by_cell[cell]) places_on(parts_[part], at, to);
        if (cell == last) return;
    }
}
void Follower::places_on(const Part& part, const CurveSample& at, std::vector<Start>& to) const {
    const double low = part.samples.front().value, high = part.samples.back().value;
    const double value = turns_ ? low + (principal_angle(at.value - low - PI) + PI) : at.value;
    // A value just below the beginning is wrapped to the far end, so it is tried one turn lower too.
    for (const double there : {value, turns_ ? value - 2.0 * PI : value}) {
        if (there < low - NEARLY_SAME || there > high + NEARLY_SAME) continue;
        for (std::size_t i = 1; i < part.samples.size(); ++i) {
            const CurveSample &a = part.samples[i - 1], &b = part.samples[i];
            if (there > b.value + NEARLY_SAME || there < a.value - NEARLY_SAME) continue;
            if (!nearer(at.q, a.q, 1.1 * b.arc + NEARLY_SAME)) continue;
            double u = way_to(a, b, at), q[7], t[7];
            for (int round = 0; round < 3; ++round) {
                between(a, b, u, q, t);
                double off = 0.0, square = 1e-300;
                for (int j = 0; j < 7; ++j) off += gap(j, at.q[j], q[j]) * t[j], square += t[j] * t[j];
                u = std::clamp(u + off / square, 0.0, 1.0);
            }
            Start place = start(MANY_ROUNDS, NEARLY_EXACT);
            between(a, b, u, place.q);
            if (!nearer(place.q, at.q, NEARLY_SAME)) continue;
            int most = 0;
            for (int j = 1; j < 7; ++j) most = std::abs(t[j]) > std::abs(t[most]) ? j : most;
            place.pin = {Pin::joint, most, at.q[most]};
            to.push_back(place);
        }
    }
}
std::vector<std::vector<int>> Follower::parts_by_cell() const {
    std::vector<std::vector<int>> out(cells_);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        if (!parts_[i].used) out[parts_[i].cell].push_back(int(i));
    }
    return out;
}

// Whether a point lies on a followed curve.
bool Follower::known(const CurveSample& at) const {
    std::vector<CurveSample> left(1, at);
    drop_known(left);
    return left.empty();
}

// The same for many points, side by side; those that do not are left over.
void Follower::drop_known(std::vector<CurveSample>& points) const {
    std::vector<Start> starts;
    std::vector<OnCurve> places;
    std::vector<std::size_t> ends;
    const std::vector<std::vector<int>> by_cell = parts_by_cell();
    for (const CurveSample& each : points) {
        places_near(each, by_cell, starts);
        ends.push_back(starts.size());
    }
    settle(starts, places);
    std::size_t place = 0, kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        bool found = false;
        for (; place < ends[i]; ++place)
            found |= !is_settled(places[place], NEARLY_EXACT) || nearer(places[place].q, points[i].q, SAME);
        if (!found) points[kept++] = points[i];
    }
    points.resize(kept);
}

// Follow a curve without a known solution at a value of the grid, from a point found on it.
void Follower::add_loop(const CurveSample& at) {
    const long cell = cell_of(at.value);
    const double value = value_from_first(at.value);
    if (value < low_of(cell) || value > high_of(cell)) return;
    CurveSample from = at;
    from.value = value;
    if (from.rate < 0.0) flip(from);
    if (from.rate < NEARLY_EXACT) return;
    std::optional<Travel> travel;
    follow({&travel.emplace(*this, from, low_of(cell), high_of(cell))});
    if (travel->stop == Stop::lost) {
        straight_ = true;
        follow({&travel.emplace(*this, from, low_of(cell), high_of(cell))});
        straight_ = false;
    }
    const Stop stop = travel->stop;
    const std::vector<CurveSample>& way = travel->way;
    const std::vector<long>& folds = travel->folds;
    if (stop == Stop::closed) {
        // Rotate the samples so that the loop begins and ends at a fold.
        if (folds.size() < 2) return;
        std::vector<CurveSample> turned(way.begin() + folds[0], way.end());
        for (long i = 1; i <= folds[0]; ++i) turned.push_back(way[i]);
        std::vector<long> cuts;
        for (std::size_t i = 1; i < folds.size(); ++i) cuts.push_back(folds[i] - folds[0]);
        add_parts(cell, turned, cuts, {}, true, Stop::closed);
        return;
    }
    if (stop == Stop::lost) return;
    // The curve leaves the cell at a solution that was not given. It becomes a node.
    const long k = stop == Stop::high ? next(cell) : cell;
    if (node_at(k, way.back()) >= 0) return;
    add_node(k, way.back(), -1);
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
    std::vector<Start> starting;
    std::vector<OnCurve> there;
    for (int i = 0; i < many; ++i) std::copy_n(&found[7 * i], 7, starting.emplace_back(start(0, 0.0)).q);
    settle(starting, there);
    std::vector<CurveSample> points;
    for (const OnCurve& each : there) points.push_back(sample_of(each, each.value));
    drop_known(points);
    bool fresh = false;  // whether a curve was added that may pass through further points
    for (CurveSample& at : points) {
        if (has_enough()) break;
        if (fresh && known(at)) continue;
        if (!settle(at.q, at.along, 0.0, at)) continue;
        if (!given_.round && (at.value < given_.grid[0] || at.value > given_.grid[given_.values - 1])) continue;
        if (std::abs(at.rate) < NEARLY_EXACT || known(at)) continue;
        add_loop(at);
        fresh = true;
    }
}

}  // namespace urdf_ik::self_motion
