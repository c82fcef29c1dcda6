// The parts of a curve inside the joint limits; see follower.hpp.
#include "self_motion/follower.hpp"

namespace urdf_ik::self_motion {

// The distance of a joint's best image to the nearer limit, negative outside.
double Follower::room(int j, double q) const {
    const double low = given_.lower[j], high = given_.upper[j];
    if (arm_.written.slides[j]) return std::min(q - low, high - q);
    if (!std::isfinite(high - low) || high - low >= 2.0 * PI) return PI;  // some image is inside
    const double middle = 0.5 * (low + high);
    return 0.5 * (high - low) - std::abs(principal_angle(q - middle));
}
bool Follower::inside(const double* q) const {
    for (int j = 0; j < 7; ++j) {
        if (limited(j) && room(j, q[j]) < 0.0) return false;
    }
    return true;
}

// Whether one joint is outside its limits all the way between two samples: farther at both ends than the way is long.
bool Follower::outside(const CurveSample& a, const CurveSample& b) const {
    for (int j = 0; j < 7; ++j) {
        const double far = -1.5 * b.arc * unit(j);
        if (limited(j) && room(j, a.q[j]) < far && room(j, b.q[j]) < far) return true;
    }
    return false;
}
// Whether all joints are inside their limits all the way between two samples: farther from them at both ends than the way is long.
bool Follower::all_inside(const CurveSample& a, const CurveSample& b) const {
    for (int j = 0; j < 7; ++j) {
        const double far = 1.5 * b.arc * unit(j);
        if (!limited(j)) continue;
        if (wide(j) ? !off_limits(j, a.q[j], far) : !(room(j, a.q[j]) > far && room(j, b.q[j]) > far)) return false;
    }
    return true;
}
// Whether a joint whose range is a turn or more is farther from its limits.
bool Follower::off_limits(int j, double q, double far) const {
    return std::abs(principal_angle(q - given_.lower[j])) > far && std::abs(principal_angle(q - given_.upper[j])) > far;
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
void Follower::crossings(const CurveSample& a, const CurveSample& b, std::vector<Crossing>& to, std::vector<Start>& starts) const {
    for (int j = 0; j < 7; ++j) {
        if (!limited(j)) continue;
        for (int side = 0; side < 2; ++side) {
            const double limit = side ? given_.upper[j] : given_.lower[j];
            if (!std::isfinite(limit)) continue;
            const double from = gap(j, a.q[j], limit), end = from + gap(j, b.q[j], a.q[j]);
            if (std::abs(from) > 2.0 || from * end > 0.0 || end == 0.0) continue;
            // One root of the cubic. split() has put samples where a joint turns back: three roots are not expected.
            Crossing& c = to.emplace_back();
            c.share = share_at(from, joint_on(arm_, j, a, b)), c.joint = j, c.upper = side, c.wide = wide(j);
            Start& near = starts.emplace_back(start(MANY_ROUNDS, EXACT));
            between(a, b, c.share, near.q);
            near.pin = {Pin::joint, j, arm_.written.slides[j] ? limit : principal_angle(limit)};
        }
    }
}

// Whether the midpoint of a part of the step is inside all limits.
bool Follower::is_inside(const CurveSample& a, const CurveSample& b, double from, double to) const {
    double q[7];
    between(a, b, 0.5 * (from + to), q);
    double least = PI;
    for (int j = 0; j < 7; ++j) {
        if (limited(j)) least = std::min(least, room(j, q[j]) / unit(j));
    }
    if (std::abs(least) > 1e-4) return least > 0.0;
    CurveSample middle;
    if (!settle(q, a.along, a.value, middle)) return least > 0.0;
    return inside(middle.q);
}

// The pieces with samples where joints turn back, and the crossings of the limits, settled side by side.
std::vector<Follower::Cut> Follower::crossed(const std::vector<Piece>& pieces) const {
    std::vector<Cut> out(pieces.size());
    std::vector<Start> starts;
    std::vector<OnCurve> points;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const std::vector<CurveSample>& samples = pieces[p].samples;
        Cut& cut = out[p];
        cut.fine.reserve(samples.size() + 8), cut.steps.reserve(samples.size() + 8);
        cut.fine.push_back(samples.front()), cut.steps.push_back(Step::outside);
        for (std::size_t i = 1; i < samples.size(); ++i) {
            const CurveSample &a = samples[i - 1], &b = samples[i];
            const Step step = outside(a, b) ? Step::outside : all_inside(a, b) ? Step::inside : Step::open;
            if (step == Step::open) split(a, b, 0, cut.fine);
            else cut.fine.push_back(b);
            cut.steps.resize(cut.fine.size(), step);
        }
        for (std::size_t i = 1; i < cut.fine.size(); ++i) {
            if (cut.steps[i] == Step::open) crossings(cut.fine[i - 1], cut.fine[i], cut.met, starts);
            cut.ends.push_back(cut.met.size());
        }
    }
    settle(starts, points);
    std::size_t next = 0;
    for (Cut& cut : out) {
        std::size_t met = 0;
        std::vector<Crossing> kept;
        for (std::size_t i = 1; i < cut.fine.size(); ++i) {
            const std::size_t first = kept.size();
            for (; met < cut.ends[i - 1]; ++met, ++next) {
                if (!is_settled(points[next], EXACT)) continue;
                Crossing& c = kept.emplace_back(cut.met[met]);
                c.at = oriented(points[next], cut.fine[i - 1].along, cut.fine[i - 1].value);
                c.at.arc = c.share * cut.fine[i].arc;
            }
            std::sort(kept.begin() + first, kept.end(), [](const Crossing& x, const Crossing& y) { return x.share < y.share; });
            cut.ends[i - 1] = kept.size();
        }
        cut.met = std::move(kept);
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

void Follower::keep_inside(const Piece& piece, const Cut& cut, long pose, Intervals& to) const {
    const std::vector<CurveSample>& fine = cut.fine;
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
        const Crossing* met = cut.met.data() + (i > 1 ? cut.ends[i - 2] : 0);
        const std::size_t many = cut.met.data() + cut.ends[i - 1] - met;
        double from = 0.0;
        for (std::size_t k = 0; k <= many; ++k) {
            const double end = k < many ? met[k].share : 1.0;
            const bool in = cut.steps[i] == Step::inside || (cut.steps[i] == Step::open && is_inside(a, b, from, end));
            if (in && !open) begin(crossed ? last_crossing.at : a, crossed);
            if (!in && open) {
                // If no crossing was found, the run ends at the last sample.
                runs.back().why[1] = crossed ? (last_crossing.upper ? EndOf::upper_limit : EndOf::lower_limit) : EndOf::singularity;
                runs.back().joint[1] = crossed ? last_crossing.joint : -1;
                open = false;
            }
            if (k < many) {
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
    // A closed curve may need several turns of the value to close.
    const double turns = piece.samples.back().value - piece.samples.front().value;
    // On a closed curve, join the last run to the first if both touch the sample at which the curve was opened.
    if (piece.closed && runs.size() > 1 && runs.front().why[0] == EndOf::nothing && runs.back().why[1] == EndOf::nothing) {
        join_first_to_last(runs, turns);
    }
    for (Run& run : runs) {
        for (const Run& part : by_turns(std::move(run))) {
            if (part.samples.size() >= 2) keep(piece, part, turns, pose, to);
        }
    }
}

// A run; if it covers more than one turn of the value, it is cut where it passes the first value of the grid.
std::vector<Follower::Run> Follower::by_turns(Run&& run) const {
    std::vector<Run> out;
    if (!given_.round || run.samples.back().value - run.samples.front().value <= 2.0 * PI + NEARLY_EXACT) {
        out.push_back(std::move(run));
        return out;
    }
    out.push_back(run);
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
