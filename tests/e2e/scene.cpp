#include "scene.hpp"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace cylpose {

cv::Mat picture_of(const CylinderPose& pose) {
  constexpr int kSamples = 4;  // per pixel and direction
  cv::Mat large(240 * kSamples, 320 * kSamples, CV_8UC3, cv::Scalar(120, 120, 120));
  for (int y = 0; y < large.rows; ++y) {
    for (int x = 0; x < large.cols; ++x) {
      const double u = ((x + 0.5) / kSamples - 0.5 - 160) / 400;
      const double v = ((y + 0.5) / kSamples - 0.5 - 120) / 400;
      if (intersect_ray(pose, 0.05, 0.3, {u, v, 1})) large.at<cv::Vec3b>(y, x) = {30, 25, 200};
    }
  }
  cv::Mat picture;
  cv::resize(large, picture, {320, 240}, 0, 0, cv::INTER_AREA);
  return picture;
}

CylinderPose pose_of_frame(int frame) {
  return {{0.01 * frame, 0, 1.2}, Eigen::Vector3d(0.1, -1, 0.2).normalized()};
}

SceneTest::SceneTest() : camera_(file("camera.yaml", kCameraText)), parts_(file("part.yaml", kPartsText)) {}

void SceneTest::write_frames(int count) const {
  std::filesystem::create_directories(folder_.path() / "frames");
  for (int i = 0; i < count; ++i) {
    ASSERT_TRUE(cv::imwrite(path(cv::format("frames/frame_%04d.png", i)), picture_of(pose_of_frame(i))));
  }
}

std::string SceneTest::write_video(const std::string& name, int frames) const {
  cv::VideoWriter writer(path(name), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10, {320, 240});
  EXPECT_TRUE(writer.isOpened());
  for (int i = 0; i < frames; ++i) writer.write(picture_of(pose_of_frame(i % 4)));
  return path(name);
}

std::vector<std::string> SceneTest::estimate_words(const std::vector<std::string>& more) const {
  std::vector<std::string> words = {"estimate", "--camera", camera_, "--parts", parts_};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace cylpose
