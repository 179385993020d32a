// The loop of `cylpose estimate`: frames in, poses and pictures out.
#pragma once

#include <cstdint>
#include <cylpose/camera.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/frame_source.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_io.hpp>
#include <span>
#include <vector>

#include "picture_files.hpp"
#include "progress.hpp"
#include "stage_table.hpp"

namespace cylpose::apps {

struct RunSummary {
  std::int64_t frames = 0;
  std::int64_t unreadable = 0;  ///< of `frames`
  std::int64_t poses = 0;       ///< frames times parts
  std::int64_t found = 0;       ///< of `poses`, with status ok
  std::vector<double> rms_px;   ///< of those found
  double seconds = 0;
  bool interrupted = false;
};

/// Where the results go; pointers to what is not wanted are null.
struct RunSinks {
  PoseWriter* poses = nullptr;  ///< always given
  OverlaySink* overlay = nullptr;
  PictureFolder* debug = nullptr;
  StageTable* timing = nullptr;
  Progress* progress = nullptr;  ///< always given
};

/// Estimates until the frames end or an interrupt is requested. An unreadable frame gives `none` rows and a message.
/// Throws what source, estimator and sinks throw; errors of the estimator name the frame.
[[nodiscard]] RunSummary run_estimation(FrameSource& source, Estimator& estimator, const CameraModel& camera,
                                        std::span<const PartModel> parts, const RunSinks& sinks);

}  // namespace cylpose::apps
