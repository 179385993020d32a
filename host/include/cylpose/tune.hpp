// The colour settings of a part, suggested from a sample of it in an image.
#pragma once

#include <cylpose/edge_field.hpp>
#include <cylpose/image.hpp>
#include <cylpose/part.hpp>
#include <opencv2/core/mat.hpp>
#include <string>

namespace cylpose {

/// Colour settings as PartModel has them.
struct ColorSuggestion {
  double hue_lo_deg;  ///< whole degrees; lo > hi wraps through 0
  double hue_hi_deg;
  double min_saturation;  ///< hundredths
  double min_value;       ///< hundredths
};

/// Settings that hold the sample's colour with some room for other light: the hues of the sample without its most
/// distant fiftieth on either side, widened by half that range and at least 6 degrees on both; three quarters of the
/// saturation and half of the value that all but a fiftieth of the sample have.
/// Throws Error(kInput) for an unusable or grey image, a sample that is empty or not inside the image, has no hue
/// (grey, white or black) or more than one.
[[nodiscard]] ColorSuggestion suggest_color(const ImageView& image, const Roi& sample);

/// `part` as a parts file that load_parts reads. A radius or height of 0 is written as a place to fill in, with a
/// comment that says so; load_parts refuses it until that is done.
[[nodiscard]] std::string parts_file_text(const PartModel& part);

/// Two pictures side by side: the image with the sample's rectangle, and the image darkened where the mask is not set.
/// BGR whatever the image's format. The mask must cover the image.
[[nodiscard]] cv::Mat mask_picture(const ImageView& image, const Mask& mask, const Roi& sample);

}  // namespace cylpose
