// The follower of one pose's curves; see curves.hpp. bridges.cpp joins solutions at neighbouring values of the grid, follower.cpp
// follows curves between two values, loops.cpp looks for loops between two values, limits.cpp cuts curves at the joint limits.
#pragma once

#include <algorithm>
#include <cmath>
#include <list>
#include <memory>
#include <numeric>
#include <optional>

#include "motion/self_motion/curves.hpp"
#include "numbers/thresholds.hpp"

namespace urdf_ik::self_motion {

// A step along a curve has at most the length LONGEST [rad, shares of size]. Its length is chosen so that the tangent turns by
// about AIM [rad]. A step is refused if the tangent turns by more than TOO_MUCH [rad], or if Newton's method corrects it by more
// than ASIDE times its length. A curve that would need steps below HALF_OF_THE_DIGITS has reached a singularity.
inline constexpr double LONGEST = 0.3, AIM = 0.2, TOO_MUCH = 0.45, ASIDE = 0.12;
// Two solutions at neighbouring values of the grid are joined without following if their arc is at most BRIDGE [rad, shares of
// size], the tangent turns by at most twice TOO_MUCH, the chord differs from the mean of the tangents by at most BRIDGE_OFF of the
// arc, and this difference is BRIDGE_CLEAR times larger for every other solution. The cubic between them is halved at most
// MOST_HALVED times; Newton's method may correct each midpoint by at most a quarter of ASIDE of the arc.
inline constexpr double BRIDGE = 1.0, BRIDGE_OFF = 0.2, BRIDGE_CLEAR = 3.0;
inline constexpr int MOST_HALVED = 3;
// Errors at which Newton's method stops. Samples of steps of WIDE_STEP or longer need ON_THE_WAY; for shorter steps, as next to
// singularities, this falls with the square of the step. Folds, crossings and grid values need EXACT. A point with an error of
// at most SETTLED is accepted even if Newton's method did not reach EXACT.
inline constexpr double ON_THE_WAY = 1e-7, WIDE_STEP = 0.03, EXACT = 3e-15, SETTLED = 1e-11;
inline constexpr int FEW_ROUNDS = 4, MANY_ROUNDS = 12;
// Two joint vectors closer than SAME in every joint are equal. Points interpolated between samples are less accurate: NEARLY_SAME.
inline constexpr double NEARLY_SAME = 3e-3;
// If a joint turns back this close [rad, m] to a limit between two samples, a sample is added there.
inline constexpr double CLOSE = 4e-3;
// A branch beyond its ends gives starts for the search only up to this pose error [rad, share of size].
inline constexpr double FAR_FROM = 0.5;
// Number of values on each side of such a start that are starts too.
inline constexpr long BESIDE = 2;
inline constexpr int MOST_SECANTS = 30, MOST_SPLITS = 5, MOST_STEPS = 4000, MOST_REDONE = 4;
// Greatest number of points settled for one pose; hundreds are usual. Solutions of some poses form surfaces (a straight S-R-S
// arm), on which the search for curves would not end.
inline constexpr long MOST_SETTLED = 15000;

class Travel;

// A solution at a value of the grid. By side, 0 behind it and 1 before it: the part that begins or ends there, -1: not yet
// followed; what was followed ahead, or null.
struct Node {
    CurveSample at;
    int column;
    bool stands;  // the parameter is stationary there
    int part[2] = {-1, -1};
    std::shared_ptr<Travel> ahead[2] = {};
};

// The numbers of a value of the grid and of a node there; -1: none.
struct Place {
    long k = -1, i = -1;
    bool operator==(const Place&) const = default;
};

// A part of a curve in one cell of the grid, with growing values.
struct Part {
    std::vector<CurveSample> samples;
    Place node[2];  // at both ends
    long cell;
    EndOf why[2] = {EndOf::fold, EndOf::fold};
    bool bridge = false, used = false;
};

// The way from a node to another one, at the next value of the grid.
struct Bridge {
    Place from;
    std::list<CurveSample> way;
    bool good = true;
};

// Consecutive parts joined over all cells.
struct Piece {
    std::vector<CurveSample> samples;
    std::vector<std::pair<double, int>> columns;  // values of the grid with the columns there
    EndOf why[2];
    bool closed;
};

class Follower;

// Where following a curve ended: at the low or the high end of its values, at its own beginning, or at a singularity.
enum class Stop { low, high, closed, lost };

// Follows a curve in the direction of the tangent of `from`, until the value leaves [low, high] or the curve closes. It asks for
// points on the curve one by one, so that several can go on side by side: Follower::follow().
class Travel {
public:
    Travel(const Follower& follower, const CurveSample& from, double low, double high);

