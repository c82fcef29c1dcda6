// The graph of a path: joint vectors at each waypoint (nodes), and motions between those of one waypoint and the next (edges).
//
// A node stands for all of its images inside the joint limits, whole turns apart; a state is a node and which image of each
// joint it is. Plain data; arrays belong to the caller.
#pragma once

#include <cstdint>

#include "motion/stop.hpp"

namespace urdf_ik {

// How the joints turn. A joint with `turn` zero slides; one that turns and is not `counted` has no limits that matter, and
// differences of its values are taken on the circle.
struct GraphJoints {
    int joints;
    const double *lower, *upper;  // limits, tolerance included [rad or m]
    const double* turn;           // distance of images [rad]
    const std::uint8_t* counted;  // whether images inside the limits are states of their own
};

// Which of the joint vectors that a solver gives are wanted.
struct GraphChoice {
    const double* q;             // (m, joints)
    const std::uint8_t* flags;   // (m) bit 0: valid
    const double* centres;       // (m / of_each, joints) where only those near are wanted, else null
    long of_each;                // how many joint vectors have a centre
    double near;                 // greatest difference of a joint that turns from the centre [rad]
    bool outside;                // whether those outside the limits are wanted, too; their counts are zero
};

struct GraphLayers {
    long waypoints;
    const std::int64_t* first;  // (waypoints + 1) each waypoint's first node
    const double* q;            // (nodes, joints) lowest image of each joint
};

enum class PathCost : int { sum, squares, largest };

struct GraphMotions {
    const double* jacobians;  // (nodes, 6, joints) of the tip
    const double* twists;     // (waypoints - 1, 6) from each waypoint to the next: position [m], rotation vector [rad]
    double position, rotation;  // greatest mismatch of J dq and the twist [m, rad]
    const double* window;     // (joints) greatest |dq| [rad or m]
    PathCost cost;
    const double* weights;  // (joints) of |dq|, or of its square
    const double* scale;    // (waypoints - 1) factors of the costs between a waypoint and the next
};

struct GraphEdges {
    std::int64_t* first;  // (nodes + 1) each node's first edge
    std::int32_t* end;    // (room) the node that it leads to
    double* cost;         // (room)
    long room;
};

// Which images states have: digit k of a state is the image of joint k.
struct GraphImages {
    long states;                  // of a node, valid or not; at most 1024
    const std::uint8_t* digits;   // (states, joints)
    const std::int64_t* strides;  // (joints) what one image more adds to a state's number
    const std::uint8_t* counts;   // (nodes, joints) images of each node's joints
};

struct GraphValues {
    const double* node;     // (nodes, states) cost of being there; infinite: excluded
    double* value;          // (nodes, states) least cost from there to the last waypoint
    std::int32_t* changes;  // (nodes, states) reconfigurations on the way; null: there may be none
    std::int32_t* edge;     // (nodes, states) the edge to take; -1 at the end, -2 for a reconfiguration
    std::int64_t* jump;     // (waypoints) the state, node * states + digit, that a reconfiguration leads to
};

struct GraphFunctions {
    // Those that take a Stop ask it after every waypoint, and leave the rest undone.
    // Of m joint vectors those that are valid, inside the limits and near their centres: their numbers in `kept`, the lowest
    // image of each joint and how many there are; returns how many are kept.
    long (*choose)(const GraphJoints&, const GraphChoice&, long m, std::int64_t* kept, double* lowest, std::uint8_t* counts);
    // Edges that may be motions along the path; their number, -1 where there is no room for all. Scratch: (joints + 2) times
    // the nodes of the largest layer.
    long (*connect)(const GraphJoints&, const GraphLayers&, const GraphMotions&, const GraphEdges&, double* scratch, const Stop&);
    // The cheapest way from every state to the last waypoint, from the last to the first.
    void (*cheapest)(const GraphJoints&, const GraphLayers&, const GraphEdges&, const GraphImages&, const GraphValues&,
                     const Stop&);
    // The states (waypoints) that the cheapest way from a state of the first waypoint passes, and the edges it takes, as in
    // GraphValues::edge.
    void (*way)(const GraphJoints&, const GraphLayers&, const GraphEdges&, const GraphImages&, const GraphValues&,
                std::int64_t state, std::int64_t* passed, std::int64_t* taken);
    // Passes marks (nodes, states) on along the edges, from the first waypoint to the last.
    void (*spread)(const GraphJoints&, const GraphLayers&, const GraphEdges&, const GraphImages&, const double* node,
                   std::uint64_t* marks, const Stop&);
};

}  // namespace urdf_ik
