#include "yaml_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <set>
#include <utility>

#include "text_file.hpp"

namespace cylpose {
namespace {

// OpenCV opens its files with "%YAML:1.0", which is no YAML directive ("%YAML 1.0" is). The line becomes a comment so
// that line numbers in messages stay right.
void disarm_opencv_directive(std::string& text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  const std::size_t start = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  if (text.compare(start, 6, "%YAML:") == 0) text[start] = '#';
}

}  // namespace

YamlValue YamlValue::from_text(const std::string& file, std::string text) {
  disarm_opencv_directive(text);
  try {
    YamlValue root(YAML::Load(text), file, "");
    root.require_map();
    return root;
  } catch (const YAML::Exception& error) {
    throw Error(ErrorKind::kInput, fmt::format("{}:{}: is no valid YAML: {}; was the file written completely?", file,
                                               error.mark.line + 1, error.msg));
  }
}

void YamlValue::fail(std::string_view message) const {
  const std::string line = node_.Mark().is_null() ? "" : fmt::format("{}:", node_.Mark().line + 1);
  const std::string key = key_.empty() ? "" : key_ + ": ";
  throw Error(ErrorKind::kInput, fmt::format("{}:{} {}{}", file_, line, key, message));
}

void YamlValue::require_map() const {
  if (!node_.IsMap()) fail("expected `key: value` lines");
}

bool YamlValue::has(const std::string& key) const {
  require_map();
  return node_[key].IsDefined();
}

YamlValue YamlValue::at(const std::string& key) const {
  if (!has(key)) fail(fmt::format("the key '{}' is missing; add it", key));
  return {node_[key], file_, key_.empty() ? key : key_ + "." + key};
}

std::vector<YamlValue> YamlValue::items() const {
  if (!node_.IsSequence()) fail("expected a list");
  std::vector<YamlValue> items;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    items.push_back({node_[i], file_, fmt::format("{}[{}]", key_, i)});
  }
  return items;
}

double YamlValue::number() const {
  const auto number = parse_number(text());
  if (!number || !std::isfinite(*number)) fail(fmt::format("'{}' is no finite number; correct it", text()));
  return *number;
}

int YamlValue::integer() const {
  const auto number = parse_integer(text());
  if (!number || !std::in_range<int>(*number)) {
    fail(fmt::format("'{}' is no whole number; correct it", text()));
  }
  return static_cast<int>(*number);
}

std::string YamlValue::text() const {
  if (!node_.IsScalar()) fail("expected a single value");
  return node_.Scalar();
}

void YamlValue::require_keys_among(const std::vector<std::string>& known) const {
  require_map();
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : std::string("(not a word)");
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      YamlValue(entry.first, file_, key_)
          .fail(fmt::format("unknown key '{}'; known keys: {}", key, fmt::join(known, ", ")));
    }
    if (!seen.insert(key).second) {
      YamlValue(entry.first, file_, key_).fail(fmt::format("the key '{}' is given twice; remove one", key));
    }
  }
}

}  // namespace cylpose
