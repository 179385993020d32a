#include "service.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cylpose/opencl_devices.hpp>
#include <cylpose/version.hpp>
#include <nlohmann/json.hpp>

#include "message.hpp"

namespace cylpose::cluster {

Service::Service(const Connection& connection, ServiceIdentity identity)
    : identity_(std::move(identity)), listener_(connection, "$SRV.>", [this, &connection](const NatsMessage& message) {
        const char* reply = natsMsg_GetReply(message.get());
        const std::string verb = verb_for_us(natsMsg_GetSubject(message.get()));
        if (reply != nullptr && !verb.empty()) connection.publish(reply, reply_to(verb));
      }) {}

std::string Service::verb_for_us(std::string_view subject) const {
  for (const char* verb : {"PING", "INFO", "STATS"}) {
    const std::string all = fmt::format("$SRV.{}", verb);
    const std::string ours = fmt::format("{}.{}", all, kService);
    if (subject == all || subject == ours || subject == fmt::format("{}.{}", ours, identity_.id)) return verb;
  }
  return {};
}

void Service::count(double busy_ms, double pixels) {
  constexpr double kWeight = 0.2;  // of the newest
  const double rate = pixels / std::max(busy_ms, 1e-3);
  const std::scoped_lock lock(mutex_);
  ++requests_;
  busy_ms_ += busy_ms;
  pixels_per_ms_ = pixels_per_ms_ == 0 ? rate : pixels_per_ms_ + kWeight * (rate - pixels_per_ms_);
}

void Service::count_failure(const std::string& why) {
  const std::scoped_lock lock(mutex_);
  ++requests_;
  ++failures_;
  last_error_ = why;
}

double Service::pixels_per_ms() const {
  const std::scoped_lock lock(mutex_);
  return pixels_per_ms_;
}

std::string Service::reply_to(const std::string& verb) const {
  nlohmann::json reply{
      {"name", kService},
      {"id", identity_.id},
      {"version", kVersion},
      {"metadata",
       {{"node", identity_.node},
        {"device", identity_.device},
        {"protocol", std::to_string(kProtocol)},
        {"kernels", kernel_hash()},
        {"pixels_per_ms", fmt::format("{:.0f}", pixels_per_ms())}}},
  };
  nlohmann::json endpoint{{"name", "tile"}, {"subject", identity_.endpoint}};
  if (verb == "INFO") {
    endpoint["metadata"] = nlohmann::json::object();
    reply["description"] = "finds the edges of coloured cylinders in tiles of frames";
    reply["endpoints"] = nlohmann::json::array({endpoint});
    reply["type"] = "io.nats.micro.v1.info_response";
  } else if (verb == "STATS") {
    const std::scoped_lock lock(mutex_);
    const auto nanoseconds = static_cast<std::int64_t>(busy_ms_ * 1e6);
    endpoint["num_requests"] = requests_;
    endpoint["num_errors"] = failures_;
    endpoint["last_error"] = last_error_;
    endpoint["processing_time"] = nanoseconds;
    endpoint["average_processing_time"] = requests_ == 0 ? 0 : nanoseconds / requests_;
    reply["started"] =
        fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(started_)));
    reply["endpoints"] = nlohmann::json::array({endpoint});
    reply["type"] = "io.nats.micro.v1.stats_response";
  } else {
    reply["type"] = "io.nats.micro.v1.ping_response";
  }
  // What a device calls itself need not be UTF-8.
  return reply.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace cylpose::cluster
