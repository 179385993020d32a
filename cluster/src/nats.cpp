#include "nats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cylpose/error.hpp>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "nkey.hpp"

namespace cylpose::cluster {
namespace {

using Options = std::unique_ptr<natsOptions, Freed<natsOptions, natsOptions_Destroy>>;

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// A quarter of a second, doubled with every round up to ten seconds.
std::int64_t reconnect_delay_ms(natsConnection* /*connection*/, int attempts, void* /*closure*/) {
  constexpr std::int64_t kFirst = 250;
  constexpr std::int64_t kLongest = 10'000;
  constexpr int kMostDoublings = 6;
  return std::min(kFirst << std::clamp(attempts - 1, 0, kMostDoublings), kLongest);
}

std::string identity_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw Error(ErrorKind::kInput, path.string() + ": cannot be read; name a credentials or NKey file");
  return text.str();
}

void set_identity(natsOptions* options, const std::filesystem::path& creds) {
  if (creds.empty()) return;
  const std::string text = identity_text(creds);
  if (text.find("BEGIN NATS USER JWT") != std::string::npos) {
    check(natsOptions_SetUserCredentialsFromFiles(options, creds.c_str(), nullptr), "set credentials");
    return;
  }
  std::string seed;
  std::istringstream(text) >> seed;
  try {
    check(natsOptions_SetNKeyFromSeed(options, public_nkey(seed).c_str(), creds.c_str()), "set NKey");
  } catch (const Error& error) {
    throw Error(error.kind(), creds.string() + ": neither NATS credentials nor the seed of an NKey: " + error.what());
  }
}

void set_tls(natsOptions* options, const ConnectionOptions& given) {
  if (given.tls_ca.empty()) return;
  check(natsOptions_SetSecure(options, true), "natsOptions_SetSecure");
  const auto load = [](natsStatus status, const std::filesystem::path& path) {
    if (status == NATS_OK) return;
    throw Error(ErrorKind::kInput,
                path.string() + ": cannot be read as a PEM certificate or key: " + natsStatus_GetText(status));
  };
  load(natsOptions_LoadCATrustedCertificates(options, given.tls_ca.c_str()), given.tls_ca);
  if (given.tls_cert.empty()) return;
  load(natsOptions_LoadCertificatesChain(options, given.tls_cert.c_str(), given.tls_key.c_str()), given.tls_cert);
}

Options options_for(const ConnectionOptions& given, const std::string& name) {
  natsOptions* made = nullptr;
  check(natsOptions_Create(&made), "natsOptions_Create");
  Options options(made);
  std::vector<const char*> servers;
  servers.reserve(given.servers.size());
  for (const std::string& server : given.servers) servers.push_back(server.c_str());
  if (natsOptions_SetServers(made, servers.data(), static_cast<int>(servers.size())) != NATS_OK) {
    throw Error(ErrorKind::kInput,
                joined(given.servers) + ": not the address of a NATS server; write nats://HOST:PORT");
  }
  check(natsOptions_SetNoRandomize(made, true), "natsOptions_SetNoRandomize");
  constexpr int kBufferBytes = 1 << 18;  // fewer calls for tiles than with the usual 32 KiB
  constexpr std::int64_t kConnectMs = 2000;
  constexpr std::int64_t kWriteMs = 2000;  // a network that takes nothing for so long is gone
  constexpr std::int64_t kPingMs = 10'000;
  check(natsOptions_SetName(made, name.c_str()), "natsOptions_SetName");
  check(natsOptions_SetTimeout(made, kConnectMs), "natsOptions_SetTimeout");
  check(natsOptions_SetPingInterval(made, kPingMs), "natsOptions_SetPingInterval");
  check(natsOptions_SetMaxReconnect(made, -1), "natsOptions_SetMaxReconnect");
  check(natsOptions_SetCustomReconnectDelay(made, reconnect_delay_ms, nullptr), "natsOptions_SetCustomReconnectDelay");
  check(natsOptions_SetSendAsap(made, true), "natsOptions_SetSendAsap");
  check(natsOptions_SetIOBufSize(made, kBufferBytes), "natsOptions_SetIOBufSize");
  check(natsOptions_SetWriteDeadline(made, kWriteMs), "natsOptions_SetWriteDeadline");
  // What was to be sent while there was no server is of no use to anybody later.
  check(natsOptions_SetReconnectBufSize(made, 1), "natsOptions_SetReconnectBufSize");
  check(natsOptions_SetFailRequestsOnDisconnect(made, true), "natsOptions_SetFailRequestsOnDisconnect");
  set_identity(made, given.creds);
  set_tls(made, given);
  return options;
}

[[noreturn]] void refused(const std::string& servers, const std::string& why) {
  throw Error(ErrorKind::kDevice, servers + ": the server refuses the connection: " + why +
                                      "; check --server, --creds and the --tls files");
}

}  // namespace

