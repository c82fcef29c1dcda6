// The graph of a path; see path_graph.hpp. A shortest path through layers, by dynamic programming (Bellman 1957).
#include "motion/path_graph.hpp"

#include "numbers/trig.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The lowest image of a joint's value inside its limits. Returns the number of images.
STEP std::uint8_t lowest_image(const GraphJoints& arm, int k, double q, double* lowest) {
    const double turn = arm.turn[k], low = arm.lower[k], high = arm.upper[k];
    *lowest = q;
    if (turn == 0.0) return q >= low && q <= high;
    if (!arm.counted[k]) return 1;
    q += __builtin_ceil((low - q) / turn) * turn;
    // The quotient is rounded; the sum decides.
    if (q < low) q += turn;
    else if (q - turn >= low) q -= turn;
    *lowest = q;
    return q <= high ? std::uint8_t(1.0 + __builtin_floor((high - q) / turn)) : 0;
}

STEP bool is_near(const GraphJoints& arm, const double* q, const double* centre, double most) {
    for (int k = 0; k < arm.joints; ++k) {
        if (arm.turn[k] == 0.0) continue;
        const double apart = q[k] - centre[k];
        if (!(__builtin_fabs(apart - __builtin_rint(apart / arm.turn[k]) * arm.turn[k]) <= most)) return false;
    }
    return true;
}

static long choose(const GraphJoints& arm, const GraphChoice& choice, long m, std::int64_t* kept, double* lowest,
                   std::uint8_t* counts) {
    const int n = arm.joints;
    long count = 0;
    for (long i = 0; i < m; ++i) {
        const double* q = choice.q + n * i;
        if (!(choice.flags[i] & 1)) continue;
        if (choice.centres && !is_near(arm, q, choice.centres + n * (i / choice.of_each), choice.near)) continue;
        bool inside = true;
        for (int k = 0; k < n; ++k) {
            counts[n * count + k] = lowest_image(arm, k, q[k], lowest + n * count + k);
            inside &= counts[n * count + k] != 0;
        }
        if (inside || choice.outside) kept[count++] = i;
    }
    return count;
}

// The whole turns to add to b to bring it nearest to a; 0 for a joint that slides.
STEP double turns_between(const GraphJoints& arm, int k, double a, double b) {
    return arm.turn[k] == 0.0 ? 0.0 : __builtin_rint((a - b) / arm.turn[k]);
}

// Steps from one joint vector to a block of others: what they cost, and those that are inside the window and match the twist.
struct Steps {
    Block cost;
    unsigned good;  // one bit per lane
};
// columns: the other joint vectors, joint by joint, `apart` numbers from joint to joint.
STEP Steps steps_from(const GraphJoints& arm, const GraphMotions& motions, const double* jacobian, const double* twist,
                      const double* from, const double* columns, long apart) {
    Block off[6], cost = 0.0;
    for (int r = 0; r < 6; ++r) off[r] = -twist[r];
    auto good = cost <= 0.0;
    for (int k = 0; k < arm.joints; ++k) {
        const double turn = arm.turn[k], inverse = turn == 0.0 ? 0.0 : 1.0 / turn;
        const Block gap = load<Block>(columns + apart * k) - from[k];
        const Block step = gap - ((gap * inverse + ROUNDS) - ROUNDS) * turn, length = abs(step);
        good = good & (length <= motions.window[k]);
        const Block each = motions.weights[k] * (motions.cost == PathCost::squares ? step * step : length);
        cost = motions.cost == PathCost::largest ? max(each, cost) : cost + each;
        for (int r = 0; r < 6; ++r) off[r] += jacobian[arm.joints * r + k] * step;
    }
    const Block position = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
    const Block rotation = off[3] * off[3] + off[4] * off[4] + off[5] * off[5];
    good = good & (position <= motions.position * motions.position) & (rotation <= motions.rotation * motions.rotation);
    return {cost, bits(good)};
}

