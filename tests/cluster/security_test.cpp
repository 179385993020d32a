// The sample configuration of cluster/deploy keeps everybody to his part, and the server lets nobody else in.
#include <cylpose/error.hpp>

#include "cluster_fixture.hpp"
#include "nats.hpp"
#include "nkey.hpp"

namespace cylpose::cluster {
namespace {

using ::cylpose::testing::eventually;
using ::cylpose::testing::four_parts;
using ::cylpose::testing::kPatience;
using ::cylpose::testing::NatsServer;
using ::cylpose::testing::Process;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

TEST(NKeys, ArePairs) {
  const NKey key = make_nkey();
  EXPECT_EQ(key.seed.size(), 58U);
  EXPECT_EQ(key.seed.substr(0, 2), "SU");
  EXPECT_EQ(key.public_key.size(), 56U);
  EXPECT_EQ(key.public_key[0], 'U');
  EXPECT_EQ(public_nkey(key.seed), key.public_key);
  EXPECT_NE(make_nkey().seed, key.seed);
  std::string wrong = key.seed;
  wrong[20] = wrong[20] == 'A' ? 'B' : 'A';
  EXPECT_THROW(static_cast<void>(public_nkey(wrong)), Error) << "the checksum does not hold";
  EXPECT_THROW(static_cast<void>(public_nkey("")), Error);
  EXPECT_THROW(static_cast<void>(public_nkey(key.public_key)), Error);
}

/// Two authorities, certificates and keys of all, and the server of the sample configuration.
class Security : public ::testing::Test {
 protected:
  Security() {
    make_authority("ca");
    make_authority("strangers");
    make_certificate("server", "ca");
    make_certificate("client", "ca");
    make_certificate("stranger", "strangers");
    for (const char* name : {"coordinator", "worker1", "guest", "unknown"}) {
      const NKey key = make_nkey();
      folder_.write(std::string(name) + ".nk", key.seed + "\n");
      std::string variable(name);
      for (char& c : variable) c = static_cast<char>(std::toupper(c));
      ::setenv((variable + "_NKEY").c_str(), key.public_key.c_str(), 1);
    }
    ::setenv("TLS_CERT", path("server.pem").c_str(), 1);
    ::setenv("TLS_KEY", path("server.key").c_str(), 1);
    ::setenv("TLS_CA", path("ca.pem").c_str(), 1);
    server_ = std::make_unique<NatsServer>(folder_.path(), text_of(CYLPOSE_SAMPLE_CONFIGURATION));
  }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  void openssl(std::vector<std::string> words) const {
    words.insert(words.begin(), "openssl");
    Process process(words, folder_.path() / "openssl.log");
    ASSERT_EQ(process.wait(), 0) << text_of(folder_.path() / "openssl.log");
  }

  void make_authority(const std::string& name) const {
    openssl({"req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
             "-subj", "/CN=" + name, "-keyout", path(name + ".key"), "-out", path(name + ".pem")});
  }

  void make_certificate(const std::string& name, const std::string& authority) const {
    folder_.write("san.cnf", "subjectAltName=IP:127.0.0.1\n");
    openssl({"req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-subj",
             "/CN=" + name, "-keyout", path(name + ".key"), "-out", path(name + ".csr")});
    openssl({"x509", "-req", "-in", path(name + ".csr"), "-CA", path(authority + ".pem"), "-CAkey",
             path(authority + ".key"), "-CAcreateserial", "-days", "2", "-extfile", path("san.cnf"), "-out",
             path(name + ".pem")});
  }

  [[nodiscard]] ConnectionOptions as(const std::string& who, const std::string& certificate = "client") const {
    ConnectionOptions options;
    options.servers = {server_->url("tls")};
    options.creds = path(who + ".nk");
    options.tls_ca = path("ca.pem");
    options.tls_cert = path(certificate + ".pem");
    options.tls_key = path(certificate + ".key");
    return options;
  }

  /// Connected for sure.
  class Client : public Connection {
   public:
    explicit Client(const ConnectionOptions& options) : Connection(options, "test") { await_server(); }
  };

  // A server that is too busy to refuse us in time is asked again.
  static bool is_refused(const ConnectionOptions& options) {
    return eventually([&] { return refusal_of(options).find("refuses") != std::string::npos; });
  }