bool ConnectionOptions::is_valid(std::string* why) const {
  const auto refuse = [why](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  if (servers.empty()) return refuse("no server is named; write nats://HOST:PORT");
  for (const std::string& server : servers) {
    if (server.starts_with("nats://") || server.starts_with("tls://")) continue;
    return refuse("'" + server + "' is no server's address; write nats://HOST:PORT");
  }
  if (tls_cert.empty() != tls_key.empty()) return refuse("a certificate and its key go together; give both or none");
  if (!tls_cert.empty() && tls_ca.empty()) return refuse("a certificate of our own needs the authority's as well");
  return true;
}

void check(natsStatus status, const char* call) {
  if (status == NATS_OK) return;
  throw Error(ErrorKind::kDevice, fmt::format("NATS: {}: {}", call, natsStatus_GetText(status)));
}

std::string random_word(std::size_t octets) {
  std::random_device random;
  std::string word;
  for (std::size_t i = 0; i < octets; ++i) word += fmt::format("{:02x}", random() & 255U);
  return word;
}

std::span<const std::uint8_t> data_of(const NatsMessage& message) {
  return {reinterpret_cast<const std::uint8_t*>(natsMsg_GetData(message.get())),
          static_cast<std::size_t>(natsMsg_GetDataLength(message.get()))};
}

Connection::Connection(const ConnectionOptions& options, const std::string& name) : servers_(joined(options.servers)) {
  if (std::string why; !options.is_valid(&why)) throw Error(ErrorKind::kInput, "connection to NATS: " + why);
  const Options settings = options_for(options, name);
  natsConnection* made = nullptr;
  natsStatus status = natsConnection_Connect(&made, settings.get());
  // The client leaves out a signature that begins with a zero, one in 256: every attempt signs something else.
  for (int again = 0; again < 2 && status == NATS_CONNECTION_AUTH_FAILED && !options.creds.empty(); ++again) {
    status = natsConnection_Connect(&made, settings.get());
  }
  // A server that dies during the greeting leaves the protocol broken.
  constexpr std::array kOutOfReach{
      NATS_NO_SERVER,        NATS_TIMEOUT,       NATS_IO_ERROR, NATS_CONNECTION_CLOSED, NATS_CONNECTION_DISCONNECTED,
      NATS_STALE_CONNECTION, NATS_PROTOCOL_ERROR};
  if (std::ranges::find(kOutOfReach, status) != kOutOfReach.end()) {
    // Only with a callback does the client try in the background.
    check(natsOptions_SetRetryOnFailedConnect(
              settings.get(), true, [](natsConnection*, void*) {}, nullptr),
          "natsOptions_SetRetryOnFailedConnect");
    status = natsConnection_Connect(&made, settings.get());
  }
  if (status != NATS_OK && status != NATS_NOT_YET_CONNECTED) {
    natsStatus ignored = NATS_OK;
    const char* detail = nats_GetLastError(&ignored);
    refused(servers_, natsStatus_GetText(status) + (detail != nullptr ? std::string(": ") + detail : std::string()));
  }
  connection_.reset(made);
}

void Connection::await_server() const {
  constexpr std::chrono::seconds kPatience{5};
  constexpr std::chrono::milliseconds kLook{10};
  const auto start = std::chrono::steady_clock::now();
  while (!connected()) {
    if (closed()) refused(servers_, last_error());
    if (std::chrono::steady_clock::now() - start > kPatience) {
      throw Error(ErrorKind::kDevice, fmt::format("{}: no NATS server answers within {} s; start nats-server there, or "
                                                  "name another with --server",
                                                  servers_, kPatience.count()));
    }
    std::this_thread::sleep_for(kLook);
  }
}

bool Connection::connected() const {
  return natsConnection_Status(connection_.get()) == NATS_CONN_STATUS_CONNECTED;
}

bool Connection::closed() const {
  return natsConnection_IsClosed(connection_.get());
}

std::string Connection::last_error() const {
  const char* text = nullptr;
  const natsStatus status = natsConnection_GetLastError(connection_.get(), &text);
  return text != nullptr && *text != '\0' ? text : natsStatus_GetText(status);
}

std::size_t Connection::most_payload() const {
  const std::int64_t bytes = connected() ? natsConnection_GetMaxPayload(connection_.get()) : 0;
  return bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

bool Connection::publish(const std::string& subject, std::span<const std::uint8_t> data,
                         const std::string& reply) const {
  const auto size = static_cast<int>(data.size());
  if (reply.empty()) return natsConnection_Publish(get(), subject.c_str(), data.data(), size) == NATS_OK;
  return natsConnection_PublishRequest(get(), subject.c_str(), reply.c_str(), data.data(), size) == NATS_OK;
}

bool Connection::publish(const std::string& subject, const std::string& text) const {
  return publish(subject, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

NatsSubscription Connection::subscribe(const std::string& subject) const {
  natsSubscription* made = nullptr;
  check(natsConnection_SubscribeSync(&made, connection_.get(), subject.c_str()), "natsConnection_SubscribeSync");
  return NatsSubscription(made);
}

NatsMessage next_message(const NatsSubscription& subscription, std::chrono::milliseconds patience) {
  natsMsg* message = nullptr;
  const natsStatus status = natsSubscription_NextMsg(&message, subscription.get(), patience.count());
  return NatsMessage(status == NATS_OK ? message : nullptr);
}

Listener::Listener(const Connection& connection, const std::string& subject, Handler handler)
    : handler_(std::move(handler)) {
  const auto on_message = [](natsConnection*, natsSubscription*, natsMsg* message, void* self) {
    static_cast<Listener*>(self)->handler_(NatsMessage(message));
  };
  natsSubscription* made = nullptr;
  check(natsConnection_Subscribe(&made, connection.get(), subject.c_str(), on_message, this),
        "natsConnection_Subscribe");
  subscription_.reset(made);
  const auto on_end = [](void* self) { static_cast<Listener*>(self)->ended_.set_value(); };
  check(natsSubscription_SetOnCompleteCB(made, on_end, this), "natsSubscription_SetOnCompleteCB");
}

Listener::~Listener() {
  // Where the connection is closed this fails, and the end has come or comes by itself.
  static_cast<void>(natsSubscription_Unsubscribe(subscription_.get()));
  ended_.get_future().wait();
}

}  // namespace cylpose::cluster
