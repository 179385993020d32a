// A backend turns a frame into an edge field. All backends do the same; serial defines what "the same" is.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/image.hpp>
#include <cylpose/part.hpp>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

/// Rows [first, end) of a searched region (EdgeField::searched), counted from its first row.
struct Rows {
  int first = 0;
  int end = std::numeric_limits<int>::max();
  friend constexpr bool operator==(const Rows&, const Rows&) = default;
};

/// A strip of a frame comes out as in the whole frame when this many rows on either side are searched with it: erosion
/// and dilation reach 1 row, and then the band around the mask's border or Sobel with suppression 2.
inline constexpr int kStripHalo = 4;

/// Options of the per-pixel stages.
struct DetectOptions {
  /// Gradient of the response, in response levels per pixel, from which an edge pixel is kept as weak. Lower finds
  /// fainter borders and more noise; noise of sigma s in the image gives about 0.5 s. Range 1..edge_high.
  int edge_low = 6;
  /// Gradient from which an edge pixel is strong. Range edge_low..255.
  int edge_high = 16;
  /// Transfer function of the camera, for locating edges in linear light.
  Transfer transfer = Transfer::kSrgb;
  /// Also return the mask of each part: debug pictures and tests, costs one byte a pixel.
  bool with_mask = false;
  /// Report regions and edges of these rows only: for strips of a frame, whose outer rows (kStripHalo) are searched for
  /// the sake of the inner ones. Not together with with_mask.
  Rows rows;
  /// Locate the edges. Off, offset_256 stays 0: where an edge lies depends on the part's colour in the whole frame, so
  /// the edges of strips are put together and then located (locate.hpp).
  bool locate = true;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// What Backend::detect is asked for, in one piece.
struct DetectRequest {
  ImageView image;
  Roi search;
  std::span<const PartModel> parts;
  DetectOptions options;
};

/// What is left to do of a detection when the device is done.
class DetectionEnd {
 public:
  virtual ~DetectionEnd() = default;
  DetectionEnd() = default;
  DetectionEnd(const DetectionEnd&) = delete;
  DetectionEnd& operator=(const DetectionEnd&) = delete;

  /// Returns or throws what Backend::detect would have. Once, on any thread; it sorts and sums up, so not on a
  /// driver's.
  [[nodiscard]] virtual EdgeField field() = 0;
};

/// Called once, when DetectionEnd::field will hardly wait: at once, or from a thread of a device's driver, where it
/// must hand over and return. Must not throw.
using OnDetected = std::function<void(std::shared_ptr<DetectionEnd> end)>;

class Backend {
 public:
  virtual ~Backend() = default;
  Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;

  [[nodiscard]] virtual std::string_view name() const = 0;

  /// Searches `search` (cut to the image) for all parts in one pass. Pixels outside `search` do not exist: the border
  /// rules of the stages (docs/algorithm.md) apply at its edge. May be called from several threads at once.
  /// The parts must be valid (PartModel::is_valid). Throws Error(kInput) for an unusable image or options,
  /// Error(kDevice) when the device fails.
  [[nodiscard]] virtual EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                         const DetectOptions& options) = 0;

  /// The same without a thread that waits for a device. Image and parts must live until DetectionEnd::field has
  /// returned or the end is destroyed, the backend too. Failures come out of field(). Backends whose detect works on
  /// the calling thread leave all of it to field().
  virtual void detect_async(const DetectRequest& request, const OnDetected& done);
};

/// What every backend does first: the part of `search` that lies in the image. Throws Error(kInput) for an unusable
/// image or options.
[[nodiscard]] Roi usable_search(const ImageView& image, const Roi& search, const DetectOptions& options);

struct BackendInfo {
  std::string name;
  std::string description;
  std::function<std::unique_ptr<Backend>()> make;
};

/// All known backends, in order of registration; `serial` is always there.
[[nodiscard]] std::vector<BackendInfo> backends();

/// Makes a backend known by name, so that libraries above host can add theirs. Throws Error(kInput) for a name taken.
void register_backend(BackendInfo info);

/// Throws Error(kInput) that lists the known names.
[[nodiscard]] std::unique_ptr<Backend> make_backend(std::string_view name);

}  // namespace cylpose
