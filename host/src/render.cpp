#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cylpose/error.hpp>
#include <cylpose/render.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "portable_random.hpp"
#include "scene_tracer.hpp"

namespace cylpose {
namespace {

// Rays (u, v, 1) of a camera without distortion.
class PinholeRays {
 public:
  explicit PinholeRays(const CameraModel& camera)
      : step_u_(1 / camera.fx), step_v_(1 / camera.fy), center_x_(camera.cx), center_y_(camera.cy) {}

  // `right` and `down` from the pixel's centre, -0.5..0.5.
  [[nodiscard]] Eigen::Vector2d at(int x, int y, double right, double down) const {
    return {(x + right - center_x_) * step_u_, (y + down - center_y_) * step_v_};
  }

 private:
  double step_u_, step_v_, center_x_, center_y_;
};

// Rays (u, v, 1) of a camera whose lens distorts: the corners of all pixels are undistorted once, and inside a pixel
// the rays run bilinearly between them; over one pixel a lens is that smooth (better than 1e-4 px).
class LensRays {
 public:
  explicit LensRays(const CameraModel& camera) : columns_(static_cast<std::size_t>(camera.width) + 1) {
    std::vector<Eigen::Vector2d> corners;
    corners.reserve(columns_ * (static_cast<std::size_t>(camera.height) + 1));
    for (int y = 0; y <= camera.height; ++y) {
      for (int x = 0; x <= camera.width; ++x) corners.emplace_back(x - 0.5, y - 0.5);
    }
    rays_ = undistorted(camera, corners);
  }

  [[nodiscard]] Eigen::Vector2d at(int x, int y, double right, double down) const {
    const std::size_t corner = static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x);
    const double a = right + 0.5;
    const double b = down + 0.5;
    return (1 - b) * ((1 - a) * rays_[corner] + a * rays_[corner + 1]) +
           b * ((1 - a) * rays_[corner + columns_] + a * rays_[corner + columns_ + 1]);
  }

 private:
  std::size_t columns_;
  std::vector<Eigen::Vector2d> rays_;
};

// A low-discrepancy set of places in a pixel: the Fibonacci lattice, best possible for its number of points. Every
// pixel shifts it (modulo 1) by its own random amount: the mean over the places then has no bias, and neighbouring
// pixels of one edge do not err alike, which a common lattice would do along a vertical side.
struct Lattice {
  int points;     // Fibonacci numbers,
  int generator;  // one before the other
};
constexpr Lattice kExact = {233, 144};  // where a part's border may be
constexpr Lattice kSmooth = {34, 21};   // at other edges, which only have to look well
constexpr Lattice kCenter = {1, 0};     // away from edges

class PixelPlaces {
 public:
  PixelPlaces(const Lattice& lattice, int x, int y) : lattice_(lattice) {
    const std::uint64_t bits = mixed((static_cast<std::uint64_t>(y) << 32) + static_cast<std::uint64_t>(x) + 1);
    shift_right_ = unit_interval(bits << 32);
    shift_down_ = unit_interval(bits);
  }

  [[nodiscard]] int count() const { return lattice_.points; }
  [[nodiscard]] double right(int i) const { return place(i, shift_right_); }
  [[nodiscard]] double down(int i) const { return place(i * lattice_.generator % lattice_.points, shift_down_); }

 private:
  [[nodiscard]] double place(int i, double shift) const {
    const double share = static_cast<double>(i) / lattice_.points + shift;
    return share - std::floor(share) - 0.5;
  }

