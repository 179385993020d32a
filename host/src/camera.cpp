#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cylpose/camera.hpp>
#include <cylpose/error.hpp>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "text_file.hpp"
#include "text_readers.hpp"
#include "yaml_file.hpp"

namespace cylpose {
namespace {

struct ModelInfo {
  DistortionModel model;
  const char* name;          ///< in files
  std::size_t fewest, most;  ///< coefficients
};

// The first of several names for a model is the one written.
constexpr std::array kModels = {
    ModelInfo{DistortionModel::kNone, "none", 0, 0},
    ModelInfo{DistortionModel::kPlumbBob, "plumb_bob", 4, 5},
    ModelInfo{DistortionModel::kRational, "rational_polynomial", 8, 8},
    ModelInfo{DistortionModel::kFisheye, "equidistant", 4, 4},
    ModelInfo{DistortionModel::kFisheye, "fisheye", 4, 4},
};

const ModelInfo& info_of(DistortionModel model) {
  return *std::find_if(kModels.begin(), kModels.end(), [&](const ModelInfo& info) { return info.model == model; });
}

/// `data` of a matrix in a calibration file, row by row.
std::vector<double> matrix_data(const YamlValue& matrix, std::string_view expected) {
  const int rows = matrix.at("rows").integer();
  const int cols = matrix.at("cols").integer();
  std::vector<double> data;
  for (const YamlValue& item : matrix.at("data").items()) data.push_back(item.number());
  if (rows < 0 || cols < 0 || static_cast<std::int64_t>(rows) * cols != static_cast<std::int64_t>(data.size())) {
    matrix.fail(fmt::format("rows {} and cols {} do not fit the {} values of data; expected {}", rows, cols,
                            data.size(), expected));
  }
  return data;
}

void read_camera_matrix(const YamlValue& matrix, CameraModel* camera) {
  const std::vector<double> k = matrix_data(matrix, "a 3 x 3 matrix");
  if (matrix.at("rows").integer() != 3 || matrix.at("cols").integer() != 3) {
    matrix.fail(fmt::format("is {} x {}; expected 3 x 3", matrix.at("rows").integer(), matrix.at("cols").integer()));
  }
  // Skew is left out of every lens model that OpenCV calibrates; dropping one silently would bend all poses.
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    matrix.fail(fmt::format("data [{}] is not of the form [fx, 0, cx, 0, fy, cy, 0, 0, 1]", fmt::join(k, ", ")));
  }
  camera->fx = k[0];
  camera->fy = k[4];
  camera->cx = k[2];
  camera->cy = k[5];
}

/// OpenCV's files do not name the model; it follows from the number of coefficients or from its own fisheye flag.
const ModelInfo& guessed_model(const YamlValue& root, std::size_t coefficients) {
  if (root.has("fisheye_model") && root.at("fisheye_model").integer() != 0) return info_of(DistortionModel::kFisheye);
  return info_of(coefficients > 5 ? DistortionModel::kRational : DistortionModel::kPlumbBob);
}

const ModelInfo& named_model(const YamlValue& name) {
  const std::string text = name.text();
  const auto known =
      std::find_if(kModels.begin(), kModels.end(), [&](const ModelInfo& info) { return info.name == text; });
  if (known == kModels.end()) {
    std::vector<std::string_view> names;
    names.reserve(kModels.size());
    for (const ModelInfo& info : kModels) names.emplace_back(info.name);
    name.fail(fmt::format("unknown lens model '{}'; known: {}", text, fmt::join(names, ", ")));
  }
  return *known;
}

void read_distortion(const YamlValue& root, CameraModel* camera) {
  const bool named = root.has("distortion_model");
  if (named && named_model(root.at("distortion_model")).model == DistortionModel::kNone &&
      !root.has("distortion_coefficients")) {
    return;
  }
  const YamlValue matrix = root.at("distortion_coefficients");
  std::vector<double> coefficients = matrix_data(matrix, "one row of coefficients");
  const ModelInfo& info = named ? named_model(root.at("distortion_model")) : guessed_model(root, coefficients.size());
  // OpenCV pads with zeros for the terms that were not calibrated (12 or 14 coefficients).
  while (coefficients.size() > info.most && coefficients.back() == 0) coefficients.pop_back();
  if (coefficients.size() < info.fewest || coefficients.size() > info.most) {
    const std::string wanted =
        info.fewest == info.most ? fmt::format("{}", info.most) : fmt::format("{} to {}", info.fewest, info.most);
    matrix.fail(
        fmt::format("has {} coefficients; lens model {} takes {}", matrix_data(matrix, "").size(), info.name, wanted));
  }
  if (std::all_of(coefficients.begin(), coefficients.end(), [](double k) { return k == 0; }) &&
      info.model != DistortionModel::kFisheye) {
    return;  // all zero is no distortion, except for the fisheye, whose image is theta and not tan theta even then
  }
  camera->distortion_model = info.model;
  camera->distortion = std::move(coefficients);
}

Transfer transfer_from(const YamlValue& value) {
  const std::string text = value.text();
  if (text == "srgb") return Transfer::kSrgb;
  if (text == "linear") return Transfer::kLinear;
  value.fail(fmt::format("unknown transfer '{}'; write srgb or linear", text));
}

/// OpenCV's radial and tangential models; k1 k2 p1 p2 k3 k4 k5 k6 with missing ones zero.
Eigen::Vector2d distorted_polynomial(const std::vector<double>& k, const Eigen::Vector2d& ray) {
  const auto coefficient = [&](std::size_t i) { return i < k.size() ? k[i] : 0.0; };
  const double u = ray.x();
  const double v = ray.y();
  const double r2 = u * u + v * v;
  const double radial = (1 + r2 * (coefficient(0) + r2 * (coefficient(1) + r2 * coefficient(4)))) /
                        (1 + r2 * (coefficient(5) + r2 * (coefficient(6) + r2 * coefficient(7))));
  const double p1 = coefficient(2);
  const double p2 = coefficient(3);
  return {u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u), v * radial + p1 * (r2 + 2 * v * v) + 2 * p2 * u * v};
}

