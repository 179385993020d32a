#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cylpose/default_backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/estimator.hpp>
#include <cylpose/thesis.hpp>
#include <utility>

#include "builtin_estimators.hpp"

namespace cylpose {

std::vector<std::string> method_names() {
  return {"default", "thesis"};
}

void require_calibrated_size(const CameraModel& camera, const ImageView& image) {
  if (image.width == camera.width && image.height == camera.height) return;
  throw Error(
      ErrorKind::kInput,
      fmt::format("image is {} x {} pixels but the camera was calibrated at {} x {}; use images of that size or "
                  "calibrate again",
                  image.width, image.height, camera.width, camera.height));
}

std::unique_ptr<Estimator> make_estimator(std::string_view method, const CameraModel& camera,
                                          const std::vector<PartModel>& parts, std::string_view backend) {
  if (parts.empty()) throw Error(ErrorKind::kInput, "no part to look for");
  if (method == "default") {
    return make_estimator(camera, parts, backend.empty() ? make_default_backend().backend : make_backend(backend));
  }
  if (method == "thesis") {
    if (!backend.empty() && backend != "opencv") {
      throw Error(ErrorKind::kInput,
                  fmt::format("the thesis's method is defined on OpenCV; leave out the backend '{}'", backend));
    }
    return make_thesis_estimator(camera, parts);
  }
  throw Error(ErrorKind::kInput,
              fmt::format("unknown method '{}'; known: {}", method, fmt::join(method_names(), ", ")));
}

std::unique_ptr<Estimator> make_estimator(const CameraModel& camera, const std::vector<PartModel>& parts,
                                          std::unique_ptr<Backend> backend) {
  if (parts.empty()) throw Error(ErrorKind::kInput, "no part to look for");
  return make_default_estimator(camera, parts, std::move(backend));
}

}  // namespace cylpose
