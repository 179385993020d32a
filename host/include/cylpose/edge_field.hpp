// What a backend finds in a frame: small, whatever the frame's size.
#pragma once

#include <cstdint>
#include <cylpose/image.hpp>
#include <string_view>
#include <vector>

namespace cylpose {

enum class EdgeStrength : std::uint8_t {
  kWeak = 1,    ///< at or above DetectOptions::edge_low: kept where it continues a strong edge
  kStrong = 2,  ///< at or above DetectOptions::edge_high
};

/// What told where a border lies; the errors that neighbours share depend on it (CommonEdgeSigma).
enum class EdgeCue : std::uint8_t {
  kNone = 0,     ///< nothing to rely on: it is taken to be at the pixel's centre, or the part is too thin there
  kShare = 1,    ///< the background's share of the light, whatever the part's shading
  kLimb = 2,     ///< how the part's own light falls off toward the border, which depends on the shading
  kSlope = 3,    ///< where that light changes most
  kClipped = 4,  ///< the share of a background that is brighter than the sensor takes: the border lies farther out
};

/// One pixel on the border between the part's colour and anything else.
struct EdgePixel {
  std::int16_t x;   ///< column in the frame
  std::int16_t y;   ///< row in the frame
  std::int16_t gx;  ///< Sobel gradient of the response at the pixel; it points into the part
  std::int16_t gy;
  /// Where the border lies from the pixel's centre, along the unit gradient (positive: further inside), in 1/256 pixel.
  std::int16_t offset_256;
  EdgeStrength strength;
  EdgeCue cue = EdgeCue::kNone;
  friend bool operator==(const EdgePixel&, const EdgePixel&) = default;
};

/// Raw moments M_ij = sum of x^i y^j over the mask in frame coordinates, and what follows from them.
struct RegionStatistics {
  std::int64_t m00 = 0;  ///< pixels in the mask
  std::int64_t m10 = 0, m01 = 0;
  std::int64_t m20 = 0, m11 = 0, m02 = 0;
  Roi box;  ///< bounding box of the mask; empty when the mask is

  void add(int x, int y);  ///< one more mask pixel; `box` is not touched

  [[nodiscard]] double mean_x() const;           ///< pixels; requires m00 > 0
  [[nodiscard]] double mean_y() const;           ///< pixels; requires m00 > 0
  [[nodiscard]] double orientation_rad() const;  ///< of the long axis from +x toward +y, (-pi/2, pi/2]; thesis eq. 5.2
  [[nodiscard]] double eccentricity()
      const;  ///< lambda_min / lambda_max of the covariance, 0 (line) to 1 (disc); eq. 5.3
  friend bool operator==(const RegionStatistics&, const RegionStatistics&) = default;
};

/// One byte a pixel, 0 or 255, of `EdgeField::searched`.
struct Mask {
  Roi roi;
  std::vector<std::uint8_t> pixels;  ///< roi.height rows of roi.width bytes
};

struct PartEdges {
  RegionStatistics region;       ///< of the mask after erosion and dilation
  std::vector<EdgePixel> edges;  ///< in row-major order of the pixels
  Mask mask;                     ///< empty unless DetectOptions::with_mask
};

/// Wall time of one stage, for --timing and the bench.
struct StageTime {
  std::string_view stage;  ///< a string literal
  double milliseconds;
  double before_end_ms = 0;  ///< of a device's command: how long before the end of the frame's last one it began
};

struct EdgeField {
  Roi searched;
  std::vector<PartEdges> parts;  ///< one per part, in the order of the request
  std::vector<StageTime> times;
};

}  // namespace cylpose
