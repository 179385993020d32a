// YAML whose complaints name file, line, key, value and remedy.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

/// Calibrations and part lists have a few hundred bytes; more is another kind of file given by mistake.
inline constexpr std::size_t kMaxYamlBytes = 1 << 20;

/// A node of a YAML file together with where it stands. All members throw Error(kInput).
class YamlValue {
 public:
  /// The file's text: standard YAML, or what OpenCV's FileStorage writes (its first line `%YAML:1.0` is no YAML
  /// directive; tags like `!!opencv-matrix` are ignored). `file` is its name in messages.
  [[nodiscard]] static YamlValue from_text(const std::string& file, std::string text);

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] YamlValue at(const std::string& key) const;  ///< refuses a missing key
  [[nodiscard]] std::vector<YamlValue> items() const;        ///< refuses what is no list

  [[nodiscard]] double number() const;  ///< refuses NaN and infinities
  [[nodiscard]] int integer() const;
  [[nodiscard]] std::string text() const;

  /// Refuses keys that are not in `known` (typing errors would otherwise change nothing, silently) and keys given
  /// twice.
  void require_keys_among(const std::vector<std::string>& known) const;

  /// Throws with the place in front: "camera.yaml:7: image_width: <message>".
  [[noreturn]] void fail(std::string_view message) const;

 private:
  YamlValue(const YAML::Node& node, std::string file, std::string key)
      : node_(node), file_(std::move(file)), key_(std::move(key)) {}
  void require_map() const;

  YAML::Node node_;
  std::string file_;
  std::string key_;  ///< path of keys from the root, empty at the root
};

}  // namespace cylpose
