// Searches as a motion planner does: group ARM.json MODEL.json [BASE TIP] < poses > solutions. MODEL.json is the robot model of the
// planner; two links that it does not have are fixed to its ends, "stand-in table" below the base and "stand-in gripper" beyond the
// tip.
// in:  m, poses T (m, 16) of TIP in BASE, seeds (m, joints); out: of each pose the number of solutions, and these
#include <urdf_ik_group.hpp>

#include <cstdio>
#include <cstdlib>

using urdf_ik::Arm;
using urdf_ik::Group;
using urdf_ik::Outcome;
using Vector = Group::Vector;

#define CHECK(fact) ((fact) ? (void)0 : (void)std::exit(std::fprintf(stderr, "line %d: %s\n", __LINE__, #fact)))

template <class T> static std::vector<T> read(std::size_t count) {
    std::vector<T> numbers(count);
    CHECK(std::fread(numbers.data(), sizeof(T), count, stdin) == count);
    return numbers;
}

static double distance(const Vector& a, const Vector& b) {
    double sum = 0.0;
    for (std::size_t j = 0; j < a.size(); ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
    return std::sqrt(sum);
}

// A quarter turn about z, and 0.3 m along it.
static const double FIXED[16] = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.3, 0, 0, 0, 1};

static void multiply(const double* A, const double* B, double* C) {
    for (int i = 0; i < 16; ++i) {
        C[i] = 0.0;
        for (int k = 0; k < 4; ++k) C[i] += A[4 * (i / 4) + k] * B[4 * k + i % 4];
    }
}

int main(int argc, char** argv) {
    std::string error;
    const Arm arm = Arm::load(argv[1], &error), model = Arm::load(argv[2], &error);
    if (!arm || !model) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
    const int n = arm.joints();
    // The planner has the joints in the opposite order.
    Group::Names names;
    for (int j = n - 1; j >= 0; --j) {
        names.joints.push_back(arm.joint(j).name);
        names.lower.push_back(arm.joint(j).lower), names.upper.push_back(arm.joint(j).upper);
    }
    names.base = argc > 3 ? argv[3] : arm.base(), names.tip = argc > 4 ? argv[4] : arm.tip();
    const auto link_pose = [&](const Vector& q, const std::string& link, double* T) {
        double at[16];
        const Vector in_order(q.rbegin(), q.rend());
        model.fk(in_order.data(), 1, at);
        for (int i = 0; i < 16; ++i) T[i] = i % 5 == 0;
        if (link == model.tip()) std::copy(at, at + 16, T);
        else if (link == "stand-in gripper") multiply(at, FIXED, T);
        else if (link == "stand-in table") std::copy(FIXED, FIXED + 16, T);
        else if (link != model.base()) return false;
        return true;
    };
    const Group group = Group::make(arm, names, link_pose, &error);
    if (!group) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
    Group::Names fewer = names;
    fewer.joints.pop_back(), fewer.lower.pop_back(), fewer.upper.pop_back();
    CHECK(!Group::make(arm, fewer, link_pose, &error) && error.find("joints") != std::string::npos);

    const std::size_t m = std::size_t(read<std::int64_t>(1)[0]);
    const auto T = read<double>(16 * m), seeds = read<double>(std::size_t(n) * m);
    for (std::size_t i = 0; i < m; ++i) {
        const double* pose = &T[16 * i];
        const Vector given(seeds.begin() + long(i) * n, seeds.begin() + long(i + 1) * n), seed(given.rbegin(), given.rend());
        std::vector<Vector> all;
        Group::Query query;
        query.step = 0.3;
        const Outcome outcome = group.all(pose, seed, query, all);
        CHECK((outcome == Outcome::found) == !all.empty() && (outcome == Outcome::none) == all.empty());
        const std::int64_t count = std::int64_t(all.size());
        std::fwrite(&count, 8, 1, stdout);
        for (const Vector& q : all) {
            double reached[16];
            group.fk(q, reached);
            for (int k = 0; k < 16; ++k) CHECK(std::fabs(reached[k] - pose[k]) < 1e-8);
            const Vector in_order(q.rbegin(), q.rend());
            std::fwrite(in_order.data(), 8, in_order.size(), stdout);
        }
        Vector q(1, 7.0);
        CHECK(group.search(pose, Vector(1, 0.0), query, {}, q) == Outcome::bad_seed);
        if (all.empty()) {
            CHECK(group.search(pose, seed, query, {}, q) == Outcome::none && q.size() == 1);
            continue;
        }
        // The nearest one first; without redundancy parameters, of all.
        CHECK(group.search(pose, seed, query, {}, q) == Outcome::found);
        if (!arm.parameters()) CHECK(q == all[0]);
        // A solution as the seed is its own nearest one.
        CHECK(group.search(pose, all.back(), query, {}, q) == Outcome::found && distance(q, all.back()) < 1e-7);
        // Every solution is offered once; a refusal leads to the next one.
        std::vector<Vector> offered;
        const auto refuse = [&](const Vector& each) { return offered.push_back(each), false; };
        CHECK(group.search(pose, seed, query, refuse, q) == Outcome::none && offered.size() == all.size());
        std::size_t asked = 0;
        const auto second = [&](const Vector&) { return asked++ > 0; };
        CHECK((group.search(pose, seed, query, second, q) == Outcome::found) == (all.size() > 1));
        CHECK(all.size() < 2 || q == offered[1]);
        // Consistency: only solutions about the seed, joint by joint; with a part of the way, exactly those within it.
        Group::Query near = query;
        near.consistency.assign(std::size_t(n), 1e-6);
        std::vector<Vector> kept;
        CHECK(group.search(pose, all.back(), near, {}, q) == Outcome::found && distance(q, all.back()) < 1e-5);
        near.consistency.assign(std::size_t(n), 1.0);
        group.all(pose, seed, near, kept);
        std::size_t within = 0;
        for (const Vector& each : all) {
            double most = 0.0;
            for (int j = 0; j < n; ++j) most = std::max(most, std::fabs(each[std::size_t(j)] - seed[std::size_t(j)]));
            within += most <= 1.0;
        }
        CHECK(kept.size() == within);
        // The parameters of the seed are kept, and no time is none.
        Group::Query locked = query;
        locked.locked = true;
        CHECK(group.all(pose, all.back(), locked, kept) == Outcome::found && kept.size() <= all.size());
        Group::Query hurried = query;
        hurried.timeout = -1.0;
        CHECK(group.search(pose, seed, hurried, {}, q) == Outcome::timed_out);
    }
    double no_pose[16] = {};
    Vector q;
    CHECK(group.search(no_pose, Vector(std::size_t(n), 0.0), {}, {}, q) == Outcome::no_pose);
    return 0;
}
