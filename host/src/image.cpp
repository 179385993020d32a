#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/image.hpp>
#include <limits>
#include <string>

namespace cylpose {

Roi intersection(const Roi& a, const Roi& b) {
  const int x = std::max(a.x, b.x);
  const int y = std::max(a.y, b.y);
  const Roi both{x, y, std::min(a.right(), b.right()) - x, std::min(a.bottom(), b.bottom()) - y};
  return both.empty() ? Roi{} : both;
}

Roi united(const Roi& a, const Roi& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  const int x = std::min(a.x, b.x);
  const int y = std::min(a.y, b.y);
  return {x, y, std::max(a.right(), b.right()) - x, std::max(a.bottom(), b.bottom()) - y};
}

Roi enlarged(const Roi& roi, double fraction, int width, int height) {
  const int dx = static_cast<int>(std::ceil(roi.width * fraction / 2));
  const int dy = static_cast<int>(std::ceil(roi.height * fraction / 2));
  return intersection({roi.x - dx, roi.y - dy, roi.width + 2 * dx, roi.height + 2 * dy}, {0, 0, width, height});
}

void require_usable(const ImageView& image) {
  constexpr int kMaxSide = std::numeric_limits<std::int16_t>::max();
  if (image.data == nullptr || image.width < 1 || image.height < 1) {
    throw Error(ErrorKind::kInput, "image is empty");
  }
  if (image.width > kMaxSide || image.height > kMaxSide) {
    throw Error(ErrorKind::kInput, "image of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                                       " pixels is too large; at most " + std::to_string(kMaxSide) + " a side");
  }
  if (image.stride < static_cast<std::ptrdiff_t>(image.width) * bytes_per_pixel(image.format)) {
    throw Error(ErrorKind::kInput, "image stride of " + std::to_string(image.stride) +
                                       " bytes does not hold a row of " + std::to_string(image.width) + " pixels");
  }
}

}  // namespace cylpose
