// See curves.hpp.
#include "curves.hpp"

#include <algorithm>
#include <cmath>

namespace urdf_ik {

namespace {

constexpr double PI = 3.141592653589793, TURN = 2.0 * PI;

// A step along a curve [rad, shares of size]: at most LONGEST, so long that the tangent turns by AIM, refused where it turns by
// TOO_MUCH [rad] or where Newton's method leads further than ASIDE times the step away. A curve whose steps would have to be
// shorter than SHORTEST has come to a singularity.
constexpr double LONGEST = 0.3, AIM = 0.2, TOO_MUCH = 0.45, ASIDE = 0.12, SHORTEST = 1e-7;
// From one solution of the grid to the next: at most so far [rad, shares of size], the tangent turned by at most BRIDGE_TURN
// [rad], the chord off the mean of the tangents by at most BRIDGE_OFF of its length, any other solution this many times further
// off. The cubic between two samples is halved at most so often; Newton's method leads off it by at most BRIDGE_ASIDE of the way.
constexpr double BRIDGE = 1.0, BRIDGE_TURN = 0.9, BRIDGE_OFF = 0.2, BRIDGE_CLEAR = 3.0, BRIDGE_ASIDE = 0.03;
constexpr int MOST_HALVED = 3;
// Newton's method ends below these errors: on the way, where steps are as long as WIDE_STEP (less by the square of shorter ones,
// which there are next to singularities), and at the points that count.
constexpr double ON_THE_WAY = 1e-7, WIDE_STEP = 0.03, NEARLY_EXACT = 1e-9, EXACT = 3e-15, SETTLED = 1e-11;
constexpr int FEW_ROUNDS = 4, MANY_ROUNDS = 12;
// Two joint vectors nearer than this in every joint are one; the same for places between samples, which are interpolated.
constexpr double SAME = 1e-6, NEARLY_SAME = 3e-3;
// Below this the parameter does not change along the tangent: at a fold, or where a joint is free at one value.
constexpr double STANDS = 1e-9;
// Where a joint comes this near [rad, m] to a limit between two samples, the place is looked at.
constexpr double CLOSE = 4e-3;
// Error [rad, share of size] of a branch beyond its ends from which it is not looked at.
constexpr double FAR_FROM = 0.5;
// Values to each side of where such a branch comes nearest that are starts, too.
constexpr long BESIDE = 2;
constexpr int MOST_SPLITS = 5, MOST_STEPS = 4000, MOST_REDONE = 3;

double wrapped(double a) {
    if (a > PI) a -= TURN * std::ceil((a - PI) / TURN);
    else if (a <= -PI) a += TURN * std::ceil((-PI - a) / TURN + (a == -PI ? 1.0 : 0.0));
    return a;
}

// A solution at a value of the grid, and the pieces that lead away from it on both sides; -1: none yet.
struct Node {
    CurveSample at;
    int column, before = -1, behind = -1;
    bool stands;  // the parameter does not change there
};

// A part of a curve in one cell of the grid, along which the value grows.
struct Part {
    std::vector<CurveSample> samples;
    long node[2][2];  // at both ends: number of the grid's value and of the node, or -1
    EndOf why[2];
    bool used = false;
};

// A whole part along which the value grows, over all cells.
struct Piece {
    std::vector<CurveSample> samples;
    std::vector<std::pair<double, int>> columns;  // values of the grid with the columns there
    EndOf why[2];
    bool closed;
};

class Follower {
public:
    Follower(const FreeArm& arm, const SelfMotionFunctions& core, const GridOfSolutions& given)
        : arm_(arm), core_(core), given_(given), nodes_(given.values) {
        turns_ = arm.given < 0 || !arm.written.slides[arm.given];
        cells_ = given.round ? given.values : given.values - 1;
    }

    void follow() {
        for (long k = 0; k < given_.values; ++k) {
            for (int b = 0; b < given_.branches; ++b) {
                const long at = k * given_.branches + b;
                if (given_.flags[at] & 1) add_node(k, sample_at(given_.q + 7 * at, given_.grid[k]), b);
            }
        }
        follow_cells();
        look_for_loops();
    }

