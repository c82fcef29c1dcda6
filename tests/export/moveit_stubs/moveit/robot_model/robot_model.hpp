// A robot model whose group is a compiled arm, with a link fixed below its base and one beyond its tip.
#pragma once
#include <memory>
#include <string>
#include <urdf_ik.hpp>
#include <vector>
namespace moveit::core {
struct VariableBounds {
    double min_position_ = 0, max_position_ = 0;
    bool position_bounded_ = false;
};
using Bounds = std::vector<VariableBounds>;
class JointModelGroup {
public:
    std::vector<std::string> joints, links;
    std::vector<Bounds> bounds;
    bool chain = true;
    bool isChain() const { return chain; }
    const std::vector<std::string>& getActiveJointModelNames() const { return joints; }
    const std::vector<std::string>& getLinkModelNames() const { return links; }
    std::vector<const Bounds*> getActiveJointModelsBounds() const {
        std::vector<const Bounds*> all;
        for (const Bounds& each : bounds) all.push_back(&each);
        return all;
    }
};
class RobotModel {
public:
    urdf_ik::Arm arm;
    JointModelGroup group;
    const JointModelGroup* getJointModelGroup(const std::string& name) const { return name == "arm" ? &group : nullptr; }
    bool hasLinkModel(const std::string& link) const {
        return link == arm.base() || link == arm.tip() || link == "stand-in table" || link == "stand-in gripper";
    }
};
using RobotModelConstPtr = std::shared_ptr<const RobotModel>;
}  // namespace moveit::core
