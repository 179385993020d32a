#include <cylpose/error.hpp>
#include <cylpose/estimator.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "backends.hpp"
#include "bindings.hpp"
#include "images.hpp"
#include "models.hpp"
#include "results.hpp"

namespace cylpose::python {
namespace {

/// An Estimator for any number of Python's threads: one of them at a time.
class LockedEstimator {
 public:
  LockedEstimator(const py::object& camera, const py::iterable& parts, const std::string& backend,
                  const std::string& device) {
    const CameraModel camera_model = camera_of(camera);
    const std::vector<PartModel> part_models = parts_of(parts);
    const py::gil_scoped_release no_gil;
    estimator_ = make_estimator(camera_model, part_models, make_python_backend(backend, device));
  }

  py::tuple estimate(const py::object& image, std::string_view color_order) {
    const ImageView view = view_of_array(image, color_order);
    try {
      const FrameEstimate result = without_gil([&] {
        const std::scoped_lock lock(mutex_);
        return estimator_->estimate(view);
      });
      return to_python(result);
    } catch (const Error& error) {
      // A device that is late may go on reading the image (make_opencl_backend): it stays until the process ends.
      if (error.kind() == ErrorKind::kDevice) image.inc_ref();
      throw;
    }
  }

  void reset() {
    const py::gil_scoped_release no_gil;
    const std::scoped_lock lock(mutex_);
    estimator_->reset();
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<Estimator> estimator_;
};

}  // namespace

void bind_estimator(py::module_& module) {
  py::class_<LockedEstimator>(module, "Estimator")
      .def(py::init<const py::object&, const py::iterable&, const std::string&, const std::string&>(),
           py::arg("camera"), py::arg("parts"), py::arg("backend"), py::arg("device"))
      .def("estimate", &LockedEstimator::estimate, py::arg("image"), py::arg("color_order"))
      .def("reset", &LockedEstimator::reset);
}

}  // namespace cylpose::python
