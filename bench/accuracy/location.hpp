// How well single edges are located: bias and scatter beside the Cramer-Rao bound, one influence after the other.
#pragma once

#include <cylpose/render.hpp>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/slanted_edge.hpp"

namespace cylpose::bench {

/// A picture of one straight border, in several orientations and phases.
struct LocationCase {
  std::string factor;  ///< what is varied, "contrast"
  std::string level;   ///< "50"
  testing::SlantedEdge edge;
  bool null_channel = true;  ///< there is a channel in which the part is zero and the background is not
  NoiseKind noise_kind = NoiseKind::kGaussian;
  bool gamma_2_2 = false;
  double sharpening = 0;
  bool chroma_420 = false;
  std::vector<double> angles_deg;  ///< of the inward normal; empty: the whole circle
  std::vector<double> phases_px;   ///< of a picture each; empty: five within a pixel
};

struct Location {
  std::string factor, level;
  bool null_channel = true;
  double bias_px = 0;           ///< mean distance of the located points from the border, positive inside
  double mean_abs_bias_px = 0;  ///< mean over the orientations of the absolute bias of one
  double worst_bias_px = 0;     ///< the largest of them
  double sigma_px = 0;          ///< scatter of single points about the mean of their orientation
  double pooled_px = 0;  ///< scatter of the mean over a picture, times the root of the number of rows or columns that
                         ///< its points come from: what counts for a line fitted to points that share pixels
  double bound_px = 0;   ///< the least scatter possible of points that share none
  int points = 0;
};

/// The influences, each varied from the usual: red before grey of 100 codes more in green and blue, noise 2, blur 0.8
/// px.
[[nodiscard]] std::vector<LocationCase> location_cases();

/// Level of LocationCase with the usual values.
inline constexpr const char* kUsual = "usual";

/// The least standard deviation, pixels along the normal, of an unbiased estimate of the place of one edge pixel's
/// border: from the pixels of one row (or column) across it, all channels, everything but the place known, noise as
/// given and the rounding to whole codes. An estimate that also looks at neighbouring rows may scatter less; a line
/// through many such points may not, which is what Location::pooled_px tells.
[[nodiscard]] double edge_bound(const LocationCase& location_case, double angle_deg);

/// Detects with the serial backend. `fine`: twelve orientations and five phases instead of four and three. Throws
/// Error(kInput) where an orientation has too few points to speak of.
[[nodiscard]] Location measured(const LocationCase& location_case, bool fine);

[[nodiscard]] std::string text_of(std::span<const Location> locations);
[[nodiscard]] std::string csv_of(std::span<const Location> locations);

}  // namespace cylpose::bench
