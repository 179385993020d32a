// Archives, jobs and poses in JetStream. Two streams: CYLPOSE_JOBS, from which a job disappears when it is
// acknowledged, and CYLPOSE_POSES, which takes one message for each subject and no second one: that is what makes every
// frame come out once, however often its job was done.
//
//   cylpose.jobs.ARCHIVE.N      a job
//   cylpose.archive.ARCHIVE     what all its jobs have in common
//   cylpose.poses.ARCHIVE.N     the poses of job N
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "nats.hpp"

namespace cylpose::cluster {

class JobStore {
 public:
  /// Makes the streams where they are not there yet. Throws Error(kDevice).
  explicit JobStore(const Connection& connection);

  /// False when a message of that subject is there already. Throws Error(kDevice).
  bool put_once(const std::string& subject, const std::string& text);
  /// Throws Error(kDevice).
  void put_job(const std::string& archive, std::int64_t number, const std::string& text);
  /// None while there is none. Throws Error(kDevice) when the server does not answer.
  [[nodiscard]] std::optional<std::string> find(const std::string& subject);

  /// The next job; none after `patience`. To be acknowledged, or somebody else gets it. Throws Error(kDevice).
  [[nodiscard]] NatsMessage next_job(std::chrono::milliseconds patience);

 private:
  std::unique_ptr<jsCtx, Freed<jsCtx, jsCtx_Destroy>> context_;
  NatsSubscription jobs_;
};

/// A store on a server that may be killed and started again at any moment.
class PatientStore {
 public:
  /// `patience`: with a server that is gone. `stop` ends any wait.
  PatientStore(
      const Connection& connection, std::chrono::seconds patience, std::function<bool()> stop = [] { return false; });

  /// Does it, again and again until it does not fail, or until it is time to stop: so it must be a thing that may be
  /// done twice. Throws Error(kDevice) when patience is at its end, or the server is there but fails for some seconds.
  void ask(const std::function<void(JobStore&)>& what);

 private:
  const Connection& connection_;
  std::chrono::seconds patience_;
  std::function<bool()> stop_;
  std::optional<JobStore> store_;
};

}  // namespace cylpose::cluster
