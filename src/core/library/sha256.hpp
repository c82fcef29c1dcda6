// SHA-256 (FIPS 180-4) of a text, in hexadecimal digits.
#pragma once

#include <string>
#include <string_view>

namespace urdf_ik { std::string sha256(std::string_view text); }  // namespace urdf_ik
