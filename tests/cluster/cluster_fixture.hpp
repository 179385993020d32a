// A server and coordinators on it, and frames compared with serial.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cylpose/cluster/backend.hpp>
#include <cylpose/cluster/worker.hpp>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/temp_dir.hpp"
#include "host/test_images.hpp"
#include "kernels/comparison.hpp"
#include "servers.hpp"

namespace cylpose::testing {

/// Leaves everything to nodes that they do in time.
inline std::unique_ptr<cluster::ClusterBackend> remote_coordinator(
    const cluster::ConnectionOptions& connection,
    std::chrono::milliseconds deadline = std::chrono::milliseconds(20'000), int tile_rows = 0) {
  cluster::ClusterOptions options;
  options.connection = connection;
  options.share_local = false;
  options.deadline = deadline;
  options.tile_rows = tile_rows;
  return cluster::make_cluster_backend(make_backend("serial"), options);
}

/// A worker in a thread.
class TestWorker {
 public:
  explicit TestWorker(const std::string& url, std::string name = "worker") : name_(std::move(name)) {
    thread_ = std::jthread([this, url](const std::stop_token& stop) {
      cluster::WorkerOptions options;
      options.connection = connection_to(url);
      options.name = name_;
      options.device = "a test";
      options.on_event = [this](const std::string& what) {
        const std::scoped_lock lock(mutex_);
        events_ += what + "\n";
      };
      const std::unique_ptr<Backend> serial = make_backend("serial");
      cluster::run_worker(*serial, options, [&stop] { return stop.stop_requested(); });
    });
  }
  [[nodiscard]] std::string events() const {
    const std::scoped_lock lock(mutex_);
    return events_;
  }

 private:
  std::string name_;
  mutable std::mutex mutex_;
  std::string events_;
  std::jthread thread_;
};

class Cluster : public ::testing::Test {
 protected:
  std::unique_ptr<cluster::ClusterBackend> coordinator(
      bool share_local = false, std::chrono::milliseconds deadline = std::chrono::milliseconds(2000), int tile_rows = 0,
      std::unique_ptr<Backend> local = nullptr) {
    cluster::ClusterOptions options;
    options.connection = connection_to(server_.url());
    options.share_local = share_local;
    options.deadline = deadline;
    options.tile_rows = tile_rows;
    options.on_event = [this](const std::string& what) {
      const std::scoped_lock lock(mutex_);
      events_ += what + "\n";
    };
    return cluster::make_cluster_backend(local != nullptr ? std::move(local) : make_backend("serial"), options);
  }

  static bool has_nodes(const cluster::ClusterBackend& backend, std::size_t count) {
    return eventually([&] { return backend.nodes().size() == count; });
  }

  // A machine that is so busy that nodes stand still for seconds loses a tile now and then.
  static bool nearly_all_by_nodes(const cluster::ClusterCounters& counters) {
    return counters.taken_back * 4 <= counters.used;
  }

  // Frames of random sizes, formats, regions and parts, each compared with serial.
  std::size_t expect_equal_frames(cluster::ClusterBackend& backend, int frames) {
    static const std::unique_ptr<Backend> serial = make_backend("serial");
    std::size_t edges = 0;
    for (int i = 0; i < frames; ++i) {
      const auto format = static_cast<PixelFormat>(i % 3);
      const int width = std::uniform_int_distribution<int>(1, 300)(random_);
      const int height = std::uniform_int_distribution<int>(1, 200)(random_);
      const TestImage image = random_image(width, height, random_, format, i % 7);
      const Roi search = i % 2 == 0 ? image.view().bounds() : Roi{width / 5, height / 7, width / 2 + 1, height / 2 + 1};
      const std::vector<PartModel> parts(four_parts().begin(), four_parts().begin() + 1 + i % 4);
      const EdgeField expected = serial->detect(image.view(), search, parts, {});
      const EdgeField actual = backend.detect(image.view(), search, parts, {});
      EXPECT_EQ(actual.searched, expected.searched);
      for (std::size_t part = 0; part < parts.size(); ++part) {
        EXPECT_EQ(actual.parts[part].region, expected.parts[part].region);
        EXPECT_EQ(actual.parts[part].edges, expected.parts[part].edges);
        edges += expected.parts[part].edges.size();
      }
      if (HasFailure()) return 0;
    }
    return edges;
  }

  std::string events() {
    const std::scoped_lock lock(mutex_);
    return events_;
  }

  TempDir folder_;
  NatsServer server_{folder_.path()};
  std::mt19937 random_{7};
  std::mutex mutex_;
  std::string events_;
};

}  // namespace cylpose::testing
