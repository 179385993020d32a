// The extension cylpose_overhead: Estimator::estimate, timed without Python around it.
#include <pybind11/numpy.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <cstdint>
#include <cylpose/estimator.hpp>
#include <filesystem>
#include <memory>
#include <string>

namespace {

namespace py = pybind11;
using Pixels = py::array_t<std::uint8_t, py::array::c_style>;

class TimedEstimator {
 public:
  TimedEstimator(const std::filesystem::path& camera, const std::filesystem::path& parts, const std::string& backend)
      : estimator_(
            cylpose::make_estimator("default", cylpose::load_camera(camera), cylpose::load_parts(parts), backend)) {}

  double estimate_us(const Pixels& image) {
    const cylpose::ImageView view{image.data(), static_cast<int>(image.shape(1)), static_cast<int>(image.shape(0)),
                                  image.strides(0), cylpose::PixelFormat::kBgr8};
    const py::gil_scoped_release no_gil;
    const auto start = std::chrono::steady_clock::now();
    const cylpose::FrameEstimate result = estimator_->estimate(view);
    const std::chrono::duration<double, std::micro> taken = std::chrono::steady_clock::now() - start;
    return taken.count();
  }

 private:
  std::unique_ptr<cylpose::Estimator> estimator_;
};

}  // namespace

PYBIND11_MODULE(cylpose_overhead, module) {
  py::class_<TimedEstimator>(module, "TimedEstimator")
      .def(py::init<const std::filesystem::path&, const std::filesystem::path&, const std::string&>())
      .def("estimate_us", &TimedEstimator::estimate_us);
}
