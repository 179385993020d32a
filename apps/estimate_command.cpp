#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <cylpose/default_backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/evaluate.hpp>
#include <cylpose/extrinsics.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core/utils/logger.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cluster_backend.hpp"
#include "commands.hpp"
#include "estimate_run.hpp"
#include "help_text.hpp"
#include "interrupt.hpp"
#include "live/live_page.hpp"
#include "output.hpp"

namespace cylpose::apps {
namespace {

struct Arguments {
  std::string camera;
  std::string parts;
  std::string extrinsics;
  std::string backend;
  std::string device;
  std::string method = "default";
  std::string output = "-";
  std::string format;
  std::string overlay;
  std::string debug_dir;
  std::string report;
  std::string truth;
  bool timing = false;
  ClusterArguments cluster;
  bool filter = false;
  bool live = false;
  bool show = false;
  std::optional<int> serve;
  std::string serve_address = "127.0.0.1";
  std::string trace;
  FrameSourceOptions frames;
  std::vector<std::string> inputs;
};

PoseFormat format_of(const Arguments& arguments) {
  if (!arguments.format.empty()) {
    if (const auto format = pose_format_from(arguments.format)) return *format;
    throw Error(ErrorKind::kInput, fmt::format("--format {}: unknown; write csv, jsonl or tum", arguments.format));
  }
  const std::string extension = std::filesystem::path(arguments.output).extension().string();
  if (extension.empty()) return PoseFormat::kCsv;
  if (const auto format = pose_format_from(extension.substr(1))) return *format;
  throw Error(ErrorKind::kInput,
              fmt::format("--output {}: the extension {} tells no format; add --format csv, jsonl or "
                          "tum",
                          arguments.output, extension));
}

// Here, not in the library: options that one backend has and the others have not, and what is said to the user.
ChosenBackend backend_for(const Arguments& arguments, const Tell& tell) {
  const bool cluster = arguments.backend == "cluster";
  if (!arguments.device.empty() && !arguments.backend.empty() && arguments.backend != "opencl" && !cluster) {
    throw Error(ErrorKind::kInput,
                fmt::format("--device {}: only the backends opencl and cluster run on devices; leave out "
                            "--backend {}",
                            arguments.device, arguments.backend));
  }
  OpenclOptions options;
  options.device = arguments.device;
  options.profile = arguments.timing || !arguments.trace.empty();
  options.on_device_lost = [tell](const OpenclDevice& device, const std::string& why) {
    tell(fmt::format("warning: going on without {}: {}", device.name, why));
  };
  if (arguments.backend == "opencl" || (!arguments.device.empty() && !cluster)) {
    return {make_opencl_backend(options), {}};
  }
  if (!arguments.backend.empty() && !cluster) return {make_backend(arguments.backend), {}};
  DefaultBackend chosen = make_default_backend(options);
  if (!chosen.note.empty()) tell(chosen.note);
  if (cluster) return cluster_backend(std::move(chosen.backend), arguments.cluster, tell);
  return {std::move(chosen.backend), {}};
}

struct Prepared {
  MakePipeline make_pipeline;
  AskCluster cluster;
};

std::vector<std::string> backend_names() {
  std::vector<std::string> names;
  for (const BackendInfo& backend : backends()) names.emplace_back(backend.name);
  return names;
}

// Made before outputs are touched: everything that can be refused about it is refused here.
Prepared prepared(const Arguments& arguments, const CameraModel& camera, const std::vector<PartModel>& parts,
                  const std::shared_ptr<graph::Trace>& trace, const Tell& tell) {
  graph::PipelineOptions options;
  options.policy = arguments.live ? graph::Policy::kLatest : graph::Policy::kAll;
  if (arguments.filter) options.filter.emplace();
  options.with_stages = !arguments.debug_dir.empty();
  options.trace = trace;
  if (arguments.method == "default") {
    ChosenBackend chosen = backend_for(arguments, tell);
    const auto backend = std::make_shared<std::unique_ptr<Backend>>(std::move(chosen.backend));
    return {[=](graph::Sink sink) {
              return std::make_unique<graph::Pipeline>(camera, parts, std::move(*backend), std::move(sink), options);
            },
            std::move(chosen.cluster)};
  }
  const bool on_device = arguments.backend.empty() && !arguments.device.empty();
  const auto estimator = std::make_shared<std::unique_ptr<Estimator>>(
      make_estimator(arguments.method, camera, parts, on_device ? "opencl" : arguments.backend));
  return {[=](graph::Sink sink) {
            return std::make_unique<graph::Pipeline>(camera, parts, std::move(*estimator), std::move(sink), options);
          },
          {}};
}

std::string nodes_text(const graph::PipelineStatistics& statistics) {
  std::string text =
      fmt::format("{:<20}{:>10}{:>10}{:>10}{:>10}{:>8}\n", "node [ms]", "mean", "median", "p95", "p99", "visits");
  const auto add = [&](const std::string& name, const graph::DurationStatistics& busy) {
    text += fmt::format("{:<20}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>8}\n", name, busy.mean_ms, busy.median_ms,
                        busy.p95_ms, busy.p99_ms, busy.count);
  };
  for (const graph::NodeStatistics& node : statistics.nodes) add(node.node, node.busy);
  add("put to sink", statistics.latency);
  return text;
}

std::string summary_text(const RunSummary& summary) {
  const auto rms = statistics_of(summary.rms_px);
  std::string text = fmt::format("{} frames, {} of {} poses found", summary.frames, summary.found, summary.poses);
  if (summary.dropped > 0) text += fmt::format(", {} frames dropped", summary.dropped);
  if (summary.unreadable > 0) text += fmt::format(", {} frames unreadable", summary.unreadable);
  if (rms) text += fmt::format(", median rms {:.3f} px", rms->median);
  if (summary.seconds > 0)
    text += fmt::format(", {:.1f} frames/s", static_cast<double>(summary.frames) / summary.seconds);
  if (summary.interrupted) text += "; interrupted, everything up to here is written";
  return text;
}

/// The inputs, the first few of many.
std::string inputs_text(const Arguments& arguments) {
  constexpr std::size_t kMost = 4;
  const std::span<const std::string> inputs = arguments.inputs;
  std::string text = fmt::format("{}", fmt::join(inputs.first(std::min(inputs.size(), kMost)), ", "));
  if (inputs.size() > kMost) text += fmt::format(" and {} more", inputs.size() - kMost);
  return text;
}

/// What report and live page say they are about.
std::vector<ReportFact> facts_of(const Arguments& arguments) {
  std::vector<ReportFact> facts = {
      {"Input", inputs_text(arguments)}, {"Camera", arguments.camera}, {"Parts", arguments.parts}};
  if (!arguments.truth.empty()) facts.push_back({"Truth", arguments.truth});
  if (!arguments.extrinsics.empty()) facts.push_back({"In the frame of", arguments.extrinsics});
  facts.push_back({"Method", arguments.method});
  if (!arguments.backend.empty()) facts.push_back({"Backend", arguments.backend});
  return facts;
}

void write_report(const Arguments& arguments, const RunSummary& summary, const ReportRecorder& recorder) {
  Report report = recorder.report();
  report.title = "Poses from " + inputs_text(arguments);
  report.facts = facts_of(arguments);
  report.facts.push_back({"Run", summary_text(summary)});
  write_result(arguments.report, to_html(report));
}

void estimate_inputs(const Arguments& arguments) {
  const InterruptGuard interrupt;
  // OpenCV tries one video library after the other and prints what each of them lacks; our errors say what matters.
  if (std::getenv("OPENCV_LOG_LEVEL") == nullptr) {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  }
  // Everything that can be refused is looked at before an output is touched.
  const PoseFormat format = format_of(arguments);
  const CameraModel camera = load_camera(arguments.camera);
  const std::vector<PartModel> parts = load_parts(arguments.parts);
  std::optional<Extrinsics> extrinsics;
  if (!arguments.extrinsics.empty()) extrinsics = load_extrinsics(arguments.extrinsics);
  std::optional<ReportRecorder> report;
  if (!arguments.report.empty()) {
    if (arguments.report == "-" && arguments.output == "-") {
      throw Error(ErrorKind::kInput, "--report -: the poses go to standard output; add --output FILE");
    }
    report.emplace(camera, parts, arguments.truth.empty() ? std::vector<TruthRow>() : load_truth(arguments.truth),
                   extrinsics);
  }
  const auto frames = open_frames(arguments.inputs, arguments.frames);
  std::optional<LiveState> live;
  std::optional<LivePage> page;
  if (arguments.serve) {
    live.emplace(camera, parts, extrinsics, facts_of(arguments));
    page.emplace(*live, arguments.serve_address, *arguments.serve);
  }
  const Tell tell = [&live](const std::string& what) {
    fmt::print(stderr, "cylpose: {}\n", what);
    if (live) live->tell(what);
  };
  const auto trace = arguments.trace.empty() ? nullptr : std::make_shared<graph::Trace>(arguments.trace);
  const Prepared run = prepared(arguments, camera, parts, trace, tell);
  std::optional<OverlayWindow> window;
  if (arguments.show) window.emplace("cylpose: q or Escape ends");
  if (report) write_result(arguments.report, "");  // what cannot be written is to fail now, not after a long run

  std::vector<std::string> names;
  names.reserve(parts.size());
  for (const PartModel& part : parts) names.push_back(part.name);
  PoseWriter poses(arguments.output, format, names);
  std::optional<OverlaySink> overlay;
  if (!arguments.overlay.empty()) {
    overlay.emplace(arguments.overlay, frames->fps(), cv::Size(camera.width, camera.height));
  }
  std::optional<PictureFolder> debug;
  if (!arguments.debug_dir.empty()) debug.emplace(arguments.debug_dir);
  std::optional<StageTable> timing;
  if (arguments.timing) timing.emplace();
  Progress progress(frames->size(), arguments.output == "-");

  if (page) {
    page->start();
    progress.message("live page: " + page->url());
  }
  const RunSummary summary =
      run_estimation(*frames, run.make_pipeline, camera, parts,
                     {&poses, extrinsics ? &*extrinsics : nullptr, overlay ? &*overlay : nullptr,
                      window ? &*window : nullptr, debug ? &*debug : nullptr, timing ? &*timing : nullptr,
                      report ? &*report : nullptr, live ? &*live : nullptr, run.cluster, &progress},
                     arguments.live);
  poses.close();
  if (trace) trace->close();
  if (report) write_report(arguments, summary, *report);
  for (const std::string& warning : frames->warnings()) progress.message("warning: " + warning);
  progress.message(summary_text(summary));
  if (timing) fmt::print(stderr, "{}\n{}", timing->text(), nodes_text(summary.pipeline));
  if (page) page->finish();
  if (summary.interrupted) throw CLI::RuntimeError(kInterrupted);
  if (summary.frames > 0 && summary.unreadable == summary.frames) {
    throw Error(ErrorKind::kInput, "none of the images can be read; see the messages above");
  }
}

}  // namespace

void add_estimate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("estimate", "Estimate the poses of coloured cylinders in images.");
  set_examples(
      *command,
      {"cylpose estimate --camera camera.yaml --parts parts.yaml --overlay overlay --output poses.csv video.mp4",
       "cylpose estimate --camera camera.yaml --parts parts.yaml --output poses.csv --report report.html frames/",
       "cylpose estimate --camera camera.yaml --parts parts.yaml --filter --live --serve 8080 /dev/video0"});
  const auto arguments = std::make_shared<Arguments>();
  add_cluster_backend(*command, arguments->cluster);
  command
      ->add_option("--camera", arguments->camera,
                   "Calibration: a camera_info or OpenCV file (YAML); all images must have its size")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--parts", arguments->parts,
                   "The cylinders (YAML): radius and height in metres, hue range; `cylpose tune` makes one")
      ->required()
      ->type_name("FILE");
  command
      ->add_option(
          "--extrinsics", arguments->extrinsics,
          "Where the camera sits on its carrier (YAML: rotation, translation_m); poses are then written in the "
          "carrier's frame (default: camera frame: x right, y down, z forward)")
      ->type_name("FILE");
  command
      ->add_option(
          "--backend", arguments->backend,
          "Who does the per-pixel work; `cylpose devices` lists them (default: opencl where a device is found, else "
          "serial)")
      ->type_name(fmt::format("{}", fmt::join(backend_names(), "|")));
  command
      ->add_option("--device", arguments->device,
                   "OpenCL devices to run on: index, type or part of the name, several with commas, cpu/2 for halves "
                   "(default: $CYLPOSE_DEVICE, or the best)")
      ->type_name("DEVICE");
  command
      ->add_option("--method", arguments->method,
                   fmt::format("`thesis` is the method of the thesis, on OpenCV (default: {})", arguments->method))
      ->type_name(fmt::format("{}", fmt::join(method_names(), "|")));
  command->add_option("-o,--output", arguments->output, "Where the poses go (default: -, standard output)")
      ->type_name("FILE|-");
  command
      ->add_option("--format", arguments->format, "Form of the poses (default: by the extension of --output, or csv)")
      ->type_name("csv|jsonl|tum");
  command->add_option("--overlay", arguments->overlay, "Pictures with the poses drawn in: a folder, or a video file")
      ->type_name("DIR|video.mp4");
  command->add_option("--debug-dir", arguments->debug_dir, "A picture per stage, part and frame")->type_name("DIR");
  CLI::Option* report =
      command->add_option("--report", arguments->report, "The run as one HTML page: tables, plots, pictures")
          ->type_name("FILE.html");
  command->add_option("--truth", arguments->truth, "Compare with this in the report; CSV as for `cylpose evaluate`")
      ->needs(report)
      ->type_name("TRUTH.csv");
  command->add_flag("--timing", arguments->timing, "Print how long each stage takes");
  command->add_flag(
      "--filter", arguments->filter,
      "Filter the poses over time: smoother, and `predicted` while a part is hidden (default: every frame on its own)");
  command->add_flag("--live", arguments->live,
                    "Drop frames that are stale instead of falling behind; recordings play at their own speed");
  command->add_flag("--show", arguments->show, "Show the overlay in a window; q or Escape ends the run");
  CLI::Option* serve =
      command
          ->add_option(
              "--serve", arguments->serve,
              "Show the run while it goes on, on a page for browsers; port 0 is any that is free (default: no page)")
          ->check(CLI::Range(0, 65535).description(""))
          ->type_name("PORT");
  command
      ->add_option("--serve-address", arguments->serve_address,
                   fmt::format("Where to serve it; 0.0.0.0 lets all the network look, without a password (default: {})",
                               arguments->serve_address))
      ->needs(serve)
      ->type_name("ADDRESS");
  command
      ->add_option("--trace", arguments->trace,
                   "Timeline of frames, nodes and device commands for ui.perfetto.dev (Chrome's JSON format)")
      ->type_name("out.json");
  command
      ->add_option("--fps", arguments->frames.fps,
                   fmt::format("Frames per second of images, and of videos that do not say (default: {})",
                               arguments->frames.fps))
      ->type_name("NUMBER");
  command
      ->add_option("INPUT", arguments->inputs,
                   "Images, folders, patterns (frame_%04d.png or a glob), videos, /dev/videoN or camera numbers")
      ->required()
      ->type_name("...");
  command->callback([arguments] { estimate_inputs(*arguments); });
}

}  // namespace cylpose::apps
