// Following curves from one value of the grid to the next; see follower.hpp.
#include "self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// One step along the curve. h: the first length tried; on return, the length for the next step. The tangent of `to` points the
// same way as that of `from`.
bool Follower::step(const CurveSample& from, const CurveSample* before, double& h, CurveSample& to) const {
    for (;;) {
        if (h < SHORTEST) return false;
        double q[7];
        const double bend = before && from.arc > 0.0 ? 0.5 * h * h / from.arc : 0.0;
        for (int j = 0; j < 7; ++j) {
            const double curved = before ? bend * (from.along[j] - before->along[j]) : 0.0;
            q[j] = from.q[j] + unit(j) * (h * from.along[j] + curved);
        }
        const double share = std::min(1.0, h / WIDE_STEP), enough = std::max(ON_THE_WAY * share * share, EXACT);
        if (settle(q, {Pin::nothing, 0, 0.0}, from.along, from.value, enough, to) && moved_ <= ASIDE * h && agree(from, to)) {
            double same = 0.0;
            for (int j = 0; j < 7; ++j) same += to.along[j] * from.along[j];
            const double turned = std::acos(std::min(1.0, same));
            if (turned <= TOO_MUCH) {
                double square = 0.0;
                for (int j = 0; j < 7; ++j) square += std::pow(gap(j, to.q[j], from.q[j]), 2);
                // The arc, from its chord.
                to.arc = std::sqrt(square) * (1.0 + turned * turned / 24.0);
                h = std::min(longest_, h * std::clamp(AIM / (turned + 1e-3), 0.3, 2.0));
                return true;
            }
        }
        h *= 0.4;
    }
}

// The fold between two samples, where the rate is zero: the secant method on the rate, from the cubic's stationary point.
bool Follower::fold_between(const CurveSample& a, const CurveSample& b, CurveSample& to) const {
    double low = 0.0, high = b.arc, q[7];
    const double ahead = stand_still(a, b);
    between(a, b, ahead > 0.0 && ahead < 1.0 ? ahead : 0.5, q);
    if (!settle(q, {Pin::nothing, 0, 0.0}, a.along, a.value, EXACT, to) || !agree(a, to)) return false;
    double at = b.arc * way_to(a, b, to), before = a.rate * to.rate > 0.0 ? high : low;
    double rate_before = before > 0.0 ? b.rate : a.rate;
    double share = 1.0;  // of the secant step: reduced after a step that left the curve
    for (int round = 0; round < MOST_SECANTS && std::abs(to.rate) >= STANDS && high - low > 1e-12 * b.arc; ++round) {
        (to.rate * a.rate > 0.0 ? low : high) = at;
        double next = at - to.rate * (at - before) / (to.rate - rate_before);
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        next = at + share * (next - at);
        for (int j = 0; j < 7; ++j) q[j] = to.q[j] + unit(j) * (next - at) * to.along[j];
        CurveSample here;
        if (!settle(q, {Pin::nothing, 0, 0.0}, to.along, to.value, EXACT, here) || !agree(to, here)) {
            share *= 0.25;
            continue;
        }
        before = at, rate_before = to.rate, share = 1.0;
        for (int j = 0; j < 7; ++j) at += gap(j, here.q[j], to.q[j]) * to.along[j];
        to = here;
    }
    to.arc = at;
    return true;
}

// The point with this value between two samples.
CurveSample Follower::at_value(const CurveSample& a, const CurveSample& b, double value, bool& found) const {
    double low = 0.0, high = 1.0;
    const double d = b.value - a.value, s = b.arc * a.rate, e = b.arc * b.rate;
    const double third = s + e - 2.0 * d, second = 3.0 * d - 2.0 * s - e;
    for (int round = 0; round < 40; ++round) {
        const double u = 0.5 * (low + high), there = a.value + u * (s + u * (second + u * third));
        if ((there - value) * d < 0.0) low = u;
        else high = u;
    }
    double q[7];
    const double u = 0.5 * (low + high);
    between(a, b, u, q);
    CurveSample out = a;
    found = settle(q, {Pin::parameter, 0, value}, a.along, value, EXACT, out) && agree(a, out);
    out.value = value;
    out.arc = u * b.arc;
    return out;
}