static long connect(const GraphJoints& arm, const GraphLayers& layers, const GraphMotions& motions, const GraphEdges& edges,
                    double* scratch, const Stop& stop) {
    const int n = arm.joints;
    long count = 0;
    for (long i = 0; i + 1 < layers.waypoints && !stop.asked(); ++i) {
        const std::int64_t next = layers.first[i + 1];
        const long many = long(layers.first[i + 2] - next), padded = (many + BLOCK - 1) / BLOCK * BLOCK;
        for (long b = 0; b < padded; ++b) {
            for (int k = 0; k < n; ++k) scratch[padded * k + b] = layers.q[n * (next + (b < many ? b : many - 1)) + k];
        }
        for (std::int64_t a = layers.first[i]; a < next; ++a) {
            edges.first[a] = count;
            for (long b = 0; b < many; b += BLOCK) {
                const Steps steps = steps_from(arm, motions, motions.jacobians + 6 * n * a, motions.twists + 6 * i,
                                               layers.q + n * a, scratch + b, padded);
                for (unsigned left = steps.good; left; left &= left - 1) {
                    const int lane = __builtin_ctz(left);
                    if (b + lane >= many) break;
                    if (count == edges.room) return -1;
                    edges.end[count] = std::int32_t(next + b + lane), edges.cost[count++] = steps.cost[lane] * motions.scale[i];
                }
            }
        }
    }
    const long last = layers.waypoints - 1;
    for (std::int64_t a = layers.first[last]; a <= layers.first[last + 1]; ++a) edges.first[a] = count;
    return count;
}

// Write the states whose image of each joint k lies in [low[k], high[k]) to `out`. Returns their number.
STEP long states_within(const GraphImages& images, int joints, const int* low, const int* high, int* out) {
    long count = 1;
    out[0] = 0;
    for (int k = 0; k < joints; ++k) {
        if (low[k] >= high[k]) return 0;
        const int stride = int(images.strides[k]), base = low[k] * stride;
        const long before = count;
        for (int image = high[k] - 1; image >= low[k]; --image) {
            const int more = image * stride;
            if (image == low[k]) {
                for (long s = 0; s < before; ++s) out[s] += base;
            } else {
                for (long s = 0; s < before; ++s) out[count++] = out[s] + more;
            }
        }
    }
    return count;
}

constexpr int MOST_JOINTS = 16, MOST_STATES = 1024;

// shift[k]: image i of joint k at node a is nearest to image i + shift[k] at node b. Returns the change of the state's number.
STEP std::int64_t shift_between(const StateGraph& graph, std::int64_t a, std::int64_t b, int* shift) {
    const auto& [arm, layers, edges, images] = graph;
    const int n = arm.joints;
    const double* q = layers.q;
    std::int64_t whole = 0;
    for (int k = 0; k < n; ++k) {
        shift[k] = arm.counted[k] ? int(turns_between(arm, k, q[n * a + k], q[n * b + k])) : 0;
        whole += shift[k] * images.strides[k];
    }
    return whole;
}

// Calls each(state of a, state of b) for the images that a motion from node a to node b connects. Of nodes with one image each it
// connects these, unless the shorter way round leads to another turn, which is outside the limits. There a joint with stride zero
// is not checked.
template <class Each> STEP void each_passage(const StateGraph& graph, std::int64_t a, std::int64_t b, const Each& each) {
    const GraphImages& images = graph.images;
    const int n = graph.arm.joints;
    int shift[MOST_JOINTS], low[MOST_JOINTS], high[MOST_JOINTS], states[MOST_STATES];
    const std::int64_t whole = shift_between(graph, a, b, shift);
    if (images.states == 1) {
        for (int k = 0; k < n; ++k) {
            if (images.strides[k] && shift[k]) return;
        }
        return each(0, 0);
    }
    for (int k = 0; k < n; ++k) {
        const int here = images.counts[n * a + k], there = images.counts[n * b + k] - shift[k];
        low[k] = shift[k] < 0 ? -shift[k] : 0, high[k] = here < there ? here : there;
    }
    const long count = states_within(images, n, low, high, states);
    for (long s = 0; s < count; ++s) each(states[s], states[s] + long(whole));
}

// Calls each(state) for every state of a node.
template <class Each> STEP void each_state(const GraphImages& images, int joints, std::int64_t node, const Each& each) {
    if (images.states == 1) return each(0);
    int low[MOST_JOINTS] = {}, high[MOST_JOINTS], states[MOST_STATES];
    for (int k = 0; k < joints; ++k) high[k] = images.counts[joints * node + k];
    const long count = states_within(images, joints, low, high, states);
    for (long s = 0; s < count; ++s) each(states[s]);
}