    std::vector<CurveSample> way;  // the samples, `from` first
    std::vector<long> folds;       // which of them are folds
    Stop stop = Stop::lost;        // once it has ended
    Start next;                    // the point that it asks for

    bool ended() const { return state_ == State::ended; }
    void end(Stop why) { stop = why, state_ = State::ended; }
    void go_on(const OnCurve& point);

private:
    enum class State { step, fold, value, ended };
    // Of the parameter along the step.
    double sense() const { return way.back().rate != 0.0 && !at_fold() ? way.back().rate : to_.rate; }
    bool at_fold() const { return !folds.empty() && folds.back() + 1 == long(way.size()); }
    void ask(double enough, State state);
    void begin_step();
    void try_step();
    void after_step(const OnCurve& point, bool settled);
    void again_shorter();
    void try_fold();
    void after_fold_point(const OnCurve& point, bool settled);
    void after_fold();
    void ask_at_value(const CurveSample& a, const CurveSample& b);
    bool push_value(const OnCurve& point, bool settled);

    const Follower& f_;
    double low_, high_;
    State state_ = State::step;
    int count_ = 0, round_ = 0;
    double h_, began_ = 0.0;  // length of the next step, and of the one before
    bool smooth_ = false, has_fold_ = false, over_ = false;
    CurveSample to_, fold_, ends_[2];  // the end of the step, the fold in it, and points on both sides of the fold
    double value_at_ = 0.0;  // arc up to the value at which the way ends
};

class Follower {
public:
    Follower(const FreeArm& arm, const SelfMotionFunctions& core, const GridOfSolutions& given)
        : arm_(arm), core_(core), given_(given), nodes_(given.values) {
        turns_ = arm.given < 0 || !arm.written.slides[arm.given];
        cells_ = given.round ? given.values : given.values - 1;
    }

    void follow() {
        add_given();
        follow_cells();
        look_for_loops();
    }

    std::vector<Piece> pieces() {
        std::vector<Piece> out;
        const std::vector<std::vector<int>> by_cell = parts_by_cell();
        for (int from_node = 0; from_node < 2; ++from_node) {
            for (const std::vector<int>& cell : by_cell) {
                for (const int part : cell) {
                    if (!parts_[part].used && (from_node || !leads_on(parts_[part], 0))) out.push_back(joined(parts_[part]));
                }
            }
        }
        mark_reach(out);
        return out;
    }

    // The intervals of pieces inside the limits.
    void cut(const std::vector<Piece>& pieces, long pose, Intervals& to) const {
        const std::vector<std::vector<Mark>> marks = marked(pieces);
        for (std::size_t i = 0; i < pieces.size(); ++i) keep_inside(pieces[i], marks[i], pose, to);
    }

private:
    friend class Travel;
    double unit(int j) const { return arm_.unit[j]; }
    double gap(int j, double a, double b) const { return gap_of(arm_, j, a, b); }
    double apart(const double* a, const double* b) const {
        double most = 0.0;
        for (int j = 0; j < 7; ++j) most = std::max(most, std::abs(gap(j, a[j], b[j])));
        return most;
    }
    // Whether two joint vectors are apart by less than this in every joint.
    bool nearer(const double* a, const double* b, double than) const {
        for (int j = 0; j < 7; ++j) {
            if (!(std::abs(gap(j, a[j], b[j])) < than)) return false;
        }
        return true;
    }
    double value_near(double value, double before) const { return turns_ ? before + principal_angle(value - before) : value; }

