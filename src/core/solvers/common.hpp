// Reads the parts that most arms share from named values.
#pragma once

#include "arm/arm.hpp"
#include "solvers/values.hpp"

namespace urdf_ik {

// Rigid motions, (count, 3, 4) row by row.
inline void read_motions(const Values& values, const char* name, Motion* to, int count) {
    std::vector<double> from(12 * std::size_t(count));
    values.read(name, from.data(), from.size());
    for (int k = 0; k < count; ++k) {
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) to[k].R[i][j] = from[12 * k + 4 * i + j];
            to[k].t[i] = from[12 * k + 4 * i + 3];
        }
    }
}

inline void read(const Values& v, Tolerances& to) {
    v.read("reach", to.reach), v.read("edge", to.edge), v.read("fold", to.fold), v.read("continuum", to.continuum);
    v.read("singular", to.singular), v.read("duplicate", to.duplicate), v.read("rotation", to.rotation);
    v.read("exact_rotation", to.exact_rotation), v.read("exact_structure", to.exact_structure);
}

template <int N> void read(const Values& v, Written<N>& to) {
    read_motions(v, "steps", to.step, N + 1);
    v.read("slides", to.slides), v.read("size", to.size);
    read(*v.group("tolerances"), to.tolerances);
    to.exact = true;
    to.task = static_cast<Task>(v.integer("task"));
    if (v.has("aimed")) v.read("aimed", to.aimed);
    if (v.has("normal")) v.read("normal", to.normal);
}

inline void read(const Values& v, Ends& to) {
    v.read("base_rotation", to.base_rotation), v.read("base_origin", to.base_origin);
    v.read("tool_rotation", to.tool_rotation), v.read("tool_point", to.tool_point);
}

inline void read(const Values& v, Displacement& to) {
    v.read("turn", to.turn), v.read("shift", to.shift), v.read("length", to.length);
}

inline void read(const Values& v, IdealFrames& to) {
    read(v, static_cast<Ends&>(to));
    v.read("cos_alpha", to.cos_alpha), v.read("sin_alpha", to.sin_alpha), v.read("a", to.a), v.read("d", to.d);
    v.read("offset", to.offset), v.read("size", to.size), v.read("imperfection", to.imperfection);
    v.read("signs", to.signs);
    read(*v.group("displacement"), to.displacement);
}

}  // namespace urdf_ik
