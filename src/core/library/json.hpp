// JSON (RFC 8259), as far as compiled arms need it: values in memory, and a reader of text.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace urdf_ik {

struct Json {
    enum Kind { null, boolean, number, word, list, group };

    Kind kind = null;
    double value = 0.0;  // of a number; of a boolean 0 or 1
    std::string text;
    std::vector<Json> items;
    std::vector<std::pair<std::string, Json>> members;

    // The member of this name, or null pointer.
    const Json* find(std::string_view name) const;
};

// Throws std::invalid_argument, which names the line.
Json read_json(std::string_view text);

}  // namespace urdf_ik