struct Best {
    std::int32_t changes;
    double value;
};

STEP bool better(const Best& a, const Best& b) { return a.changes < b.changes || (a.changes == b.changes && a.value < b.value); }

static constexpr std::int32_t NO_WAY = 1 << 30;

// The stored value of a state.
STEP Best best_of(const GraphValues& values, std::int64_t at) {
    if (values.value[at] == __builtin_inf()) return {NO_WAY, __builtin_inf()};
    return {values.changes ? values.changes[at] : 0, values.value[at]};
}

STEP void keep(const GraphValues& values, std::int64_t at, const Best& best, std::int32_t edge) {
    values.value[at] = best.value, values.edge[at] = edge;
    if (values.changes) values.changes[at] = best.changes;
}

static void cheapest(const StateGraph& graph, const GraphValues& values, const Stop& stop) {
    const auto& [arm, layers, edges, images] = graph;
    const long states = images.states;
    for (long i = layers.waypoints - 1; i >= 0 && !stop.asked(); --i) {
        const bool last = i + 1 == layers.waypoints;
        Best jump = {NO_WAY, __builtin_inf()};
        if (!last && values.changes) {
            values.jump[i] = -1;
            for (std::int64_t at = layers.first[i + 1] * states; at < layers.first[i + 2] * states; ++at) {
                if (better(best_of(values, at), jump)) jump = best_of(values, at), values.jump[i] = at;
            }
            ++jump.changes;
        }
        for (std::int64_t a = layers.first[i]; a < layers.first[i + 1]; ++a) {
            for (long s = 0; s < states; ++s) keep(values, a * states + s, {NO_WAY, __builtin_inf()}, -1);
            each_state(images, arm.joints, a,
                       [&](long s) { keep(values, a * states + s, last ? Best{0, 0.0} : jump, last ? -1 : -2); });
            for (std::int64_t e = edges.first[a]; e < edges.first[a + 1]; ++e) {
                const double cost = edges.cost[e];
                if (cost == __builtin_inf()) continue;
                const std::int64_t b = edges.end[e];
                each_passage(graph, a, b, [&](long from, long to) {
                    Best way = best_of(values, b * states + to);
                    way.value += cost;
                    if (better(way, best_of(values, a * states + from))) keep(values, a * states + from, way, std::int32_t(e));
                });
            }
            for (long s = 0; s < states; ++s) values.value[a * states + s] += values.node[a * states + s];
        }
    }
}

static void way(const StateGraph& graph, const GraphValues& values, std::int64_t state, std::int64_t* passed, std::int64_t* taken) {
    const long states = graph.images.states;
    for (long i = 0; i < graph.layers.waypoints; ++i) {
        const std::int64_t edge = values.edge[state], node = state / states;
        passed[i] = state, taken[i] = edge;
        if (edge == -2) state = values.jump[i];
        if (edge < 0) continue;
        int shift[MOST_JOINTS];
        const std::int64_t next = graph.edges.end[edge];
        state = next * states + state % states + shift_between(graph, node, next, shift);
    }
}

static void spread(const StateGraph& graph, const double* node, std::uint64_t* marks, const Stop& stop) {
    const auto& [arm, layers, edges, images] = graph;
    const long states = images.states;
    for (long i = 0; i + 1 < layers.waypoints && !stop.asked(); ++i) {
        for (std::int64_t a = layers.first[i]; a < layers.first[i + 1]; ++a) {
            for (std::int64_t e = edges.first[a]; e < edges.first[a + 1]; ++e) {
                if (edges.cost[e] == __builtin_inf()) continue;
                const std::int64_t b = edges.end[e];
                each_passage(graph, a, b, [&](long from, long to) {
                    if (node[b * states + to] != __builtin_inf()) marks[b * states + to] |= marks[a * states + from];
                });
            }
        }
    }
}

extern const GraphFunctions graph_functions = {choose, connect, cheapest, way, spread};

}  // namespace urdf_ik::URDF_IK_LEVEL
