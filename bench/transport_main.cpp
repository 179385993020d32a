// Core NATS against a JetStream work queue for what a frame needs: tiles to a worker, small answers back.
//
//   cylpose_transport_bench URL     the server needs JetStream
#include <fmt/format.h>
#include <nats/nats.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kAnswerBytes = 12'000;
constexpr std::int64_t kPatienceMs = 5000;

void check(natsStatus status, const char* call) {
  if (status != NATS_OK) throw std::runtime_error(fmt::format("{}: {}", call, natsStatus_GetText(status)));
}

natsConnection* connected(const char* url, bool send_asap) {
  natsOptions* options = nullptr;
  natsConnection* connection = nullptr;
  check(natsOptions_Create(&options), "natsOptions_Create");
  check(natsOptions_SetURL(options, url), "natsOptions_SetURL");
  check(natsOptions_SetSendAsap(options, send_asap), "natsOptions_SetSendAsap");
  check(natsConnection_Connect(&connection, options), "natsConnection_Connect");
  natsOptions_Destroy(options);
  return connection;
}

void answer(natsConnection* connection, const char* reply) {
  static const std::vector<char> bytes(kAnswerBytes);
  check(natsConnection_Publish(connection, reply, bytes.data(), kAnswerBytes), "natsConnection_Publish");
}

// Median and 99th percentile of the time from the first tile to the last answer.
template <typename Send>
void measure(const char* name, int tiles, int bytes, natsSubscription* answers, const Send& send) {
  constexpr int kWarmUp = 20;
  constexpr int kFrames = 200;
  const std::vector<char> tile(static_cast<std::size_t>(bytes));
  std::vector<double> times;
  for (int i = 0; i < kWarmUp + kFrames; ++i) {
    const auto start = Clock::now();
    for (int t = 0; t < tiles; ++t) send(tile);
    for (int t = 0; t < tiles; ++t) {
      natsMsg* message = nullptr;
      check(natsSubscription_NextMsg(&message, answers, kPatienceMs), "natsSubscription_NextMsg");
      natsMsg_Destroy(message);
    }
    if (i >= kWarmUp) times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  std::ranges::sort(times);
  fmt::print("{:<28} {} x {:>7} B: median {:6.2f} ms, p99 {:6.2f} ms\n", name, tiles, bytes, times[times.size() / 2],
             times[times.size() * 99 / 100]);
}

void core(const char* url, bool send_asap, int tiles, int bytes) {
  natsConnection* client = connected(url, send_asap);
  natsConnection* server = connected(url, send_asap);
  natsSubscription* work = nullptr;
  natsSubscription* answers = nullptr;
  check(natsConnection_SubscribeSync(&work, server, "bench.tile"), "natsConnection_SubscribeSync");
  check(natsConnection_SubscribeSync(&answers, client, "bench.answer"), "natsConnection_SubscribeSync");
  check(natsConnection_Flush(server), "natsConnection_Flush");
  check(natsConnection_Flush(client), "natsConnection_Flush");
  {
    const std::jthread worker([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        natsMsg* message = nullptr;
        if (natsSubscription_NextMsg(&message, work, 100) != NATS_OK) continue;
        answer(server, natsMsg_GetReply(message));
        natsMsg_Destroy(message);
      }
    });
    measure(send_asap ? "core NATS, sent at once" : "core NATS, client's default", tiles, bytes, answers,
            [&](const std::vector<char>& tile) {
              check(natsConnection_PublishRequest(client, "bench.tile", "bench.answer", tile.data(),
                                                  static_cast<int>(tile.size())),
                    "natsConnection_PublishRequest");
            });
  }
  natsSubscription_Destroy(work);
  natsSubscription_Destroy(answers);
  natsConnection_Destroy(client);
  natsConnection_Destroy(server);
}

void jetstream(const char* url, int tiles, int bytes) {
  natsConnection* client = connected(url, true);
  natsConnection* server = connected(url, true);
  jsCtx* sending = nullptr;
  jsCtx* working = nullptr;
  check(natsConnection_JetStream(&sending, client, nullptr), "natsConnection_JetStream");
  check(natsConnection_JetStream(&working, server, nullptr), "natsConnection_JetStream");
  jsStreamConfig config;
  check(jsStreamConfig_Init(&config), "jsStreamConfig_Init");
  const char* subjects[] = {"bench.job"};
  config.Name = "BENCH";
  config.Subjects = subjects;
  config.SubjectsLen = 1;
  config.Retention = js_WorkQueuePolicy;
  config.Storage = js_MemoryStorage;
  config.MaxAge = 1'000'000'000;
  static_cast<void>(js_DeleteStream(sending, "BENCH", nullptr, nullptr));
  check(js_AddStream(nullptr, sending, &config, nullptr, nullptr), "js_AddStream");
  natsSubscription* work = nullptr;
  natsSubscription* answers = nullptr;
  check(js_PullSubscribe(&work, working, "bench.job", "worker", nullptr, nullptr, nullptr), "js_PullSubscribe");
  check(natsConnection_SubscribeSync(&answers, client, "bench.answer"), "natsConnection_SubscribeSync");
  check(natsConnection_Flush(client), "natsConnection_Flush");
  {
    const std::jthread worker([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        natsMsgList list{};
        if (natsSubscription_Fetch(&list, work, 1, 100, nullptr) != NATS_OK) continue;
        answer(server, "bench.answer");
        check(natsMsg_Ack(list.Msgs[0], nullptr), "natsMsg_Ack");
        natsMsgList_Destroy(&list);
      }
    });
    measure("JetStream work queue", tiles, bytes, answers, [&](const std::vector<char>& tile) {
      check(js_PublishAsync(sending, "bench.job", tile.data(), static_cast<int>(tile.size()), nullptr),
            "js_PublishAsync");
    });
  }
  static_cast<void>(js_DeleteStream(sending, "BENCH", nullptr, nullptr));
  natsSubscription_Destroy(work);
  natsSubscription_Destroy(answers);
  jsCtx_Destroy(sending);
  jsCtx_Destroy(working);
  natsConnection_Destroy(client);
  natsConnection_Destroy(server);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("usage: cylpose_transport_bench URL");
    for (const auto& [tiles, bytes] : {std::pair{1, 140'625}, std::pair{1, 768'000}, std::pair{8, 345'600}}) {
      core(argv[1], false, tiles, bytes);
      core(argv[1], true, tiles, bytes);
      jetstream(argv[1], tiles, bytes);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cylpose_transport_bench: %s\n", error.what());
    return 1;
  }
}
