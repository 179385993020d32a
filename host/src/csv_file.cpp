#include "csv_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <utility>

#include "text_file.hpp"

namespace cylpose {
namespace {

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  std::size_t start = 0;
  for (std::size_t end = 0; end != std::string_view::npos; start = end + 1) {
    end = line.find(separator, start);
    fields.push_back(trimmed(line.substr(start, end == std::string_view::npos ? end : end - start)));
  }
  return fields;
}

}  // namespace

CsvFile::CsvFile(std::string name, std::string content, const std::vector<std::string>& required)
    : name_(std::move(name)), text_(std::move(content)) {
  const std::string_view text = text_;
  std::size_t line_number = 0;
  for (std::size_t start = 0, end = 0; start < text.size(); start = end + 1) {
    end = std::min(text.find('\n', start), text.size());
    const std::string_view line = trimmed(text.substr(start, end - start));
    ++line_number;
    if (line.empty()) continue;
    std::vector<std::string_view> fields = split(line, ',');
    if (header_.empty()) {
      header_ = std::move(fields);
      for (const std::string& column : required) {
        if (!has(column)) {
          fail_at_line(line_number,
                       fmt::format("the header has no column '{}'; it needs {}", column, fmt::join(required, ",")));
        }
      }
    } else if (fields.size() != header_.size()) {
      fail_at_line(line_number,
                   fmt::format("has {} of {} fields; a line cut short by an interrupted run can be removed",
                               fields.size(), header_.size()));
    } else {
      rows_.push_back({line_number, std::move(fields)});
    }
  }
}

bool CsvFile::has(std::string_view column) const {
  return std::find(header_.begin(), header_.end(), column) != header_.end();
}

std::size_t CsvFile::column_index(std::string_view column) const {
  return static_cast<std::size_t>(std::find(header_.begin(), header_.end(), column) - header_.begin());
}

std::string_view CsvFile::text(std::size_t row, std::string_view column) const {
  return rows_[row].fields.at(column_index(column));
}

double CsvFile::number(std::size_t row, std::string_view column) const {
  const auto number = parse_number(text(row, column));
  if (!number || !std::isfinite(*number)) {
    fail(row, fmt::format("{} is '{}'; expected a finite number", column, text(row, column)));
  }
  return *number;
}

std::int64_t CsvFile::index(std::size_t row, std::string_view column) const {
  const auto number = parse_integer(text(row, column));
  if (!number || *number < 0) {
    fail(row, fmt::format("{} is '{}'; expected a whole number from 0", column, text(row, column)));
  }
  return *number;
}

Eigen::Vector3d CsvFile::vector(std::size_t row, const std::string& prefix) const {
  return {number(row, prefix + "x"), number(row, prefix + "y"), number(row, prefix + "z")};
}

void CsvFile::fail(std::size_t row, std::string_view message) const {
  fail_at_line(rows_[row].line, message);
}

void CsvFile::fail_at_line(std::size_t line, std::string_view message) const {
  throw Error(ErrorKind::kInput, fmt::format("{}:{}: {}", name_, line, message));
}

}  // namespace cylpose