  Lattice lattice_;
  double shift_right_ = 0;
  double shift_down_ = 0;
};

// An edge can only cross a pixel if one beside it shows another surface at its centre.
const Lattice& lattice_for(const cv::Mat& surfaces, int x, int y) {
  const auto own = static_cast<std::uint32_t>(surfaces.at<int>(y, x));
  const Lattice* lattice = &kCenter;
  for (int ny = std::max(0, y - 1); ny <= std::min(surfaces.rows - 1, y + 1); ++ny) {
    for (int nx = std::max(0, x - 1); nx <= std::min(surfaces.cols - 1, x + 1); ++nx) {
      const auto other = static_cast<std::uint32_t>(surfaces.at<int>(ny, nx));
      if (other == own) continue;
      if (((own | other) & kPartBit) != 0) return kExact;
      lattice = &kSmooth;
    }
  }
  return *lattice;
}

// The mean of `probe` over every pixel. A probe takes a ray and gives {value, surface}; Value is a Sum of less
// precision. `mixed` is told of every pixel that an edge may cross: (x, y, places in it, values there, their mean);
// from several threads, but of the pixels of a row from one.
template <typename Value, typename Sum, typename Rays, typename Probe, typename Mixed>
cv::Mat integrate(const CameraModel& camera, const Rays& rays, const Probe& probe, const Mixed& mixed) {
  cv::Mat_<Value> image(camera.height, camera.width);
  cv::Mat surfaces(camera.height, camera.width, CV_32SC1);
  const cv::Range all_rows(0, camera.height);
  cv::parallel_for_(all_rows, [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const std::pair<Sum, std::uint32_t> center = probe(rays.at(x, y, 0, 0));
        image(y, x) = static_cast<Value>(center.first);
        surfaces.at<int>(y, x) = static_cast<int>(center.second);
      }
    }
  });
  cv::parallel_for_(all_rows, [&](const cv::Range& rows) {
    std::vector<Sum> values;
    for (int y = rows.start; y < rows.end; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Lattice& lattice = lattice_for(surfaces, x, y);
        if (lattice.points == 1) continue;
        const PixelPlaces places(lattice, x, y);
        values.clear();
        Sum sum{};
        for (int i = 0; i < lattice.points; ++i) {
          values.push_back(probe(rays.at(x, y, places.right(i), places.down(i))).first);
          sum += values.back();
        }
        const Sum mean = sum * (1.0 / lattice.points);
        image(y, x) = static_cast<Value>(mean);
        mixed(x, y, places, values, mean);
      }
    }
  });
  return image;
}

template <typename Value, typename Sum, typename Probe, typename Mixed>
cv::Mat integrate(const CameraModel& camera, const Probe& probe, const Mixed& mixed) {
  const bool distorts =
      camera.distortion_model != DistortionModel::kNone &&
      std::any_of(camera.distortion.begin(), camera.distortion.end(), [](double k) { return k != 0; });
  if (distorts) return integrate<Value, Sum>(camera, LensRays(camera), probe, mixed);
  return integrate<Value, Sum>(camera, PinholeRays(camera), probe, mixed);
}

MixedPixel divided(int x, int y, const PixelPlaces& places, const std::vector<cv::Vec3d>& lights,
                   const cv::Vec3d& mean) {
  const auto cell_of = [](double place) {
    return std::min(MixedPixel::kCells - 1, static_cast<std::size_t>((place + 0.5) * MixedPixel::kCells));
  };
  MixedPixel pixel{x, y, {}};
  for (int i = 0; i < places.count(); ++i) {
    pixel.excess[cell_of(places.down(i))][cell_of(places.right(i))] +=
        cv::Vec3f((lights[static_cast<std::size_t>(i)] - mean) * (1.0 / places.count()));
  }
  return pixel;
}

void require_camera(const CameraModel& camera) {
  std::string why;
  if (!camera.is_valid(&why)) throw Error(ErrorKind::kInput, "camera of the scene: " + why);
}

}  // namespace

SceneLight::SceneLight(cv::Mat light, std::vector<MixedPixel> unevenly_lit)
    : pixels(std::move(light)), mixed(std::move(unevenly_lit)) {}

SceneLight render(const Scene& scene) {
  require_camera(scene.camera);
  const SceneTracer tracer(scene);
  std::vector<std::vector<MixedPixel>> mixed_of_row(static_cast<std::size_t>(scene.camera.height));
  cv::Mat pixels = integrate<cv::Vec3f, cv::Vec3d>(
      scene.camera,
      [&](const Eigen::Vector2d& ray) {
        const LightSample sample = tracer.light_along(ray);
        return std::pair(cv::Vec3d(sample.light.z(), sample.light.y(), sample.light.x()), sample.surface);
      },
      [&](int x, int y, const PixelPlaces& places, const std::vector<cv::Vec3d>& lights, const cv::Vec3d& mean) {
        mixed_of_row[static_cast<std::size_t>(y)].push_back(divided(x, y, places, lights, mean));
      });
  std::vector<MixedPixel> mixed;
  for (const auto& row : mixed_of_row) mixed.insert(mixed.end(), row.begin(), row.end());
  return {std::move(pixels), std::move(mixed)};
}

cv::Mat render_coverage(const Scene& scene, std::size_t part) {
  require_camera(scene.camera);
  if (part >= scene.parts.size()) {
    throw Error(ErrorKind::kInput, "scene has no part " + std::to_string(part) + "; it has " +
                                       std::to_string(scene.parts.size()) + ", counted from 0");
  }
  const SceneTracer tracer(scene);
  return integrate<float, double>(
      scene.camera,
      [&](const Eigen::Vector2d& ray) {
        const bool seen = tracer.solid_along(ray) == part;
        return std::pair(seen ? 1.0 : 0.0, seen ? kPartBit : 0U);
      },
      [](const auto&...) {});
}

cv::Mat truth_mask(const Scene& scene, std::size_t part) {
  return render_coverage(scene, part) >= 0.5;
}

}  // namespace cylpose
