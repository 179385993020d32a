// Archives, jobs and poses in JetStream. CYLPOSE_JOBS is a stream, from which a job disappears when it is
// acknowledged, and CYLPOSE_POSES, which takes one message for each subject and no second one: that is what makes every
// frame come out once, however often its job was done. CYLPOSE_FRAMES holds images that were uploaded.
//
//   cylpose.jobs.ARCHIVE.N             a job
//   cylpose.archive.ARCHIVE            what all its jobs have in common
//   cylpose.poses.ARCHIVE.N            the poses of job N
//   cylpose.frames.ARCHIVE.N.I.PIECE   a piece of the file of its frame I
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "nats.hpp"

namespace cylpose::cluster {

inline constexpr const char* kJobSubjects = "cylpose.jobs.";
inline constexpr std::size_t kHeaderBytes = 1024;  ///< more than what the server counts besides the data of a message

/// `job` is ARCHIVE.N everywhere.
class JobStore {
 public:
  /// Makes the streams where they are not there yet. Throws Error(kDevice).
  explicit JobStore(const Connection& connection);

  /// False when a message of that subject is there already. Throws Error(kDevice).
  bool put_once(const std::string& subject, const std::string& text);
  /// Throws Error(kDevice).
  void put_job(const std::string& job, const std::string& text);
  /// None while there is none. Throws Error(kDevice) when the server does not answer.
  [[nodiscard]] std::optional<std::string> find(const std::string& subject);

  /// Puts a file in; returns how many messages it takes. Throws Error(kDevice).
  int put_frame(const std::string& job, std::size_t index, const std::string& bytes);
  /// None when a piece is not there. Throws Error(kDevice).
  [[nodiscard]] std::optional<std::string> frame(const std::string& job, std::size_t index, int messages);
  /// Of a job, or of a whole archive. Throws Error(kDevice).
  void drop_frames(const std::string& job_or_archive);

  /// The next job; none after `patience`. To be acknowledged, or somebody else gets it. Throws Error(kDevice).
  [[nodiscard]] NatsMessage next_job(std::chrono::milliseconds patience);

 private:
  void put(const std::string& subject, std::string_view bytes);

  const Connection& connection_;
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
