#include "scenes.hpp"

#include <algorithm>
#include <cylpose/render.hpp>
#include <cylpose/scenario.hpp>
#include <cylpose/search_region.hpp>
#include <map>
#include <opencv2/imgproc.hpp>

namespace cylpose::bench {
namespace {

// Both bases and both sides can be seen, and the part turns from frame to frame.
constexpr const char* kScenario = "series4";
constexpr int kFrame = 50;

constexpr FrameSize kPlainSize{1280, 720};

CameraModel scaled(CameraModel camera, const FrameSize& size) {
  const double scale = std::min(static_cast<double>(size.width) / camera.width,  //
                                static_cast<double>(size.height) / camera.height);
  camera.width = size.width;
  camera.height = size.height;
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx = (size.width - 1) / 2.0;
  camera.cy = (size.height - 1) / 2.0;
  return camera;
}

cv::Mat rendered(const Scenario& scenario, const CameraModel& camera, int frame = kFrame) {
  Scene scene = scenario.scene(frame);
  scene.camera = camera;
  DegradeOptions options;
  options.blur_sigma_px = scenario.blur_sigma_px;
  options.noise_sigma = scenario.noise_sigma;
  options.transfer = camera.transfer;
  return degrade(render(scene), options);
}

BenchScene plain_scene() {
  BenchScene scene;
  scene.picture = cv::Mat(kPlainSize.height, kPlainSize.width, CV_8UC3, cv::Scalar(90, 90, 90));
  scene.camera = scaled(scenario_camera(), kPlainSize);
  scene.parts = {{"red", 0.05, 0.4, 340, 20, 0.3, 0.2}};
  scene.search = scene.image().bounds();
  return scene;
}

}  // namespace

std::string to_string(const FrameSize& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

BenchScene full_scene(const FrameSize& size) {
  static std::map<FrameSize, BenchScene> scenes;
  const auto known = scenes.find(size);
  if (known != scenes.end()) return known->second;
  const Scenario& scenario = find_scenario(kScenario);
  BenchScene scene;
  scene.camera = scaled(scenario.camera, size);
  scene.picture = rendered(scenario, scene.camera);
  scene.parts = scenario.parts;
  scene.search = scene.image().bounds();
  return scenes.emplace(size, std::move(scene)).first->second;
}

BenchScene roi_scene(const FrameSize& size) {
  BenchScene scene = full_scene(size);
  std::vector<PoseEstimate> before;
  for (const ScenePart& part : find_scenario(kScenario).scene(kFrame - 1).parts) {
    before.emplace_back().status = PoseStatus::kOk;
    before.back().pose = part.cylinder.pose;
  }
  SearchRegion region(scene.camera);
  region.update(scene.parts, before);
  scene.search = region.next();
  return scene;
}

const Recording& recording() {
  static const Recording made = [] {
    constexpr int kFrames = 8;
    const Scenario& scenario = find_scenario(kScenario);
    Recording result{{}, scaled(scenario.camera, kPlainSize), scenario.parts};
    for (int i = 0; i < kFrames; ++i) result.pictures.push_back(rendered(scenario, result.camera, kFrame + i));
    return result;
  }();
  return made;
}

BenchScene empty_scene() {
  BenchScene scene = plain_scene();
  scene.search = {600, 300, 64, 64};
  return scene;
}

BenchScene rectangle_scene() {
  BenchScene scene = plain_scene();
  cv::rectangle(scene.picture, cv::Rect(400, 300, 500, 120), cv::Scalar(20, 30, 220), cv::FILLED);
  return scene;
}

}  // namespace cylpose::bench
