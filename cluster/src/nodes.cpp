#include <algorithm>
#include <cylpose/cluster/nodes.hpp>
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>
#include <nlohmann/json.hpp>

#include "message.hpp"
#include "nats.hpp"
#include "service.hpp"

namespace cylpose::cluster {
namespace {

using Json = nlohmann::json;

// What strangers answer need not be what it should be: then the report lacks it.
std::string text_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

template <typename Number>
Number number_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<Number>() : Number{};
}

bool read_report(const NatsMessage& message, NodeReport& report) {
  const std::span<const std::uint8_t> data = data_of(message);
  const Json json = Json::parse(data.begin(), data.end(), nullptr, false);
  if (!json.is_object() || text_in(json, "name") != kService) return false;
  report.id = text_in(json, "id");
  report.version = text_in(json, "version");
  report.started = text_in(json, "started");
  if (const auto metadata = json.find("metadata"); metadata != json.end() && metadata->is_object()) {
    report.name = text_in(*metadata, "node");
    report.device = text_in(*metadata, "device");
    report.kernels = text_in(*metadata, "kernels");
    report.protocol = static_cast<std::uint32_t>(std::strtoul(text_in(*metadata, "protocol").c_str(), nullptr, 10));
    report.pixels_per_ms = std::strtod(text_in(*metadata, "pixels_per_ms").c_str(), nullptr);
  }
  report.usable = report.protocol == kProtocol && report.kernels == kernel_hash();
  const auto endpoints = json.find("endpoints");
  if (endpoints == json.end() || !endpoints->is_array() || endpoints->empty() || !endpoints->front().is_object()) {
    return true;
  }
  const Json& endpoint = endpoints->front();
  report.failed = number_in<std::int64_t>(endpoint, "num_errors");
  report.done = number_in<std::int64_t>(endpoint, "num_requests") - report.failed;
  report.last_error = text_in(endpoint, "last_error");
  return true;
}

}  // namespace

std::vector<NodeReport> list_nodes(const ConnectionOptions& options, std::chrono::milliseconds patience) {
  const Connection connection(options, "cylpose nodes");
  connection.await_server();
  natsInbox* made = nullptr;
  check(natsInbox_Create(&made), "natsInbox_Create");
  const std::string inbox = made;
  natsInbox_Destroy(made);
  const NatsSubscription answers = connection.subscribe(inbox);
  connection.publish(std::string("$SRV.STATS.") + kService, {}, inbox);

  std::vector<NodeReport> reports;
  const auto end = std::chrono::steady_clock::now() + patience;
  for (auto now = std::chrono::steady_clock::now(); now < end; now = std::chrono::steady_clock::now()) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - now) + std::chrono::milliseconds(1);
    NatsMessage message = next_message(answers, left);
    NodeReport report;
    if (message != nullptr && !natsMsg_IsNoResponders(message.get()) && read_report(message, report)) {
      reports.push_back(std::move(report));
    }
  }
  std::ranges::sort(reports, {}, [](const NodeReport& report) { return std::tie(report.name, report.id); });
  return reports;
}

}  // namespace cylpose::cluster
