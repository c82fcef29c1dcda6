// What a motion planner asks of an arm beyond ik(): solutions inside the planner's limits with all their turns, nearest to a seed
// first, kept or refused by a callback, within a time; base and tip that stand on those of the arm; a comparison with the planner's
// own model. The plugin for MoveIt 2 (ros/urdf_ik_moveit) is this with MoveIt's types.
//
//     const urdf_ik::Group group = urdf_ik::Group::make(arm, {joints, lower, upper, "base", "gripper"}, link_pose, &error);
//     if (group.search(T, seed, {}, accept, solution) == urdf_ik::Outcome::found) ...
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <urdf_ik.hpp>

namespace urdf_ik {

enum class Outcome { found, none, timed_out, no_pose, bad_seed };

class Group {
public:
    using Vector = std::vector<double>;  // joint values in the order of the planner [rad, m]

    // The planner's view of the arm. Limits are infinite where there are none; they may be narrower than the URDF's.
    struct Names {
        std::vector<std::string> joints;
        Vector lower, upper;
        std::string base, tip;  // links: those of the arm, or fixed to them
    };
    struct Query {
        Vector consistency;  // greatest distance of each joint from the seed; empty: any
        double timeout = std::numeric_limits<double>::infinity();  // [s]
        bool locked = false;  // redundancy parameters keep the seed's values
        double step = 0.1;  // between values of a redundancy parameter [rad, m]
    };
    // The pose (16) of a link in any one frame at joint values, by the planner's model; false: it has no such link.
    using LinkPose = std::function<bool(const Vector& q, const std::string& link, double* T)>;
    // Whether a solution is taken; planners refuse those in collision.
    using Accept = std::function<bool(const Vector& q)>;

    // Difference of a pose's entries [m, and of rotations] up to which the planner's model is the arm's.
    static constexpr double SAME_MODEL = 1e-7;
    // Images of the solutions of one value of the redundancy parameters that are looked at, at most.
    static constexpr std::size_t MOST_IMAGES = 4096;

    Group() = default;
    // Empty, and `error` says why: other joints, other links, or forward kinematics that differ at one of eight joint vectors, as
    // after a calibration.
    static Group make(Arm arm, Names names, const LinkPose& pose, std::string* error = nullptr) {
        Group made;
        const std::string problem = made.fill(std::move(arm), std::move(names), pose);
        if (problem.empty()) return made;
        if (error) *error = problem;
        return {};
    }
    explicit operator bool() const { return bool(arm_); }
    const Arm& arm() const { return arm_; }
    const Names& names() const { return names_; }

    // The pose T (16) of the tip in the base.
    void fk(const Vector& q, double* T) const {
        double at[16], left[16];
        arm_.fk(to_arm(q).data(), 1, at);
        product(from_base_, at, left), product(left, to_tip_, T);
    }

    // The nearest solution that is accepted. An arm with redundancy parameters is solved at the seed's values of them first, then
    // at values one step away, two steps, and so on; the nearest solution of a step comes first. `accept` may be empty.
    Outcome search(const double* T, const Vector& seed, const Query& query, const Accept& accept, Vector& solution) const {
        return each(T, seed, query, [&](const Vector& q) {
            if (accept && !accept(q)) return false;
            solution = q;
            return true;
        });
    }
    // All solutions inside the limits, nearest first; with redundancy parameters, all at the steps of them.
    Outcome all(const double* T, const Vector& seed, const Query& query, std::vector<Vector>& solutions) const {
        solutions.clear();
        const Outcome end = each(T, seed, query, [&](const Vector& q) { return solutions.push_back(q), false; });
        if (end != Outcome::none || solutions.empty()) return end;
        std::stable_sort(solutions.begin(), solutions.end(),
                         [&](const Vector& a, const Vector& b) { return apart(a, seed) < apart(b, seed); });
        return Outcome::found;
    }

private:
    struct Found {
        Vector q;
        double distance;
    };

