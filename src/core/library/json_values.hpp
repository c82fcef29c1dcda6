// The members of a JSON object as named values. null counts as missing; the words "inf", "-inf" and "nan" count as numbers.
#pragma once

#include "library/json.hpp"
#include "solvers/values.hpp"

namespace urdf_ik {

class JsonValues : public Values {
public:
    // The object must outlive the values.
    JsonValues(const Json& object, std::string path) : Values(std::move(path)), object_(object) {}

    bool has(const char* name) const override;
    double number(const char* name) const override;
    std::string word(const char* name) const override;
    std::vector<double> array(const char* name) const override;
    std::unique_ptr<Values> group(const char* name) const override;
    // The objects of a list.
    std::vector<JsonValues> groups(const char* name) const;
    std::vector<std::string> words(const char* name) const;

private:
    const Json& at(const char* name) const;
    const Json& at(const char* name, Json::Kind kind, const char* needed) const;
    double number_in(const Json& held, const char* name) const;
    void append(const Json& held, const char* name, std::vector<double>& to) const;

    const Json& object_;
};

}  // namespace urdf_ik
