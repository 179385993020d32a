// The coloured cylinder to look for.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cylpose {

/// A right circular cylinder of one colour.
struct PartModel {
  std::string name;
  double radius_m = 0;        ///< > 0
  double height_m = 0;        ///< > 0, distance of the two bases
  double hue_lo_deg = 0;      ///< hue circle 0..360 (HSV; red 0, green 120, blue 240)
  double hue_hi_deg = 0;      ///< range from lo upward to hi; lo > hi wraps through 0
  double min_saturation = 0;  ///< HSV saturation, 0..1
  double min_value = 0;       ///< HSV value, 0..1

  /// False, with the reason in `why`, for NaN, sizes not above zero, a hue range of no width, floors outside 0..1, and
  /// names with commas, quotes, slashes or control characters (they become cells of CSV files and parts of file names).
  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Reads the `parts:` list of a YAML file. Throws Error(kInput) that names file, part, value and remedy.
[[nodiscard]] std::vector<PartModel> load_parts(const std::filesystem::path& path);

/// Writes what load_parts reads. Throws Error(kOutput).
void save_parts(const std::vector<PartModel>& parts, const std::filesystem::path& path);

}  // namespace cylpose