// The position of a point along the step between two samples, from 0 to 1.
double Follower::way_to(const CurveSample& a, const CurveSample& b, const CurveSample& point) const {
    double ahead = 0.0;
    for (int j = 0; j < 7; ++j) ahead += gap(j, point.q[j], a.q[j]) * a.along[j];
    return std::clamp(ahead / b.arc, 0.0, 1.0);
}
// Whether the step between two samples passes through a point, in the direction of its tangent.
bool Follower::closes(const CurveSample& a, const CurveSample& b, const CurveSample& point) const {
    if (apart(a.q, point.q) > 1.5 * b.arc || apart(b.q, point.q) > 1.5 * b.arc) return false;
    double ahead = 0.0, behind = 0.0, same = 0.0, q[7];
    for (int j = 0; j < 7; ++j) {
        ahead += gap(j, point.q[j], a.q[j]) * a.along[j], behind += gap(j, b.q[j], point.q[j]) * b.along[j];
        same += a.along[j] * point.along[j];
    }
    if (!(ahead > 0.0 && behind >= 0.0 && same > 0.0 && agree(a, point))) return false;
    between(a, b, way_to(a, b, point), q);
    return apart(q, point.q) < NEARLY_SAME;
}

// Follow the curve in the direction of the tangent of `from`, until the value leaves [low, high] or the curve closes.
// way: the samples, `from` first; folds: the indices of the samples that are folds.
Follower::Stop Follower::travel(const CurveSample& from, double low, double high, std::vector<CurveSample>& way,
                                std::vector<long>& folds) const {
    double h = 0.5 * longest_;
    way.assign(1, from);
    for (int count = 0; count < MOST_STEPS; ++count) {
        const CurveSample& last = way.back();
        const bool smooth = way.size() > 1 && (folds.empty() || folds.back() + 1 < long(way.size()));
        const CurveSample before = smooth ? way[way.size() - 2] : last;
        CurveSample to;
        const double began = h;
        if (!step(last, smooth ? &before : nullptr, h, to)) return Stop::lost;
        double u;
        const double sense = last.rate != 0.0 ? last.rate : to.rate;
        CurveSample a = last, b = to;
        if (sense < 0.0) a.value = -a.value, a.rate = -a.rate, b.value = -b.value, b.rate = -b.rate;
        if (b.rate >= 0.0 && a.rate > STANDS && least_rate(a, b, u) <= 0.0 && to.arc > 1e-5) {
            h = 0.4 * std::min(began, to.arc);  // two folds may lie in this step
            continue;
        }
        const bool folds_here = last.rate * to.rate < 0.0 && std::abs(last.rate) > STANDS;
        CurveSample fold;
        const bool has_fold = folds_here && fold_between(last, to, fold);
        if (folds_here && !has_fold) return Stop::lost;
        if (has_fold && to.arc > 1e-5 && (folds_twice(last, fold, fold.arc) || folds_twice(to, fold, to.arc - fold.arc))) {
            h = 0.4 * std::min(began, to.arc);  // three folds may lie in this step
            continue;
        }
        const CurveSample& end = has_fold ? fold : to;
        const bool over = end.value > high, under = end.value < low;
        if ((over && sense > 0.0) || (under && sense < 0.0)) {
            bool found;
            CurveSample there = at_value(last, end, over ? high : low, found);
            if (!found) {
                if (to.arc < 1e-5) return Stop::lost;
                h = 0.3 * to.arc;
                continue;
            }
            way.push_back(there);
            return over ? Stop::high : Stop::low;
        }
        const long known = long(way.size());
        if (has_fold) {
            folds.push_back(known);
            way.push_back(fold);
            to.arc -= fold.arc;
        }
        if (!has_fold || to.arc > SHORTEST) way.push_back(to);
        for (long k = known; known > 2 && k < long(way.size()); ++k) {
            if (!closes(way[k - 1], way[k], from)) continue;
            way.resize(k + 1);
            if (!folds.empty() && folds.back() == k) folds.pop_back();
            way[k].arc *= way_to(way[k - 1], way[k], from);
            const double arc = way[k].arc;
            way[k] = from;
            way[k].arc = arc;
            return Stop::closed;
        }
        // The sample behind the fold may lie outside the cell.
        if (has_fold && ((to.value > high && to.rate > 0.0) || (to.value < low && to.rate < 0.0))) {
            bool found;
            const bool up = to.value > high;
            CurveSample there = at_value(fold, to, up ? high : low, found);
            if (!found) return Stop::lost;
            way.resize(known + 1);
            way.push_back(there);
            return up ? Stop::high : Stop::low;
        }
    }
    return Stop::lost;
}

// The index of the node at a value of the grid that equals this sample, or -1.
long Follower::node_at(long k, const CurveSample& at) const {
    long best = -1;
    double nearest = SAME;
    for (long i = 0; i < long(nodes_[k].size()); ++i) {
        const double away = apart(nodes_[k][i].at.q, at.q);
        if (away < nearest) nearest = away, best = i;
    }
    return best;
}

