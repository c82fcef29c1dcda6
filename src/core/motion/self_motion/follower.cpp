// Following curves from one value of the grid to the next; see follower.hpp.
#include "motion/self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// The index of the node at a value of the grid that equals this sample, or -1.
long Follower::node_at(long k, const CurveSample& at) const {
    long best = -1;
    double nearest = SAME;
    for (long i = 0; i < long(nodes_[k].size()); ++i) {
        if (nearer(nodes_[k][i].at.q, at.q, nearest)) nearest = apart(nodes_[k][i].at.q, at.q), best = i;
    }
    return best;
}

// Split a followed curve at its folds and add the parts. Returns false if it ends at its own start, or at a node that another
// curve has met from this side.
bool Follower::add_parts(long cell, std::vector<CurveSample>& way, const std::vector<long>& folds, const Place& from, bool up,
                         Stop stop) {
    Place to;
    if (stop == Stop::low || stop == Stop::high) {
        const int side = stop == Stop::high;
        to.k = side ? next(cell) : cell;
        to.i = node_at(to.k, way.back());
        if (to.i < 0) to.i = add_node(to.k, way.back(), -1);
        if (node(to).part[side] >= 0 || (to == from && bool(side) == !up)) return false;
    }
    std::vector<long> cuts = folds;
    cuts.insert(cuts.begin(), 0);
    cuts.push_back(long(way.size()) - 1);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        if (cuts[i + 1] <= cuts[i]) continue;
        Part part;
        part.cell = cell;
        part.samples.assign(way.begin() + cuts[i], way.begin() + cuts[i + 1] + 1);
        const bool last = i + 2 == cuts.size(), grows = part.samples.back().value >= part.samples.front().value;
        const int end = grows ? 1 : 0;
        if (i == 0) part.node[!end] = from;
        if (last) part.node[end] = to;
        for (int side = 0; side < 2; ++side) {
            if (part.node[side].k >= 0) node(part.node[side]).part[side] = int(parts_.size());
        }
        if (last && stop == Stop::lost) part.why[end] = EndOf::singularity;
        if (!grows) {
            std::reverse(part.samples.begin(), part.samples.end());
            for (CurveSample& each : part.samples) flip(each);
            // The arc belongs to the step before a sample.
            for (std::size_t k = part.samples.size() - 1; k > 0; --k) part.samples[k].arc = part.samples[k - 1].arc;
        }
        part.samples.front().arc = 0.0;
        parts_.push_back(std::move(part));
    }
    return true;
}

// Follow the curve of every solution at the ends of a cell into the cell. Returns false if a curve was contradicted (see
// add_parts), or lost while crossings were not allowed.
bool Follower::follow_cell(long cell) {
    const double low = low_of(cell), high = high_of(cell);
    bool agrees = true;
    for (int side = 0; side < 2; ++side) {
        const long k = side ? next(cell) : cell;
        for (long i = 0; i < long(nodes_[k].size()); ++i) {
            const Node& node = nodes_[k][i];
            if (node.stands || node.part[side] >= 0) continue;
            CurveSample from = node.at;
            if (side) {
                flip(from);
                from.value = high;
            }
            Travel* travel = straight_ || longest_ != LONGEST ? nullptr : node.ahead[side].get();
            std::optional<Travel> fresh;
            if (!travel) follow({travel = &fresh.emplace(*this, from, low, high)});
            const Stop stop = travel->stop;
            if (!add_parts(cell, travel->way, travel->folds, {k, i}, !side, stop) || (stop == Stop::lost && !straight_))
                agrees = false;
        }
    }
    return agrees;
}

void Follower::follow_cells() {
    for (int pass = 0; pass < 3 && !has_enough(); ++pass) {
        bool open = false;
        bridge_cells();
        travel_ahead();
        for (long cell = 0; cell < cells_ && !has_enough(); ++cell) {
            const std::size_t parts = parts_.size();
            for (int redone = 0; !follow_cell(cell) && redone < MOST_REDONE; ++redone) {
                // Either a curve was lost, perhaps because another one crosses it: the next try allows it to go straight on.
                // Or two curves met one solution, so one of them has jumped: later tries also take shorter steps.
                if (straight_) {
                    longest_ *= 0.3;
                    drop_bridges(cell);
                }
                straight_ = true;
                parts_.resize(parts);
                for (const long k : {cell, next(cell)}) {
                    for (Node& node : nodes_[k]) {
                        for (int& part : node.part) part = part < int(parts) ? part : -1;
                    }
                }
            }
            longest_ = LONGEST, straight_ = false;
        }
        for (long k = 0; k < given_.values; ++k) {
            for (const Node& node : nodes_[k]) {
                const bool first = !given_.round && k == 0, last = !given_.round && k + 1 == given_.values;
                open |= !node.stands && ((node.part[1] < 0 && !first) || (node.part[0] < 0 && !last));
            }
        }
        if (!open) break;
    }
}

// The piece that begins with this part.
Piece Follower::joined(Part& first) {
    Piece out;
    out.samples.reserve(4 * cells_);
    out.why[0] = first.node[0].k >= 0 ? EndOf::range : first.why[0];
    out.closed = false;
    Part* part = &first;
    double turned = 0.0;
    for (;;) {
        part->used = true;
        for (std::size_t i = out.samples.empty() ? 0 : 1; i < part->samples.size(); ++i) {
            out.samples.push_back(part->samples[i]);
            out.samples.back().value += turned;
        }
        if (part->node[0].k >= 0) out.columns.push_back({part->samples.front().value + turned, node(part->node[0]).column});
        out.why[1] = part->why[1];
        if (part->node[1].k < 0) break;
        const Node& to = node(part->node[1]);
        if (to.part[0] < 0) {
            out.columns.push_back({part->samples.back().value + turned, to.column});
            const bool last = !given_.round && part->node[1].k + 1 == given_.values;
            out.why[1] = last ? EndOf::range : EndOf::singularity;
            break;
        }
        Part* behind = &parts_[to.part[0]];
        if (behind == &first) {
            out.closed = true, out.why[0] = out.why[1] = EndOf::nothing;
            break;
        }
        if (behind->used) break;
        turned += part->samples.back().value - behind->samples.front().value;
        part = behind;
    }
    if (out.why[0] == EndOf::range && !(!given_.round && first.node[0].k == 0)) out.why[0] = EndOf::singularity;
    return out;
}

// A fold is the edge of reach if no branch has a solution beyond it.
void Follower::mark_reach(std::vector<Piece>& pieces) const {
    for (Piece& piece : pieces) {
        for (int side = 0; side < 2; ++side) {
            if (piece.why[side] != EndOf::fold) continue;
            const double beyond = side ? piece.samples.back().value + 1e-6 : piece.samples.front().value - 1e-6;
            bool any = false;
            for (const Piece& other : pieces) {
                const double low = other.samples.front().value, high = other.samples.back().value;
                const double there = turns_ && given_.round ? low + (principal_angle(beyond - low - PI) + PI) : beyond;
                any |= other.closed || (there >= low && there <= high);
            }
            if (!any) piece.why[side] = EndOf::reach;
        }
    }
}

}  // namespace urdf_ik::self_motion
