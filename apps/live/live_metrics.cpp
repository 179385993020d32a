#include <fmt/format.h>

#include <cylpose/pose.hpp>
#include <cylpose/version.hpp>
#include <numbers>
#include <string_view>
#include <utility>

#include "live_text.hpp"

namespace cylpose::apps {
namespace {

using Labels = std::vector<std::pair<std::string_view, std::string_view>>;

constexpr double kSecondsPerMs = 1e-3;

class Exposition {
 public:
  /// Heads the samples that follow. `unit_and_kind`: the end of the name.
  void family(std::string_view name, std::string_view kind, std::string_view help) {
    name_ = name;
    text_ += fmt::format("# HELP cylpose_{} {}\n# TYPE cylpose_{} {}\n", name, help, name, kind);
  }

  template <typename Number>
  void sample(const Labels& labels, Number value, std::string_view end_of_name = "") {
    text_ += fmt::format("cylpose_{}{}", name_, end_of_name);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      text_ += fmt::format("{}{}=\"{}\"", i == 0 ? "{" : ",", labels[i].first, escaped(labels[i].second));
    }
    text_ += fmt::format("{} {}\n", labels.empty() ? "" : "}", value);
  }

  void summary(const Labels& labels, const graph::DurationStatistics& durations) {
    const auto quantile = [&](std::string_view which, double milliseconds) {
      Labels with = labels;
      with.emplace_back("quantile", which);
      sample(with, milliseconds * kSecondsPerMs);
    };
    quantile("0.5", durations.median_ms);
    quantile("0.95", durations.p95_ms);
    quantile("0.99", durations.p99_ms);
    sample(labels, durations.mean_ms * kSecondsPerMs * static_cast<double>(durations.count), "_sum");
    sample(labels, durations.count, "_count");
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  static std::string escaped(std::string_view value) {
    std::string result;
    for (const char c : value) {
      if (c == '\\' || c == '"') result += '\\';
      result += c == '\n' ? std::string("\\n") : std::string(1, c);
    }
    return result;
  }

  std::string name_;
  std::string text_;
};

void add_frames(const LiveView& view, Exposition& out) {
  const graph::PipelineStatistics& pipeline = view.pipeline;
  const auto counter = [&](std::string_view name, std::uint64_t value, std::string_view help) {
    out.family(name, "counter", help);
    out.sample({}, value);
  };
  counter("frames_accepted_total", pipeline.accepted, "Frames that the pipeline took.");
  counter("frames_dropped_total", pipeline.dropped, "Frames that newer ones replaced, or that were cancelled.");
  counter("frames_delivered_total", pipeline.delivered, "Frames whose poses are known.");
  counter("frames_failed_total", pipeline.failed, "Delivered frames that could not be used.");
  counter("frames_searched_again_total", pipeline.searched_again,
          "Delivered frames that were searched as a whole after a region.");
  counter("messages_total", view.messages_in_all, "What the user should know, as on standard error.");
  out.family("frame_latency_seconds", "summary", "From a frame being put to its poses being known.");
  out.summary({}, pipeline.latency);
  out.family("node_busy_seconds", "summary", "Work of a node on a frame.");
  for (const graph::NodeStatistics& node : pipeline.nodes) out.summary({{"node", node.node}}, node.busy);
}

void add_parts(const LiveView& view, Exposition& out) {
  out.family("poses_total", "counter", "Frames by what became of the part's pose.");
  for (const LivePart& part : view.parts) {
    for (const PoseStatus status : {PoseStatus::kOk, PoseStatus::kPredicted, PoseStatus::kNone}) {
      out.sample({{"part", part.latest.part}, {"status", to_string(status)}},
                 part.by_status[static_cast<std::size_t>(status)]);
    }
  }
  // Of the latest frame; no sample where it has no pose.
  const auto gauge = [&](std::string_view name, std::string_view help, const auto& add) {
    out.family(name, "gauge", help);
    for (const LivePart& part : view.parts) {
      if (part.latest.status != PoseStatus::kNone) add(part.latest);
    }
  };
  const auto axes = [&](const PoseRow& row, const Eigen::Vector3d& vector) {
    for (const auto& [axis, value] : {std::pair("x", vector.x()), std::pair("y", vector.y()), {"z", vector.z()}}) {
      out.sample({{"part", row.part}, {"axis", axis}}, value);
    }
  };
  gauge("part_center_meters", "Centre in the latest frame.",
        [&](const PoseRow& row) { axes(row, row.pose.center_in_cam); });
  gauge("part_center_sigma_meters", "Stated standard deviation of the centre.",
        [&](const PoseRow& row) { axes(row, row.sigma_center_m); });
  gauge("part_axis_sigma_radians", "Stated standard deviation of the axis's direction.", [&](const PoseRow& row) {
    out.sample({{"part", row.part}}, row.sigma_axis_deg * std::numbers::pi / 180);
  });
  gauge("part_residual_pixels", "Root mean square distance of edges from the outline.", [&](const PoseRow& row) {
    out.sample({{"part", row.part}}, row.rms_px);
  });
}

void add_cluster(const ClusterView& cluster, Exposition& out) {
  out.family("cluster_tiles_total", "counter", "Tiles of frames, by what became of them.");
  for (const auto& [fate, count] :
       {std::pair("sent", cluster.sent), std::pair("used", cluster.used), std::pair("late", cluster.late),
        std::pair("refused", cluster.refused), std::pair("taken_back", cluster.taken_back)}) {
    out.sample({{"fate", fate}}, count);
  }
  out.family("cluster_nodes", "gauge", "Nodes that can be given tiles now.");
  out.sample({}, cluster.nodes.size());
  out.family("cluster_node_tiles_total", "counter", "Tiles of a node, by whether its results were used.");
  for (const ClusterView::Node& node : cluster.nodes) {
    out.sample({{"node", node.name}, {"result", "used"}}, node.used);
    out.sample({{"node", node.name}, {"result", "failed"}}, node.failed);
  }
  constexpr double kPerSecond = 1e3;
  out.family("cluster_node_pixels_per_second", "gauge", "A node's speed, as it says itself.");
  for (const ClusterView::Node& node : cluster.nodes) {
    out.sample({{"node", node.name}}, node.pixels_per_ms * kPerSecond);
  }
}

}  // namespace

std::string to_metrics(const LiveView& view) {
  Exposition out;
  out.family("build_info", "gauge", "Version of cylpose.");
  out.sample({{"version", kVersion}}, 1);
  out.family("running", "gauge", "1 until the run has ended.");
  out.sample({}, view.ended ? 0 : 1);
  add_frames(view, out);
  add_parts(view, out);
  if (view.cluster) add_cluster(*view.cluster, out);
  return out.text();
}

}  // namespace cylpose::apps