// Split a followed curve at its folds and add the parts. Returns false if it ends at its own start, or at a node that another
// curve has met from this side.
bool Follower::add_parts(long cell, std::vector<CurveSample>& way, const std::vector<long>& folds, long from_k, long from_node,
                         bool up, Stop stop) {
    long end_k = -1, end_node = -1;
    if (stop == Stop::low || stop == Stop::high) {
        end_k = stop == Stop::high ? next(cell) : cell;
        end_node = node_at(end_k, way.back());
        if (end_node < 0) {
            CurveSample at = way.back();
            at.value = given_.grid[end_k];
            if (at.rate < 0.0) flip(at);
            end_node = add_node(end_k, at, -1);
        }
        const Node& met = nodes_[end_k][end_node];
        const bool taken = (stop == Stop::high ? met.before : met.behind) >= 0;
        if (taken || (end_k == from_k && end_node == from_node && (stop == Stop::high) == !up)) return false;
    }
    std::vector<long> cuts = folds;
    cuts.insert(cuts.begin(), 0);
    cuts.push_back(long(way.size()) - 1);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        if (cuts[i + 1] <= cuts[i]) continue;
        Part part;
        part.samples.assign(way.begin() + cuts[i], way.begin() + cuts[i + 1] + 1);
        const bool first = i == 0, last = i + 2 == cuts.size();
        const bool grows = part.samples.back().value >= part.samples.front().value;
        const int begin = grows ? 0 : 1, end = grows ? 1 : 0;
        part.node[0][0] = part.node[1][0] = part.node[0][1] = part.node[1][1] = -1;
        part.why[0] = part.why[1] = EndOf::fold;
        const int number = int(parts_.size());
        if (first && from_node >= 0) {
            part.node[begin][0] = from_k, part.node[begin][1] = from_node;
            (begin ? nodes_[from_k][from_node].before : nodes_[from_k][from_node].behind) = number;
        }
        if (last && end_node >= 0) {
            part.node[end][0] = end_k, part.node[end][1] = end_node;
            (end ? nodes_[end_k][end_node].before : nodes_[end_k][end_node].behind) = number;
        }
        if (last && stop == Stop::lost) part.why[end] = EndOf::singularity;
        if (!grows) {
            std::vector<CurveSample> back(part.samples.rbegin(), part.samples.rend());
            for (std::size_t k = 0; k < back.size(); ++k) {
                // The arc belongs to the step before a sample.
                back[k].arc = k ? part.samples[part.samples.size() - k].arc : 0.0;
                flip(back[k]);
            }
            part.samples = std::move(back);
        }
        part.samples.front().arc = 0.0;
        parts_.push_back(std::move(part));
    }
    return true;
}

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
    turned = std::acos(std::clamp(same, -1.0, 1.0));
    arc = std::sqrt(square) * (1.0 + turned * turned / 24.0);
    if (!(arc <= BRIDGE && turned <= BRIDGE_TURN)) return INFINITY;
    double off = 0.0;
    for (int j = 0; j < 7; ++j) off += std::pow(way[j] - 0.5 * arc * (a.along[j] + b.along[j]), 2);
    return std::sqrt(off) / (arc + 1e-300);
}

// The samples behind `a` up to `b`: the curve is halved until its steps are as short as those of step(), at least once. Returns
// false if a midpoint is far from the cubic, or if the value does not grow all the way.
bool Follower::halved(const CurveSample& a, CurveSample b, int depth, std::vector<CurveSample>& way) const {
    double arc, turned, u;
    if (!(off_line(a, b, arc, turned) <= BRIDGE_OFF)) return false;
    b.arc = arc;
    const bool grows = least_rate(a, b, u) > 0.0;
    if (depth && grows && arc <= LONGEST && turned <= 2.0 * AIM) {
        way.push_back(b);
        return true;
    }
    if (depth == MOST_HALVED) return false;
    double q[7];
    between(a, b, 0.5, q);
    CurveSample middle;
    if (!settle(q, {Pin::nothing, 0, 0.0}, a.along, a.value, ON_THE_WAY, middle) || moved_ > BRIDGE_ASIDE * arc) return false;
    if (!(middle.rate > 0.0 && middle.value > a.value && middle.value < b.value)) return false;
    return halved(a, middle, depth + 1, way) && halved(middle, b, depth + 1, way);
}

// Join solutions at the two ends of a cell that clearly lie on one curve.
void Follower::bridge_cell(long cell) {
    const long after = next(cell);
    for (long i = 0; i < long(nodes_[cell].size()); ++i) {
        const Node& from = nodes_[cell][i];
        if (from.stands || from.behind >= 0) continue;
        long best = -1;
        double least = INFINITY, second = INFINITY, arc, turned;
        for (long j = 0; j < long(nodes_[after].size()); ++j) {
            const double off = off_line(from.at, nodes_[after][j].at, arc, turned);
            if (off < least) second = least, least = off, best = j;
            else second = std::min(second, off);
        }
        if (best < 0 || least > BRIDGE_OFF || second < BRIDGE_CLEAR * least) continue;
        const Node& to = nodes_[after][best];
        if (to.stands || to.before >= 0) continue;
        std::vector<CurveSample> way(1, from.at);
        CurveSample end = to.at;
        way.front().value = low_of(cell), end.value = high_of(cell);
        if (halved(way.front(), end, 0, way)) add_parts(cell, way, {}, cell, i, true, Stop::high);
    }
}

