// The named values of an arm, from any source, such as a Python dataclass (bindings/python_values.hpp). Values are numbers, words,
// arrays of numbers, and groups of such values.
#pragma once

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace urdf_ik {

class Values {
public:
    explicit Values(std::string path) : path_(std::move(path)) {}
    virtual ~Values() = default;

    virtual bool has(const char* name) const = 0;
    // These throw std::invalid_argument if the name is missing or its value has another type.
    virtual double number(const char* name) const = 0;  // false and true are 0 and 1
    virtual std::string word(const char* name) const = 0;
    virtual std::vector<double> array(const char* name) const = 0;  // of any shape, in C order
    virtual std::unique_ptr<Values> group(const char* name) const = 0;

    int integer(const char* name) const {
        const double value = number(name);
        if (!(std::fabs(value) < 1e9) || value != std::floor(value)) throw error(name, "an integer is needed");
        return int(value);
    }

    // Read a number, or an array of fixed size and any number of dimensions, into a struct's member.
    template <class T> void read(const char* name, T& to) const {
        if constexpr (std::is_array_v<T>) {
            using Number = std::remove_all_extents_t<T>;
            read(name, reinterpret_cast<Number*>(&to), sizeof(T) / sizeof(Number));
        } else if constexpr (std::is_floating_point_v<T> || std::is_same_v<T, bool>) {
            to = static_cast<T>(number(name));
        } else {
            to = integer(name);
        }
    }
    // Read an array of `count` numbers.
    template <class T> void read(const char* name, T* to, std::size_t count) const {
        const std::vector<double> from = array(name);
        if (from.size() != count) {
            throw error(name, std::to_string(from.size()) + " numbers given, " + std::to_string(count) + " needed");
        }
        for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<T>(from[i]);
    }

    std::invalid_argument error(const char* name, const std::string& text) const {
        return std::invalid_argument(path_ + "." + name + ": " + text);
    }

protected:
    // The names on the way to this group, such as "imperfect.family".
    const std::string path_;
};

}  // namespace urdf_ik
