// CSV with a header line, whose complaints name file, line, column and value.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

/// A day of poses at 100 frames a second stays below this; a video given by mistake often does not.
inline constexpr std::size_t kMaxCsvBytes = std::size_t{2} << 30;

/// A whole CSV file: comma-separated without quotes, LF or CRLF, empty lines skipped, columns found by name.
class CsvFile {
 public:
  /// Throws Error(kInput) unless the header has all `required` columns and every line as many fields as the header.
  /// `name` stands for the file in messages. Blank content, which read_file refuses, has no rows.
  CsvFile(std::string name, std::string content, const std::vector<std::string>& required);
  CsvFile(const CsvFile&) = delete;  // the rows point into the text
  CsvFile& operator=(const CsvFile&) = delete;

  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  [[nodiscard]] bool has(std::string_view column) const;

  [[nodiscard]] std::string_view text(std::size_t row, std::string_view column) const;
  [[nodiscard]] double number(std::size_t row, std::string_view column) const;       ///< refuses NaN and infinities
  [[nodiscard]] std::int64_t index(std::size_t row, std::string_view column) const;  ///< whole number from 0
  /// Three numbers in columns `prefix`x, `prefix`y, `prefix`z.
  [[nodiscard]] Eigen::Vector3d vector(std::size_t row, const std::string& prefix) const;

  /// Throws Error(kInput) with the place in front: "poses.csv:7: <message>".
  [[noreturn]] void fail(std::size_t row, std::string_view message) const;

 private:
  struct Row {
    std::size_t line;
    std::vector<std::string_view> fields;  ///< into text_
  };

  [[nodiscard]] std::size_t column_index(std::string_view column) const;
  [[noreturn]] void fail_at_line(std::size_t line, std::string_view message) const;

  std::string name_;
  std::string text_;
  std::vector<std::string_view> header_;
  std::vector<Row> rows_;
};

}  // namespace cylpose
