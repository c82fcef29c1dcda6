// Kinematics of a group by a compiled arm, for MoveIt 2: every solution, and the one nearest to the seed that is accepted.
//
// The parameter robot_description_kinematics.GROUP.compiled_arm holds what `urdf-ik compile` writes: the text, or the path of the
// file. At start its forward kinematics are compared with the robot model's, so that a URDF that changed since is refused.
#include <class_loader/class_loader.hpp>
#include <moveit/kinematics_base/kinematics_base.hpp>
#include <moveit/robot_model/robot_model.hpp>
#include <moveit/robot_state/robot_state.hpp>
#include <rclcpp/rclcpp.hpp>

#include <urdf_ik_group.hpp>

namespace urdf_ik_moveit {

using Codes = moveit_msgs::msg::MoveItErrorCodes;
using Options = kinematics::KinematicsQueryOptions;
using Pose = geometry_msgs::msg::Pose;
using State = moveit::core::RobotState;
using Vector = std::vector<double>;

namespace {

// A pose as 16 numbers; the quaternion may have any length but zero.
void to_matrix(const Pose& pose, double* T) {
    const double x = pose.orientation.x, y = pose.orientation.y, z = pose.orientation.z, w = pose.orientation.w;
    const double s = 2.0 / (x * x + y * y + z * z + w * w);
    const double rows[16] = {1 - s * (y * y + z * z),
                             s * (x * y - w * z),
                             s * (x * z + w * y),
                             pose.position.x,
                             s * (x * y + w * z),
                             1 - s * (x * x + z * z),
                             s * (y * z - w * x),
                             pose.position.y,
                             s * (x * z - w * y),
                             s * (y * z + w * x),
                             1 - s * (x * x + y * y),
                             pose.position.z,
                             0,
                             0,
                             0,
                             1};
    std::copy(rows, rows + 16, T);
}

Pose to_pose(const double* T) {
    Pose pose;
    pose.position.x = T[3], pose.position.y = T[7], pose.position.z = T[11];
    // The largest component by its square, the others by sums and differences over it.
    const double trace = T[0] + T[5] + T[10];
    const double squares[4] = {1 + 2 * T[0] - trace, 1 + 2 * T[5] - trace, 1 + 2 * T[10] - trace, 1 + trace};
    const long k = std::max_element(squares, squares + 4) - squares;
    const double twice = std::sqrt(squares[k]), over = 0.5 / twice;
    const double xy = (T[1] + T[4]) * over, xz = (T[2] + T[8]) * over, yz = (T[6] + T[9]) * over;
    const double xw = (T[9] - T[6]) * over, yw = (T[2] - T[8]) * over, zw = (T[4] - T[1]) * over;
    const double rows[4][4] = {{twice / 2, xy, xz, xw}, {xy, twice / 2, yz, yw}, {xz, yz, twice / 2, zw}, {xw, yw, zw, twice / 2}};
    pose.orientation.x = rows[k][0], pose.orientation.y = rows[k][1], pose.orientation.z = rows[k][2];
    pose.orientation.w = rows[k][3];
    return pose;
}

}  // namespace

class Plugin : public kinematics::KinematicsBase {
public:
    bool initialize(const rclcpp::Node::SharedPtr& node, const moveit::core::RobotModel& model, const std::string& group,
                    const std::string& base, const std::vector<std::string>& tips, double discretization) override {
        storeValues(model, group, base, tips, discretization);
        supported_methods_ = {kinematics::DiscretizationMethods::NO_DISCRETIZATION,
                              kinematics::DiscretizationMethods::ALL_DISCRETIZED};
        if (discretization > 0.0) step_ = discretization;
        const std::string problem = prepare(*node, model, tips);
        if (!problem.empty()) RCLCPP_ERROR(rclcpp::get_logger("urdf_ik"), "group %s: %s", group.c_str(), problem.c_str());
        return problem.empty();
    }