// Follow the curve of every solution at the ends of a cell into the cell. Returns false if a curve was contradicted (see
// add_parts), or lost while crossings were not allowed.
bool Follower::follow_cell(long cell) {
    const double low = low_of(cell), high = high_of(cell);
    bool agrees = true;
    if (longest_ == LONGEST) bridge_cell(cell);
    for (int side = 0; side < 2; ++side) {
        const long k = side ? next(cell) : cell;
        for (long i = 0; i < long(nodes_[k].size()); ++i) {
            const Node& node = nodes_[k][i];
            if (node.stands || (side ? node.before : node.behind) >= 0) continue;
            CurveSample from = node.at;
            if (side) {
                flip(from);
                from.value = high;
            }
            std::vector<CurveSample> way;
            std::vector<long> folds;
            const Stop stop = travel(from, low, high, way, folds);
            if (!add_parts(cell, way, folds, k, i, !side, stop) || (stop == Stop::lost && !straight_)) agrees = false;
        }
    }
    return agrees;
}

void Follower::follow_cells() {
    for (int pass = 0; pass < 3 && !has_enough(); ++pass) {
        bool open = false;
        for (long cell = 0; cell < cells_ && !has_enough(); ++cell) {
            const std::size_t parts = parts_.size();
            for (int redone = 0; !follow_cell(cell) && redone < MOST_REDONE; ++redone) {
                // Either a curve was lost, perhaps because another one crosses it: the next try allows it to go straight on.
                // Or two curves met one solution, so one of them has jumped: later tries also take shorter steps.
                if (straight_) longest_ *= 0.3;
                straight_ = true;
                parts_.resize(parts);
                for (const long k : {cell, next(cell)}) {
                    for (Node& node : nodes_[k]) {
                        if (node.before >= int(parts)) node.before = -1;
                        if (node.behind >= int(parts)) node.behind = -1;
                    }
                }
            }
            longest_ = LONGEST, straight_ = false;
        }
        for (long k = 0; k < given_.values; ++k) {
            for (const Node& node : nodes_[k]) {
                const bool first = !given_.round && k == 0, last = !given_.round && k + 1 == given_.values;
                open |= !node.stands && ((node.before < 0 && !first) || (node.behind < 0 && !last));
            }
        }
        if (!open) break;
    }
}

// The piece that begins with this part.
Piece Follower::joined(Part& first) {
    Piece out;
    out.why[0] = first.node[0][0] >= 0 ? EndOf::range : first.why[0];
    out.closed = false;
    Part* part = &first;
    double turned = 0.0;
    for (;;) {
        part->used = true;
        for (std::size_t i = out.samples.empty() ? 0 : 1; i < part->samples.size(); ++i) {
            out.samples.push_back(part->samples[i]);
            out.samples.back().value += turned;
        }
        if (part->node[0][0] >= 0) {
            const Node& node = nodes_[part->node[0][0]][part->node[0][1]];
            out.columns.push_back({part->samples.front().value + turned, node.column});
        }
        out.why[1] = part->why[1];
        if (part->node[1][0] < 0) break;
        const Node& node = nodes_[part->node[1][0]][part->node[1][1]];
        if (node.behind < 0) {
            out.columns.push_back({part->samples.back().value + turned, node.column});
            const bool last = !given_.round && part->node[1][0] + 1 == given_.values;
            out.why[1] = last ? EndOf::range : EndOf::singularity;
            break;
        }
        Part* behind = &parts_[node.behind];
        if (behind == &first) {
            out.closed = true, out.why[0] = out.why[1] = EndOf::nothing;
            break;
        }
        if (behind->used) break;
        turned += part->samples.back().value - behind->samples.front().value;
        part = behind;
    }
    if (out.why[0] == EndOf::range && !(!given_.round && first.node[0][0] == 0)) out.why[0] = EndOf::singularity;
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
                any |= other.closed || (beyond >= low && beyond <= high);
                if (turns_ && given_.round) {
                    const double there = low + (wrapped(beyond - low - PI) + PI);
                    any |= there <= high;
                }
            }
            if (!any) piece.why[side] = EndOf::reach;
        }
    }
}

}  // namespace urdf_ik::self_motion
