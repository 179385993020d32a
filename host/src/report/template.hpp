// Texts with places to fill.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace cylpose {

using Field = std::pair<std::string_view, std::string>;

/// `text` with each `{{name}}` replaced by its field; what stands in the fields is not looked at.
[[nodiscard]] std::string filled(std::string_view text, std::initializer_list<Field> fields);

}  // namespace cylpose
