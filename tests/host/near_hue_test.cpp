#include <gtest/gtest.h>

#include <cmath>
#include <cylpose/backend.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/pose_solver.hpp>
#include <cylpose/render.hpp>
#include <cylpose/scenario.hpp>

namespace cylpose {
namespace {

struct Outcome {
  bool found;
  double depth_error;  // share of the distance
};

// A random scene whose part stands before a plain, saturated background so many degrees beside its own hue.
Outcome before_hue(std::uint64_t seed, double degrees_away) {
  RandomScene random = random_scene(seed);
  const double lo = random.part.hue_lo_deg;
  const double width = std::fmod(random.part.hue_hi_deg - lo + 360, 360);
  const double hue = lo + width / 2 + (seed % 2 == 0 ? degrees_away : -degrees_away);
  random.scene.background = Texture{};
  random.scene.background.color = linear_from_hsv(std::fmod(hue + 720, 360), 0.65, 0.6);
  const cv::Mat picture = degrade(render(random.scene), random.degrade);
  DetectOptions options;
  options.transfer = random.scene.camera.transfer;
  const ImageView image = view_of(picture);
  const std::vector<PartModel> parts{random.part};
  const EdgeField field = make_backend("serial")->detect(image, image.bounds(), parts, options);
  const PoseEstimate estimate = PoseSolver(random.scene.camera, parts).solve(field).front();
  const Eigen::Vector3d& truth = random.scene.parts.front().cylinder.pose.center_in_cam;
  return {estimate.status == PoseStatus::kOk,
          std::abs(estimate.pose.center_in_cam.norm() - truth.norm()) / truth.norm()};
}

TEST(NearHue, BackgroundsBesideTheRangeHideNothing) {
  int found = 0;
  for (std::uint64_t seed = 1000; seed < 1008; ++seed) {
    const Outcome outcome = before_hue(seed, 35);  // the range ends at 25
    if (!outcome.found) continue;
    ++found;
    EXPECT_LT(outcome.depth_error, 0.005) << seed;
  }
  EXPECT_GE(found, 7);
}

// The background passes the gate in parts; what is found of the part is in its place all the same.
TEST(NearHue, ABackgroundOnTheRangesLimitDoesNotShiftTheEdges) {
  int found = 0;
  for (const std::uint64_t seed : {1005U, 1027U, 1028U, 1063U, 1072U, 1001U, 1002U}) {
    const Outcome outcome = before_hue(seed, 25);
    if (!outcome.found) continue;
    ++found;
    EXPECT_LT(outcome.depth_error, 0.01) << seed;
  }
  EXPECT_GE(found, 3);
}

}  // namespace
}  // namespace cylpose
