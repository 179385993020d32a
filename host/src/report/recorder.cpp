#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/overlay.hpp>
#include <cylpose/report_recorder.hpp>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

namespace cylpose {
namespace {

constexpr std::size_t kPicturesPerKind = 2;

ReportPicture encoded(const cv::Mat& picture, std::string caption) {
  cv::Mat small = picture;
  if (picture.cols > ReportRecorder::kPictureWidth) {
    const double scale = static_cast<double>(ReportRecorder::kPictureWidth) / picture.cols;
    cv::resize(picture, small, {}, scale, scale, cv::INTER_AREA);
  }
  ReportPicture result;
  result.caption = std::move(caption);
  result.width = small.cols;
  result.height = small.rows;
  cv::imencode(".jpg", small, result.jpeg, {cv::IMWRITE_JPEG_QUALITY, 70});
  return result;
}

}  // namespace

ReportRecorder::ReportRecorder(CameraModel camera, std::vector<PartModel> parts, std::vector<TruthRow> truth,
                               std::optional<Extrinsics> extrinsics)
    : camera_(std::move(camera)), parts_(std::move(parts)), extrinsics_(std::move(extrinsics)) {
  const bool named = std::any_of(truth.begin(), truth.end(), [](const TruthRow& row) { return !row.part.empty(); });
  if (!named && parts_.size() > 1 && !truth.empty()) {
    throw Error(ErrorKind::kInput,
                fmt::format("there are {} parts and the truth has no column 'part'; add it", parts_.size()));
  }
  for (const TruthRow& row : truth) {
    const std::string& part = named ? row.part : parts_.at(0).name;
    if (!true_poses_.emplace(std::pair(row.frame, part), row.pose).second) {
      throw Error(ErrorKind::kInput,
                  fmt::format("frame {}, part {}: given twice in the truth; each frame and part may have one row",
                              row.frame, part));
    }
  }
  report_.truth = std::move(truth);
}

void ReportRecorder::add(const Frame& frame, const FrameEstimate& estimate, double milliseconds) {
  const FrameEstimate written = extrinsics_ ? in_body(estimate, *extrinsics_) : estimate;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    report_.poses.push_back(pose_row(frame.index, frame.timestamp_s, parts_[i].name, written.parts.at(i)));
  }
  report_.frame_times.push_back({frame.index, milliseconds});
  if (!frame.image.empty()) consider(frame, estimate, score_of(frame.index, written));
}

void ReportRecorder::add_times(std::span<const StageTime> times) {
  stages_.add(times);
}

double ReportRecorder::score_of(std::int64_t frame, const FrameEstimate& written) const {
  double score = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const PoseEstimate& part = written.parts[i];
    const auto truth = true_poses_.find({frame, parts_[i].name});
    if (truth != true_poses_.end()) {
      score = std::max(score, (part.pose.center_in_cam - truth->second.center_in_cam).norm());
    } else if (true_poses_.empty()) {
      score = std::max(score, part.rms_px);
    }
  }
  return score;
}

void ReportRecorder::consider(const Frame& frame, const FrameEstimate& estimate, double score) {
  const bool found = std::all_of(estimate.parts.begin(), estimate.parts.end(),
                                 [](const PoseEstimate& part) { return part.status == PoseStatus::kOk; });
  const auto keep = [&](std::vector<Candidate>* kept, auto goes_before) {
    const auto place =
        std::find_if(kept->begin(), kept->end(), [&](const Candidate& c) { return goes_before(c.score); });
    if (place == kept->end() && kept->size() >= kPicturesPerKind) return;
    Frame copy = frame;
    copy.image = frame.image.clone();  // sources may use the pixels again
    kept->insert(place, {score, std::move(copy), estimate});
    if (kept->size() > kPicturesPerKind) kept->pop_back();
  };
  if (!found) return keep(&none_, [](double) { return false; });
  if (!std::isfinite(score)) return;
  keep(&best_, [&](double other) { return score < other; });
  keep(&worst_, [&](double other) { return score > other; });
}

std::vector<ReportPicture> ReportRecorder::pictures() const {
  std::vector<ReportPicture> all;
  std::set<std::int64_t> shown;  // in a short run the best frames are the worst as well
  const auto show = [&](const std::vector<Candidate>& candidates, const auto& caption) {
    for (const Candidate& candidate : candidates) {
      if (!shown.insert(candidate.frame.index).second) continue;
      all.push_back(encoded(overlay(candidate.frame.image, camera_, parts_, candidate.estimate), caption(candidate)));
    }
  };
  const auto score_text = [&](const Candidate& candidate) {
    return true_poses_.empty() ? fmt::format("residual {:.3f} px", candidate.score)
                               : fmt::format("centre off by {:.3f} mm", 1000 * candidate.score);
  };
  show(best_, [&](const Candidate& c) { return fmt::format("Best: frame {}, {}", c.frame.index, score_text(c)); });
  show(worst_, [&](const Candidate& c) { return fmt::format("Worst: frame {}, {}", c.frame.index, score_text(c)); });
  show(none_, [](const Candidate& c) { return fmt::format("Not found: frame {}", c.frame.index); });
  return all;
}

Report ReportRecorder::report() const {
  Report report = report_;
  report.stages = stages_.summaries();
  report.pictures = pictures();
  return report;
}

}  // namespace cylpose
