// The parts of a curve inside the joint limits; see follower.hpp.
#include "motion/self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// The distance of a joint's best image to the nearer limit, negative outside.
double Follower::room(int j, double q) const {
    const double low = given_.lower[j], high = given_.upper[j];
    if (arm_.written.slides[j]) return std::min(q - low, high - q);
    if (!std::isfinite(high - low) || high - low >= 2.0 * PI) return PI;  // some image is inside
    const double middle = 0.5 * (low + high);
    return 0.5 * (high - low) - std::abs(principal_angle(q - middle));
}
double Follower::least_room(const double* q) const {
    double least = PI;
    for (int j = 0; j < 7; ++j) least = limited(j) ? std::min(least, room(j, q[j]) / unit(j)) : least;
    return least;
}

// What is known of the joints between two samples, which are no farther from each other than the way is long.
Follower::Step Follower::step_of(const CurveSample& a, const CurveSample& b) const {
    Step out = Step::inside;
    for (int j = 0; j < 7; ++j) {
        const double far = 1.5 * b.arc * unit(j), low = given_.lower[j], high = given_.upper[j], one = room(j, a.q[j]);
        if (!limited(j)) continue;
        if (one < -far && room(j, b.q[j]) < -far) return Step::outside;
        const bool off = wide(j) ? std::abs(principal_angle(a.q[j] - low)) > far && std::abs(principal_angle(a.q[j] - high)) > far
                                 : one > far && room(j, b.q[j]) > far;
        if (!off) out = Step::open;
    }
    return out;
}

// Append `b`, after samples between `a` and `b` at which a joint turns back near a limit.
void Follower::split(const CurveSample& a, const CurveSample& b, int depth, std::vector<CurveSample>& to) const {
    double where = -1.0;
    for (int j = 0; depth < MOST_SPLITS && b.arc > SAME && j < 7 && where < 0.0; ++j) {
        if (!limited(j) || std::min(room(j, a.q[j]), room(j, b.q[j])) > 2.0 * b.arc * unit(j)) continue;
        const auto [one, other] = joint_on(arm_, j, a, b).level();
        for (const double u : {one, other}) {
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
        if (settle(q, a.along, a.value, middle)) {
            CurveSample last = b;
            middle.arc = where * b.arc, last.arc = (1.0 - where) * b.arc;
            split(a, middle, depth + 1, to);
            split(middle, last, depth + 1, to);
            return;
        }
    }
    to.push_back(b);
}

// Where joints cross their limits between two samples: the starts from which the crossings are settled.
void Follower::crossings(const CurveSample& a, const CurveSample& b, std::vector<Mark>& to, std::vector<Start>& starts) const {
    for (int j = 0; j < 7; ++j) {
        for (const bool upper : {false, true}) {
            const double limit = upper ? given_.upper[j] : given_.lower[j];
            if (!std::isfinite(limit)) continue;
            const double from = gap(j, a.q[j], limit), end = from + gap(j, b.q[j], a.q[j]);
            if (std::abs(from) > 2.0 || from * end > 0.0 || end == 0.0) continue;
            // One root of the cubic. split() has put samples where a joint turns back: three roots are not expected.
            const double share = share_at(from, joint_on(arm_, j, a, b));
            to.push_back({b, share, wide(j) ? -1 : j, upper, true});
            Start& near = starts.emplace_back(start(MANY_ROUNDS, EXACT));
            between(a, b, share, near.q);
            near.pin = {Pin::joint, j, arm_.written.slides[j] ? limit : principal_angle(limit)};
        }
    }
}

// Whether the midpoint of a part of the step is inside all limits.
bool Follower::is_inside(const CurveSample& a, const CurveSample& b, double from, double to) const {
    double q[7];
    between(a, b, 0.5 * (from + to), q);
    const double least = least_room(q);
    CurveSample middle;
    if (std::abs(least) > 1e-4 || !settle(q, a.along, a.value, middle)) return least > 0.0;
    return least_room(middle.q) >= 0.0;
}

// The pieces with samples where joints turn back and where they cross their limits, which are settled side by side.
std::vector<std::vector<Follower::Mark>> Follower::marked(const std::vector<Piece>& pieces) const {
    // Samples, and behind each the crossings on the way to it.
    std::vector<std::vector<Mark>> out(pieces.size());
    std::vector<Start> starts;
    std::vector<OnCurve> points;
    std::vector<CurveSample> fine;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const std::vector<CurveSample>& samples = pieces[p].samples;
        out[p].push_back({samples.front()});
        for (std::size_t i = 1; i < samples.size(); ++i) {
            const Step step = step_of(samples[i - 1], samples[i]);
            fine.assign(1, samples[i - 1]);
            if (step == Step::open) split(samples[i - 1], samples[i], 0, fine);
            else fine.push_back(samples[i]);
            for (std::size_t k = 1; k < fine.size(); ++k) {
                out[p].push_back({fine[k], 1.0, -1, false, false, step});
                if (step == Step::open) crossings(fine[k - 1], fine[k], out[p], starts);
            }
        }
    }
    settle(starts, points);
    const OnCurve* point = points.data();
    for (std::vector<Mark>& marks : out) {
        std::vector<Mark> kept(1, marks[0]);
        for (std::size_t i = 1, next = 1; i < marks.size(); i = next) {
            const CurveSample a = kept.back().at, &b = marks[i].at;
            const std::size_t first = kept.size();
            for (++next; next < marks.size() && marks[next].crossing; ++next, ++point) {
                if (!is_settled(*point, EXACT)) continue;
                kept.push_back(marks[next]);
                kept.back().at = oriented(*point, a.along, a.value);
            }
            std::sort(kept.begin() + first, kept.end(), [](const Mark& x, const Mark& y) { return x.share < y.share; });
            kept.push_back(marks[i]);
            double from = 0.0;
            for (std::size_t k = first; k < kept.size(); from = kept[k++].share) {
                kept[k].at.arc = (kept[k].share - from) * b.arc;
                if (marks[i].step == Step::open) kept[k].step = is_inside(a, b, from, kept[k].share) ? Step::inside : Step::outside;
                else kept[k].step = marks[i].step;
            }
        }
        marks = std::move(kept);
    }
    return out;
}

