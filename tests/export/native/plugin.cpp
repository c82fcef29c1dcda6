// Calls the plugin as MoveIt does, through the base class: plugin LIBRARY ARM.json MODEL.json [BASE TIP].
// The status is 0 if all facts hold; the plugin's own message is on stderr.
#include <class_loader/class_loader.hpp>
#include <moveit/kinematics_base/kinematics_base.hpp>
#include <moveit/robot_state/robot_state.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

using Codes = moveit_msgs::msg::MoveItErrorCodes;
using Pose = geometry_msgs::msg::Pose;
using Vector = std::vector<double>;
namespace methods = kinematics::DiscretizationMethods;
namespace errors = kinematics::KinematicErrors;

#define CHECK(fact) ((fact) ? (void)0 : (void)std::exit(std::fprintf(stderr, "line %d: %s\n", __LINE__, #fact)))

static double distance(const Vector& a, const Vector& b) {
    double sum = 0.0;
    for (std::size_t j = 0; j < a.size(); ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
    return std::sqrt(sum);
}
static bool same(const Pose& a, const Pose& b) {
    const auto &p = a.orientation, &q = b.orientation;
    const double turn = std::fabs(p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w);
    return std::fabs(a.position.x - b.position.x) + std::fabs(a.position.y - b.position.y) +
                   std::fabs(a.position.z - b.position.z) <
               1e-8 &&
           std::fabs(turn - 1.0) < 1e-12;
}

int main(int argc, char** argv) {
    class_loader::ClassLoader loader(argv[1]);
    const auto plugin = loader.createInstance<kinematics::KinematicsBase>("urdf_ik_moveit::Plugin");
    const urdf_ik::Arm arm = urdf_ik::Arm::load(argv[2]);
    moveit::core::RobotModel model;
    model.arm = urdf_ik::Arm::load(argv[3]);
    CHECK(arm && model.arm);
    const int n = arm.joints();
    const bool is_free = arm.parameters() > 0;
    for (int j = 0; j < n; ++j) {
        const auto& joint = arm.joint(j);
        model.group.joints.push_back(joint.name);
        model.group.bounds.push_back({{joint.lower, joint.upper, std::isfinite(joint.lower) && std::isfinite(joint.upper)}});
    }
    const std::string base = argc > 4 ? argv[4] : arm.base(), tip = argc > 5 ? argv[5] : arm.tip();
    const auto node = std::make_shared<rclcpp::Node>();
    CHECK(!plugin->initialize(node, model, "arm", base, {tip}, 0.3));  // no arm named
    node->parameters["robot_description_kinematics.arm.compiled_arm"] = argv[2];
    CHECK(!plugin->initialize(node, model, "legs", base, {tip}, 0.3));
    CHECK(!plugin->initialize(node, model, "arm", base, {tip, tip}, 0.3));
    if (!plugin->initialize(node, model, "arm", base, {tip}, 0.3)) return 2;
    CHECK(plugin->getJointNames() == model.group.joints);

    std::mt19937 random(1);
    std::size_t several = 0;
    for (int i = 0; i < 20; ++i) {
        Vector at, seed;
        for (int j = 0; j < n; ++j) {
            std::uniform_real_distribution<double> value(std::max(arm.joint(j).lower, -M_PI), std::min(arm.joint(j).upper, M_PI));
            at.push_back(value(random)), seed.push_back(value(random));
        }
        std::vector<Pose> poses, again;
        CHECK(plugin->getPositionFK({tip}, at, poses) && poses.size() == 1 && !plugin->getPositionFK({"nowhere"}, at, again));
        const Pose pose = poses[0];
        Codes code;
        kinematics::KinematicsResult result;
        kinematics::KinematicsQueryOptions options;
        options.discretization_method = methods::ALL_DISCRETIZED;
        std::vector<Vector> all;
        Vector q, offered;
        // From a solution as the seed every overload returns it.
        const auto take = [&](const Pose&, const Vector&, Codes& c) { c.val = Codes::SUCCESS; };
        const Vector little(std::size_t(n), 1e-3);
        CHECK(plugin->getPositionIK(pose, at, q, code, options) && code.val == Codes::SUCCESS && distance(q, at) < 1e-5);
        CHECK(plugin->searchPositionIK(pose, at, 1.0, q, code, options) && distance(q, at) < 1e-5);
        CHECK(plugin->searchPositionIK(pose, at, 1.0, little, q, code, options) && distance(q, at) < 1e-5);
        CHECK(plugin->searchPositionIK(pose, at, 1.0, q, take, code, options) && distance(q, at) < 1e-5);
        CHECK(plugin->searchPositionIK(pose, at, 1.0, little, q, take, code, options) && distance(q, at) < 1e-5);
        CHECK(plugin->searchPositionIK(poses, at, 1.0, little, q, take, code, options) && distance(q, at) < 1e-5);
        // All of them reach the pose, inside the limits, nearest first.
        CHECK(plugin->getPositionIK(poses, at, all, result, options) && result.kinematic_error == errors::OK && !all.empty());
        several += all.size() > 1;
        double last = 0.0;
        for (const Vector& each : all) {
            CHECK(plugin->getPositionFK({tip}, each, again) && same(again[0], pose));
            for (int j = 0; j < n; ++j)
                CHECK(each[std::size_t(j)] >= arm.joint(j).lower && each[std::size_t(j)] <= arm.joint(j).upper);
            CHECK(distance(each, at) >= last - 1e-9);
            last = distance(each, at);
        }
        // A refusal leads to another solution; the cost function chooses among all.
        const auto refuse_near = [&](const Pose&, const Vector& each, Codes& c) {
            c.val = distance(each, at) < 1e-5 ? Codes::NO_IK_SOLUTION : Codes::SUCCESS;
        };
        CHECK(plugin->searchPositionIK(pose, at, 5.0, q, refuse_near, code, options) == (distance(all.back(), at) > 1e-5));
        CHECK(all.size() < 2 || is_free || distance(q, all[1]) < 1e-5);
        const auto farthest = [&](const Pose&, const moveit::core::RobotState&, const moveit::core::JointModelGroup* group,
                                  const Vector&) {
            CHECK(group == &model.group);
            return offered.size() == 0 ? 1.0 : 2.0;
        };
        CHECK(plugin->searchPositionIK(poses, at, 5.0, {}, q, take, farthest, code, options) && code.val == Codes::SUCCESS);
        // What cannot be done says so.
        CHECK(!plugin->searchPositionIK(pose, seed, 1.0, Vector(std::size_t(n), 1e-9), q, code, options));
        CHECK(code.val == Codes::NO_IK_SOLUTION);
        CHECK(!plugin->searchPositionIK(pose, at, -1.0, q, code, options) && code.val == Codes::TIMED_OUT);
        CHECK(!plugin->getPositionIK(pose, {0.0}, q, code, options) && code.val == Codes::NO_IK_SOLUTION);
        CHECK(!plugin->getPositionIK({}, at, all, result, options) && result.kinematic_error == errors::EMPTY_TIP_POSES);
        CHECK(!plugin->getPositionIK({pose, pose}, at, all, result, options));
        CHECK(result.kinematic_error == errors::MULTIPLE_TIPS_NOT_SUPPORTED);
        options.discretization_method = methods::ALL_RANDOM_SAMPLED;
        CHECK(!plugin->getPositionIK(poses, at, all, result, options));
        CHECK(result.kinematic_error == errors::UNSUPORTED_DISCRETIZATION_REQUESTED);
        Pose far = pose;
        far.position.x += 100.0;
        CHECK(!plugin->getPositionIK(far, at, q, code, {}) && code.val == Codes::NO_IK_SOLUTION);
    }
    std::printf("%zu of 20 poses with several solutions\n", several);
    return 0;
}
