#include "results.hpp"

#include <pybind11/numpy.h>

#include <cylpose/overlay.hpp>
#include <cylpose/pose_io.hpp>
#include <limits>
#include <string_view>
#include <tuple>
#include <vector>

#include "bindings.hpp"
#include "fields.hpp"
#include "images.hpp"
#include "models.hpp"
#include "text.hpp"

namespace cylpose::python {
namespace {

using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
/// Per side of the cylinder: its line's normal (x, y) and distance.
using Sides = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <typename Matrix>
py::array_t<double> array(const Matrix& matrix) {
  if constexpr (Matrix::ColsAtCompileTime == 1) {
    return py::array_t<double>(matrix.size(), matrix.data());
  } else {
    static_assert(Matrix::IsRowMajor);
    return py::array_t<double>({matrix.rows(), matrix.cols()}, matrix.data());
  }
}

py::tuple to_python(const PoseEstimate& part) {
  PoseRow row = pose_row(0, 0, {}, part);
  RowMajor6 covariance = part.covariance;
  Sides sides;
  for (Eigen::Index i = 0; i < 2; ++i) {
    const ImageLine& side = part.sides.at(static_cast<std::size_t>(i));
    sides.row(i) << side.normal.x(), side.normal.y(), side.distance;
  }
  if (part.status == PoseStatus::kNone) {
    row.pose.center_in_cam.setConstant(kNan);
    row.pose.axis_in_cam.setConstant(kNan);
    row.sigma_center_m.setConstant(kNan);
    row.sigma_axis_deg = row.rms_px = kNan;
    covariance.setConstant(kNan);
    sides.setConstant(kNan);
  }
  return py::make_tuple(python_text(to_string(part.status)), python_text(row.reason), array(row.pose.center_in_cam),
                        array(row.pose.axis_in_cam), array(covariance), array(row.sigma_center_m), row.sigma_axis_deg,
                        row.rms_px, part.support, part.seen, array(sides));
}

// A row-major matrix or a column.
template <typename Matrix>
Matrix matrix_field(const py::handle& object, const char* name) {
  using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
  const auto numbers = field<Numbers>(object, name, "an array of numbers");
  if (numbers.size() != Matrix::SizeAtCompileTime) {
    throw py::value_error(fmt::format("{} has {} numbers instead of {}", name, numbers.size(),
                                      static_cast<int>(Matrix::SizeAtCompileTime)));
  }
  return Eigen::Map<const Matrix>(numbers.data());
}

PoseStatus status_from(std::string_view word) {
  for (const PoseStatus status : {PoseStatus::kOk, PoseStatus::kPredicted}) {
    if (word == to_string(status)) return status;
  }
  return PoseStatus::kNone;
}

PoseEstimate pose_estimate_of(const py::handle& part) {
  PoseEstimate estimate;
  estimate.status = status_from(field<std::string>(part, "status", "a status"));
  estimate.reason = native_text(field<py::str>(part, "reason", "text"));
  estimate.pose.center_in_cam = matrix_field<Eigen::Vector3d>(part, "center_in_cam");
  estimate.pose.axis_in_cam = matrix_field<Eigen::Vector3d>(part, "axis_in_cam");
  estimate.covariance = matrix_field<RowMajor6>(part, "covariance");
  estimate.rms_px = field<double>(part, "rms_px", "a number");
  estimate.support = field<int>(part, "support", "a whole number");
  estimate.seen = field<double>(part, "seen", "a number");
  const auto sides = matrix_field<Sides>(part, "sides");
  for (Eigen::Index i = 0; i < 2; ++i) {
    estimate.sides.at(static_cast<std::size_t>(i)) = {sides.row(i).head<2>().transpose(), sides(i, 2)};
  }
  return estimate;
}

}  // namespace

py::tuple to_python(const FrameEstimate& estimate) {
  py::tuple parts(estimate.parts.size());
  for (std::size_t i = 0; i < estimate.parts.size(); ++i) parts[i] = to_python(estimate.parts[i]);
  py::dict times;
  for (const StageTime& time : estimate.times) {
    const py::str stage = python_text(time.stage);
    // A stage runs twice in a frame that is searched again.
    times[stage] = time.milliseconds + (times.contains(stage) ? times[stage].cast<double>() : 0);
  }
  const Roi& searched = estimate.searched;
  return py::make_tuple(py::make_tuple(searched.x, searched.y, searched.width, searched.height), parts, times);
}

FrameEstimate frame_estimate_of(const py::object& estimate) {
  FrameEstimate frame;
  const auto [x, y, width, height] =
      field<std::tuple<int, int, int, int>>(estimate, "searched", "(x, y, width, height)");
  frame.searched = {x, y, width, height};
  for (const py::handle part : estimate.attr("parts")) frame.parts.push_back(pose_estimate_of(part));
  return frame;
}

void bind_overlay(py::module_& module) {
  module.def(
      "overlay",
      [](const py::object& image, const py::object& camera, const py::iterable& parts, const py::object& estimate) {
        const ImageView view = view_of_array(image, "bgr");
        const CameraModel camera_model = camera_of(camera);
        const std::vector<PartModel> part_models = parts_of(parts);
        const FrameEstimate frame = frame_estimate_of(estimate);
        return array_on(graph::shared(
            without_gil([&] { return cylpose::overlay(mat_of(view), camera_model, part_models, frame); })));
      },
      py::arg("image"), py::arg("camera"), py::arg("parts"), py::arg("estimate"));
}

}  // namespace cylpose::python