    CurveSample sample_of(const OnCurve& point, double before) const {
        CurveSample out;
        std::copy_n(point.q, 7, out.q), std::copy_n(point.along, 7, out.along);
        out.value = value_near(point.value, before), out.rate = point.rate, out.arc = 0.0, out.sense = point.sense;
        return out;
    }
    // The given solutions become nodes, their tangents towards growing values.
    void add_given() {
        std::vector<Start> starts;
        std::vector<OnCurve> points;
        std::vector<std::pair<long, int>> of;
        for (long k = 0; k < given_.values; ++k) {
            for (int b = 0; b < given_.branches; ++b) {
                const long at = k * given_.branches + b;
                if (!(given_.flags[at] & 1)) continue;
                std::copy_n(given_.q + 7 * at, 7, starts.emplace_back(start(0, 0.0)).q);
                of.push_back({k, b});
            }
        }
        settle(starts, points);
        for (std::size_t i = 0; i < of.size(); ++i) {
            const auto [k, b] = of[i];
            add_node(k, sample_of(points[i], given_.grid[k]), b);
        }
    }
    // The cosine of two tangents' angle, and how far the way from one joint vector to another leads along a tangent.
    static double same(const double* a, const double* b) { return std::inner_product(a, a + 7, b, 0.0); }
    double ahead(const double* from, const double* to, const double* along) const {
        double sum = 0.0;
        for (int j = 0; j < 7; ++j) sum += gap(j, to[j], from[j]) * along[j];
        return sum;
    }
    static bool is_settled(const OnCurve& point, double enough) { return point.left <= std::max(enough, SETTLED); }
    // A point on the curve as a sample, its tangent oriented like `along`.
    CurveSample oriented(const OnCurve& point, const double* along, double before) const {
        CurveSample out = sample_of(point, before);
        if (same(point.along, along) < 0.0) flip(out);
        return out;
    }
    Start start(int rounds, double enough) const { return {given_.T, {}, {Pin::nothing, 0, 0.0}, rounds, enough}; }
    // Points near starts, side by side.
    void settle(const std::vector<Start>& starts, std::vector<OnCurve>& points) const {
        points.resize(starts.size());
        settled_ += long(starts.size());
        core_.settle(arm_, starts.data(), int(starts.size()), points.data());
    }
    static void flip(CurveSample& s) {
        for (double& each : s.along) each = -each;
        s.rate = -s.rate, s.sense = -s.sense;
    }
    // Whether two points with similar tangents may lie on one curve. If two curves nearly meet, a step that jumps from one to the
    // other changes the sense (Allgower and Georg, chapter 8). At a crossing the curve goes straight on, and the sense may change.
    bool agree(const CurveSample& a, const CurveSample& b) const { return straight_ || a.sense * b.sense >= 0; }
    // The point on the curve near q, its tangent oriented like `along`. Returns whether Newton's method converged.
    bool settle(const double* q, const double* along, double before, CurveSample& out) const {
        if (++settled_ > MOST_SETTLED) return false;
        Start from = start(MANY_ROUNDS, EXACT);
        std::copy_n(q, 7, from.q);
        OnCurve point;
        core_.settle(arm_, &from, 1, &point);
        if (!is_settled(point, EXACT)) return false;
        out = oriented(point, along, before);
        return true;
    }

    void between(const CurveSample& a, const CurveSample& b, double u, double* q, double* along = nullptr) const {
        interpolate(arm_, a, b, u, q, along);
    }
    // The least derivative of the parameter between two samples, times the arc.
    static double least_rate(const CurveSample& a, const CurveSample& b) {
        const Cubic value = value_on(a, b);
        const double u = -value.second / (3.0 * value.third);
        return u > 0.0 && u < 1.0 ? value.slope(u) : b.arc * std::min(a.rate, b.rate);
    }
    // Whether the cubic in the arc from a sample to a fold has another fold in between. The rate is a quadratic that is zero at the
    // fold. It has a second zero on the way if and only if the value gains less than a third of arc times the sample's rate.
    static bool folds_twice(const CurveSample& a, const CurveSample& fold, double arc) {
        return std::abs(fold.value - a.value) < std::abs(a.rate) * arc / 3.0;
    }
    static double share_at(double from, const Cubic& way);
    double way_to(const CurveSample& a, const CurveSample& b, const CurveSample& point) const;
    bool closes(const CurveSample& a, const CurveSample& b, const CurveSample& point) const;
    double off_line(const CurveSample& a, const CurveSample& b, double& arc, double& turned) const;
    void halve(std::vector<Bridge>& bridges) const;
    void bridge_cells();
    void follow(std::vector<Travel*> ways) const;
    void travel_ahead();

