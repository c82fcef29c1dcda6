// Each file of this folder binds a part of the module urdf_ik._core.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include "levels.hpp"

namespace urdf_ik {

namespace nb = nanobind;

void bind_answer(nb::module_& m);
void bind_chain(nb::module_& m);
void bind_elimination(nb::module_& m);
void bind_images(nb::module_& m);
void bind_path_graph(nb::module_& m);
void bind_self_motion(nb::module_& m);
void bind_tracker(nb::module_& m);

}  // namespace urdf_ik