  static std::string refusal_of(const ConnectionOptions& options) {
    try {
      const Connection connection(options, "test");
      return connection.connected() ? "connected" : "waiting";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kDevice);
      return error.what();
    }
  }

  TempDir folder_;
  std::unique_ptr<NatsServer> server_;
};

TEST_F(Security, FramesGoThroughTheSampleServer) {
  std::jthread worker([this](const std::stop_token& stop) {
    WorkerOptions options;
    options.connection = as("worker1");
    options.name = "worker1";
    const std::unique_ptr<Backend> serial = make_backend("serial");
    run_worker(*serial, options, [&] { return stop.stop_requested(); });
  });
  const auto cluster = testing::remote_coordinator(as("coordinator"), milliseconds(20'000), 16);
  ASSERT_TRUE(eventually([&] { return cluster->nodes().size() == 1; })) << server_->log();
  std::mt19937 random(1);
  const testing::TestImage image = testing::random_image(100, 80, random);
  for (int i = 0; i < 3; ++i) testing::expect_equal(*cluster, image.view(), image.view().bounds(), four_parts());
  const EdgeField expected = make_backend("serial")->detect(image.view(), image.view().bounds(), four_parts(), {});
  const EdgeField actual = cluster->detect(image.view(), image.view().bounds(), four_parts(), {});
  EXPECT_EQ(actual.parts[0].edges, expected.parts[0].edges);
  EXPECT_GE(cluster->counters().used, 5);
}

TEST_F(Security, NobodyElseGetsIn) {
  EXPECT_NO_THROW(Client(as("coordinator")));
  EXPECT_TRUE(is_refused(as("unknown")));
  ConnectionOptions nobody = as("coordinator");
  nobody.creds.clear();
  EXPECT_TRUE(is_refused(nobody));
  EXPECT_NE(refusal_of(as("coordinator", "stranger")), "connected");
  ConnectionOptions no_certificate = as("coordinator");
  no_certificate.tls_cert.clear();
  no_certificate.tls_key.clear();
  EXPECT_NE(refusal_of(no_certificate), "connected");
  ConnectionOptions other_authority = as("coordinator");
  other_authority.tls_ca = path("strangers.pem");
  EXPECT_NE(refusal_of(other_authority), "connected") << "we do not talk to a server of another authority";
  ConnectionOptions plain = as("coordinator");
  plain.servers = {server_->url("nats")};
  plain.tls_ca.clear();
  plain.tls_cert.clear();
  plain.tls_key.clear();
  EXPECT_NE(refusal_of(plain), "connected");
}

// Of so many signatures some begin with a zero, which libnats 3.4 does not send.
TEST(NKeys, OpenTheDoorEveryTime) {
  const TempDir folder;
  const NKey key = make_nkey();
  const NatsServer server(folder.path(), "authorization: {users: [{nkey: " + key.public_key + "}]}\n");
  ConnectionOptions options = testing::connection_to(server.url());
  options.creds = folder.write("key.nk", key.seed + "\n");
  for (int i = 0; i < 1000; ++i) ASSERT_NO_THROW(Connection(options, "test").await_server()) << i;
}

TEST_F(Security, AServerWithoutTlsIsNotTalkedToWhenTlsIsAskedFor) {
  TempDir folder;
  const NatsServer plain(folder.path());
  ConnectionOptions options = as("coordinator");
  options.servers = {plain.url("nats")};
  EXPECT_NE(refusal_of(options), "connected");
}

TEST_F(Security, FilesThatAreNoneAreNamed) {
  for (const char* member : {"creds", "ca", "cert"}) {
    ConnectionOptions options = as("coordinator");
    const std::string file = folder_.write("nonsense", "this is nothing\n").string();
    (member == std::string("creds") ? options.creds
     : member == std::string("ca")  ? options.tls_ca
                                    : options.tls_cert) = file;
    try {
      const Connection connection(options, "test");
      ADD_FAILURE() << member;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      EXPECT_THAT(error.what(), HasSubstr("nonsense"));
    }
  }
  ConnectionOptions half = as("coordinator");
  half.tls_key.clear();
  std::string why;
  EXPECT_FALSE(half.is_valid(&why));
}

// What reaches a listener in the coordinator's place, and one in a worker's.
TEST_F(Security, AWorkerKeepsToItsSubjects) {
  const Client coordinator(as("coordinator"));
  const NatsSubscription hellos = coordinator.subscribe("cylpose.node.>");
  const NatsSubscription results = coordinator.subscribe("cylpose.result.>");
  const Client worker(as("worker1"));
  const NatsSubscription tiles = worker.subscribe("cylpose.tile.worker1.aa");
  // The server refuses these and says so; nothing ever arrives.
  const NatsSubscription others_tiles = worker.subscribe("cylpose.tile.worker2.aa");
  const NatsSubscription others_results = worker.subscribe("cylpose.result.>");
  for (const Client* connection : {&coordinator, &worker}) {
    ASSERT_EQ(natsConnection_Flush(connection->get()), NATS_OK);
  }
  worker.publish("cylpose.node.worker2.aa", std::string("in another's name"));
  worker.publish("cylpose.tile.worker1.aa", std::string("a frame"));
  worker.publish("cylpose.result.session.1", std::string("unasked"));
  worker.publish("cylpose.who", std::string());
  worker.publish("cylpose.node.worker1.aa", std::string("allowed"));
  NatsMessage message = next_message(hellos, kPatience);
  ASSERT_NE(message, nullptr);
  EXPECT_STREQ(natsMsg_GetSubject(message.get()), "cylpose.node.worker1.aa") << "the only one that came through";
  EXPECT_EQ(next_message(hellos, milliseconds(100)), nullptr);
  EXPECT_EQ(next_message(results, milliseconds(100)), nullptr);
  EXPECT_EQ(next_message(tiles, milliseconds(100)), nullptr) << "a worker gives no work";

  const std::uint8_t tile[] = {1};
  coordinator.publish("cylpose.tile.worker2.aa", tile, "cylpose.result.session.1");
  coordinator.publish("cylpose.tile.worker1.aa", tile, "cylpose.result.session.2");
  ASSERT_NE(next_message(tiles, kPatience), nullptr);
  // The server tells that nobody got the first: worker2 is not there, and worker1 did not get to listen in its place.
  EXPECT_EQ(next_message(results, milliseconds(100)), nullptr);
  EXPECT_EQ(next_message(others_tiles, milliseconds(100)), nullptr);
  worker.publish("cylpose.result.session.2", std::string("the answer"));
  worker.publish("cylpose.result.session.2", std::string("a second answer"));
  ASSERT_NE(next_message(results, kPatience), nullptr) << "it may answer what it was asked";
  EXPECT_EQ(next_message(results, milliseconds(100)), nullptr) << "once";
  EXPECT_EQ(next_message(others_results, milliseconds(100)), nullptr);
}

TEST_F(Security, AnotherAccountHearsAndReachesNothing) {
  const Client coordinator(as("coordinator"));
  const NatsSubscription hellos = coordinator.subscribe("cylpose.node.>");
  const Client guest(as("guest"));
  const NatsSubscription everything = guest.subscribe(">");
  ASSERT_EQ(natsConnection_Flush(coordinator.get()), NATS_OK);
  ASSERT_EQ(natsConnection_Flush(guest.get()), NATS_OK);
  guest.publish("cylpose.node.guest.aa", std::string("let me in"));
  coordinator.publish("cylpose.tile.worker1.aa", std::string("a frame"));
  const NatsMessage own = next_message(everything, kPatience);
  ASSERT_NE(own, nullptr);
  EXPECT_STREQ(natsMsg_GetSubject(own.get()), "cylpose.node.guest.aa") << "only what it said itself";
  EXPECT_EQ(next_message(everything, milliseconds(200)), nullptr);
  EXPECT_EQ(next_message(hellos, milliseconds(100)), nullptr);
}

TEST_F(Security, TheServerTakesNoMessageLargerThanItsLimit) {
  const Client coordinator(as("coordinator"));
  ASSERT_GT(coordinator.most_payload(), 1000U);
  const std::vector<std::uint8_t> large(coordinator.most_payload() + 1);
  EXPECT_FALSE(coordinator.publish("cylpose.tile.worker1.aa", large));
}

}  // namespace
}  // namespace cylpose::cluster