Eigen::Vector2d distorted_fisheye(const std::vector<double>& k, const Eigen::Vector2d& ray) {
  const double r = ray.norm();
  if (r == 0) return ray;
  const double theta = std::atan(r);
  const double t2 = theta * theta;
  const double theta_d = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  return ray * (theta_d / r);
}

}  // namespace

bool CameraModel::is_valid(std::string* why) const {
  const auto refuse = [&](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  constexpr int kMaxSide = std::numeric_limits<std::int16_t>::max();
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    return refuse(fmt::format("image size {} x {} is not within 1..{} pixels a side", width, height, kMaxSide));
  }
  const std::pair<const char*, double> numbers[] = {{"fx", fx}, {"fy", fy}, {"cx", cx}, {"cy", cy}};
  for (const auto& [key, value] : numbers) {
    if (!std::isfinite(value)) return refuse(fmt::format("{} is {}; give a finite number", key, value));
  }
  if (fx == 0 || fy == 0) {
    return refuse("focal length is 0, which means uncalibrated; calibrate the camera first");
  }
  if (fx < 0 || fy < 0) return refuse(fmt::format("focal length {}, {} is negative; give pixels above 0", fx, fy));
  const ModelInfo& info = info_of(distortion_model);
  if (distortion.size() < info.fewest || distortion.size() > info.most) {
    return refuse(fmt::format("{} distortion coefficients do not fit the lens model {}", distortion.size(), info.name));
  }
  if (!std::all_of(distortion.begin(), distortion.end(), [](double k) { return std::isfinite(k); })) {
    return refuse(fmt::format("distortion coefficients [{}] are not all finite", fmt::join(distortion, ", ")));
  }
  return true;
}

CameraModel camera_from_yaml(const std::string& name, std::string text) {
  const YamlValue root = YamlValue::from_text(name, std::move(text));
  CameraModel camera;
  camera.width = root.at("image_width").integer();
  camera.height = root.at("image_height").integer();
  read_camera_matrix(root.at("camera_matrix"), &camera);
  read_distortion(root, &camera);
  if (root.has("transfer")) camera.transfer = transfer_from(root.at("transfer"));
  std::string why;
  if (!camera.is_valid(&why)) {
    const bool focal_length = why.starts_with("focal");
    (focal_length ? root.at("camera_matrix") : root).fail(why);
  }
  return camera;
}

CameraModel load_camera(const std::filesystem::path& path) {
  return camera_from_yaml(path.string(), read_file(path, kMaxYamlBytes));
}

void save_camera(const CameraModel& camera, const std::filesystem::path& path) {
  // camera_info has no name for "no distortion"; a plumb_bob of zeros is what its readers understand.
  const bool none = camera.distortion_model == DistortionModel::kNone;
  const std::vector<double> coefficients = none ? std::vector<double>(5, 0.0) : camera.distortion;
  write_file(path,
             fmt::format("image_width: {}\nimage_height: {}\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
                         "  data: [{}, 0, {}, 0, {}, {}, 0, 0, 1]\ndistortion_model: {}\n"
                         "distortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\ntransfer: {}\n",
                         camera.width, camera.height, camera.fx, camera.cx, camera.fy, camera.cy,
                         info_of(none ? DistortionModel::kPlumbBob : camera.distortion_model).name, coefficients.size(),
                         fmt::join(coefficients, ", "), camera.transfer == Transfer::kSrgb ? "srgb" : "linear"));
}

Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& point_in_cam) {
  Eigen::Vector2d ray = point_in_cam.head<2>() / point_in_cam.z();
  switch (camera.distortion_model) {
    case DistortionModel::kNone:
      break;
    case DistortionModel::kPlumbBob:
    case DistortionModel::kRational:
      ray = distorted_polynomial(camera.distortion, ray);
      break;
    case DistortionModel::kFisheye:
      ray = distorted_fisheye(camera.distortion, ray);
      break;
  }
  return {camera.fx * ray.x() + camera.cx, camera.fy * ray.y() + camera.cy};
}

std::vector<Eigen::Vector2d> undistorted(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels) {
  std::vector<Eigen::Vector2d> rays(pixels.size());
  if (pixels.empty()) return rays;
  if (camera.distortion_model == DistortionModel::kNone) {
    std::transform(pixels.begin(), pixels.end(), rays.begin(), [&](const Eigen::Vector2d& pixel) {
      return Eigen::Vector2d((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
    });
    return rays;
  }
  std::vector<cv::Point2d> points(pixels.size());
  std::transform(pixels.begin(), pixels.end(), points.begin(),
                 [](const Eigen::Vector2d& pixel) { return cv::Point2d(pixel.x(), pixel.y()); });
  const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  // OpenCV's default of 5 (10) iterations leaves errors of some hundredths of a pixel at the corners of wide lenses.
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10);
  std::vector<cv::Point2d> results;
  if (camera.distortion_model == DistortionModel::kFisheye) {
    cv::fisheye::undistortPoints(points, results, k, camera.distortion, cv::noArray(), cv::noArray(), criteria);
  } else {
    cv::undistortPoints(points, results, k, camera.distortion, cv::noArray(), cv::noArray(), criteria);
  }
  std::transform(results.begin(), results.end(), rays.begin(),
                 [](const cv::Point2d& point) { return Eigen::Vector2d(point.x, point.y); });
  return rays;
}

}  // namespace cylpose
