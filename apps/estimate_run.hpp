// The loop of `cylpose estimate`: frames in, poses and pictures out.
#pragma once

#include <cstdint>
#include <cylpose/camera.hpp>
#include <cylpose/extrinsics.hpp>
#include <cylpose/frame_source.hpp>
#include <cylpose/graph/pipeline.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_io.hpp>
#include <cylpose/report_recorder.hpp>
#include <cylpose/stage_table.hpp>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "live/live_state.hpp"
#include "overlay_window.hpp"
#include "picture_files.hpp"
#include "progress.hpp"

namespace cylpose::apps {

struct RunSummary {
  std::int64_t frames = 0;      ///< without those dropped
  std::int64_t unreadable = 0;  ///< of `frames`
  std::int64_t dropped = 0;     ///< of a live stream, because newer ones had come
  std::int64_t poses = 0;       ///< frames times parts
  std::int64_t found = 0;       ///< of `poses`, with status ok
  std::vector<double> rms_px;   ///< of those found
  double seconds = 0;
  bool interrupted = false;
  graph::PipelineStatistics pipeline;
};

/// Where the results go; pointers to what is not wanted are null.
struct RunSinks {
  PoseWriter* poses = nullptr;             ///< always given
  const Extrinsics* extrinsics = nullptr;  ///< poses are written in the body's frame
  OverlaySink* overlay = nullptr;
  OverlayWindow* window = nullptr;
  PictureFolder* debug = nullptr;
  StageTable* timing = nullptr;
  ReportRecorder* report = nullptr;
  LiveState* live = nullptr;
  AskCluster cluster;            ///< for the live page; may be empty
  Progress* progress = nullptr;  ///< always given
};

using MakePipeline = std::function<std::unique_ptr<graph::Pipeline>(graph::Sink sink)>;

/// Estimates until the frames end, an interrupt is requested or the window is closed. An unreadable frame gives `none`
/// rows and a message. `live`: recordings are played at their own speed. Throws what source, pipeline and sinks throw;
/// an image that cannot be used ends the run with an error that names the frame.
[[nodiscard]] RunSummary run_estimation(FrameSource& source, const MakePipeline& make_pipeline,
                                        const CameraModel& camera, std::span<const PartModel> parts,
                                        const RunSinks& sinks, bool live);

}  // namespace cylpose::apps
