// NumPy's C-API, for short calls, in which nanobind's typed arrays would take most of the time.
#pragma once

#include <cmath>

#include <nanobind/nanobind.h>

#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#define PY_ARRAY_UNIQUE_SYMBOL urdf_ik_array_api
#ifndef URDF_IK_IMPORTS_NUMPY
#define NO_IMPORT_ARRAY
#endif
#include <numpy/arrayobject.h>

#include "arm/arm.hpp"

namespace urdf_ik {

// The object if it is a C-ordered float64 array, else null.
inline PyArrayObject* doubles(nanobind::handle object) {
    if (!PyArray_CheckExact(object.ptr())) return nullptr;
    PyArrayObject* array = (PyArrayObject*)object.ptr();
    return PyArray_TYPE(array) == NPY_DOUBLE && PyArray_ISCARRAY_RO(array) ? array : nullptr;
}

// A new array; to: its numbers.
template <class Number> nanobind::object new_array(int dimensions, const npy_intp* shape, int type, Number*& to) {
    nanobind::object made = nanobind::steal(PyArray_SimpleNew(dimensions, shape, type));
    if (!made.is_valid()) throw nanobind::python_error();
    to = (Number*)PyArray_DATA((PyArrayObject*)made.ptr());
    return made;
}

// Whether all numbers are within +-LARGEST; NaN is not.
inline bool all_in_range(const double* x, npy_intp count) {
    bool bad = false;
    for (npy_intp i = 0; i < count; ++i) bad |= !(std::fabs(x[i]) <= LARGEST);
    return !bad;
}

}  // namespace urdf_ik
