// See json_values.hpp.
#include "library/json_values.hpp"

namespace urdf_ik {

bool JsonValues::has(const char* name) const {
    const Json* held = object_.find(name);
    return held && held->kind != Json::null;
}

const Json& JsonValues::at(const char* name) const {
    if (!has(name)) throw error(name, "missing");
    return *object_.find(name);
}

const Json& JsonValues::at(const char* name, Json::Kind kind, const char* needed) const {
    const Json& held = at(name);
    if (held.kind != kind) throw error(name, needed);
    return held;
}

double JsonValues::number_in(const Json& held, const char* name) const {
    if (held.kind == Json::number || held.kind == Json::boolean) return held.value;
    if (held.kind == Json::word) {
        if (held.text == "inf") return __builtin_inf();
        if (held.text == "-inf") return -__builtin_inf();
        if (held.text == "nan") return __builtin_nan("");
    }
    throw error(name, "a number is needed");
}

double JsonValues::number(const char* name) const { return number_in(at(name), name); }

std::string JsonValues::word(const char* name) const { return at(name, Json::word, "a word is needed").text; }

void JsonValues::append(const Json& held, const char* name, std::vector<double>& to) const {
    for (const Json& each : held.items) {
        if (each.kind == Json::list) append(each, name, to);
        else to.push_back(number_in(each, name));
    }
}

std::vector<double> JsonValues::array(const char* name) const {
    const Json& held = at(name);
    std::vector<double> numbers;
    if (held.kind == Json::list) append(held, name, numbers);
    else numbers.push_back(number_in(held, name));
    return numbers;
}

std::unique_ptr<Values> JsonValues::group(const char* name) const {
    return std::make_unique<JsonValues>(at(name, Json::group, "a group is needed"), path_ + "." + name);
}

std::vector<JsonValues> JsonValues::groups(const char* name) const {
    std::vector<JsonValues> read;
    for (const Json& each : at(name, Json::list, "a list is needed").items) {
        if (each.kind != Json::group) throw error(name, "groups are needed");
        read.emplace_back(each, path_ + "." + name + "[" + std::to_string(read.size()) + "]");
    }
    return read;
}

std::vector<std::string> JsonValues::words(const char* name) const {
    std::vector<std::string> read;
    for (const Json& each : at(name, Json::list, "a list is needed").items) {
        if (each.kind != Json::word) throw error(name, "words are needed");
        read.push_back(each.text);
    }
    return read;
}

}  // namespace urdf_ik