    std::vector<Piece> pieces() {
        std::vector<Piece> out;
        for (int from_node = 0; from_node < 2; ++from_node) {
            for (Part& part : parts_) {
                if (part.used || (!from_node && leads_on(part, 0))) continue;
                out.push_back(joined(part));
            }
        }
        mark_reach(out);
        return out;
    }

    // The intervals of a piece inside the limits.
    void cut(const Piece& piece, long pose, Intervals& to) const;

private:
    double unit(int j) const { return arm_.unit[j]; }
    double gap(int j, double a, double b) const { return gap_of(arm_, j, a, b); }
    double apart(const double* a, const double* b) const {
        double most = 0.0;
        for (int j = 0; j < 7; ++j) most = std::max(most, std::abs(gap(j, a[j], b[j])));
        return most;
    }
    double value_near(double value, double before) const { return turns_ ? before + wrapped(value - before) : value; }

    CurveSample sample_of(const OnCurve& point, double before) const {
        CurveSample out;
        std::copy_n(point.q, 7, out.q), std::copy_n(point.along, 7, out.along);
        out.value = value_near(point.value, before), out.rate = point.rate, out.arc = 0.0;
        return out;
    }
    // A solution that is given, turned so that the value grows along the tangent.
    CurveSample sample_at(const double* q, double value) const {
        CurveSample out = sample_of(core_.settle(arm_, given_.T, q, {Pin::nothing, 0, 0.0}, 0, 0.0), value);
        out.value = value;
        if (out.rate < 0.0) flip(out);
        return out;
    }
    static void flip(CurveSample& s) {
        for (double& each : s.along) each = -each;
        s.rate = -s.rate;
    }
    // The point pinned down from a start near it; along: the sense of its tangent. Returns whether there is one.
    bool settle(const double* q, const Pinned& pin, const double* along, double before, double enough, CurveSample& out) const {
        const int rounds = enough < ON_THE_WAY ? MANY_ROUNDS : FEW_ROUNDS;
        const OnCurve point = core_.settle(arm_, given_.T, q, pin, rounds, enough);
        if (!(point.left <= std::max(enough, SETTLED))) return false;
        out = sample_of(point, before);
        double same = 0.0;
        for (int j = 0; j < 7; ++j) same += point.along[j] * along[j];
        if (same < 0.0) flip(out);
        moved_ = point.moved;
        return true;
    }

    void between(const CurveSample& a, const CurveSample& b, double u, double* q, double* along = nullptr) const {
        interpolate(arm_, a, b, u, q, along);
    }
    // Where the parameter changes along the curve's cubic by least, between two samples in order.
    double least_rate(const CurveSample& a, const CurveSample& b, double& u) const {
        const double d = b.value - a.value, s = b.arc * a.rate, e = b.arc * b.rate;
        const double third = s + e - 2.0 * d, second = 3.0 * d - 2.0 * s - e;
        u = std::abs(third) > 1e-300 ? -second / (3.0 * third) : -1.0;
        if (!(u > 0.0 && u < 1.0)) return std::min(s, e);
        return s + u * (2.0 * second + 3.0 * u * third);
    }

    // Where the parameter stands still along the cubic between two samples, of which one is before the fold, one behind.
    double stand_still(const CurveSample& a, const CurveSample& b) const {
        const double d = b.value - a.value, s = b.arc * a.rate, e = b.arc * b.rate;
        const double third = 3.0 * (s + e - 2.0 * d), second = 3.0 * d - 2.0 * s - e, root = second * second - third * s;
        if (!(root >= 0.0)) return -1.0;
        const double sum = -(second + std::copysign(std::sqrt(root), second)), one = sum / third;
        return one > 0.0 && one < 1.0 ? one : s / sum;
    }
    bool step(const CurveSample& from, const CurveSample* before, double& h, CurveSample& to) const;
    bool fold_between(const CurveSample& a, const CurveSample& b, CurveSample& to) const;
    CurveSample at_value(const CurveSample& a, const CurveSample& b, double value, bool& found) const;
    double way_to(const CurveSample& a, const CurveSample& b, const CurveSample& point) const;
    bool closes(const CurveSample& a, const CurveSample& b, const CurveSample& point) const;
    double off_line(const CurveSample& a, const CurveSample& b, double& arc, double& turned) const;
    bool halved(const CurveSample& a, CurveSample b, int depth, std::vector<CurveSample>& way) const;
    void bridge_cell(long cell);
    enum class Stop { low, high, closed, lost };
    Stop travel(const CurveSample& from, double low, double high, std::vector<CurveSample>& way, std::vector<long>& folds) const;

