#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cylpose/error.hpp>
#include <cylpose/extrinsics.hpp>
#include <string>

#include "temp_dir.hpp"

namespace cylpose {
namespace {

class ExtrinsicsTest : public ::testing::Test {
 protected:
  Extrinsics load(const std::string& text) const { return load_extrinsics(folder.write("extrinsics.yaml", text)); }

  std::string refusal(const std::string& text) const {
    try {
      (void)load(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      return error.what();
    }
    return "accepted";
  }

  TempDir folder;
};

// The camera looks along the body's x axis: z forward becomes x, x right becomes -y, y down becomes -z.
constexpr const char* kQuaternion = "rotation: [-0.5, 0.5, -0.5, 0.5]\ntranslation_m: [1, 2, 3]\n";
constexpr const char* kMatrix = "rotation:\n  - [0, 0, 1]\n  - [-1, 0, 0]\n  - [0, -1, 0]\ntranslation_m: [1, 2, 3]\n";

TEST_F(ExtrinsicsTest, QuaternionAndMatrixSayTheSame) {
  for (const char* text : {kQuaternion, kMatrix}) {
    const Extrinsics extrinsics = load(text);
    EXPECT_LT((extrinsics.body_from_cam * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
    EXPECT_LT((extrinsics.body_from_cam * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY()).norm(), 1e-12);
    EXPECT_EQ(extrinsics.cam_in_body, Eigen::Vector3d(1, 2, 3));
  }
}

TEST_F(ExtrinsicsTest, PosesAndCovariancesTurn) {
  const Extrinsics extrinsics = load(kMatrix);
  FrameEstimate estimate;
  estimate.parts.resize(2);
  PoseEstimate& part = estimate.parts[0];
  part.status = PoseStatus::kOk;
  part.pose = {{0.1, 0.2, 2}, {0, -1, 0}};
  part.covariance.diagonal() << 1, 2, 3, 4, 5, 6;
  part.covariance(0, 5) = part.covariance(5, 0) = 0.5;
  const FrameEstimate turned = in_body(estimate, extrinsics);
  const PoseEstimate& result = turned.parts[0];
  EXPECT_LT((result.pose.center_in_cam - Eigen::Vector3d(1 + 2, 2 - 0.1, 3 - 0.2)).norm(), 1e-12);
  EXPECT_LT((result.pose.axis_in_cam - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  Eigen::Matrix<double, 6, 1> diagonal;
  diagonal << 3, 1, 2, 6, 4, 5;
  EXPECT_LT((result.covariance.diagonal() - diagonal).norm(), 1e-12);
  EXPECT_NEAR(result.covariance(1, 3), -0.5, 1e-12);  // x of the camera is -y of the body, z is x
  EXPECT_EQ(turned.parts[1].status, PoseStatus::kNone);
}

TEST_F(ExtrinsicsTest, TheAxisKeepsItsSignRuleInTheBody) {
  FrameEstimate estimate;
  estimate.parts.resize(1);
  estimate.parts[0].status = PoseStatus::kOk;
  estimate.parts[0].pose = {{0, 0, 1}, Eigen::Vector3d(-0.6, -0.8, 0)};
  EXPECT_LT(in_body(estimate, load(kMatrix)).parts[0].pose.axis_in_cam.y(), 0);
}

TEST_F(ExtrinsicsTest, RefusesWhatIsNoMotion) {
  EXPECT_NE(refusal("rotation: [0, 0, 0, 2]\ntranslation_m: [0, 0, 0]\n").find("length 2"), std::string::npos);
  EXPECT_NE(refusal("rotation: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\ntranslation_m: [0, 0, 0]\n").find("no rotation"),
            std::string::npos);
  EXPECT_NE(refusal("rotation: [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]\ntranslation_m: [0, 0, 0]\n").find("no rotation"),
            std::string::npos);
  EXPECT_NE(refusal("rotation: [1, 0]\ntranslation_m: [0, 0, 0]\n").find("2 values"), std::string::npos);
  EXPECT_NE(refusal("rotation: [0, 0, 0, 1]\ntranslation_m: [0, 0]\n").find("2 values"), std::string::npos);
  EXPECT_NE(refusal("rotation: [0, 0, 0, 1]\n").find("translation_m"), std::string::npos);
  EXPECT_NE(refusal("rotation: [0, 0, 0, .nan]\ntranslation_m: [0, 0, 0]\n"), "accepted");
  EXPECT_NE(refusal("rotation: [0, 0, 0, 1]\ntranslation_m: [0, 0, 0]\nscale: 2\n").find("scale"), std::string::npos);
  EXPECT_NE(refusal(""), "accepted");
}

}  // namespace
}  // namespace cylpose
