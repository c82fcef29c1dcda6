// Named values from Python to structs of plain numbers.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <string>
#include <type_traits>

#include "kinematics/arm.hpp"

namespace urdf_ik {

namespace nb = nanobind;

// A dict of floats, bools, float64 arrays and dicts. A name that is missing, or an array of another shape, is an error.
class Values {
public:
    Values(nb::dict dict, std::string where) : dict_(std::move(dict)), where_(std::move(where)) {}

    bool has(const char* name) const { return dict_.contains(name); }
    Values group(const char* name) const { return {nb::cast<nb::dict>(at(name)), where_ + "." + name}; }
    nb::object at(const char* name) const {
        if (!has(name)) throw nb::key_error((where_ + " lacks '" + name + "'").c_str());
        return nb::object(dict_[name]);
    }
    template <class T> T get(const char* name) const { return nb::cast<T>(at(name)); }

    // A number, or an array of fixed size and any number of dimensions.
    template <class T> void read(const char* name, T& to) const {
        if constexpr (std::is_array_v<T>) read_array(name, to);
        else to = nb::cast<T>(at(name));
    }

    // Any number of float64 in C order, of any shape.
    template <class F> void numbers(const char* name, std::size_t count, F&& take) const {
        const auto array = nb::cast<nb::ndarray<const double, nb::c_contig, nb::device::cpu>>(at(name));
        if (array.size() != count) {
            throw nb::value_error(
                (where_ + "." + name + ": " + std::to_string(array.size()) + " numbers given, " + std::to_string(count) + " needed")
                    .c_str());
        }
        take(array.data());
    }

private:
    template <class T> void read_array(const char* name, T& to) const {
        using Each = std::remove_all_extents_t<T>;
        constexpr std::size_t count = sizeof(T) / sizeof(Each);
        numbers(name, count, [&](const double* from) {
            Each* out = reinterpret_cast<Each*>(&to);
            for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<Each>(from[i]);
        });
    }

    nb::dict dict_;
    std::string where_;
};

// Rigid motions, (count, 3, 4) or (count, 4, 4) row by row; only the first three rows count.
inline void read_motions(const Values& values, const char* name, Motion* to, int count) {
    values.numbers(name, 12 * std::size_t(count), [&](const double* from) {
        for (int k = 0; k < count; ++k) {
            for (int i = 0; i < 3; ++i) {
                for (int j = 0; j < 3; ++j) to[k].R[i][j] = from[12 * k + 4 * i + j];
                to[k].t[i] = from[12 * k + 4 * i + 3];
            }
        }
    });
}

inline void read(const Values& v, Tolerances& to) {
    v.read("reach", to.reach), v.read("edge", to.edge), v.read("fold", to.fold), v.read("continuum", to.continuum);
    v.read("singular", to.singular), v.read("duplicate", to.duplicate), v.read("rotation", to.rotation);
    v.read("exact_rotation", to.exact_rotation), v.read("exact_structure", to.exact_structure);
}

template <int N> void read(const Values& v, Written<N>& to) {
    read_motions(v, "steps", to.step, N + 1);
    v.read("slides", to.slides), v.read("size", to.size);
    read(v.group("tolerances"), to.tolerances);
    to.exact = true, to.beside = to.raw = false;
    to.task = v.has("task") ? static_cast<Task>(v.get<int>("task")) : Task::pose;
    if (v.has("aimed")) v.read("aimed", to.aimed);
    if (v.has("normal")) v.read("normal", to.normal);
}

inline void read(const Values& v, Ends& to) {
    v.read("base_rotation", to.base_rotation), v.read("base_origin", to.base_origin);
    v.read("tool_rotation", to.tool_rotation), v.read("tool_point", to.tool_point);
}

inline void read(const Values& v, IdealFrames& to) {
    read(v, static_cast<Ends&>(to));
    v.read("cos_alpha", to.cos_alpha), v.read("sin_alpha", to.sin_alpha), v.read("a", to.a), v.read("d", to.d);
    v.read("offset", to.offset), v.read("size", to.size), v.read("clamp", to.clamp);
    v.read("imperfection", to.imperfection), v.read("signs", to.signs);
}

}  // namespace urdf_ik
