// From images to poses, one frame at a time, the search region carried from frame to frame.
#pragma once

#include <Eigen/Core>
#include <cylpose/backend.hpp>
#include <cylpose/camera.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose {

/// What the stages saw of one part, in pixels of the ideal camera (camera.hpp); for debug pictures and tests.
struct PartTrace {
  Mask mask;
  std::vector<Eigen::Vector2d> edges;                  ///< after hysteresis
  std::vector<std::vector<Eigen::Vector2d>> chains;    ///< ordered, connected
  std::vector<std::vector<Eigen::Vector2d>> segments;  ///< chains cut where they bend
  std::vector<ImageLine> lines;                        ///< fitted and merged
};

struct StageTrace {
  std::vector<PartTrace> parts;
};

class Estimator {
 public:
  virtual ~Estimator() = default;
  Estimator() = default;
  Estimator(const Estimator&) = delete;
  Estimator& operator=(const Estimator&) = delete;

  [[nodiscard]] virtual std::string_view name() const = 0;

  /// The pose of every part in the next frame of the stream. A part that is not found has the status kNone and a
  /// reason. Fills `trace` where one is given. Throws Error(kInput) for an image of another size than the calibration.
  [[nodiscard]] virtual FrameEstimate estimate(const ImageView& image, StageTrace* trace = nullptr) = 0;

  /// Forgets where the parts were: the next frame belongs to another stream and is searched as a whole.
  virtual void reset() = 0;
};

/// Throws Error(kInput) that names both sizes unless the image has the size of the calibration.
void require_calibrated_size(const CameraModel& camera, const ImageView& image);

/// Names of the methods: `default`, and `thesis` (the baseline that everything is measured against).
[[nodiscard]] std::vector<std::string> method_names();

/// Makes an estimator by the name of its method. `backend` names the backend of the per-pixel stages; empty means the
/// method's own choice (`default`: OpenCL where a device works, else serial; see make_default_backend). The thesis's
/// method is defined on OpenCV and takes no other. Throws Error(kInput) for unknown names, an invalid camera or invalid
/// parts.
[[nodiscard]] std::unique_ptr<Estimator> make_estimator(std::string_view method, const CameraModel& camera,
                                                        const std::vector<PartModel>& parts,
                                                        std::string_view backend = {});

/// The default method on a backend with options of its own. Throws like the above.
[[nodiscard]] std::unique_ptr<Estimator> make_estimator(const CameraModel& camera, const std::vector<PartModel>& parts,
                                                        std::unique_ptr<Backend> backend);

}  // namespace cylpose
