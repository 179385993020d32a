#include "job_store.hpp"

#include <fmt/format.h>

#include <cylpose/error.hpp>
#include <thread>
#include <utility>

namespace cylpose::cluster {
namespace {

constexpr const char* kJobs = "CYLPOSE_JOBS";
constexpr const char* kPoses = "CYLPOSE_POSES";
constexpr const char* kFrames = "CYLPOSE_FRAMES";

std::string frame_subject(const std::string& job, std::size_t index, int piece) {
  return fmt::format("cylpose.frames.{}.{}.{}", job, index, piece);
}

void add_stream(jsCtx* context, const char* name, std::vector<const char*> subjects, jsRetentionPolicy retention,
                std::int64_t per_subject) {
  jsStreamInfo* found = nullptr;
  const natsStatus there = js_GetStreamInfo(&found, context, name, nullptr, nullptr);
  jsStreamInfo_Destroy(found);
  if (there == NATS_OK) return;
  jsStreamConfig config;
  check(jsStreamConfig_Init(&config), "jsStreamConfig_Init");
  config.Name = name;
  config.Subjects = subjects.data();
  config.SubjectsLen = static_cast<int>(subjects.size());
  config.Retention = retention;
  config.Storage = js_FileStorage;
  config.MaxMsgsPerSubject = per_subject;
  config.AllowDirect = true;  // whole messages, not JSON around them
  check(js_AddStream(nullptr, context, &config, nullptr, nullptr), "js_AddStream (is JetStream on?)");
}

}  // namespace

JobStore::JobStore(const Connection& connection) : connection_(connection) {
  jsCtx* made = nullptr;
  check(natsConnection_JetStream(&made, connection.get(), nullptr), "natsConnection_JetStream");
  context_.reset(made);
  add_stream(made, kJobs, {"cylpose.jobs.*.*"}, js_WorkQueuePolicy, 1);
  add_stream(made, kPoses, {"cylpose.archive.*", "cylpose.poses.*.*"}, js_LimitsPolicy, 1);
  add_stream(made, kFrames, {"cylpose.frames.*.*.*.*"}, js_LimitsPolicy, 1);
}

bool JobStore::put_once(const std::string& subject, const std::string& text) {
  natsMsg* made = nullptr;
  check(natsMsg_Create(&made, subject.c_str(), nullptr, text.data(), static_cast<int>(text.size())), "natsMsg_Create");
  const NatsMessage message(made);
  // The client's own option is about the whole stream; that about the subject it can only say with a number above 0.
  check(natsMsgHeader_Set(made, "Nats-Expected-Last-Subject-Sequence", "0"), "natsMsgHeader_Set");
  jsErrCode error{};
  const natsStatus status = js_PublishMsg(nullptr, context_.get(), made, nullptr, &error);
  if (error == JSStreamWrongLastSequenceErr) return false;
  check(status, "js_PublishMsg");
  return true;
}

void JobStore::put_job(const std::string& job, const std::string& text) {
  put(kJobSubjects + job, text);
}

void JobStore::put(const std::string& subject, std::string_view bytes) {
  check(js_Publish(nullptr, context_.get(), subject.c_str(), bytes.data(), static_cast<int>(bytes.size()), nullptr,
                   nullptr),
        "js_Publish");
}

int JobStore::put_frame(const std::string& job, std::size_t index, const std::string& bytes) {
  const std::size_t most = connection_.most_payload();
  if (most <= kHeaderBytes) check(NATS_CONNECTION_DISCONNECTED, "natsConnection_GetMaxPayload");
  int pieces = 0;
  for (std::size_t from = 0; from < bytes.size(); from += most - kHeaderBytes) {
    put(frame_subject(job, index, pieces++), std::string_view(bytes).substr(from, most - kHeaderBytes));
  }
  return pieces;
}

std::optional<std::string> JobStore::frame(const std::string& job, std::size_t index, int messages) {
  std::string bytes;
  for (int piece = 0; piece < messages; ++piece) {
    const std::string subject = frame_subject(job, index, piece);
    jsDirectGetMsgOptions options;
    check(jsDirectGetMsgOptions_Init(&options), "jsDirectGetMsgOptions_Init");
    options.LastBySubject = subject.c_str();
    natsMsg* made = nullptr;
    const natsStatus status = js_DirectGetMsg(&made, context_.get(), kFrames, nullptr, &options);
    const NatsMessage message(made);
    if (status == NATS_NOT_FOUND) return std::nullopt;
    check(status, "js_DirectGetMsg");
    const auto data = data_of(message);
    bytes.append(data.begin(), data.end());
  }
  return bytes;
}

void JobStore::drop_frames(const std::string& job_or_archive) {
  jsOptions options;
  check(jsOptions_Init(&options), "jsOptions_Init");
  const std::string subject = fmt::format("cylpose.frames.{}.>", job_or_archive);
  options.Stream.Purge.Subject = subject.c_str();
  check(js_PurgeStream(context_.get(), kFrames, &options, nullptr), "js_PurgeStream");
}

std::optional<std::string> JobStore::find(const std::string& subject) {
  natsMsg* made = nullptr;
  jsErrCode error{};
  const natsStatus status = js_GetLastMsg(&made, context_.get(), kPoses, subject.c_str(), nullptr, &error);
  const NatsMessage message(made);
  if (error == JSNoMessageFoundErr) return std::nullopt;
  check(status, "js_GetLastMsg");
  const auto data = data_of(message);
  return std::string(data.begin(), data.end());
}

NatsMessage JobStore::next_job(std::chrono::milliseconds patience) {
  if (jobs_ == nullptr) {
    natsSubscription* made = nullptr;
    jsSubOptions options;
    check(jsSubOptions_Init(&options), "jsSubOptions_Init");
    options.Stream = kJobs;
    options.Config.AckWait = std::chrono::nanoseconds(std::chrono::seconds(10)).count();
    options.Config.AckPolicy = js_AckExplicit;
    check(js_PullSubscribe(&made, context_.get(), "cylpose.jobs.*.*", "workers", nullptr, &options, nullptr),
          "js_PullSubscribe");
    jobs_.reset(made);
  }
  natsMsgList list{};
  const natsStatus status = natsSubscription_Fetch(&list, jobs_.get(), 1, patience.count(), nullptr);
  if (status == NATS_TIMEOUT) return nullptr;
  check(status, "natsSubscription_Fetch");
  NatsMessage message(list.Msgs[0]);
  list.Msgs[0] = nullptr;
  natsMsgList_Destroy(&list);
  return message;
}

PatientStore::PatientStore(const Connection& connection, std::chrono::seconds patience, std::function<bool()> stop)
    : connection_(connection), patience_(patience), stop_(std::move(stop)) {}

void PatientStore::ask(const std::function<void(JobStore&)>& what) {
  constexpr std::chrono::seconds kFailing{20};
  constexpr std::chrono::milliseconds kRetry{50};
  const auto start = std::chrono::steady_clock::now();
  auto there_since = start;
  while (!stop_()) {
    try {
      if (!store_) store_.emplace(connection_);
      return what(*store_);
    } catch (const Error&) {
      store_.reset();
      const auto now = std::chrono::steady_clock::now();
      if (!connection_.connected()) there_since = now;
      if (connection_.closed() || now - start > patience_ || now - there_since > kFailing) throw;
    }
    std::this_thread::sleep_for(kRetry);
  }
}

}  // namespace cylpose::cluster