    long add_node(long k, const CurveSample& at, int column) {
        nodes_[k].push_back({at, column, -1, -1, std::abs(at.rate) < STANDS});
        return long(nodes_[k].size()) - 1;
    }
    double low_of(long cell) const { return given_.grid[cell]; }
    double high_of(long cell) const { return cell + 1 < given_.values ? given_.grid[cell + 1] : given_.grid[0] + TURN; }
    long next(long cell) const { return cell + 1 < given_.values ? cell + 1 : 0; }

    void follow_cells();
    bool follow_cell(long cell);
    bool take(long cell, std::vector<CurveSample>& way, const std::vector<long>& folds, long from_k, long from_node, bool up,
              Stop stop);
    long node_at(long k, const CurveSample& at) const;
    void look_for_loops();
    void add_nearest(std::vector<double>& starts) const;
    bool known(const CurveSample& at) const;
    bool meets(const double* q, const double* t, const CurveSample& point) const;
    void add_loop(const CurveSample& at);
    bool leads_on(const Part& part, int side) const {
        const long* node = part.node[side];
        if (node[0] < 0) return false;
        const Node& n = nodes_[node[0]][node[1]];
        return (side ? n.behind : n.before) >= 0;
    }
    Piece joined(Part& first);
    void mark_reach(std::vector<Piece>& pieces) const;

    // Of a limit: which joint, which side, where.
    // The image of a joint of more than a turn leaves the limits there, another one is still inside: it ends nothing.
    struct Crossing {
        CurveSample at;
        double share;
        int joint;
        bool upper, wide;
    };
    bool limited(int j) const { return std::isfinite(given_.lower[j]) || std::isfinite(given_.upper[j]); }
    bool wide(int j) const { return !arm_.written.slides[j] && given_.upper[j] - given_.lower[j] >= TURN; }
    double room(int j, double q) const;
    bool inside(const double* q) const;
    void split(const CurveSample& a, const CurveSample& b, int depth, std::vector<CurveSample>& to) const;
    void crossings(const CurveSample& a, const CurveSample& b, std::vector<Crossing>& to) const;
    bool is_inside(const CurveSample& a, const CurveSample& b, double from, double to) const;

