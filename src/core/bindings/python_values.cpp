// See python_values.hpp.
#include "bindings/python_values.hpp"

#include <nanobind/ndarray.h>

namespace urdf_ik {

nb::object PythonValues::at(const char* name) const {
    if (!has(name)) throw error(name, "missing");
    return object_.attr(name);
}

double PythonValues::number(const char* name) const {
    const double value = PyFloat_AsDouble(at(name).ptr());
    if (value == -1.0 && PyErr_Occurred()) throw nb::python_error();
    return value;
}

std::string PythonValues::word(const char* name) const {
    const nb::object value = at(name);
    if (!nb::isinstance<nb::str>(value)) throw error(name, "a word is needed");
    return nb::borrow<nb::str>(value).c_str();
}

std::vector<double> PythonValues::array(const char* name) const {
    const auto from = nb::cast<nb::ndarray<const double, nb::c_contig, nb::device::cpu>>(at(name));
    return {from.data(), from.data() + from.size()};
}

std::unique_ptr<Values> PythonValues::group(const char* name) const {
    return std::make_unique<PythonValues>(at(name), path_ + "." + name);
}

}  // namespace urdf_ik
