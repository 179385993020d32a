#include <fmt/format.h>

#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <cylpose/sequence.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <system_error>

#include "portable_random.hpp"
#include "text_file.hpp"

namespace cylpose {
namespace {

constexpr int kMaxFrames = 10000;

class Video {
 public:
  Video(const std::filesystem::path& folder, double rate_hz, const CameraModel& camera) {
    const cv::Size size(camera.width, camera.height);
    path_ = folder / "video.mp4";
    writer_.open(path_.string(), cv::CAP_ANY, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), rate_hz, size);
    if (!writer_.isOpened()) {
      path_ = folder / "video.avi";
      writer_.open(path_.string(), cv::CAP_ANY, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate_hz, size);
    }
    if (!writer_.isOpened()) {
      throw Error(ErrorKind::kOutput, fmt::format("cannot write a video into {}: OpenCV has no writer for MPEG-4 or "
                                                  "Motion JPEG, or the folder cannot be written; leave --video out",
                                                  folder.string()));
    }
  }

  void write(const cv::Mat& image) { writer_.write(image); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  cv::VideoWriter writer_;
};

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder)) {
    throw Error(ErrorKind::kOutput, fmt::format("cannot make the folder {}: {}; give another --output", folder.string(),
                                                error ? error.message() : "a file of that name is there"));
  }
}

void write_image(const cv::Mat& image, const std::filesystem::path& path) {
  bool written = false;
  std::string reason = "disk full, or no permission?";
  try {
    written = cv::imwrite(path.string(), image);
  } catch (const cv::Exception& error) {
    reason = error.what();
  }
  if (!written) throw Error(ErrorKind::kOutput, fmt::format("cannot write {}: {}", path.string(), reason));
}

// As text; without the sign of a zero, which says nothing and differs with the way it was computed.
std::string nine_digits(double value) {
  return fmt::format("{:.9f}", std::round(value * 1e9) / 1e9 + 0.0);
}

std::filesystem::path frame_path(const std::filesystem::path& folder, int frame) {
  return folder / fmt::format("frame_{:04d}.png", frame);
}

// Frames of an earlier, longer sequence would be taken for frames of this one.
void remove_frames_from(int frame, const std::filesystem::path& folder) {
  std::error_code error;
  while (std::filesystem::remove(frame_path(folder, frame), error)) ++frame;
  if (error) {
    throw Error(ErrorKind::kOutput, fmt::format("cannot remove {}, which is left from an earlier sequence: {}; give "
                                                "another --output",
                                                frame_path(folder, frame).string(), error.message()));
  }
}

}  // namespace

void save_truth(const std::vector<CylinderPose>& poses, const std::filesystem::path& path) {
  std::string text = "frame,cx,cy,cz,ax,ay,az\n";
  for (std::size_t frame = 0; frame < poses.size(); ++frame) {
    const CylinderPose pose = with_fixed_sign(poses[frame]);
    const Eigen::Vector3d& c = pose.center_in_cam;
    const Eigen::Vector3d& a = pose.axis_in_cam;
    text += fmt::format("{},{},{},{},{},{},{}\n", frame, nine_digits(c.x()), nine_digits(c.y()), nine_digits(c.z()),
                        nine_digits(a.x()), nine_digits(a.y()), nine_digits(a.z()));
  }
  write_file(path, text);
}

bool SequenceOptions::is_valid(std::string* why) const {
  if (frames < 1 || frames > kMaxFrames) {
    if (why != nullptr) *why = fmt::format("{} frames is not within 1 to {}", frames, kMaxFrames);
    return false;
  }
  return DegradeOptions{blur_sigma_px, noise_sigma, Transfer::kSrgb, seed}.is_valid(why);
}

SequenceOptions default_options(const Scenario& scenario) {
  SequenceOptions options;
  options.frames = scenario.frames;
  options.blur_sigma_px = scenario.blur_sigma_px;
  options.noise_sigma = scenario.noise_sigma;
  return options;
}

cv::Mat sequence_frame(const Scenario& scenario, const SequenceOptions& options, int frame) {
  const std::uint64_t seed = mixed(options.seed + mixed(static_cast<std::uint64_t>(frame)));
  return degrade(render(scenario.scene(frame, options.frames)),
                 {options.blur_sigma_px, options.noise_sigma, scenario.camera.transfer, seed});
}

std::vector<std::filesystem::path> write_sequence(const Scenario& scenario, const SequenceOptions& options,
                                                  const std::filesystem::path& folder,
                                                  const std::function<bool(int)>& progress) {
  std::string why;
  if (!options.is_valid(&why)) throw Error(ErrorKind::kInput, why);
  make_folder(folder);
  std::vector<std::filesystem::path> files = {folder / "truth.csv", folder / "camera.yaml", folder / "parts.yaml"};
  save_camera(scenario.camera, files[1]);
  save_parts(scenario.parts, files[2]);
  std::optional<Video> video;
  if (options.video) {
    video.emplace(folder, scenario.rate_for(options.frames), scenario.camera);
    files.push_back(video->path());
  }
  std::vector<CylinderPose> truth;
  for (int frame = 0; frame < options.frames; ++frame) {
    const cv::Mat image = sequence_frame(scenario, options, frame);
    write_image(image, frame_path(folder, frame));
    if (video) video->write(image);
    truth.push_back(scenario.scene(frame, options.frames).parts.at(0).cylinder.pose);
    if (!progress(frame + 1)) break;
  }
  remove_frames_from(static_cast<int>(truth.size()), folder);
  save_truth(truth, files[0]);
  return files;
}

}  // namespace cylpose