    static void product(const double* A, const double* B, double* C) {
        for (int r = 0; r < 4; ++r) {
            for (int c = 0; c < 4; ++c) {
                C[4 * r + c] = 0.0;
                for (int k = 0; k < 4; ++k) C[4 * r + c] += A[4 * r + k] * B[4 * k + c];
            }
        }
    }
    static void inverse(const double* A, double* B) {
        for (int r = 0; r < 3; ++r) {
            B[4 * r + 3] = 0.0;
            for (int c = 0; c < 3; ++c) B[4 * r + c] = A[4 * c + r], B[4 * r + 3] -= A[4 * c + r] * A[4 * c + 3];
        }
        B[12] = B[13] = B[14] = 0.0, B[15] = 1.0;
    }
    static double difference(const double* A, const double* B) {
        double most = 0.0;
        for (int i = 0; i < 16; ++i) most = std::isnan(A[i] - B[i]) ? INFINITY : std::max(most, std::fabs(A[i] - B[i]));
        return most;
    }
    static double apart(const Vector& a, const Vector& b) {
        double sum = 0.0;
        for (std::size_t j = 0; j < a.size(); ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
        return sum;
    }

    std::string fill(Arm arm, Names names, const LinkPose& pose) {
        const std::size_t n = std::size_t(arm.joints());
        if (names.joints.size() != n || names.lower.size() != n || names.upper.size() != n) {
            return "the compiled arm has " + std::to_string(n) + " joints, the group " + std::to_string(names.joints.size());
        }
        for (int j = 0; j < arm.joints(); ++j) {
            const std::string& name = arm.joint(j).name;
            const auto found = std::find(names.joints.begin(), names.joints.end(), name);
            if (found == names.joints.end()) return "the compiled arm's joint " + name + " is not one of the group's";
            at_.push_back(std::size_t(found - names.joints.begin()));
            turn_.push_back(0.0);
        }
        for (std::size_t j = 0; j < n; ++j) turn_[at_[j]] = arm.joint(int(j)).turn;
        arm_ = std::move(arm), names_ = std::move(names);
        const std::string problem = compare(pose);
        if (!problem.empty()) arm_ = Arm();
        return problem;
    }
    // The fixed poses between the planner's links and the arm's, and whether both models agree.
    std::string compare(const LinkPose& pose) {
        for (int k = 0; k < 8; ++k) {
            Vector q(names_.joints.size());
            // Within the limits, spread evenly; the first at zero or beside it.
            for (std::size_t j = 0; j < q.size(); ++j) {
                const double low = std::max(names_.lower[j], -3.0), high = std::min(names_.upper[j], 3.0);
                const double share = std::fmod(0.5 + 0.618034 * double(k) * double(j + 1), 1.0);
                q[j] = low + share * (high - low);
            }
            double links[4][16], back[16], reached[16], expected[16], offset[16];
            const std::string* const wanted[4] = {&names_.base, &arm_.base(), &arm_.tip(), &names_.tip};
            for (int i = 0; i < 4; ++i) {
                if (!pose(q, *wanted[i], links[i])) return "the robot model has no link " + *wanted[i];
            }
            inverse(links[1], back), product(back, links[2], reached);
            arm_.fk(to_arm(q).data(), 1, expected);
            if (!(difference(reached, expected) <= SAME_MODEL)) {
                return "the robot model puts " + arm_.tip() + " " + std::to_string(1e3 * difference(reached, expected)) +
                       " mm or mrad from where the compiled arm does: the URDF changed since; urdf-ik compile writes it anew";
            }
            inverse(links[0], back), product(back, links[1], offset);
            if (!fixed(k, offset, from_base_)) return names_.base + " is not fixed to " + arm_.base();
            inverse(links[2], back), product(back, links[3], offset);
            if (!fixed(k, offset, to_tip_)) return names_.tip + " is not fixed to " + arm_.tip();
        }
        return {};
    }
    static bool fixed(int k, const double* offset, double* kept) {
        if (k == 0) std::copy(offset, offset + 16, kept);
        return difference(offset, kept) <= SAME_MODEL;
    }
    Vector to_arm(const Vector& q) const {
        Vector in_order(q.size());
        for (std::size_t j = 0; j < q.size(); ++j) in_order[j] = q[at_[j]];
        return in_order;
    }

    // Calls `take` with solutions until it returns true.
    template <class Take> Outcome each(const double* T, const Vector& seed, const Query& query, const Take& take) const {
        const auto start = std::chrono::steady_clock::now();
        const auto late = [&] {
            return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > query.timeout;
        };
        const std::size_t n = names_.joints.size(), p = std::size_t(arm_.parameters());
        if (seed.size() != n || (!query.consistency.empty() && query.consistency.size() != n)) return Outcome::bad_seed;
        for (const double value : seed)
            if (!std::isfinite(value)) return Outcome::bad_seed;
        double back[16], left[16], target[16];
        inverse(from_base_, back), product(back, T, left), inverse(to_tip_, back), product(left, back, target);
        const Vector near = to_arm(seed);
        Vector at_seed(p), values(p), q(std::size_t(arm_.columns()) * n);
        std::vector<std::uint8_t> flags(std::size_t(arm_.columns()));
        if (p) {
            arm_.fk(near.data(), 1, left);
            arm_.redundancy_of(near.data(), left, at_seed.data());
        }
        std::vector<Found> found;
        const long rings = p && !query.locked ? most_steps(query.step) : 0;
        for (long ring = 0; ring <= rings; ++ring) {
            found.clear();
            std::vector<long> steps(p, -ring);
            do {
                if (!on_ring(steps, ring) || !parameters(at_seed, steps, query.step, values)) continue;
                if (late()) return Outcome::timed_out;
                if (arm_.ik(target, 1, q.data(), flags.data(), near.data(), p ? values.data() : nullptr) >= 0)
                    return Outcome::no_pose;
                for (std::size_t c = 0; c < flags.size(); ++c) {
                    if (Arm::valid(flags[c])) add_images(&q[c * n], seed, query.consistency, found);
                }
            } while (next(steps, ring));
            std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.distance < b.distance; });
            for (const Found& one : found) {
                if (late()) return Outcome::timed_out;
                if (take(one.q)) return Outcome::found;
            }
        }
        return Outcome::none;
    }