    const FreeArm& arm_;
    const SelfMotionFunctions& core_;
    const GridOfSolutions& given_;
    std::vector<std::vector<Node>> nodes_;
    std::vector<Part> parts_;
    long cells_;
    bool turns_;
    double longest_ = LONGEST;
    mutable double moved_ = 0.0;
};

// One step along the curve; h is what it begins with, then what the next may be. `to` is turned as `from` is.
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
        if (settle(q, {Pin::nothing, 0, 0.0}, from.along, from.value, enough, to) && moved_ <= ASIDE * h) {
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

// The fold between two samples, at which the parameter stands still: by the method of false position.
bool Follower::fold_between(const CurveSample& a, const CurveSample& b, CurveSample& to) const {
    double low = 0.0, high = 1.0, at_low = a.rate, at_high = b.rate;
    bool found = false;
    for (int round = 0; round < 30; ++round) {
        double u = round ? low + (high - low) * at_low / (at_low - at_high) : stand_still(a, b);
        if (!(u > low && u < high)) u = 0.5 * (low + high);
        double q[7];
        between(a, b, u, q);
        CurveSample here;
        if (!settle(q, {Pin::nothing, 0, 0.0}, a.along, a.value, EXACT, here)) return found;
        to = here, found = true;
        to.arc = u * b.arc;
        if (std::abs(here.rate) < STANDS || high - low < 1e-12) break;
        // Illinois: the side that stays counts half.
        if (here.rate * at_low > 0.0) low = u, at_low = here.rate, at_high *= 0.5;
        else high = u, at_high = here.rate, at_low *= 0.5;
    }
    return found;
}

// The point between two samples that has this value.
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
    found = settle(q, {Pin::parameter, 0, value}, a.along, value, EXACT, out);
    out.value = value;
    out.arc = u * b.arc;
    return out;
}

// How far along the step between two samples a point is.
double Follower::way_to(const CurveSample& a, const CurveSample& b, const CurveSample& point) const {
    double ahead = 0.0;
    for (int j = 0; j < 7; ++j) ahead += gap(j, point.q[j], a.q[j]) * a.along[j];
    return std::clamp(ahead / b.arc, 0.0, 1.0);
}
// Whether the step between two samples passes through a point, the way that its tangent points.
bool Follower::closes(const CurveSample& a, const CurveSample& b, const CurveSample& point) const {
    if (apart(a.q, point.q) > 1.5 * b.arc || apart(b.q, point.q) > 1.5 * b.arc) return false;
    double ahead = 0.0, behind = 0.0, same = 0.0, q[7];
    for (int j = 0; j < 7; ++j) {
        ahead += gap(j, point.q[j], a.q[j]) * a.along[j], behind += gap(j, b.q[j], point.q[j]) * b.along[j];
        same += a.along[j] * point.along[j];
    }
    if (!(ahead > 0.0 && behind >= 0.0 && same > 0.0)) return false;
    between(a, b, way_to(a, b, point), q);
    return apart(q, point.q) < NEARLY_SAME;
}

// Along the curve, the way that the tangent of `from` points, until the value leaves [low, high] or the curve is closed.
// way: the samples, `from` first; folds: their numbers.
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
        // What lies behind the fold may have left the cell already.
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

// The node at a value of the grid that is met.
long Follower::node_at(long k, const CurveSample& at) const {
    long best = -1;
    double nearest = SAME;
    for (long i = 0; i < long(nodes_[k].size()); ++i) {
        const double away = apart(nodes_[k][i].at.q, at.q);
        if (away < nearest) nearest = away, best = i;
    }
    return best;
}

// Keep what was followed in a cell as parts along which the value grows. Returns whether nothing contradicts it.
bool Follower::take(long cell, std::vector<CurveSample>& way, const std::vector<long>& folds, long from_k, long from_node, bool up,
                    Stop stop) {
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
            for (std::size_t k = part.samples.size() - 1; k > 0; --k) part.samples[k].arc = part.samples[k].arc;
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

// How far a way between two samples is from one that turns evenly, as a share of its length; infinite where it is no step.
double Follower::off_line(const CurveSample& a, const CurveSample& b, double& arc, double& turned) const {
    double way[7], square = 0.0, same = 0.0;
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

// The samples behind `a` up to `b`, the curve halved until its steps are as short as those of step(); at least once. False
// where the curve is not what the two ends let expect, or turns round on the way.
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

// Join the solutions at both ends of a cell that lie on one curve beyond doubt.
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
        if (halved(way.front(), end, 0, way)) take(cell, way, {}, cell, i, true, Stop::high);
    }
}

// Follow every solution at the ends of a cell into it. Returns whether each was met by one curve.
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
            if (!take(cell, way, folds, k, i, !side, stop)) agrees = false;
        }
    }
    return agrees;
}

