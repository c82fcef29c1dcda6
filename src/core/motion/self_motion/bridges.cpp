// Joining solutions at neighbouring values of the grid without following; see follower.hpp.
#include "motion/self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// The difference between two samples' chord and the mean of their tangents times the arc, as a share of the arc. Small on a short
// circular arc; infinite if the two samples cannot be joined.
double Follower::off_line(const CurveSample& a, const CurveSample& b, double& arc, double& turned) const {
    double way[7], square = 0.0, same = 0.0;
    if (!agree(a, b)) return INFINITY;
    for (int j = 0; j < 7; ++j) {
        way[j] = gap(j, b.q[j], a.q[j]);
        if (std::abs(way[j]) > BRIDGE) return INFINITY;
        square += way[j] * way[j], same += a.along[j] * b.along[j];
    }
    if (same < 0.5) return INFINITY;  // a turn of more than twice TOO_MUCH
    turned = std::acos(std::min(same, 1.0));
    arc = std::sqrt(square) * (1.0 + turned * turned / 24.0);
    if (!(arc <= BRIDGE && turned <= 2.0 * TOO_MUCH)) return INFINITY;
    double off = 0.0;
    for (int j = 0; j < 7; ++j) off += std::pow(way[j] - 0.5 * arc * (a.along[j] + b.along[j]), 2);
    return std::sqrt(off) / (arc + 1e-300);
}

// Halve bridges until their steps are as short as those of step(), at least once. A bridge is given up if the value does not grow
// all the way, if a step is no short arc, or if a middle is far from the cubic, or not between its neighbours' values.
void Follower::halve(std::vector<Bridge>& bridges) const {
    struct Gap {
        Bridge* of;
        std::list<CurveSample>::iterator end;
    };
    std::vector<Gap> gaps, halved;
    for (Bridge& each : bridges) gaps.push_back({&each, std::prev(each.way.end())});
    std::vector<Start> middles;
    std::vector<OnCurve> points;
    for (int depth = 0; depth <= MOST_HALVED; ++depth) {
        middles.clear(), halved.clear();
        for (const Gap& gap : gaps) {
            const CurveSample& a = *std::prev(gap.end);
            CurveSample& b = *gap.end;
            double arc, turned;
            gap.of->good = gap.of->good && off_line(a, b, arc, turned) <= BRIDGE_OFF;
            if (!gap.of->good) continue;
            b.arc = arc;
            if (depth && arc <= LONGEST && turned <= 2.0 * AIM && least_rate(a, b) > 0.0) continue;
            gap.of->good = depth < MOST_HALVED;
            halved.push_back(gap);
            between(a, b, 0.5, middles.emplace_back(start(FEW_ROUNDS, ON_THE_WAY)).q);
        }
        settle(middles, points);
        gaps.clear();
        for (std::size_t i = 0; i < halved.size(); ++i) {
            const auto& [bridge, end] = halved[i];
            const CurveSample &a = *std::prev(end), &b = *end, middle = oriented(points[i], a.along, a.value);
            bridge->good = bridge->good && points[i].left <= ON_THE_WAY && points[i].moved <= 0.25 * ASIDE * b.arc &&
                           middle.rate > 0.0 && middle.value > a.value && middle.value < b.value;
            gaps.push_back({bridge, bridge->way.insert(end, middle)});
            gaps.push_back(halved[i]);
        }
    }
}

// Join solutions at the two ends of cells that clearly lie on one curve.
void Follower::bridge_cells() {
    std::vector<Bridge> bridges;
    for (long cell = 0; cell < cells_; ++cell) {
        const long after = next(cell);
        for (long i = 0; i < long(nodes_[cell].size()); ++i) {
            const Node& from = nodes_[cell][i];
            if (from.stands || from.part[0] >= 0) continue;
            long best = -1;
            double least = INFINITY, second = INFINITY, arc, turned;
            for (long j = 0; j < long(nodes_[after].size()); ++j) {
                const double off = off_line(from.at, nodes_[after][j].at, arc, turned);
                if (off < least) second = least, least = off, best = j;
                else second = std::min(second, off);
            }
            if (best < 0 || least > BRIDGE_OFF || second < BRIDGE_CLEAR * least) continue;
            const Node& to = nodes_[after][best];
            if (to.stands || to.part[1] >= 0) continue;
            Bridge& bridge = bridges.emplace_back();
            bridge.from = {cell, i};
            bridge.way = {from.at, to.at};
            bridge.way.front().value = low_of(cell), bridge.way.back().value = high_of(cell);
        }
    }
    halve(bridges);
    for (const Bridge& bridge : bridges) {
        if (!bridge.good) continue;
        const std::size_t parts = parts_.size();
        std::vector<CurveSample> way(bridge.way.begin(), bridge.way.end());
        if (add_parts(bridge.from.k, way, {}, bridge.from, true, Stop::high)) parts_[parts].bridge = true;
    }
}
// Undo the bridges of a cell: its curves contradict each other.
void Follower::drop_bridges(long cell) {
    for (Node& from : nodes_[cell]) {
        if (from.part[0] < 0 || !parts_[from.part[0]].bridge) continue;
        Part& part = parts_[from.part[0]];
        node(part.node[1]).part[1] = from.part[0] = -1;
        part.used = true;
    }
}

}  // namespace urdf_ik::self_motion