    bool getPositionIK(const Pose& pose, const Vector& seed, Vector& solution, Codes& code, const Options& options) const override {
        return search(pose, seed, default_timeout_, {}, solution, {}, {}, code, options, nullptr);
    }
    bool getPositionIK(const std::vector<Pose>& poses, const Vector& seed, std::vector<Vector>& solutions,
                       kinematics::KinematicsResult& result, const Options& options) const override {
        solutions.clear();
        result.solution_percentage = 0.0;
        result.kinematic_error = all(poses, seed, solutions, options);
        if (result.kinematic_error == kinematics::KinematicErrors::OK) result.solution_percentage = 1.0;
        return !solutions.empty();
    }
    bool searchPositionIK(const Pose& pose, const Vector& seed, double timeout, Vector& solution, Codes& code,
                          const Options& options) const override {
        return search(pose, seed, timeout, {}, solution, {}, {}, code, options, nullptr);
    }
    bool searchPositionIK(const Pose& pose, const Vector& seed, double timeout, const Vector& consistency, Vector& solution,
                          Codes& code, const Options& options) const override {
        return search(pose, seed, timeout, consistency, solution, {}, {}, code, options, nullptr);
    }
    bool searchPositionIK(const Pose& pose, const Vector& seed, double timeout, Vector& solution, const IKCallbackFn& callback,
                          Codes& code, const Options& options) const override {
        return search(pose, seed, timeout, {}, solution, callback, {}, code, options, nullptr);
    }
    bool searchPositionIK(const Pose& pose, const Vector& seed, double timeout, const Vector& consistency, Vector& solution,
                          const IKCallbackFn& callback, Codes& code, const Options& options) const override {
        return search(pose, seed, timeout, consistency, solution, callback, {}, code, options, nullptr);
    }
    bool searchPositionIK(const std::vector<Pose>& poses, const Vector& seed, double timeout, const Vector& consistency,
                          Vector& solution, const IKCallbackFn& callback, Codes& code, const Options& options,
                          const State* context) const override {
        return searchPositionIK(poses, seed, timeout, consistency, solution, callback, {}, code, options, context);
    }
    // With a cost function the accepted solution of least cost is returned.
    bool searchPositionIK(const std::vector<Pose>& poses, const Vector& seed, double timeout, const Vector& consistency,
                          Vector& solution, const IKCallbackFn& callback, const IKCostFn& cost, Codes& code, const Options& options,
                          const State* context) const override {
        if (poses.size() != 1) return code.val = Codes::NO_IK_SOLUTION, false;
        return search(poses[0], seed, timeout, consistency, solution, callback, cost, code, options, context);
    }

    bool getPositionFK(const std::vector<std::string>& links, const Vector& q, std::vector<Pose>& poses) const override {
        poses.clear();
        double base[16], at[16], T[16];
        if (q.size() != getJointNames().size() || !link_pose(*robot_model_, getJointNames(), q, base_frame_, base)) return false;
        for (const std::string& link : links) {
            if (!link_pose(*robot_model_, getJointNames(), q, link, at)) return false;
            relative(base, at, T);
            poses.push_back(to_pose(T));
        }
        return true;
    }
    const std::vector<std::string>& getJointNames() const override { return group_.names().joints; }
    const std::vector<std::string>& getLinkNames() const override { return links_; }

    // The compiled arm says what a pose leaves free: other joints cannot be redundant.
    bool setRedundantJoints(const std::vector<unsigned int>& joints) override {
        for (const unsigned int joint : joints) {
            bool is_free = false;
            for (int k = 0; k < group_.arm().parameters() && joint < getJointNames().size(); ++k) {
                is_free |= group_.arm().parameter(k).name == getJointNames()[joint];
            }
            if (!is_free) return false;
        }
        return KinematicsBase::setRedundantJoints(joints);
    }

private:
    std::string prepare(rclcpp::Node& node, const moveit::core::RobotModel& model, const std::vector<std::string>& tips) {
        if (tips.size() != 1) return "one tip link is needed";
        joints_ = model.getJointModelGroup(group_name_);
        if (!joints_) return "the robot model has no such group";
        std::string problem;
        if (!supportsGroup(joints_, &problem)) return problem;
        const std::string parameter = "robot_description_kinematics." + group_name_ + ".compiled_arm";
        if (!node.has_parameter(parameter)) node.declare_parameter<std::string>(parameter, "");
        std::string source;
        node.get_parameter(parameter, source);
        if (source.empty()) return "the parameter " + parameter + " is missing; urdf-ik compile writes what it holds";
        const bool is_text =
            source.find_first_not_of(" \t\r\n") != std::string::npos && source[source.find_first_not_of(" \t\r\n")] == '{';
        const urdf_ik::Arm arm = is_text ? urdf_ik::Arm::parse(source, &problem) : urdf_ik::Arm::load(source, &problem);
        if (!arm) return problem;
        links_ = joints_->getLinkModelNames();
        urdf_ik::Group::Names names;
        names.joints = joints_->getActiveJointModelNames(), names.base = base_frame_, names.tip = tip_frames_[0];
        for (const auto* bounds : joints_->getActiveJointModelsBounds()) {
            const auto& bound = bounds->at(0);
            names.lower.push_back(bound.position_bounded_ ? bound.min_position_ : -INFINITY);
            names.upper.push_back(bound.position_bounded_ ? bound.max_position_ : INFINITY);
        }
        const std::vector<std::string> order = names.joints;
        const auto pose = [&](const Vector& q, const std::string& link, double* T) { return link_pose(model, order, q, link, T); };
        group_ = urdf_ik::Group::make(arm, names, pose, &problem);
        return problem;
    }

