// Collects a run for its report, frame by frame.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/extrinsics.hpp>
#include <cylpose/frame_source.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <cylpose/report.hpp>
#include <cylpose/stage_table.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cylpose {

class ReportRecorder {
 public:
  /// `extrinsics`: the rows are to be in the body's frame, as those of the poses file are, and so is `truth`.
  /// Throws Error(kInput) for truth given twice, and for truth without a column `part` when there are several parts.
  ReportRecorder(CameraModel camera, std::vector<PartModel> parts, std::vector<TruthRow> truth,
                 std::optional<Extrinsics> extrinsics = std::nullopt);

  /// `estimate` in the camera's frame, one per part; `milliseconds` from the frame being there to its poses being
  /// known. Copies the image (which may be empty) where the frame is, so far, one of the two best or worst, or of the
  /// first two without a pose: by the position error of its worst part, or by the residual where there is no truth.
  void add(const Frame& frame, const FrameEstimate& estimate, double milliseconds);

  /// Times of stages, as StageTable::add.
  void add_times(std::span<const StageTime> times);

  /// Everything but title and facts. The pictures are overlays, at most kPictureWidth wide.
  [[nodiscard]] Report report() const;

  static constexpr int kPictureWidth = 640;

 private:
  struct Candidate {
    double score;  ///< metres with truth, pixels without
    Frame frame;
    FrameEstimate estimate;
  };

  void consider(const Frame& frame, const FrameEstimate& estimate, double score);
  [[nodiscard]] double score_of(std::int64_t frame, const FrameEstimate& written) const;
  [[nodiscard]] std::vector<ReportPicture> pictures() const;

  CameraModel camera_;
  std::vector<PartModel> parts_;
  std::optional<Extrinsics> extrinsics_;
  std::map<std::pair<std::int64_t, std::string>, CylinderPose> true_poses_;  ///< by frame and part
  Report report_;
  StageTable stages_;
  std::vector<Candidate> best_;   ///< lowest score first
  std::vector<Candidate> worst_;  ///< highest score first
  std::vector<Candidate> none_;   ///< in order; score unused
};

}  // namespace cylpose
