// Following a curve between two values; see follower.hpp.
#include "motion/self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// The share at which a number that changes its sign along the way is zero: Newton's method, and bisection where it leaves the
// bracket.
double Follower::share_at(double from, const Cubic& way) {
    const double change = way.at(1.0);
    double low = 0.0, high = 1.0, u = -from / change;
    for (int round = 0; round < MOST_SECANTS; ++round) {
        const double there = from + way.at(u);
        (there * change < 0.0 ? low : high) = u;
        double next = u - there / way.slope(u);
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (std::abs(next - u) < 1e-12) return next;
        u = next;
    }
    return u;
}

// The position of a point along the step between two samples, from 0 to 1.
double Follower::way_to(const CurveSample& a, const CurveSample& b, const CurveSample& point) const {
    return std::clamp(ahead(a.q, point.q, a.along) / (b.arc + 1e-300), 0.0, 1.0);
}
// Whether the step between two samples passes through a point, in the direction of its tangent.
bool Follower::closes(const CurveSample& a, const CurveSample& b, const CurveSample& point) const {
    if (apart(a.q, point.q) > 1.5 * b.arc || apart(b.q, point.q) > 1.5 * b.arc) return false;
    if (!(ahead(a.q, point.q, a.along) > 0.0 && ahead(point.q, b.q, b.along) >= 0.0 && same(a.along, point.along) > 0.0 &&
          agree(a, point)))
        return false;
    double q[7];
    between(a, b, way_to(a, b, point), q);
    return apart(q, point.q) < NEARLY_SAME;
}

Travel::Travel(const Follower& follower, const CurveSample& from, double low, double high)
    : way(1, from), next(follower.start(0, 0.0)), f_(follower), low_(low), high_(high), h_(0.5 * follower.longest_) {
    begin_step();
}

void Travel::ask(double enough, State state) {
    next.rounds = enough < ON_THE_WAY ? MANY_ROUNDS : FEW_ROUNDS, next.enough = enough;
    state_ = state;
}

// Newton's method has reached a point from what was asked for.
void Travel::go_on(const OnCurve& point) {
    const bool settled = Follower::is_settled(point, next.enough);
    switch (state_) {
        case State::step:
            return after_step(point, settled);
        case State::fold:
            return after_fold_point(point, settled);
        case State::value:
            if (push_value(point, settled)) return end(over_ ? Stop::high : Stop::low);
            if (to_.arc < 1e-5) return end(Stop::lost);
            h_ = 0.3 * to_.arc;
            return begin_step();
        case State::ended:
            return;
    }
}

// One more step along the curve.
void Travel::begin_step() {
    if (count_++ == MOST_STEPS) return end(Stop::lost);
    smooth_ = way.size() > 1 && !at_fold();
    began_ = h_;
    try_step();
}
void Travel::try_step() {
    if (h_ < HALF_OF_THE_DIGITS) return end(Stop::lost);
    const CurveSample& from = way.back();
    const double bend = smooth_ && from.arc > 0.0 ? 0.5 * h_ * h_ / from.arc : 0.0;
    for (int j = 0; j < 7; ++j) {
        const double curved = smooth_ ? bend * (from.along[j] - way[way.size() - 2].along[j]) : 0.0;
        next.q[j] = from.q[j] + f_.unit(j) * (h_ * from.along[j] + curved);
    }
    const double share = std::min(1.0, h_ / WIDE_STEP);
    ask(std::max(ON_THE_WAY * share * share, EXACT), State::step);
}
void Travel::after_step(const OnCurve& point, bool settled) {
    const CurveSample& from = way.back();
    to_ = f_.oriented(point, from.along, from.value);
    const double turned = std::acos(std::min(1.0, f_.same(to_.along, from.along)));
    if (!(settled && point.moved <= ASIDE * h_ && f_.agree(from, to_) && turned <= TOO_MUCH)) {
        h_ *= 0.4;
        return try_step();
    }
    double square = 0.0;
    for (int j = 0; j < 7; ++j) square += std::pow(f_.gap(j, to_.q[j], from.q[j]), 2);
    // The arc, from its chord.
    to_.arc = std::sqrt(square) * (1.0 + turned * turned / 24.0);
    h_ = std::min(f_.longest_, h_ * std::clamp(AIM / (turned + 1e-3), 0.3, 2.0));

    CurveSample a = from, b = to_;
    if (sense() < 0.0) a.value = -a.value, a.rate = -a.rate, b.value = -b.value, b.rate = -b.rate;
    if (b.rate >= 0.0 && a.rate > NEARLY_EXACT && f_.least_rate(a, b) <= 0.0 && to_.arc > 1e-5)
        return again_shorter();  // two folds
    has_fold_ = from.rate * to_.rate < 0.0 && std::abs(from.rate) > NEARLY_EXACT;
    if (!has_fold_) return after_fold();
    ends_[0] = from, ends_[1] = to_, round_ = 0;
    try_fold();
}
// Several folds may lie in the step.
void Travel::again_shorter() {
    h_ = 0.4 * std::min(began_, to_.arc);
    begin_step();
}

