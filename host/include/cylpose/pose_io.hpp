// Poses in files: CSV, JSON lines and TUM trajectories; and the truth they are compared with.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <cstdio>
#include <cylpose/pose.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

enum class PoseFormat {
  kCsv,    ///< one row per frame and part; fields of `none` rows are empty
  kJsonl,  ///< one JSON object per frame and part, with the full covariance, or the reason for `none`
  kTum,    ///< `timestamp tx ty tz qx qy qz qw`, z axis along the cylinder; `none` rows are left out
};

/// "csv", "jsonl" or "tum"; none for other words.
[[nodiscard]] std::optional<PoseFormat> pose_format_from(std::string_view name);

/// First line of a poses CSV.
inline constexpr std::string_view kPosesHeader =
    "frame,timestamp_s,part,status,cx,cy,cz,ax,ay,az,sigma_cx,sigma_cy,sigma_cz,sigma_axis_deg,rms_px";

/// Camera-from-cylinder rotation: z along the axis. The roll cannot be observed; it is fixed by taking as x axis the
/// camera's x axis projected perpendicular to the cylinder's (the camera's y axis where the two are within about 2.5
/// degrees). qw >= 0.
[[nodiscard]] Eigen::Quaterniond cam_from_cyl_rotation(const Eigen::Vector3d& axis_in_cam);

/// Writes poses frame by frame; every frame is flushed, so that an interrupted run keeps what was written.
class PoseWriter {
 public:
  /// Opens `destination` (replacing a file of that name), or standard output for "-". A TUM trajectory has no place for
  /// a part's name, so more than one part is refused there with Error(kInput). Throws Error(kOutput).
  PoseWriter(const std::filesystem::path& destination, PoseFormat format, std::vector<std::string> part_names);

  /// Writes the rows of one frame, in the order of the parts. Throws Error(kOutput) that names the destination when the
  /// disk is full or the reader of the pipe is gone.
  void write(std::int64_t frame, double timestamp_s, const FrameEstimate& estimate);

  /// Closes; what the system reports only now (network drives) throws Error(kOutput).
  void close();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const;
  };

  void put(std::string_view text);
  [[noreturn]] void fail(int error_number) const;

  std::string name_;
  PoseFormat format_;
  std::vector<std::string> part_names_;
  std::unique_ptr<std::FILE, CloseFile> file_;  ///< null after close()
};

/// One row of a poses file. Pose, sigmas and rms are valid unless status is kNone.
struct PoseRow {
  std::int64_t frame = 0;
  double timestamp_s = 0;
  std::string part;
  PoseStatus status = PoseStatus::kNone;
  std::string reason;  ///< for kNone: the test that fired; CSV files do not hold it
  CylinderPose pose;
  Eigen::Vector3d sigma_center_m = Eigen::Vector3d::Zero();
  double sigma_axis_deg = 0;
  double rms_px = 0;
};

/// The row that a writer writes for the estimate.
[[nodiscard]] PoseRow pose_row(std::int64_t frame, double timestamp_s, std::string part, const PoseEstimate& estimate);

/// Reads a poses file, CSV or JSON lines (told apart by its first character). Throws Error(kInput) that names file,
/// line and value for a wrong header, rows cut short, numbers that are not finite, axes that are no unit vectors.
[[nodiscard]] std::vector<PoseRow> load_poses(const std::filesystem::path& path);

struct TruthRow {
  std::int64_t frame = 0;
  std::string part;  ///< empty when the file has no column `part`
  CylinderPose pose;
};

/// Reads a truth CSV: columns frame,cx,cy,cz,ax,ay,az in any order, optionally part, others ignored. Throws like
/// load_poses.
[[nodiscard]] std::vector<TruthRow> load_truth(const std::filesystem::path& path);

}  // namespace cylpose
