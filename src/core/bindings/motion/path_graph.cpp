// Bindings of the path graph: arrays in, arrays filled.
#include "motion/path_graph.hpp"

#include <nanobind/stl/optional.h>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "bindings/module.hpp"
#include "bindings/signals.hpp"

namespace urdf_ik {

namespace {

template <class Number, std::size_t D> using In = nb::ndarray<const Number, nb::ndim<D>, nb::c_contig, nb::device::cpu>;
template <class Number, std::size_t D> using Out = nb::ndarray<Number, nb::ndim<D>, nb::c_contig, nb::device::cpu>;

void require(bool fits) {
    if (!fits) throw nb::value_error("arrays of a path's graph do not fit each other");
}

struct PyPathGraph {
    std::vector<double> lower, upper, turn;
    std::vector<std::uint8_t> counted;

    PyPathGraph(const In<double, 1>& low, const In<double, 1>& high, const In<double, 1>& turns, const In<std::uint8_t, 1>& images)
        : lower(low.data(), low.data() + low.size()),
          upper(high.data(), high.data() + high.size()),
          turn(turns.data(), turns.data() + turns.size()),
          counted(images.data(), images.data() + images.size()) {
        require(upper.size() == lower.size() && turn.size() == lower.size() && counted.size() == lower.size() &&
                lower.size() <= 16);
    }

    std::size_t joints() const { return lower.size(); }
    GraphJoints arm() const { return {int(joints()), lower.data(), upper.data(), turn.data(), counted.data()}; }

    GraphLayers layers(const In<std::int64_t, 1>& first, const In<double, 2>& q) const {
        require(first.size() >= 2 && q.shape(1) == joints() && first.data()[0] == 0);
        for (std::size_t i = 1; i < first.size(); ++i) require(first.data()[i] >= first.data()[i - 1]);
        require(std::size_t(first.data()[first.size() - 1]) == q.shape(0));
        return {long(first.size()) - 1, first.data(), q.data()};
    }
};

// first, q, edge_first, end, cost, digits, strides, counts: see path_graph.hpp.
using StateArrays = std::tuple<In<std::int64_t, 1>, In<double, 2>, Out<std::int64_t, 1>, Out<std::int32_t, 1>, Out<double, 1>,
                               In<std::uint8_t, 2>, In<std::int64_t, 1>, In<std::uint8_t, 2>>;

// The states of a graph and the edges that `connect` made.
struct PyStateGraph {
    StateArrays arrays;
    StateGraph graph;
    std::size_t states, waypoints;  // the states of all nodes

