#include <cylpose/pose.hpp>
#include <nlohmann/json.hpp>

#include "live_text.hpp"

namespace cylpose::apps {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Json json_of(const graph::DurationStatistics& durations) {
  return {{"count", durations.count},   {"mean_ms", durations.mean_ms}, {"median_ms", durations.median_ms},
          {"p95_ms", durations.p95_ms}, {"p99_ms", durations.p99_ms},   {"max_ms", durations.max_ms}};
}

Json json_of(const LivePart& part) {
  const PoseRow& row = part.latest;
  Json json{{"part", row.part}, {"status", to_string(row.status)}, {"reason", row.reason}};
  if (row.status != PoseStatus::kNone) {
    json["center_m"] = json_of(row.pose.center_in_cam);
    json["axis"] = json_of(row.pose.axis_in_cam);
    json["sigma_center_m"] = json_of(row.sigma_center_m);
    json["sigma_axis_deg"] = row.sigma_axis_deg;
    json["rms_px"] = row.rms_px;
  }
  for (const PoseStatus status : {PoseStatus::kOk, PoseStatus::kPredicted, PoseStatus::kNone}) {
    json["frames"][std::string(to_string(status))] = part.by_status[static_cast<std::size_t>(status)];
  }
  return json;
}

Json json_of(const ClusterView& cluster) {
  Json nodes = Json::array();
  for (const ClusterView::Node& node : cluster.nodes) {
    nodes.push_back({{"node", node.name},
                     {"slots", node.slots},
                     {"mpixel_per_s", node.pixels_per_ms * 1e-3},
                     {"used", node.used},
                     {"failed", node.failed}});
  }
  return {{"nodes", nodes},
          {"tiles",
           {{"sent", cluster.sent},
            {"used", cluster.used},
            {"late", cluster.late},
            {"refused", cluster.refused},
            {"taken_back", cluster.taken_back}}}};
}

}  // namespace

std::string to_json(const LiveView& view, const std::vector<ReportFact>& facts) {
  const auto known = [](std::int64_t frame) { return frame < 0 ? Json() : Json(frame); };
  const graph::PipelineStatistics& pipeline = view.pipeline;
  Json json{{"state", view.ended ? "ended" : "running"},
            {"seconds", view.seconds},
            {"facts", Json::array()},
            {"frame", known(view.frame)},
            {"timestamp_s", view.timestamp_s},
            {"failure", view.failure},
            {"latency_ms", view.latency_ms},
            {"picture", known(view.picture)},
            {"frames",
             {{"accepted", pipeline.accepted},
              {"delivered", pipeline.delivered},
              {"dropped", pipeline.dropped},
              {"failed", pipeline.failed},
              {"searched_again", pipeline.searched_again}}},
            {"parts", Json::array()},
            {"put_to_sink", json_of(pipeline.latency)},
            {"nodes", Json::array()},
            {"cluster", view.cluster ? json_of(*view.cluster) : Json()},
            {"messages", Json::array()},
            {"messages_in_all", view.messages_in_all}};
  for (const ReportFact& fact : facts) json["facts"].push_back({{"label", fact.label}, {"value", fact.value}});
  for (const LivePart& part : view.parts) json["parts"].push_back(json_of(part));
  for (const graph::NodeStatistics& node : pipeline.nodes) {
    Json entry{{"node", node.node}};
    entry.update(json_of(node.busy));
    json["nodes"].push_back(std::move(entry));
  }
  for (const LiveMessage& message : view.messages) {
    json["messages"].push_back({{"text", message.text}, {"times", message.times}});
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace cylpose::apps