    long add_node(long k, CurveSample at, int column) {
        at.value = given_.grid[k];
        if (at.rate < 0.0) flip(at);
        nodes_[k].push_back({at, column, std::abs(at.rate) < NEARLY_EXACT});
        return long(nodes_[k].size()) - 1;
    }
    Node& node(const Place& place) { return nodes_[place.k][place.i]; }
    double low_of(long cell) const { return given_.grid[cell]; }
    double high_of(long cell) const { return cell + 1 < given_.values ? given_.grid[cell + 1] : given_.grid[0] + 2.0 * PI; }
    // A value of a periodic grid, in the turn from its first value.
    double value_from_first(double value) const {
        return turns_ && given_.round ? given_.grid[0] + (principal_angle(value - given_.grid[0] - PI) + PI) : value;
    }
    long cell_of(double value) const {
        const double* end = given_.grid + given_.values;
        const long above = std::upper_bound(given_.grid, end, value_from_first(value)) - given_.grid;
        return std::clamp(above - 1, 0l, cells_ - 1);
    }
    long next(long cell) const { return cell + 1 < given_.values ? cell + 1 : 0; }

    bool has_enough() const { return settled_ > MOST_SETTLED; }
    void follow_cells();
    bool follow_cell(long cell);
    void drop_bridges(long cell);
    bool add_parts(long cell, std::vector<CurveSample>& way, const std::vector<long>& folds, const Place& from, bool up, Stop stop);
    long node_at(long k, const CurveSample& at) const;
    void look_for_loops();
    void add_nearest(std::vector<double>& starts) const;
    bool known(const CurveSample& at) const;
    void places_near(const CurveSample& at, const std::vector<std::vector<int>>& by_cell, std::vector<Start>& to) const;
    void places_on(const Part& part, const CurveSample& at, std::vector<Start>& to) const;
    std::vector<std::vector<int>> parts_by_cell() const;
    void drop_known(std::vector<CurveSample>& points) const;
    void add_loop(const CurveSample& at);
    bool leads_on(const Part& part, int side) const {
        const auto [k, i] = part.node[side];
        return k >= 0 && nodes_[k][i].part[!side] >= 0;
    }
    Piece joined(Part& first);
    void mark_reach(std::vector<Piece>& pieces) const;

    // Whether a step between two samples is known to be inside or outside the limits all the way.
    enum class Step : std::uint8_t { inside, outside, open };
    // A sample, or where a joint crosses a limit, `share` of the way to a sample. joint: -1 for a sample, or where the joint's
    // range is a turn or more, so that another image is still inside and no interval ends. step: up to here.
    struct Mark {
        CurveSample at;
        double share = 1.0;
        int joint = -1;
        bool upper = false, crossing = false;
        Step step = Step::open;
    };
    bool limited(int j) const { return std::isfinite(given_.lower[j]) || std::isfinite(given_.upper[j]); }
    bool wide(int j) const { return !arm_.written.slides[j] && given_.upper[j] - given_.lower[j] >= 2.0 * PI; }
    double room(int j, double q) const;
    double least_room(const double* q) const;
    Step step_of(const CurveSample& a, const CurveSample& b) const;
    void split(const CurveSample& a, const CurveSample& b, int depth, std::vector<CurveSample>& to) const;
    void crossings(const CurveSample& a, const CurveSample& b, std::vector<Mark>& to, std::vector<Start>& starts) const;
    std::vector<std::vector<Mark>> marked(const std::vector<Piece>& pieces) const;
    void keep_inside(const Piece& piece, const std::vector<Mark>& marks, long pose, Intervals& to) const;
    bool is_inside(const CurveSample& a, const CurveSample& b, double from, double to) const;
    // A part of a piece inside the limits.
    struct Run {
        std::vector<CurveSample> samples;
        EndOf why[2];
        int joint[2];
    };
    std::vector<Run> by_turns(const Run& run) const;
    void keep(const Piece& piece, const Run& run, double turns, long pose, Intervals& to) const;

    const FreeArm& arm_;
    const SelfMotionFunctions& core_;
    const GridOfSolutions& given_;
    std::vector<std::vector<Node>> nodes_;
    std::vector<Part> parts_;
    long cells_;
    bool turns_;
    double longest_ = LONGEST;
    bool straight_ = false;
    mutable long settled_ = 0;
};

}  // namespace urdf_ik::self_motion
