// Image files as 8-bit images.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace cylpose {

/// Decodes an image file into `image`, in memory of its allocator: to 8 bits and one (grey) or three (BGR) channels;
/// 16-bit codes are scaled, alpha is dropped, the EXIF orientation is applied. Throws Error(kInput) that names the file
/// for what is missing, empty, no image, cut short, or of another depth.
void read_image_file(const std::filesystem::path& path, cv::Mat& image);

/// True for the extensions of the formats that read_image_file is known to read.
[[nodiscard]] bool has_image_extension(const std::filesystem::path& path);

}  // namespace cylpose
