#pragma once
#include <cstdio>
#include <map>
#include <memory>
#include <string>
namespace rclcpp {
struct Logger {};
inline Logger get_logger(const std::string&) { return {}; }
struct Node {
    using SharedPtr = std::shared_ptr<Node>;
    std::map<std::string, std::string> parameters;
    bool has_parameter(const std::string& name) const { return parameters.count(name) > 0; }
    template <class T> void declare_parameter(const std::string& name, const T& value) { parameters[name] = value; }
    bool get_parameter(const std::string& name, std::string& value) const {
        const auto found = parameters.find(name);
        return found != parameters.end() && (value = found->second, true);
    }
};
}  // namespace rclcpp
#define RCLCPP_ERROR(logger, ...) ((void)(logger), std::fprintf(stderr, __VA_ARGS__), std::fputc('\n', stderr))
