// Frames from image files, folders, patterns, videos and cameras, as one stream.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cylpose {

/// One frame of a stream. A file that cannot be decoded is still a frame, with `error` set: the stream goes on, and
/// frame numbers stay those of the files.
struct Frame {
  std::int64_t index = 0;  ///< from 0, counted over all inputs
  /// Seconds from the first frame. Videos: position by the file's frame rate; images: index / FrameSourceOptions::fps;
  /// cameras: the clock's.
  double timestamp_s = 0;
  std::string name;   ///< file, or file and number of the frame, for messages
  cv::Mat image;      ///< 8-bit, 1 (grey) or 3 (BGR) channels; empty when `error` is set
  std::string error;  ///< why there is no image: names the file and the remedy
};

struct FrameSourceOptions {
  /// Frames per second of image files, and of videos that do not say. Range: above 0.
  double fps = 30;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  /// The next frame; none at the end. Each frame has pixels of its own. Throws Error(kDevice) when a camera fails.
  [[nodiscard]] virtual std::optional<Frame> next() = 0;

  /// Number of frames in all, where it can be known beforehand (a video's header may be wrong).
  [[nodiscard]] virtual std::optional<std::int64_t> size() const = 0;

  /// Frames per second as the input states it, or FrameSourceOptions::fps where it does not.
  [[nodiscard]] virtual double fps() const = 0;

  /// What the user should know about the frames so far, such as a video that ended early. Empty when all is well.
  [[nodiscard]] virtual std::vector<std::string> warnings() const = 0;
};

/// Opens inputs one after the other as one stream. An input is
///  - an image file (8-bit or 16-bit, which is scaled to 8; an alpha channel is dropped),
///  - a folder: its image files, in natural order (frame_9 before frame_10),
///  - a pattern with one printf integer (`frame_%04d.png`): the files that exist, by number, or a glob (`*.png`), in
///    natural order,
///  - a video file,
///  - a camera: its device file (`/dev/video0`) or number.
/// Throws Error(kInput) for an input that is missing or matches nothing, Error(kDevice) for a camera that cannot be
/// opened.
[[nodiscard]] std::unique_ptr<FrameSource> open_frames(const std::vector<std::string>& inputs,
                                                       const FrameSourceOptions& options = {});

/// The image files that open_frames would read, in its order, without reading them. Throws Error(kInput) like
/// open_frames, and for videos and cameras.
[[nodiscard]] std::vector<std::string> image_files(const std::vector<std::string>& inputs);

}  // namespace cylpose
