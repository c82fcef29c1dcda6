// The graph of a path. Nodes are joint vectors at the waypoints. Edges are motions from one waypoint to the next.
//
// A node represents all of its images inside the joint limits, whole turns apart. A state is a node with a choice of one image
// for each joint. Plain data; arrays belong to the caller.
#pragma once

#include <cstdint>

#include "motion/stop.hpp"

namespace urdf_ik {

// A joint with `turn` zero slides. For a joint that turns and is not `counted`, limits do not matter, and differences of its
// values are taken on the circle.
struct GraphJoints {
    int joints;
    const double *lower, *upper;  // limits, tolerance included [rad or m]
    const double* turn;           // distance of images [rad]
    const std::uint8_t* counted;  // whether each image inside the limits is a separate state
};

// A solver's joint vectors, and the conditions for keeping one.
struct GraphChoice {
    const double* q;             // (m, joints)
    const std::uint8_t* flags;   // (m) bit 0: valid
    const double* centres;       // (m / of_each, joints) keep only joint vectors near these; null: all
    long of_each;                // number of joint vectors per centre
    double near;                 // greatest difference of a joint that turns from the centre [rad]
    bool outside;                // keep joint vectors outside the limits too; a joint outside has the count zero
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
    std::int32_t* end;    // (room) the edge's second node
    double* cost;         // (room)
    long room;
};

// The images of states: digit k of a state is the image of joint k.
struct GraphImages {
    long states;                  // of a node, valid or not; at most 1024
    const std::uint8_t* digits;   // (states, joints)
    const std::int64_t* strides;  // (joints) a state's number grows by this with each image of the joint
    const std::uint8_t* counts;   // (nodes, joints) images of each node's joints
};

// What the states of a graph are connected by.
struct StateGraph {
    GraphJoints arm;
    GraphLayers layers;
    GraphEdges edges;
    GraphImages images;
};

struct GraphValues {
    const double* node;     // (nodes, states) cost of the state itself; infinite: excluded
    double* value;          // (nodes, states) least cost from the state to the last waypoint
    std::int32_t* changes;  // (nodes, states) reconfigurations on the way; null: not allowed
    std::int32_t* edge;     // (nodes, states) the edge to take; -1 at the end, -2 for a reconfiguration
    std::int64_t* jump;     // (waypoints) the state, node * states + digit, that a reconfiguration leads to
};

struct GraphFunctions {
    // Functions with a Stop poll it at every waypoint; when it stops them, the other waypoints are not done.

    // Keep the joint vectors that meet the choice's conditions: their indices in `kept`, each joint's lowest image and number of
    // images. Returns how many are kept.
    long (*choose)(const GraphJoints&, const GraphChoice&, long m, std::int64_t* kept, double* lowest, std::uint8_t* counts);
    // Write the edges whose steps are inside the window and match the twist. Returns their number, or -1 if there is too little
    // room. Scratch: joints times the nodes of the largest layer and seven more.
    long (*connect)(const GraphJoints&, const GraphLayers&, const GraphMotions&, const GraphEdges&, double* scratch, const Stop&);
    // The cheapest way from every state to the last waypoint, computed from the last waypoint to the first.
    void (*cheapest)(const StateGraph&, const GraphValues&, const Stop&);
    // The states (waypoints) on the cheapest way from a state of the first waypoint, and its edges, as in GraphValues::edge.
    void (*way)(const StateGraph&, const GraphValues&, std::int64_t state, std::int64_t* passed, std::int64_t* taken);
    // Propagate marks (nodes, states) along the edges, from the first waypoint to the last.
    void (*spread)(const StateGraph&, const double* node, std::uint64_t* marks, const Stop&);
};

}  // namespace urdf_ik
