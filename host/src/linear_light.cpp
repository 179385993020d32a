#include "linear_light.hpp"

#include <cmath>
#include <cstddef>

namespace cylpose {
namespace {

constexpr double kFull = 65535;

// IEC 61966-2-1, codes and light 0..1.
double srgb_to_linear(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

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
  static const LinearTable srgb = tabulated(srgb_to_linear);
  static const LinearTable linear = tabulated([](double code) { return code; });
  return transfer == Transfer::kSrgb ? srgb : linear;
}

}  // namespace cylpose
