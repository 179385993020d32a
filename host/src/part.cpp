#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/part.hpp>
#include <string_view>
#include <utility>

#include "text_file.hpp"
#include "text_readers.hpp"
#include "yaml_file.hpp"

namespace cylpose {
namespace {

// Names become cells of CSV files and parts of file names.
bool is_plain(std::string_view name) {
  return std::none_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f ||
           std::string_view(",\"/\\").find(c) != std::string_view::npos;
  });
}

PartModel part_from(const YamlValue& entry) {
  entry.require_keys_among({"name", "radius_m", "height_m", "hue_deg", "min_saturation", "min_value"});
  PartModel part;
  part.name = entry.at("name").text();
  if (part.name.empty()) entry.at("name").fail("is empty; give the part a name");
  part.radius_m = entry.at("radius_m").number();
  part.height_m = entry.at("height_m").number();
  const auto hue = entry.at("hue_deg").items();
  if (hue.size() != 2) {
    entry.at("hue_deg").fail(fmt::format("has {} values; write [lo, hi] in degrees, like [345, 15]", hue.size()));
  }
  part.hue_lo_deg = hue[0].number();
  part.hue_hi_deg = hue[1].number();
  part.min_saturation = entry.at("min_saturation").number();
  part.min_value = entry.at("min_value").number();
  std::string why;
  if (!part.is_valid(&why)) entry.fail(fmt::format("part '{}': {}", part.name, why));
  return part;
}

// In double quotes, the one YAML style in which every name can be written.
std::string yaml_quoted(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

}  // namespace

bool PartModel::is_valid(std::string* why) const {
  const auto refuse = [&](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  const std::pair<const char*, double> numbers[] = {{"radius_m", radius_m},
                                                    {"height_m", height_m},
                                                    {"hue_deg lo", hue_lo_deg},
                                                    {"hue_deg hi", hue_hi_deg},
                                                    {"min_saturation", min_saturation},
                                                    {"min_value", min_value}};
  for (const auto& [key, value] : numbers) {
    if (!std::isfinite(value)) return refuse(fmt::format("{} is {}; give a finite number", key, value));
  }
  if (!is_plain(name))
    return refuse("name holds a comma, quote, slash or control character; use letters, digits, _ and -");
  if (radius_m <= 0) return refuse(fmt::format("radius_m is {}; give metres above 0", radius_m));
  if (height_m <= 0) return refuse(fmt::format("height_m is {}; give metres above 0", height_m));
  for (const double hue : {hue_lo_deg, hue_hi_deg}) {
    if (hue < 0 || hue > 360) {
      return refuse(fmt::format("hue_deg has {}; give degrees 0..360, a range over red wraps like [345, 15]", hue));
    }
  }
  if (hue_lo_deg == hue_hi_deg || (hue_lo_deg == 360 && hue_hi_deg == 0)) {
    return refuse(fmt::format("hue_deg [{}, {}] is a range of no width; widen it, [0, 360] takes every hue", hue_lo_deg,
                              hue_hi_deg));
  }
  if (min_saturation < 0 || min_saturation > 1) {
    return refuse(fmt::format("min_saturation is {}; give 0..1", min_saturation));
  }
  if (min_value < 0 || min_value > 1) return refuse(fmt::format("min_value is {}; give 0..1", min_value));
  return true;
}

std::vector<PartModel> parts_from_yaml(const std::string& name, std::string text) {
  const YamlValue root = YamlValue::from_text(name, std::move(text));
  root.require_keys_among({"parts"});
  std::vector<PartModel> parts;
  for (const YamlValue& entry : root.at("parts").items()) {
    PartModel part = part_from(entry);
    if (std::any_of(parts.begin(), parts.end(), [&](const PartModel& other) { return other.name == part.name; })) {
      entry.at("name").fail(fmt::format("a part named '{}' is there already; names must differ", part.name));
    }
    parts.push_back(std::move(part));
  }
  if (parts.empty()) root.at("parts").fail("the list is empty; describe at least one part");
  return parts;
}

std::vector<PartModel> load_parts(const std::filesystem::path& path) {
  return parts_from_yaml(path.string(), read_file(path, kMaxYamlBytes));
}

void save_parts(const std::vector<PartModel>& parts, const std::filesystem::path& path) {
  std::string text = "parts:\n";
  for (const PartModel& part : parts) {
    text += fmt::format(
        "  - name: {}\n    radius_m: {}\n    height_m: {}\n    hue_deg: [{}, {}]\n    min_saturation: {}\n"
        "    min_value: {}\n",
        yaml_quoted(part.name), part.radius_m, part.height_m, part.hue_lo_deg, part.hue_hi_deg, part.min_saturation,
        part.min_value);
  }
  write_file(path, text);
}

}  // namespace cylpose
