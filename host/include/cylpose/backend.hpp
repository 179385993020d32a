// A backend turns a frame into an edge field. All backends do the same; serial defines what "the same" is.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/image.hpp>
#include <cylpose/part.hpp>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

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

  [[nodiscard]] bool is_valid(std::string* why) const;
};

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
