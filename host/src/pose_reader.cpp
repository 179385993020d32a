#include <fmt/format.h>

#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/pose_io.hpp>
#include <fstream>
#include <istream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "csv_file.hpp"
#include "text_file.hpp"
#include "text_readers.hpp"

namespace cylpose {
namespace {

using nlohmann::json;

// A row is an object of words, numbers and flat lists; later versions may nest a little. The parser takes any depth,
// but json::dump, which the messages use, calls itself per level and would run out of stack.
constexpr int kMaxDepth = 16;

constexpr const char* kStatusRemedy = "expected ok, predicted or none";

std::optional<PoseStatus> status_from(std::string_view text) {
  for (const PoseStatus status : {PoseStatus::kOk, PoseStatus::kPredicted, PoseStatus::kNone}) {
    if (text == to_string(status)) return status;
  }
  return std::nullopt;
}

/// The axis as a unit vector; none when it is not one up to the rounding of a hand-written file. What we wrote stays as
/// it is, to the last digit.
std::optional<Eigen::Vector3d> unit_axis(const Eigen::Vector3d& axis) {
  constexpr double kRounding = 0.01;
  constexpr double kOfDoubles = 1e-14;
  if (std::abs(axis.norm() - 1) < kOfDoubles) return axis;
  if (std::abs(axis.norm() - 1) > kRounding) return std::nullopt;
  return axis.normalized();
}

std::string axis_message(const Eigen::Vector3d& axis) {
  return fmt::format("the axis ({}, {}, {}) has the length {}; expected a unit vector", axis.x(), axis.y(), axis.z(),
                     axis.norm());
}

CylinderPose pose_in(const CsvFile& file, std::size_t row) {
  const Eigen::Vector3d axis = file.vector(row, "a");
  const auto unit = unit_axis(axis);
  if (!unit) file.fail(row, axis_message(axis));
  return {file.vector(row, "c"), *unit};
}

Eigen::Vector3d vector_in(const json& row, const char* key) {
  const json& values = row.at(key);
  if (!values.is_array() || values.size() != 3) {
    throw std::invalid_argument(fmt::format("{} is {}; expected three numbers", key, values.dump()));
  }
  return {values[0].get<double>(), values[1].get<double>(), values[2].get<double>()};
}

/// Throws std::invalid_argument or json::exception; the caller knows file and line.
json parsed(const std::string& line) {
  return json::parse(line, [](int depth, json::parse_event_t, const json&) {
    if (depth > kMaxDepth) throw std::invalid_argument(fmt::format("is nested deeper than {} levels", kMaxDepth));
    return true;
  });
}

/// Throws like parsed().
PoseRow row_from(const json& object) {
  PoseRow row;
  const json& frame = object.at("frame");
  if (!frame.is_number_integer() || frame.get<std::int64_t>() < 0) {
    throw std::invalid_argument(fmt::format("frame is {}; expected a whole number from 0", frame.dump()));
  }
  row.frame = frame.get<std::int64_t>();
  row.timestamp_s = object.at("timestamp_s").get<double>();
  row.part = object.at("part").get<std::string>();
  const auto status = status_from(object.at("status").get<std::string>());
  if (!status) throw std::invalid_argument(fmt::format("status is {}; {}", object["status"].dump(), kStatusRemedy));
  row.status = *status;
  if (row.status == PoseStatus::kNone) {
    row.reason = object.value("reason", "");
    return row;
  }
  const Eigen::Vector3d axis = vector_in(object, "axis");
  const auto unit = unit_axis(axis);
  if (!unit) throw std::invalid_argument(axis_message(axis));
  row.pose = {vector_in(object, "center_m"), *unit};
  row.sigma_center_m = vector_in(object, "sigma_center_m");
  row.sigma_axis_deg = object.at("sigma_axis_deg").get<double>();
  row.rms_px = object.at("rms_px").get<double>();
  return row;
}

}  // namespace

std::vector<PoseRow> poses_from_csv(std::string name, std::string text) {
  const CsvFile file(std::move(name), std::move(text),
                     {"frame", "timestamp_s", "part", "status", "cx", "cy", "cz", "ax", "ay", "az", "sigma_cx",
                      "sigma_cy", "sigma_cz", "sigma_axis_deg", "rms_px"});
  std::vector<PoseRow> rows(file.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    PoseRow& row = rows[i];
    row.frame = file.index(i, "frame");
    row.timestamp_s = file.number(i, "timestamp_s");
    row.part = file.text(i, "part");
    const auto status = status_from(file.text(i, "status"));
    if (!status) file.fail(i, fmt::format("status is '{}'; {}", file.text(i, "status"), kStatusRemedy));
    row.status = *status;
    if (row.status == PoseStatus::kNone) continue;
    row.pose = pose_in(file, i);
    row.sigma_center_m = file.vector(i, "sigma_c");
    row.sigma_axis_deg = file.number(i, "sigma_axis_deg");
    row.rms_px = file.number(i, "rms_px");
  }
  return rows;
}

std::vector<PoseRow> poses_from_jsonl(const std::string& name, std::istream& lines) {
  std::vector<PoseRow> rows;
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (trimmed(line).empty()) continue;
    try {
      rows.push_back(row_from(parsed(line)));
    } catch (const json::exception& error) {
      throw Error(ErrorKind::kInput, fmt::format("{}:{}: {}; a line cut short by an interrupted run can be removed",
                                                 name, number, error.what()));
    } catch (const std::invalid_argument& error) {
      throw Error(ErrorKind::kInput, fmt::format("{}:{}: {}", name, number, error.what()));
    }
  }
  return rows;
}

std::vector<PoseRow> load_poses(const std::filesystem::path& path) {
  char first = 0;
  std::ifstream(path, std::ios::binary) >> first;  // skips blanks; read_file complains about what cannot be opened
  if (first != '{') return poses_from_csv(path.string(), read_file(path, kMaxCsvBytes));
  std::ifstream lines(path, std::ios::binary);
  return poses_from_jsonl(path.string(), lines);
}

std::vector<TruthRow> truth_from_csv(std::string name, std::string text) {
  const CsvFile file(std::move(name), std::move(text), {"frame", "cx", "cy", "cz", "ax", "ay", "az"});
  std::vector<TruthRow> rows(file.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].frame = file.index(i, "frame");
    if (file.has("part")) rows[i].part = file.text(i, "part");
    rows[i].pose = pose_in(file, i);
  }
  return rows;
}

std::vector<TruthRow> load_truth(const std::filesystem::path& path) {
  return truth_from_csv(path.string(), read_file(path, kMaxCsvBytes));
}

}  // namespace cylpose
