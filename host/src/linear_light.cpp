#include "linear_light.hpp"

#include <cmath>
#include <cstddef>
#include <cylpose/srgb.hpp>

namespace cylpose {
namespace {

constexpr double kFull = 65535;

template <typename Curve>
LinearTable tabulated(Curve curve) {
  LinearTable table{};
  for (std::size_t code = 0; code < table.size(); ++code) {
    table[code] = static_cast<std::uint16_t>(std::lround(kFull * curve(static_cast<double>(code) / 255)));
  }
  return table;
}

}  // namespace

const LinearTable& linear_light(Transfer transfer) {
  static const LinearTable srgb = tabulated(linear_from_srgb);
  static const LinearTable linear = tabulated([](double code) { return code; });
  return transfer == Transfer::kSrgb ? srgb : linear;
}

}  // namespace cylpose
