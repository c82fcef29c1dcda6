#pragma once
#include <moveit/robot_model/robot_model.hpp>
namespace moveit::core {
// As Eigen's: entries by row and column.
struct Isometry {
    double T[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const Isometry& matrix() const { return *this; }
    double operator()(int row, int column) const { return T[4 * row + column]; }
};
class RobotState {
public:
    explicit RobotState(const RobotModelConstPtr& model) : model_(model), q_(std::size_t(model->arm.joints())) {}
    void setToDefaultValues() { q_.assign(q_.size(), 0.0); }
    void setVariablePosition(const std::string& name, double value) {
        for (int j = 0; j < model_->arm.joints(); ++j)
            if (model_->arm.joint(j).name == name) q_[std::size_t(j)] = value;
    }
    void update() {
        model_->arm.fk(q_.data(), 1, tip_.T);
        gripper_ = tip_;
        for (int row = 0; row < 3; ++row) gripper_.T[4 * row + 3] += 0.2 * tip_.T[4 * row + 2];
        table_.T[11] = -0.5;
    }
    const Isometry& getGlobalLinkTransform(const std::string& link) const {
        if (link == "stand-in gripper") return gripper_;
        return link == "stand-in table" ? table_ : link == model_->arm.tip() ? tip_ : base_;
    }

private:
    RobotModelConstPtr model_;
    std::vector<double> q_;
    Isometry base_, tip_, gripper_, table_;
};
}  // namespace moveit::core