void Follower::follow_cells() {
    for (int pass = 0; pass < 3; ++pass) {
        bool open = false;
        for (long cell = 0; cell < cells_; ++cell) {
            const std::size_t parts = parts_.size();
            for (int redone = 0; !follow_cell(cell) && redone < MOST_REDONE; ++redone) {
                // Two curves met one solution: one of them has left its way. The cell is followed again by shorter steps.
                longest_ *= 0.3;
                parts_.resize(parts);
                for (const long k : {cell, next(cell)}) {
                    for (Node& node : nodes_[k]) {
                        if (node.before >= int(parts)) node.before = -1;
                        if (node.behind >= int(parts)) node.behind = -1;
                    }
                }
            }
            longest_ = LONGEST;
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

// Whether the curve that passes near q, along t, passes through a point, too: two may be next to each other, on both sides of an
// elbow that is all but straight. The joint that moves most is brought to its value at the point.
bool Follower::meets(const double* q, const double* t, const CurveSample& point) const {
    int most = 0;
    for (int j = 1; j < 7; ++j) most = std::abs(t[j]) > std::abs(t[most]) ? j : most;
    CurveSample there;
    if (!settle(q, {Pin::joint, most, point.q[most]}, t, point.value, NEARLY_EXACT, there)) return true;
    return apart(there.q, point.q) < SAME;
}

// Whether a point lies on what was followed.
bool Follower::known(const CurveSample& at) const {
    for (const Part& part : parts_) {
        const double low = part.samples.front().value, high = part.samples.back().value;
        const double value = turns_ ? low + (wrapped(at.value - low - PI) + PI) : at.value;
        // A turn less, where it lies just below the beginning.
        for (const double there : {value, turns_ ? value - TURN : value}) {
            if (there < low - NEARLY_SAME || there > high + NEARLY_SAME) continue;
            for (std::size_t i = 1; i < part.samples.size(); ++i) {
                const CurveSample &a = part.samples[i - 1], &b = part.samples[i];
                if (there > b.value + NEARLY_SAME || there < a.value - NEARLY_SAME) continue;
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

// Follow a curve that no solution of the grid lies on, or that one was missing on.
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
    const Stop stop = travel(from, low_of(cell), high_of(cell), way, folds);
    if (stop == Stop::closed) {
        // It begins and ends at a fold.
        if (folds.size() < 2) return;
        std::vector<CurveSample> turned(way.begin() + folds[0], way.end());
        for (long i = 1; i <= folds[0]; ++i) turned.push_back(way[i]);
        std::vector<long> cuts;
        for (std::size_t i = 1; i < folds.size(); ++i) cuts.push_back(folds[i] - folds[0]);
        take(cell, turned, cuts, -1, -1, true, Stop::closed);
        return;
    }
    if (stop == Stop::lost) return;
    // It leaves the cell: where it does, there is a solution that was not given.
    const long k = stop == Stop::high ? next(cell) : cell;
    if (node_at(k, way.back()) >= 0) return;
    CurveSample node = way.back();
    node.value = given_.grid[k];
    if (node.rate < 0.0) flip(node);
    add_node(k, node, -1);
    follow_cells();
}

// Where a branch of the closed form comes nearest to being a solution, beyond its ends, and next to its ends: starts for the
// search.
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
            // Another loop may be beside the one that is nearest.
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
    for (int i = 0; i < many; ++i) {
        const double* q = &found[7 * i];
        if (known(sample_of(core_.settle(arm_, given_.T, q, {Pin::nothing, 0, 0.0}, 0, 0.0), 0.0))) continue;
        CurveSample at;
        const double along[7] = {};
        if (!settle(q, {Pin::nothing, 0, 0.0}, along, 0.0, EXACT, at)) continue;
        if (!given_.round && (at.value < given_.grid[0] || at.value > given_.grid[given_.values - 1])) continue;
        if (std::abs(at.rate) < STANDS || known(at)) continue;
        add_loop(at);
    }
}

// A part and all that continue it.
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

// Folds beyond which no branch has a solution are the edge of reach.
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

// How far a joint is inside its limits by its best image, negative outside.
double Follower::room(int j, double q) const {
    const double low = given_.lower[j], high = given_.upper[j];
    if (arm_.written.slides[j]) return std::min(q - low, high - q);
    if (!std::isfinite(high - low) || high - low >= TURN) return PI;  // some image is inside
    const double middle = 0.5 * (low + high);
    return 0.5 * (high - low) - std::abs(wrapped(q - middle));
}
bool Follower::inside(const double* q) const {
    for (int j = 0; j < 7; ++j) {
        if (limited(j) && room(j, q[j]) < 0.0) return false;
    }
    return true;
}

// Samples between two, where a joint turns round near a limit: `b` last.
void Follower::split(const CurveSample& a, const CurveSample& b, int depth, std::vector<CurveSample>& to) const {
    double where = -1.0;
    for (int j = 0; depth < MOST_SPLITS && b.arc > SAME && j < 7 && where < 0.0; ++j) {
        if (!limited(j) || std::min(room(j, a.q[j]), room(j, b.q[j])) > 2.0 * b.arc * unit(j)) continue;
        const double d = gap(j, b.q[j], a.q[j]), s = b.arc * a.along[j], e = b.arc * b.along[j];
        const double third = 3.0 * (s + e - 2.0 * d), second = 3.0 * d - 2.0 * s - e, root = second * second - third * s;
        if (root < 0.0) continue;
        const double sum = -(second + std::copysign(std::sqrt(root), second));
        for (const double u : {sum / third, s / sum}) {
            if (!(u > 0.01 && u < 0.99)) continue;
            double q[7];
            between(a, b, u, q);
            if (std::abs(room(j, q[j])) < CLOSE * (depth ? 0.1 : 1.0)) where = u;
        }
    }
    if (where > 0.0) {
        double q[7];
        between(a, b, where, q);
        CurveSample middle;
        if (settle(q, {Pin::nothing, 0, 0.0}, a.along, a.value, EXACT, middle)) {
            CurveSample last = b;
            middle.arc = where * b.arc, last.arc = (1.0 - where) * b.arc;
            split(a, middle, depth + 1, to);
            split(middle, last, depth + 1, to);
            return;
        }
    }
    to.push_back(b);
}

// Where joints cross their limits between two samples, in order.
void Follower::crossings(const CurveSample& a, const CurveSample& b, std::vector<Crossing>& to) const {
    const std::size_t before = to.size();
    for (int j = 0; j < 7; ++j) {
        if (!limited(j)) continue;
        for (int side = 0; side < 2; ++side) {
            const double limit = side ? given_.upper[j] : given_.lower[j];
            if (!std::isfinite(limit)) continue;
            const double from = gap(j, a.q[j], limit), d = gap(j, b.q[j], a.q[j]);
            if (std::abs(from) > 2.0 || from * (from + d) > 0.0 || (from + d == 0.0)) continue;
            // The cubic's root, by bisection; where there are three, one of them: samples lie where a joint turns round.
            const double s = b.arc * a.along[j], e = b.arc * b.along[j], third = s + e - 2.0 * d, second = 3.0 * d - 2.0 * s - e;
            double low = 0.0, high = 1.0;
            for (int round = 0; round < 40; ++round) {
                const double u = 0.5 * (low + high);
                if ((from + u * (s + u * (second + u * third))) * d < 0.0) low = u;
                else high = u;
            }
            Crossing c;
            c.share = 0.5 * (low + high), c.joint = j, c.upper = side, c.wide = wide(j);
            double q[7];
            between(a, b, c.share, q);
            if (!settle(q, {Pin::joint, j, arm_.written.slides[j] ? limit : wrapped(limit)}, a.along, a.value, EXACT, c.at))
                continue;
            c.at.arc = c.share * b.arc;
            to.push_back(c);
        }
    }
    std::sort(to.begin() + before, to.end(), [](const Crossing& x, const Crossing& y) { return x.share < y.share; });
}

// Whether the middle of a part of the step is inside all limits.
bool Follower::is_inside(const CurveSample& a, const CurveSample& b, double from, double to) const {
    double q[7];
    between(a, b, 0.5 * (from + to), q);
    double least = PI;
    for (int j = 0; j < 7; ++j) {
        if (limited(j)) least = std::min(least, room(j, q[j]) / unit(j));
    }
    if (std::abs(least) > 1e-4) return least > 0.0;
    CurveSample middle;
    if (!settle(q, {Pin::nothing, 0, 0.0}, a.along, a.value, EXACT, middle)) return least > 0.0;
    return inside(middle.q);
}

void Follower::cut(const Piece& piece, long pose, Intervals& to) const {
    std::vector<CurveSample> fine(1, piece.samples.front());
    for (std::size_t i = 1; i < piece.samples.size(); ++i) split(piece.samples[i - 1], piece.samples[i], 0, fine);
    struct Run {
        std::vector<CurveSample> samples;
        EndOf why[2];
        int joint[2];
    };
    std::vector<Run> runs;
    bool open = false;
    Crossing last_crossing = {};
    bool crossed = false;
    const auto begin = [&](const CurveSample& at, bool at_crossing) {
        Run run;
        run.samples.push_back(at);
        run.samples.back().arc = 0.0;
        run.why[0] = at_crossing ? (last_crossing.upper ? EndOf::upper_limit : EndOf::lower_limit) : piece.why[0];
        run.joint[0] = at_crossing ? last_crossing.joint : -1;
        runs.push_back(std::move(run));
        open = true;
    };
    for (std::size_t i = 1; i < fine.size(); ++i) {
        const CurveSample &a = fine[i - 1], &b = fine[i];
        std::vector<Crossing> met;
        crossings(a, b, met);
        double from = 0.0;
        for (std::size_t k = 0; k <= met.size(); ++k) {
            const double end = k < met.size() ? met[k].share : 1.0;
            const bool in = is_inside(a, b, from, end);
            if (in && !open) begin(crossed ? last_crossing.at : a, crossed);
            if (!in && open) {
                // A joint left its limits without a crossing that was found: at the sample, then.
                runs.back().why[1] = crossed ? (last_crossing.upper ? EndOf::upper_limit : EndOf::lower_limit) : EndOf::singularity;
                runs.back().joint[1] = crossed ? last_crossing.joint : -1;
                open = false;
            }
            if (k < met.size()) {
                if (!met[k].wide) last_crossing = met[k], crossed = true;
                if (open) {
                    CurveSample at = met[k].at;
                    at.arc = (end - from) * b.arc;
                    runs.back().samples.push_back(at);
                }
                from = end;
            } else if (open) {
                runs.back().samples.push_back(b);
                runs.back().samples.back().arc = (end - from) * b.arc;
                crossed = false;
            } else {
                crossed = false;
            }
        }
    }
    if (open) runs.back().why[1] = piece.why[1], runs.back().joint[1] = -1;
    // A run that passes the place where a closed curve was opened.
    if (piece.closed && runs.size() > 1 && runs.front().why[0] == EndOf::nothing && runs.back().why[1] == EndOf::nothing) {
        Run& back = runs.back();
        for (std::size_t i = 1; i < runs.front().samples.size(); ++i) {
            back.samples.push_back(runs.front().samples[i]);
            back.samples.back().value += TURN;
        }
        back.why[1] = runs.front().why[1], back.joint[1] = runs.front().joint[1];
        runs.erase(runs.begin());
    }
    for (const Run& run : runs) {
        if (run.samples.size() < 2) continue;
        Interval found = {pose, long(to.samples.size()),  long(run.samples.size()),
                          -1,   {run.why[0], run.why[1]}, {run.joint[0], run.joint[1]}};
        const double low = run.samples.front().value, high = run.samples.back().value, middle = 0.5 * (low + high);
        double nearest = INFINITY;
        for (const auto& [value, column] : piece.columns) {
            for (const double there : {value, value + TURN}) {
                if (column < 0 || (there != value && !piece.closed) || there < low || there > high) continue;
                if (std::abs(there - middle) < nearest) nearest = std::abs(there - middle), found.column = column;
            }
        }
        to.samples.insert(to.samples.end(), run.samples.begin(), run.samples.end());
        to.found.push_back(found);
    }
}

}  // namespace

double gap_of(const FreeArm& arm, int j, double a, double b) {
    return arm.written.slides[j] ? (a - b) / arm.unit[j] : wrapped(a - b);
}

void interpolate(const FreeArm& arm, const CurveSample& a, const CurveSample& b, double share, double* q, double* along) {
    const double u = share;
    for (int j = 0; j < 7; ++j) {
        const double d = gap_of(arm, j, b.q[j], a.q[j]), s = b.arc * a.along[j], e = b.arc * b.along[j];
        const double third = s + e - 2.0 * d, second = 3.0 * d - 2.0 * s - e;
        q[j] = a.q[j] + arm.unit[j] * u * (s + u * (second + u * third));
        if (along) along[j] = s + u * (2.0 * second + 3.0 * u * third);
    }
}

void follow_curves(const FreeArm& arm, const SelfMotionFunctions& core, const GridOfSolutions& given, long pose, Intervals& to) {
    Follower follower(arm, core, given);
    follower.follow();
    for (const Piece& piece : follower.pieces()) {
        follower.cut(piece, pose, to);
        const bool seen =
            std::any_of(piece.columns.begin(), piece.columns.end(), [](const auto& each) { return each.second >= 0; });
        if (!seen) to.unseen.push_back({pose, piece.samples[piece.samples.size() / 2].value});
    }
}

}  // namespace urdf_ik
