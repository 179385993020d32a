// Whole recordings as jobs in a queue that the server keeps on disk: workers and servers may die at any moment, and
// every frame comes out once. Needs a server with JetStream.
#pragma once

#include <cstdint>
#include <cylpose/backend.hpp>
#include <cylpose/cluster/connection.hpp>
#include <cylpose/pose_io.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace cylpose::cluster {

struct Archive {
  /// Letters, digits, - and _: what it is called by submit and collect. Submitting it again goes on where it stopped.
  std::string name;
  std::string camera_yaml;
  std::string parts_yaml;
  std::vector<std::string> files;  ///< images, by paths that workers can open, unless they are uploaded
  /// Also put the images into the server, where they stay until their job is done: workers need no files.
  bool upload = false;
  PoseFormat format = PoseFormat::kCsv;
  double fps = 30;
  /// A job is so many frames in a row; each job begins with a search of the whole frame. Above 0.
  int frames_per_job = 16;

  [[nodiscard]] bool is_valid(std::string* why) const;
};

/// Puts all jobs into the queue; returns their number. Throws Error(kInput) for an archive that cannot be used or
/// another one of that name, Error(kDevice) when the server fails.
std::int64_t submit_archive(const ConnectionOptions& connection, const Archive& archive);

/// Works on jobs of all archives until `stop` says so. A server that is gone is waited for. Throws like run_worker.
void run_jobs(Backend& backend, const ConnectionOptions& connection, const std::function<bool()>& stop,
              const std::function<void(const std::string& what)>& on_event = {});

/// Gives the poses of all frames in order, as soon as they are there, to `write`: the text of a poses file in pieces.
/// Returns the number of jobs gathered, less than all only when `stop` said so. Throws Error(kInput) for an unknown
/// archive or one with a job that cannot be done, Error(kDevice) when the server refuses us.
std::int64_t collect_archive(const ConnectionOptions& connection, const std::string& name,
                             const std::function<void(std::string_view text)>& write,
                             const std::function<bool()>& stop);

}  // namespace cylpose::cluster
