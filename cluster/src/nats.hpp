// The NATS C client, checked and owned. Subjects of cylpose:
//
//   cylpose.who               coordinator -> nodes        who is there?
//   cylpose.node.NODE         node -> coordinators        Hello: a request for tiles
//   cylpose.tile.NODE         coordinator -> node         Tile or Refusal; NODE is name.random
//   cylpose.result.SESSION.ID node -> that coordinator    Result; the reply subject of the tile
//   $SRV.*                                                the services convention of NATS (service.hpp)
#pragma once

#include <nats/nats.h>

#include <chrono>
#include <cylpose/cluster/connection.hpp>
#include <functional>
#include <future>
#include <memory>
#include <span>
#include <string>

namespace cylpose::cluster {

template <typename T, void (*Free)(T*)>
struct Freed {
  void operator()(T* object) const { Free(object); }
};
using NatsMessage = std::unique_ptr<natsMsg, Freed<natsMsg, natsMsg_Destroy>>;
using NatsSubscription = std::unique_ptr<natsSubscription, Freed<natsSubscription, natsSubscription_Destroy>>;

/// Throws Error(kDevice) that names the call.
void check(natsStatus status, const char* call);

/// Twice so many hexadecimal digits.
[[nodiscard]] std::string random_word(std::size_t octets);

[[nodiscard]] std::span<const std::uint8_t> data_of(const NatsMessage& message);

/// No callbacks: who needs to know the state asks for it.
class Connection {
 public:
  /// Connects. Servers that cannot be reached are tried for ever, ever more slowly; one that refuses us is an error.
  /// Throws Error(kInput) for options, Error(kDevice) for a refusal.
  Connection(const ConnectionOptions& options, const std::string& name);

  /// Waits for a server; one that is being restarted is back within seconds. Throws Error(kDevice) when none answers in
  /// time, or one refuses us.
  void await_server() const;

  [[nodiscard]] natsConnection* get() const { return connection_.get(); }
  [[nodiscard]] bool connected() const;
  /// Refused after all, for instance because the server's configuration changed: it will not come back.
  [[nodiscard]] bool closed() const;
  [[nodiscard]] std::string last_error() const;
  /// The server's limit; 0 when not connected.
  [[nodiscard]] std::size_t most_payload() const;

  /// False when it could not be handed to the network.
  bool publish(const std::string& subject, std::span<const std::uint8_t> data, const std::string& reply = {}) const;
  bool publish(const std::string& subject, const std::string& text) const;

  /// Throws Error(kDevice).
  [[nodiscard]] NatsSubscription subscribe(const std::string& subject) const;

 private:
  std::string servers_;  ///< as given, for messages
  std::unique_ptr<natsConnection, Freed<natsConnection, natsConnection_Destroy>> connection_;
};

/// The next message; none after `patience`, or when the subscription is gone.
[[nodiscard]] NatsMessage next_message(const NatsSubscription& subscription, std::chrono::milliseconds patience);

/// Gives all messages on a subject to a handler, from a thread of the client's; also the server's word that nobody was
/// there to get what we sent (natsMsg_IsNoResponders), which next_message leaves out.
class Listener {
 public:
  /// The handler must not throw. Throws Error(kDevice).
  using Handler = std::function<void(const NatsMessage& message)>;
  Listener(const Connection& connection, const std::string& subject, Handler handler);
  /// Waits for the handler to return for the last time.
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

 private:
  Handler handler_;
  std::promise<void> ended_;
  NatsSubscription subscription_;
};

}  // namespace cylpose::cluster
