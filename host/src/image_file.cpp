#include "image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cylpose/error.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>

#include "text_file.hpp"

namespace cylpose {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;

/// Does a JPEG go on to its end-of-image marker? libjpeg fills what is missing with grey and only prints a warning, and
/// half a picture would give a wrong pose, not none.
bool jpeg_is_whole(std::string_view bytes) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  std::size_t at = 2;  // behind the start-of-image marker
  while (at + 1 < bytes.size()) {
    if (byte(at) != 0xFF || byte(at + 1) == 0x00 || byte(at + 1) == 0xFF ||
        (byte(at + 1) >= 0xD0 && byte(at + 1) <= 0xD7)) {
      ++at;  // picture data, an escaped FF in it, padding, or a restart marker
      continue;
    }
    if (byte(at + 1) == 0xD9) return true;
    if (at + 3 >= bytes.size()) return false;
    at += 2 + static_cast<std::size_t>(byte(at + 2) * 256 + byte(at + 3));  // a segment that states its length
  }
  return false;
}

}  // namespace

void read_image_file(const std::filesystem::path& path, cv::Mat& image) {
  const std::string bytes = read_file(path, kMaxBytes);
  if (bytes.starts_with("\xFF\xD8") && !jpeg_is_whole(bytes)) {
    throw Error(ErrorKind::kInput,
                fmt::format("{}: the JPEG is cut short after {} bytes; copy it again", path.string(), bytes.size()));
  }
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  try {
    cv::imdecode(encoded, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH, &image);
  } catch (const cv::Exception& error) {
    throw Error(ErrorKind::kInput, fmt::format("{}: cannot be decoded: {}", path.string(), error.err));
  }
  if (image.empty()) {
    throw Error(ErrorKind::kInput,
                fmt::format("{}: is no image that can be decoded; is it an image, and whole?", path.string()));
  }
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1.0 / 257);  // 65535 becomes 255
  if (image.depth() != CV_8U) {
    throw Error(ErrorKind::kInput,
                fmt::format("{}: has floating-point pixels; convert it to 8 or 16 bits", path.string()));
  }
}

bool has_image_extension(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 14> kExtensions = {".bmp", ".dib", ".jp2", ".jpe", ".jpeg", ".jpg",  ".pbm",
                                                            ".pgm", ".png", ".pnm", ".ppm", ".tif",  ".tiff", ".webp"};
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

}  // namespace cylpose
