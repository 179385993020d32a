#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <cylpose/default_backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/evaluate.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core/utils/logger.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "estimate_run.hpp"
#include "interrupt.hpp"

namespace cylpose::apps {
namespace {

struct Arguments {
  std::string camera;
  std::string parts;
  std::string backend;
  std::string device;
  std::string method = "default";
  std::string output = "-";
  std::string format;
  std::string overlay;
  std::string debug_dir;
  bool timing = false;
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
std::unique_ptr<Backend> backend_for(const Arguments& arguments) {
  if (!arguments.device.empty() && !arguments.backend.empty() && arguments.backend != "opencl") {
    throw Error(ErrorKind::kInput, fmt::format("--device {}: only the backend opencl runs on devices; leave out "
                                               "--backend {}",
                                               arguments.device, arguments.backend));
  }
  OpenclOptions options;
  options.device = arguments.device;
  options.profile = arguments.timing;
  options.on_device_lost = [](const OpenclDevice& device, const std::string& why) {
    fmt::print(stderr, "cylpose: warning: going on without {}: {}\n", device.name, why);
  };
  if (arguments.backend == "opencl" || !arguments.device.empty()) return make_opencl_backend(options);
  if (!arguments.backend.empty()) return make_backend(arguments.backend);
  DefaultBackend chosen = make_default_backend(options);
  if (!chosen.note.empty()) fmt::print(stderr, "cylpose: {}\n", chosen.note);
  return std::move(chosen.backend);
}

std::unique_ptr<Estimator> estimator_for(const Arguments& arguments, const CameraModel& camera,
                                         const std::vector<PartModel>& parts) {
  if (arguments.method == "default") return make_estimator(camera, parts, backend_for(arguments));
  const bool on_device = arguments.backend.empty() && !arguments.device.empty();
  return make_estimator(arguments.method, camera, parts, on_device ? "opencl" : arguments.backend);
}

std::string summary_text(const RunSummary& summary) {
  const auto rms = statistics_of(summary.rms_px);
  std::string text = fmt::format("{} frames, {} of {} poses found", summary.frames, summary.found, summary.poses);
  if (summary.unreadable > 0) text += fmt::format(", {} frames unreadable", summary.unreadable);
  if (rms) text += fmt::format(", median rms {:.3f} px", rms->median);
  if (summary.seconds > 0)
    text += fmt::format(", {:.1f} frames/s", static_cast<double>(summary.frames) / summary.seconds);
  if (summary.interrupted) text += "; interrupted, everything up to here is written";
  return text;
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
  const auto estimator = estimator_for(arguments, camera, parts);
  const auto frames = open_frames(arguments.inputs, arguments.frames);

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

  const RunSummary summary = run_estimation(
      *frames, *estimator, camera, parts,
      {&poses, overlay ? &*overlay : nullptr, debug ? &*debug : nullptr, timing ? &*timing : nullptr, &progress});
  poses.close();
  for (const std::string& warning : frames->warnings()) progress.message("warning: " + warning);
  progress.message(summary_text(summary));
  if (timing) fmt::print(stderr, "{}", timing->text());
  if (summary.interrupted) throw CLI::RuntimeError(kInterrupted);
  if (summary.frames > 0 && summary.unreadable == summary.frames) {
    throw Error(ErrorKind::kInput, "none of the images can be read; see the messages above");
  }
}

}  // namespace

void add_estimate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("estimate", "Estimate the poses of coloured cylinders in images.");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("--camera", arguments->camera, "Calibration: YAML of camera_info or of OpenCV")
      ->required()
      ->type_name("FILE");
  command->add_option("--parts", arguments->parts, "The cylinders: YAML with sizes and colours")
      ->required()
      ->type_name("FILE");
  command
      ->add_option(
          "--backend", arguments->backend,
          "Who does the per-pixel work; `cylpose devices` lists them (default: opencl where a device is found, else "
          "serial)")
      ->type_name("NAME");
  command
      ->add_option("--device", arguments->device,
                   "OpenCL devices to run on: index, type or part of the name, several with commas, cpu/2 for halves "
                   "(default: $CYLPOSE_DEVICE, or the best)")
      ->type_name("DEVICE");
  command
      ->add_option("--method", arguments->method,
                   fmt::format("One of: {} (default: {})", fmt::join(method_names(), ", "), arguments->method))
      ->type_name("NAME");
  command->add_option("-o,--output", arguments->output, "Where the poses go; - is standard output (default)")
      ->type_name("FILE|-");
  command
      ->add_option("--format", arguments->format, "csv, jsonl or tum (default: by the extension of --output, or csv)")
      ->type_name("NAME");
  command->add_option("--overlay", arguments->overlay, "Pictures with the poses drawn in: a folder, or a video file")
      ->type_name("DIR|video.mp4");
  command->add_option("--debug-dir", arguments->debug_dir, "A picture per stage, part and frame")->type_name("DIR");
  command->add_flag("--timing", arguments->timing, "Print how long each stage takes");
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
