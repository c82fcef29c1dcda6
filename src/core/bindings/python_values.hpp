// The attributes of a Python object, such as a dataclass, as named values. None counts as missing.
#pragma once

#include <nanobind/nanobind.h>

#include "solvers/values.hpp"

namespace urdf_ik {

namespace nb = nanobind;

class PythonValues : public Values {
public:
    PythonValues(nb::object object, std::string path) : Values(std::move(path)), object_(std::move(object)) {}

    bool has(const char* name) const override { return nb::hasattr(object_, name) && !object_.attr(name).is_none(); }
    double number(const char* name) const override;
    std::string word(const char* name) const override;
    std::vector<double> array(const char* name) const override;
    std::unique_ptr<Values> group(const char* name) const override;

private:
    nb::object at(const char* name) const;

    nb::object object_;
};

}  // namespace urdf_ik
