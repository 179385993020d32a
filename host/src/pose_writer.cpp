#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <cylpose/error.hpp>
#include <cylpose/pose_io.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

namespace cylpose {
namespace {

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

struct RowKey {
  std::int64_t frame;
  double timestamp_s;
  const std::string& part;
};

Eigen::Vector3d sigma_center_m(const PoseEstimate& estimate) {
  return estimate.covariance.diagonal().head<3>().cwiseMax(0).cwiseSqrt();
}

// fmt's "{}" gives the shortest digits that read back as the same double, whatever the locale.
std::string csv_row(const RowKey& key, const PoseEstimate& estimate) {
  const std::string start =
      fmt::format("{},{},{},{}", key.frame, key.timestamp_s, key.part, to_string(estimate.status));
  if (estimate.status == PoseStatus::kNone) return start + ",,,,,,,,,,,\n";
  const Eigen::Vector3d& c = estimate.pose.center_in_cam;
  const Eigen::Vector3d& a = estimate.pose.axis_in_cam;
  const Eigen::Vector3d sigma = sigma_center_m(estimate);
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", start, c.x(), c.y(), c.z(), a.x(), a.y(), a.z(),
                     sigma.x(), sigma.y(), sigma.z(), estimate.sigma_axis_rad() * kDegreesPerRadian, estimate.rms_px);
}

std::string json_row(const RowKey& key, const PoseEstimate& estimate) {
  nlohmann::ordered_json row;
  row["frame"] = key.frame;
  row["timestamp_s"] = key.timestamp_s;
  row["part"] = key.part;
  row["status"] = to_string(estimate.status);
  if (estimate.status == PoseStatus::kNone) {
    row["reason"] = estimate.reason;
  } else {
    const auto numbers = [](const auto& vector) { return std::vector<double>(vector.begin(), vector.end()); };
    row["center_m"] = numbers(estimate.pose.center_in_cam);
    row["axis"] = numbers(estimate.pose.axis_in_cam);
    row["sigma_center_m"] = numbers(sigma_center_m(estimate));
    row["sigma_axis_deg"] = estimate.sigma_axis_rad() * kDegreesPerRadian;
    row["rms_px"] = estimate.rms_px;
    row["support"] = estimate.support;
    row["seen"] = estimate.seen;
    row["covariance"] = numbers(estimate.covariance.reshaped<Eigen::RowMajor>());
  }
  // Part names come from files in any encoding; a bad byte must not end the run.
  return row.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string tum_row(const RowKey& key, const PoseEstimate& estimate) {
  if (estimate.status == PoseStatus::kNone) return {};
  const Eigen::Vector3d& t = estimate.pose.center_in_cam;
  const Eigen::Quaterniond q = cam_from_cyl_rotation(estimate.pose.axis_in_cam);
  return fmt::format("{} {} {} {} {} {} {} {}\n", key.timestamp_s, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

std::string row_of(PoseFormat format, const RowKey& key, const PoseEstimate& estimate) {
  switch (format) {
    case PoseFormat::kCsv:
      return csv_row(key, estimate);
    case PoseFormat::kJsonl:
      return json_row(key, estimate);
    case PoseFormat::kTum:
      return tum_row(key, estimate);
  }
  return {};
}

}  // namespace

std::optional<PoseFormat> pose_format_from(std::string_view name) {
  if (name == "csv") return PoseFormat::kCsv;
  if (name == "jsonl") return PoseFormat::kJsonl;
  if (name == "tum") return PoseFormat::kTum;
  return std::nullopt;
}

Eigen::Quaterniond cam_from_cyl_rotation(const Eigen::Vector3d& axis_in_cam) {
  constexpr double kParallel = 0.999;
  const Eigen::Vector3d z = axis_in_cam.normalized();
  const Eigen::Vector3d guide = std::abs(z.x()) > kParallel ? Eigen::Vector3d(Eigen::Vector3d::UnitY())
                                                            : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  const Eigen::Vector3d x = (guide - z * z.dot(guide)).normalized();
  Eigen::Matrix3d cam_from_cyl;
  cam_from_cyl << x, z.cross(x), z;
  Eigen::Quaterniond rotation(cam_from_cyl);
  if (rotation.w() < 0) rotation.coeffs() = -rotation.coeffs();
  return rotation;
}

PoseRow pose_row(std::int64_t frame, double timestamp_s, std::string part, const PoseEstimate& estimate) {
  PoseRow row;
  row.frame = frame;
  row.timestamp_s = timestamp_s;
  row.part = std::move(part);
  row.status = estimate.status;
  row.reason = estimate.reason;
  if (estimate.status == PoseStatus::kNone) return row;
  row.pose = estimate.pose;
  row.sigma_center_m = sigma_center_m(estimate);
  row.sigma_axis_deg = estimate.sigma_axis_rad() * kDegreesPerRadian;
  row.rms_px = estimate.rms_px;
  return row;
}

PoseWriter::PoseWriter(const std::filesystem::path& destination, PoseFormat format, std::vector<std::string> part_names)
    : name_(destination == "-" ? "standard output" : destination.string()),
      format_(format),
      part_names_(std::move(part_names)) {
  if (format_ == PoseFormat::kTum && part_names_.size() > 1) {
    throw Error(ErrorKind::kInput, fmt::format("a TUM trajectory holds one part, not {}; choose the format csv or "
                                               "jsonl, or describe one part",
                                               part_names_.size()));
  }
  file_.reset(destination == "-" ? stdout : std::fopen(destination.c_str(), "wb"));
  if (!file_) fail(errno);
  if (format_ == PoseFormat::kCsv) put(std::string(kPosesHeader) + "\n");
}

void PoseWriter::CloseFile::operator()(std::FILE* file) const {
  if (file != stdout) std::fclose(file);
}

void PoseWriter::write(std::int64_t frame, double timestamp_s, const FrameEstimate& estimate) {
  std::string rows;
  for (std::size_t i = 0; i < part_names_.size(); ++i) {
    rows += row_of(format_, {frame, timestamp_s, part_names_[i]}, estimate.parts.at(i));
  }
  put(rows);
}

void PoseWriter::close() {
  std::FILE* const file = file_.release();
  if (file == nullptr) return;
  const int failed = file == stdout ? std::fflush(file) : std::fclose(file);
  if (failed != 0) fail(errno);
}

void PoseWriter::put(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() || std::fflush(file_.get()) != 0)
    fail(errno);
}

void PoseWriter::fail(int error_number) const {
  const char* remedy = error_number == EPIPE ? "the program that reads it has ended"
                                             : "choose a place that exists, is writable and has room";
  throw Error(ErrorKind::kOutput,
              fmt::format("{}: poses cannot be written: {}; {}", name_, std::strerror(error_number), remedy));
}

}  // namespace cylpose
