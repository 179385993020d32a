// The live page: a run watched in a browser, and by Prometheus.
#pragma once

#include <atomic>
#include <cstddef>
#include <string>

#include "bounded_server.hpp"
#include "live_picture.hpp"
#include "live_state.hpp"

namespace cylpose::apps {

/// Serves /, /events (server-sent events), /picture.jpg and /metrics from threads of its own, which have less priority
/// than those of the pipeline.
class LivePage {
 public:
  /// Binds, without serving yet. Throws like BoundedServer.
  LivePage(const LiveState& state, const std::string& address, int port, const ServerLimits& limits = {});

  void start() { server_.start(); }

  /// At the end of the run: gives those who look the time to get the last state and picture, kPartingTime at most, and
  /// stops.
  void finish();

  [[nodiscard]] std::string url() const { return server_.url(); }
  [[nodiscard]] int port() const { return server_.port(); }
  [[nodiscard]] std::size_t streams() const { return streams_; }
  [[nodiscard]] std::uint64_t pictures_made() const { return picture_.made(); }

  static constexpr std::size_t kMostStreams = 8;
  static constexpr std::chrono::milliseconds kEventPeriod{200};
  static constexpr std::chrono::milliseconds kPartingTime{1000};

 private:
  [[nodiscard]] HttpAnswer answer(const std::string& path);
  [[nodiscard]] HttpAnswer events();

  const LiveState& state_;
  LivePicture picture_;
  std::atomic<std::size_t> streams_ = 0;
  BoundedServer server_;  ///< ends first
};

}  // namespace cylpose::apps