// The fold, where the rate is zero: between two points on the curve with rates of opposite signs, the next one is where the cubic
// stands still, and takes the place of one of them.
void Travel::try_fold() {
    const auto [one, other] = value_on(ends_[0], ends_[1]).level();
    const double share = one > 0.0 && one < 1.0 ? one : other;
    f_.between(ends_[0], ends_[1], share > 0.0 && share < 1.0 ? share : 0.5, next.q);
    ask(EXACT, State::fold);
}
void Travel::after_fold_point(const OnCurve& point, bool settled) {
    const CurveSample& from = way.back();
    auto& [begin, end_] = ends_;
    fold_ = f_.oriented(point, begin.along, begin.value);
    if (!settled || !f_.agree(from, fold_)) return end(Stop::lost);
    fold_.arc = end_.arc * f_.way_to(begin, end_, fold_);
    const bool before = fold_.rate * from.rate > 0.0;
    if (before) end_.arc -= fold_.arc, begin = fold_;
    else end_ = fold_;
    if (std::abs(fold_.rate) >= NEARLY_EXACT && ++round_ < MOST_SECANTS && end_.arc > 1e-12 * to_.arc) return try_fold();
    fold_.arc = to_.arc * f_.way_to(from, to_, fold_);
    after_fold();
}

// The step, up to its fold or to its end, is known. Where the value leaves the range, the way ends.
void Travel::after_fold() {
    const CurveSample &from = way.back(), &last = has_fold_ ? fold_ : to_;
    if (has_fold_ && to_.arc > 1e-5 &&
        (Follower::folds_twice(from, fold_, fold_.arc) || Follower::folds_twice(to_, fold_, to_.arc - fold_.arc)))
        return again_shorter();  // three folds
    over_ = last.value > high_;
    if ((over_ && sense() > 0.0) || (last.value < low_ && sense() < 0.0)) return ask_at_value(from, last);
    const std::size_t k = way.size();
    way.push_back(last);
    if (k > 2 && f_.closes(way[k - 1], last, way[0])) {
        way[k] = way[0], way[k].arc = last.arc * f_.way_to(way[k - 1], last, way[0]);
        return end(Stop::closed);
    }
    if (!has_fold_) return begin_step();
    folds.push_back(long(k));
    has_fold_ = false, to_.arc -= fold_.arc;
    if (to_.arc > HALF_OF_THE_DIGITS) after_fold();
    else begin_step();
}

// The point between two samples at which the value leaves the range.
void Travel::ask_at_value(const CurveSample& a, const CurveSample& b) {
    const double value = over_ ? high_ : low_;
    const double share = Follower::share_at(a.value - value, value_on(a, b));
    f_.between(a, b, share, next.q);
    next.pin = {Pin::parameter, 0, value};
    value_at_ = share * b.arc;
    ask(EXACT, State::value);
}
bool Travel::push_value(const OnCurve& point, bool settled) {
    CurveSample there = f_.oriented(point, way.back().along, next.pin.value);
    there.value = next.pin.value, there.arc = value_at_;
    next.pin = {Pin::nothing, 0, 0.0};
    if (!settled || !f_.agree(way.back(), there)) return false;
    way.push_back(there);
    return true;
}

// Follow the curves of nodes that are not joined side by side, before the cells are gone through. The two ends of a fold lead to
// each other, so of two nodes that look like its ends only one is followed.
void Follower::travel_ahead() {
    std::vector<Travel*> ways;
    for (long cell = 0; cell < cells_; ++cell) {
        for (int side = 0; side < 2; ++side) {
            std::vector<Node*> open;
            for (Node& each : nodes_[side ? next(cell) : cell]) {
                each.ahead[side] = nullptr;
                if (!each.stands && each.part[side] < 0) open.push_back(&each);
            }
            while (!open.empty()) {
                Node& node = *open.front();
                open.erase(open.begin());
                CurveSample from = node.at;
                if (side) flip(from), from.value = high_of(cell);
                node.ahead[side] = std::make_shared<Travel>(*this, from, low_of(cell), high_of(cell));
                ways.push_back(node.ahead[side].get());
                const auto away = [&](const Node* other) { return apart(node.at.q, other->at.q); };
                const auto mate = std::min_element(open.begin(), open.end(), [&](auto a, auto b) { return away(a) < away(b); });
                if (mate != open.end() && node.at.sense * (*mate)->at.sense < 0) open.erase(mate);
            }
        }
    }
    follow(ways);
}

// Follow curves side by side, each to its end.
void Follower::follow(std::vector<Travel*> ways) const {
    std::vector<Start> starts;
    std::vector<OnCurve> points;
    for (;;) {
        std::erase_if(ways, [](const Travel* each) { return each->ended(); });
        if (ways.empty()) return;
        starts.clear();
        for (const Travel* each : ways) starts.push_back(each->next);
        settle(starts, points);
        for (std::size_t i = 0; i < ways.size(); ++i) {
            if (has_enough()) ways[i]->end(Stop::lost);
            else ways[i]->go_on(points[i]);
        }
    }
}

}  // namespace urdf_ik::self_motion