    // The pose of a link in the model's frame; other joints stand at their defaults.
    static bool link_pose(const moveit::core::RobotModel& model, const std::vector<std::string>& joints, const Vector& q,
                          const std::string& link, double* T) {
        if (!model.hasLinkModel(link)) return false;
        State state(moveit::core::RobotModelConstPtr(&model, [](const moveit::core::RobotModel*) {}));
        state.setToDefaultValues();
        for (std::size_t j = 0; j < q.size(); ++j) state.setVariablePosition(joints[j], q[j]);
        state.update();
        const auto& at = state.getGlobalLinkTransform(link).matrix();
        for (int i = 0; i < 16; ++i) T[i] = at(i / 4, i % 4);
        return true;
    }
    // B in A.
    static void relative(const double* A, const double* B, double* C) {
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 4; ++c) {
                C[4 * r + c] = 0.0;
                for (int k = 0; k < 3; ++k) C[4 * r + c] += A[4 * k + r] * (B[4 * k + c] - (c == 3 ? A[4 * k + 3] : 0.0));
            }
        }
        C[12] = C[13] = C[14] = 0.0, C[15] = 1.0;
    }

    kinematics::KinematicError all(const std::vector<Pose>& poses, const Vector& seed, std::vector<Vector>& solutions,
                                   const Options& options) const {
        namespace errors = kinematics::KinematicErrors;
        if (poses.empty()) return errors::EMPTY_TIP_POSES;
        if (poses.size() > 1) return errors::MULTIPLE_TIPS_NOT_SUPPORTED;
        if (!group_) return errors::SOLVER_NOT_ACTIVE;
        const auto& methods = supported_methods_;
        if (std::find(methods.begin(), methods.end(), options.discretization_method) == methods.end()) {
            return errors::UNSUPORTED_DISCRETIZATION_REQUESTED;
        }
        urdf_ik::Group::Query query;
        query.step = step_, query.timeout = default_timeout_;
        query.locked =
            options.lock_redundant_joints || options.discretization_method == kinematics::DiscretizationMethods::NO_DISCRETIZATION;
        double T[16];
        to_matrix(poses[0], T);
        if (group_.all(T, seed, query, solutions) == urdf_ik::Outcome::found) return errors::OK;
        solutions.clear();
        return errors::NO_SOLUTION;
    }

    bool search(const Pose& pose, const Vector& seed, double timeout, const Vector& consistency, Vector& solution,
                const IKCallbackFn& callback, const IKCostFn& cost, Codes& code, const Options& options,
                const State* context) const {
        if (!group_) return code.val = Codes::NO_IK_SOLUTION, false;
        urdf_ik::Group::Query query;
        query.consistency = consistency, query.timeout = timeout, query.step = step_, query.locked = options.lock_redundant_joints;
        double T[16];
        to_matrix(pose, T);
        double least = INFINITY;
        const auto accept = [&](const Vector& q) {
            code.val = Codes::SUCCESS;
            if (callback) callback(pose, q, code);
            if (code.val != Codes::SUCCESS) return false;
            if (!cost) return true;
            // Every accepted solution is weighed, so none ends the search.
            State state = context ? State(*context) : State(robot_model_);
            if (!context) state.setToDefaultValues();
            for (std::size_t j = 0; j < q.size(); ++j) state.setVariablePosition(getJointNames()[j], q[j]);
            state.update();
            const double each = cost(pose, state, joints_, seed);
            if (each < least) least = each, solution = q;
            return false;
        };
        urdf_ik::Outcome outcome = group_.search(T, seed, query, accept, solution);
        if (least < INFINITY) outcome = urdf_ik::Outcome::found;
        switch (outcome) {
            case urdf_ik::Outcome::found:
                code.val = Codes::SUCCESS;
                return true;
            case urdf_ik::Outcome::timed_out:
                code.val = Codes::TIMED_OUT;
                return false;
            default:
                code.val = Codes::NO_IK_SOLUTION;
                return false;
        }
    }

    urdf_ik::Group group_;
    const moveit::core::JointModelGroup* joints_ = nullptr;
    std::vector<std::string> links_;
    double step_ = DEFAULT_SEARCH_DISCRETIZATION;
};

}  // namespace urdf_ik_moveit

CLASS_LOADER_REGISTER_CLASS(urdf_ik_moveit::Plugin, kinematics::KinematicsBase)
