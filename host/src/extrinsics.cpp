#include <fmt/format.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <cylpose/extrinsics.hpp>
#include <string>
#include <utility>
#include <vector>

#include "text_file.hpp"
#include "text_readers.hpp"
#include "yaml_file.hpp"

namespace cylpose {
namespace {

// Files carry a few digits; what is farther from a rotation than this is something else.
constexpr double kRotationTolerance = 1e-3;

Eigen::Vector3d three_numbers(const YamlValue& value) {
  const auto items = value.items();
  if (items.size() != 3) value.fail(fmt::format("has {} values; give three", items.size()));
  return {items[0].number(), items[1].number(), items[2].number()};
}

Eigen::Matrix3d rotation_from(const YamlValue& value) {
  const auto items = value.items();
  if (items.size() == 4) {
    const Eigen::Quaterniond q(items[3].number(), items[0].number(), items[1].number(), items[2].number());
    if (!(std::abs(q.norm() - 1) < kRotationTolerance)) {
      value.fail(fmt::format("is a quaternion of length {}; give a unit quaternion [x, y, z, w]", q.norm()));
    }
    return q.normalized().toRotationMatrix();
  }
  if (items.size() != 3) {
    value.fail(fmt::format("has {} values; give a quaternion [x, y, z, w] or three rows of three", items.size()));
  }
  Eigen::Matrix3d matrix;
  for (std::size_t row = 0; row < 3; ++row) matrix.row(static_cast<Eigen::Index>(row)) = three_numbers(items[row]);
  const double off = (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off < kRotationTolerance) || matrix.determinant() < 0) {
    value.fail(
        fmt::format("is no rotation (rows off being perpendicular unit vectors by {:.3g}, determinant {:.3g}); "
                    "give the matrix R of x_in_body = R x_in_cam + t",
                    off, matrix.determinant()));
  }
  return Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
}

PoseEstimate in_body(PoseEstimate estimate, const Extrinsics& extrinsics) {
  const Eigen::Matrix3d& turn = extrinsics.body_from_cam;
  CylinderPose& pose = estimate.pose;
  pose.center_in_cam = turn * pose.center_in_cam + extrinsics.cam_in_body;
  pose.axis_in_cam = turn * pose.axis_in_cam;
  pose = with_fixed_sign(pose);
  Eigen::Matrix<double, 6, 6> turn_both = Eigen::Matrix<double, 6, 6>::Zero();
  turn_both.topLeftCorner<3, 3>() = turn;
  turn_both.bottomRightCorner<3, 3>() = turn;
  estimate.covariance = turn_both * estimate.covariance * turn_both.transpose();
  return estimate;
}

}  // namespace

Extrinsics extrinsics_from_yaml(const std::string& name, std::string text) {
  const YamlValue root = YamlValue::from_text(name, std::move(text));
  root.require_keys_among({"rotation", "translation_m"});
  return {rotation_from(root.at("rotation")), three_numbers(root.at("translation_m"))};
}

Extrinsics load_extrinsics(const std::filesystem::path& path) {
  return extrinsics_from_yaml(path.string(), read_file(path, kMaxYamlBytes));
}

FrameEstimate in_body(FrameEstimate estimate, const Extrinsics& extrinsics) {
  for (PoseEstimate& part : estimate.parts) {
    if (part.status != PoseStatus::kNone) part = in_body(std::move(part), extrinsics);
  }
  return estimate;
}

}  // namespace cylpose