template <class Run> static void join_first_to_last(std::vector<Run>& runs, double turns) {
    Run& back = runs.back();
    for (std::size_t i = 1; i < runs.front().samples.size(); ++i) {
        back.samples.push_back(runs.front().samples[i]);
        back.samples.back().value += turns;
    }
    back.why[1] = runs.front().why[1], back.joint[1] = runs.front().joint[1];
    runs.erase(runs.begin());
}

void Follower::keep_inside(const Piece& piece, const std::vector<Mark>& marks, long pose, Intervals& to) const {
    std::vector<Run> runs;
    // The cause of an end of a run: where no crossing was found, it ends at the last sample.
    const auto end = [&](int side, const Mark& at, EndOf other) {
        runs.back().why[side] = at.joint < 0 ? other : at.upper ? EndOf::upper_limit : EndOf::lower_limit;
        runs.back().joint[side] = at.joint;
    };
    bool open = false;
    for (std::size_t i = 1; i < marks.size(); ++i) {
        const bool in = marks[i].step == Step::inside;
        if (in && !open) {
            runs.push_back({{marks[i - 1].at}, {}, {}});
            runs.back().samples[0].arc = 0.0;
            end(0, marks[i - 1], i == 1 ? piece.why[0] : EndOf::singularity);
        }
        if (!in && open) end(1, marks[i - 1], EndOf::singularity);
        if (in) runs.back().samples.push_back(marks[i].at);
        open = in;
    }
    if (open) end(1, marks.back(), piece.why[1]);
    // A closed curve may need several turns of the value to close.
    const double turns = piece.samples.back().value - piece.samples.front().value;
    // On a closed curve, join the last run to the first if both touch the sample at which the curve was opened.
    if (piece.closed && runs.size() > 1 && runs.front().why[0] == EndOf::nothing && runs.back().why[1] == EndOf::nothing) {
        join_first_to_last(runs, turns);
    }
    for (const Run& run : runs) {
        for (const Run& part : by_turns(run)) {
            if (part.samples.size() >= 2) keep(piece, part, turns, pose, to);
        }
    }
}

// A run; if it covers more than one turn of the value, it is cut where it passes the first value of the grid.
std::vector<Follower::Run> Follower::by_turns(const Run& run) const {
    std::vector<Run> out(1, run);
    if (!given_.round || run.samples.back().value - run.samples.front().value <= 2.0 * PI + NEARLY_EXACT) return out;
    out[0].samples.clear();
    for (const CurveSample& each : run.samples) {
        out.back().samples.push_back(each);
        const bool inside = &each != &run.samples.front() && &each != &run.samples.back();
        if (!inside || std::abs(principal_angle(each.value - given_.grid[0])) > NEARLY_EXACT) continue;
        Run next = run;
        next.samples.assign(1, each);
        next.samples.front().arc = 0.0;
        out.back().why[1] = next.why[0] = EndOf::nothing, out.back().joint[1] = next.joint[0] = -1;
        out.push_back(std::move(next));
    }
    return out;
}

// Add a run as an interval, with the column of the given solution nearest to its middle.
void Follower::keep(const Piece& piece, const Run& run, double turns, long pose, Intervals& to) const {
    Interval found = {pose, long(to.samples.size()),  long(run.samples.size()),
                      -1,   {run.why[0], run.why[1]}, {run.joint[0], run.joint[1]}};
    const double low = run.samples.front().value, high = run.samples.back().value, middle = 0.5 * (low + high);
    double nearest = INFINITY;
    for (const auto& [value, column] : piece.columns) {
        for (const double there : {value, value + turns}) {
            if (column < 0 || (there != value && !piece.closed) || there < low || there > high) continue;
            if (std::abs(there - middle) < nearest) nearest = std::abs(there - middle), found.column = column;
        }
    }
    to.samples.insert(to.samples.end(), run.samples.begin(), run.samples.end());
    to.found.push_back(found);
}

}  // namespace urdf_ik::self_motion