    // Steps of the redundancy parameters: each is between -ring and ring, and one is at an end.
    static bool on_ring(const std::vector<long>& steps, long ring) {
        return ring == 0 || std::any_of(steps.begin(), steps.end(), [&](long k) { return std::labs(k) == ring; });
    }
    static bool next(std::vector<long>& steps, long ring) {
        for (long& each : steps) {
            if (++each <= ring) return true;
            each = -ring;
        }
        return false;
    }
    // Whether a redundancy parameter goes round: it takes any value, modulo one turn.
    static bool round(const Arm::Parameter& each) { return each.unit == "rad" && !(each.upper - each.lower < 2.0 * M_PI - 1e-9); }
    // The most steps from any value of a parameter to the farthest one.
    long most_steps(double step) const {
        double most = 0.0;
        for (int k = 0; k < arm_.parameters(); ++k) {
            const Arm::Parameter& each = arm_.parameter(k);
            most = std::max(most, round(each) ? M_PI : each.upper - each.lower);
        }
        return step > 0.0 && std::isfinite(most) ? long(std::min(std::ceil(most / step), 1e4)) : 0;
    }
    // The values of the parameters so many steps from the seed's; false: one is outside its range, or comes again.
    bool parameters(const Vector& at_seed, const std::vector<long>& steps, double step, Vector& values) const {
        for (std::size_t k = 0; k < values.size(); ++k) {
            const Arm::Parameter& each = arm_.parameter(int(k));
            const double moved = double(steps[k]) * step;
            values[k] = at_seed[k] + moved;
            if (round(each)) {
                if (moved > M_PI || moved <= -M_PI) return false;
                values[k] = std::remainder(values[k], 2.0 * M_PI);
            } else if (steps[k] != 0 && !(values[k] >= each.lower && values[k] <= each.upper)) {
                return false;
            }
        }
        return true;
    }

    // Every image of a solution (in the arm's order) inside the limits and near enough to the seed; of a joint that turns without
    // limits, the one nearest to the seed.
    void add_images(const double* row, const Vector& seed, const Vector& consistency, std::vector<Found>& found) const {
        // As the contract of solutions: a value may lie beyond a limit by its error.
        constexpr double ERROR = 1e-9;
        const std::size_t n = seed.size();
        std::vector<Found> images = {{Vector(n), 0.0}}, longer;
        for (std::size_t j = 0; j < n; ++j) {
            const std::size_t at = at_[j];
            const double low = names_.lower[at], high = names_.upper[at], turn = turn_[at];
            const bool endless = !std::isfinite(low) || !std::isfinite(high);
            const double first = turn == 0.0 ? 0.0
                                 : endless   ? std::nearbyint((seed[at] - row[j]) / turn)
                                             : std::ceil((low - ERROR - row[j]) / turn);
            const double last = turn == 0.0 || endless ? first : std::floor((high + ERROR - row[j]) / turn);
            longer.clear();
            for (double k = first; k <= last && k < first + 64.0; k += 1.0) {
                const double raw = row[j] + k * turn;
                if (raw < low - ERROR || raw > high + ERROR) continue;
                const double value = std::min(std::max(raw, low), high), moved = value - seed[at];
                if (!consistency.empty() && std::fabs(moved) > consistency[at]) continue;
                for (const Found& image : images) {
                    if (longer.size() >= MOST_IMAGES) break;
                    longer.push_back(image);
                    longer.back().q[at] = value, longer.back().distance += moved * moved;
                }
            }
            images.swap(longer);
        }
        found.insert(found.end(), std::make_move_iterator(images.begin()), std::make_move_iterator(images.end()));
    }

    Arm arm_;
    Names names_;
    std::vector<std::size_t> at_;  // of the arm's joints among the planner's
    Vector turn_;
    double from_base_[16] = {}, to_tip_[16] = {};
};

}  // namespace urdf_ik