    PyStateGraph(const PyPathGraph& of, const StateArrays& given) : arrays(given) {
        const auto& [first, q, edge_first, end, cost, digits, strides, counts] = arrays;
        const std::size_t nodes = q.shape(0), images = digits.shape(0);
        require(edge_first.size() == nodes + 1 && end.size() == cost.size() && std::size_t(edge_first.data()[nodes]) <= end.size());
        require(images && images <= 1024 && digits.shape(1) == of.joints() && strides.size() == of.joints());
        require(counts.shape(0) == nodes && counts.shape(1) == of.joints());
        graph = {of.arm(),
                 of.layers(first, q),
                 {edge_first.data(), end.data(), cost.data(), long(end.size())},
                 {long(images), digits.data(), strides.data(), counts.data()}};
        states = nodes * images, waypoints = first.size() - 1;
    }
};

long choose(const PyPathGraph& self, const In<double, 2>& q, const In<std::uint8_t, 1>& flags,
            const std::optional<In<double, 2>>& centres, double near, bool outside, const Out<std::int64_t, 1>& kept,
            const Out<double, 2>& lowest, const Out<std::uint8_t, 2>& counts) {
    const std::size_t m = q.shape(0);
    require(q.shape(1) == self.joints() && flags.size() == m && kept.size() == m && lowest.size() == q.size());
    require(counts.size() == q.size() && (!centres || (centres->shape(1) == self.joints() && centres->shape(0))));
    const std::size_t of_each = centres ? m / centres->shape(0) : 1;
    require(!centres || of_each * centres->shape(0) == m);
    const GraphChoice choice = {q.data(), flags.data(), centres ? centres->data() : nullptr, long(of_each), near, outside};
    nb::gil_scoped_release release;
    return level().graph->choose(self.arm(), choice, long(m), kept.data(), lowest.data(), counts.data());
}

long connect(const PyPathGraph& self, const In<std::int64_t, 1>& first, const In<double, 2>& q, const In<double, 3>& jacobians,
             const In<double, 2>& twists, const std::pair<double, double>& mismatch, const In<double, 1>& window, int cost,
             const In<double, 1>& weights, const In<double, 1>& scale, const Out<std::int64_t, 1>& edge_first,
             const Out<std::int32_t, 1>& end, const Out<double, 1>& costs) {
    const GraphLayers layers = self.layers(first, q);
    const std::size_t segments = first.size() - 2;
    require(jacobians.size() == 6 * q.size() && twists.shape(0) == segments && twists.shape(1) == 6 &&
            window.size() == self.joints() && weights.size() == self.joints() && scale.size() == segments);
    require(edge_first.size() == q.shape(0) + 1 && end.size() == costs.size() && cost >= 0 && cost <= 2);
    long widest = 0;
    for (long i = 0; i < layers.waypoints; ++i) widest = std::max(widest, long(layers.first[i + 1] - layers.first[i]));
    std::vector<double> scratch(self.joints() * (widest + 7));
    const GraphMotions motions = {jacobians.data(), twists.data(),  mismatch.first, mismatch.second,
                                  window.data(),    PathCost(cost), weights.data(), scale.data()};
    const GraphEdges edges = {edge_first.data(), end.data(), costs.data(), long(end.size())};
    return without_gil(
        [&](const Stop& stop) { return level().graph->connect(self.arm(), layers, motions, edges, scratch.data(), stop); });
}

void cheapest(const PyStateGraph& self, const In<double, 2>& node, const Out<double, 2>& value,
              const std::optional<Out<std::int32_t, 2>>& changes, const Out<std::int32_t, 2>& edge,
              const Out<std::int64_t, 1>& jump) {
    require(node.size() == self.states && value.size() == self.states && edge.size() == self.states);
    require((!changes || changes->size() == self.states) && jump.size() == self.waypoints);
    const GraphValues values = {node.data(), value.data(), changes ? changes->data() : nullptr, edge.data(), jump.data()};
    without_gil([&](const Stop& stop) { level().graph->cheapest(self.graph, values, stop); });
}

void way(const PyStateGraph& self, const Out<std::int32_t, 2>& edge, const Out<std::int64_t, 1>& jump, std::int64_t state,
         const Out<std::int64_t, 1>& passed, const Out<std::int64_t, 1>& taken) {
    require(edge.size() == self.states && jump.size() == self.waypoints && passed.size() == self.waypoints);
    require(taken.size() == self.waypoints && state >= 0 && std::size_t(state) < edge.size());
    level().graph->way(self.graph, {nullptr, nullptr, nullptr, edge.data(), jump.data()}, state, passed.data(), taken.data());
}

void spread(const PyStateGraph& self, const In<double, 2>& node, const Out<std::uint64_t, 2>& marks) {
    require(marks.size() == self.states && node.size() == self.states);
    without_gil([&](const Stop& stop) { level().graph->spread(self.graph, node.data(), marks.data(), stop); });
}

}  // namespace

void bind_path_graph(nb::module_& m) {
    nb::class_<PyPathGraph>(m, "PathGraph", "Joint vectors along a path and the motions between them; see paths/planner/graph.py.")
        .def(nb::init<const In<double, 1>&, const In<double, 1>&, const In<double, 1>&, const In<std::uint8_t, 1>&>(),
             nb::arg("lower"), nb::arg("upper"), nb::arg("turn"), nb::arg("counted"))
        .def("choose", &choose, nb::arg("q"), nb::arg("flags"), nb::arg("centres").none(), nb::arg("near"), nb::arg("outside"),
             nb::arg("kept"), nb::arg("lowest"), nb::arg("counts"))
        .def("connect", &connect, nb::arg("first"), nb::arg("q"), nb::arg("jacobians"), nb::arg("twists"), nb::arg("mismatch"),
             nb::arg("window"), nb::arg("cost"), nb::arg("weights"), nb::arg("scale"), nb::arg("edge_first"), nb::arg("end"),
             nb::arg("costs"));
    nb::class_<PyStateGraph>(m, "StateGraph", "The states of a path's graph, and the edges between them.")
        .def(nb::init<const PyPathGraph&, const StateArrays&>(), nb::keep_alive<1, 2>(), nb::arg("joints"), nb::arg("arrays"))
        .def("cheapest", &cheapest, nb::arg("node"), nb::arg("value"), nb::arg("changes").none(), nb::arg("edge"), nb::arg("jump"))
        .def("way", &way, nb::arg("edge"), nb::arg("jump"), nb::arg("state"), nb::arg("passed"), nb::arg("taken"))
        .def("spread", &spread, nb::arg("node"), nb::arg("marks"));
}

}  // namespace urdf_ik
