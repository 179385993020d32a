// From the codes a camera delivers to the light they stand for.
#pragma once

#include <array>
#include <cstdint>
#include <cylpose/camera.hpp>

namespace cylpose {

using LinearTable = std::array<std::uint16_t, 256>;

/// Light of each code, 65535 for code 255.
[[nodiscard]] const LinearTable& linear_light(Transfer transfer);

}  // namespace cylpose
