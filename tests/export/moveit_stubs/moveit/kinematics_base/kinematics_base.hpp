// The interface of MoveIt 2's KinematicsBase, as its documentation has it: names, arguments, defaults and protected members, so
// that an override that MoveIt would not call does not compile.
#pragma once
#include <algorithm>
#include <functional>
#include <geometry_msgs/msg/pose.hpp>
#include <map>
#include <moveit/robot_model/robot_model.hpp>
#include <moveit_msgs/msg/move_it_error_codes.hpp>
#include <rclcpp/rclcpp.hpp>
namespace moveit::core { class RobotState; }
namespace kinematics {
namespace DiscretizationMethods {
enum DiscretizationMethod { NO_DISCRETIZATION = 1, ALL_DISCRETIZED, SOME_DISCRETIZED, ALL_RANDOM_SAMPLED, SOME_RANDOM_SAMPLED };
}
using DiscretizationMethod = DiscretizationMethods::DiscretizationMethod;
namespace KinematicErrors {
enum KinematicError {
    OK = 1,
    UNSUPORTED_DISCRETIZATION_REQUESTED,
    DISCRETIZATION_NOT_INITIALIZED,
    MULTIPLE_TIPS_NOT_SUPPORTED,
    EMPTY_TIP_POSES,
    IK_SEED_OUTSIDE_LIMITS,
    SOLVER_NOT_ACTIVE,
    NO_SOLUTION
};
}
using KinematicError = KinematicErrors::KinematicError;
struct KinematicsQueryOptions {
    bool lock_redundant_joints = false, return_approximate_solution = false;
    DiscretizationMethod discretization_method = DiscretizationMethods::NO_DISCRETIZATION;
};
struct KinematicsResult {
    KinematicError kinematic_error;
    double solution_percentage;
};
class KinematicsBase {
public:
    static constexpr double DEFAULT_SEARCH_DISCRETIZATION = 0.1, DEFAULT_TIMEOUT = 1.0;
    using Pose = geometry_msgs::msg::Pose;
    using Code = moveit_msgs::msg::MoveItErrorCodes;
    using Vector = std::vector<double>;
    using Options = KinematicsQueryOptions;
    using IKCallbackFn = std::function<void(const Pose&, const Vector&, Code&)>;
    using IKCostFn =
        std::function<double(const Pose&, const moveit::core::RobotState&, const moveit::core::JointModelGroup*, const Vector&)>;

    virtual bool getPositionIK(const Pose&, const Vector&, Vector&, Code&, const Options& = Options()) const = 0;
    virtual bool getPositionIK(const std::vector<Pose>&, const Vector&, std::vector<Vector>&, KinematicsResult&,
                               const Options&) const = 0;
    virtual bool searchPositionIK(const Pose&, const Vector&, double, Vector&, Code&, const Options& = Options()) const = 0;
    virtual bool searchPositionIK(const Pose&, const Vector&, double, const Vector&, Vector&, Code&,
                                  const Options& = Options()) const = 0;
    virtual bool searchPositionIK(const Pose&, const Vector&, double, Vector&, const IKCallbackFn&, Code&,
                                  const Options& = Options()) const = 0;
    virtual bool searchPositionIK(const Pose&, const Vector&, double, const Vector&, Vector&, const IKCallbackFn&, Code&,
                                  const Options& = Options()) const = 0;
    virtual bool searchPositionIK(const std::vector<Pose>&, const Vector&, double, const Vector&, Vector&, const IKCallbackFn&,
                                  Code&, const Options& = Options(), const moveit::core::RobotState* = nullptr) const = 0;
    virtual bool searchPositionIK(const std::vector<Pose>&, const Vector&, double, const Vector&, Vector&, const IKCallbackFn&,
                                  const IKCostFn&, Code&, const Options& = Options(),
                                  const moveit::core::RobotState* = nullptr) const = 0;
    virtual bool getPositionFK(const std::vector<std::string>&, const Vector&, std::vector<Pose>&) const = 0;
    virtual bool initialize(const rclcpp::Node::SharedPtr&, const moveit::core::RobotModel&, const std::string&, const std::string&,
                            const std::vector<std::string>&, double) = 0;
    virtual bool setRedundantJoints(const std::vector<unsigned int>& joints) { return redundant_joint_indices_ = joints, true; }
    virtual const std::vector<std::string>& getJointNames() const = 0;
    virtual const std::vector<std::string>& getLinkNames() const = 0;
    virtual bool supportsGroup(const moveit::core::JointModelGroup* group, std::string* error = nullptr) const {
        if (!group->isChain() && error) *error = "the group is no chain";
        return group->isChain();
    }
    virtual ~KinematicsBase() = default;

protected:
    rclcpp::Node::SharedPtr node_;
    moveit::core::RobotModelConstPtr robot_model_;
    std::string group_name_, base_frame_;
    std::vector<std::string> tip_frames_;
    double default_timeout_ = DEFAULT_TIMEOUT;
    std::vector<unsigned int> redundant_joint_indices_;
    std::map<int, double> redundant_joint_discretization_;
    std::vector<DiscretizationMethod> supported_methods_;
    void storeValues(const moveit::core::RobotModel& model, const std::string& group, const std::string& base,
                     const std::vector<std::string>& tips, double) {
        robot_model_ = moveit::core::RobotModelConstPtr(&model, [](const moveit::core::RobotModel*) {});
        group_name_ = group, base_frame_ = base, tip_frames_ = tips;
    }
};
}  // namespace kinematics
