// Clients that mean no good, and many of them.
#include "live/bounded_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cylpose/error.hpp>
#include <memory>
#include <system_error>
#include <vector>

#include "browser.hpp"

namespace cylpose::apps {
namespace {

using cylpose::testing::answered;
using cylpose::testing::Connection;
using cylpose::testing::get;
using ::testing::AllOf;
using ::testing::HasSubstr;

HttpAnswer greeting(const std::string& path) {
  if (path == "/large") return {200, "text/plain", std::string(50'000'000, 'x')};  // more than sockets hold
  if (path != "/") return {404, "text/plain", "no"};
  return {200, "text/plain", "hello"};
}

std::unique_ptr<BoundedServer> started(const ServerLimits& limits = {}, const std::string& address = "127.0.0.1") {
  auto server = std::make_unique<BoundedServer>(address, 0, greeting, HttpHeaders{{"X-Always", "yes"}}, limits);
  server->start();
  return server;
}

TEST(BoundedServer, AnswersGetAndHeadAndNothingElse) {
  const auto server = started();
  const auto page = get(server->port(), "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "hello");
  EXPECT_THAT(page.head, AllOf(HasSubstr("X-Always: yes"), HasSubstr("Connection: close")));
  const auto head = answered(server->port(), "HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.body, "");
  EXPECT_EQ(get(server->port(), "/elsewhere").status, 404);
  EXPECT_EQ(get(server->port(), "/../../etc/passwd").status, 404);
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "OPTIONS"}) {
    const auto refused = answered(
        server->port(), std::string(method) + " / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello");
    EXPECT_EQ(refused.status, 405) << method;
    EXPECT_THAT(refused.head, HasSubstr("Allow: GET, HEAD")) << method;
  }
}

TEST(BoundedServer, OnLoopbackOnlyLoopbackNamesAreAnswered) {
  const auto server = started();
  const auto status = [&](const std::string& host) {
    return answered(server->port(), "GET / HTTP/1.1\r\n" + host + "\r\n").status;
  };
  EXPECT_EQ(status("Host: localhost:1234\r\n"), 200);
  EXPECT_EQ(status("Host: 127.0.0.1\r\n"), 200);
  EXPECT_EQ(status("Host: [::1]:80\r\n"), 200);
  EXPECT_EQ(status("Host: evil.example\r\n"), 403);
  EXPECT_EQ(status("Host: 127.0.0.1.evil.example\r\n"), 403);
  EXPECT_EQ(status(""), 403);
}

TEST(BoundedServer, ListensWhereItIsToldAndNowhereElse) {
  const auto here = started();
  EXPECT_THROW(Connection(here->port(), "127.0.0.2"), std::system_error);
  const auto everywhere = started({}, "0.0.0.0");
  EXPECT_NO_THROW(Connection(everywhere->port(), "127.0.0.2"));
  EXPECT_EQ(answered(everywhere->port(), "GET / HTTP/1.1\r\nHost: camera.example\r\n\r\n").status, 200);
}

TEST(BoundedServer, SaysWhyAPortCannotBeServed) {
  const auto first = started();
  const auto refusal = [](const std::string& address, int port) -> std::string {
    try {
      const BoundedServer server(address, port, greeting, {});
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kOutput);
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("127.0.0.1", first->port()), AllOf(HasSubstr(std::to_string(first->port())), HasSubstr("in use"),
                                                         HasSubstr("0 for one that is free")));
  EXPECT_THAT(refusal("203.0.113.7", 0), HasSubstr("203.0.113.7"));
  EXPECT_THAT(refusal("no address", 0), HasSubstr("no address"));
}

TEST(BoundedServer, SurvivesRequestsThatAreNone) {
  const auto server = started();
  const std::string start = "GET / HTTP/1.1\r\nHost: localhost\r\n";
  std::string many_headers = start;
  while (many_headers.size() < 100'000) many_headers += "X-Some: thing\r\n";
  const std::vector<std::string> requests{
      "\r\n\r\n",
      "nonsense\r\n\r\n",
      std::string(1000, '\0') + "\r\n\r\n",
      "GET / HTTP/9.9\r\n\r\n",
      "BREW / HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /%zz%00%ff HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /" + std::string(1'000'000, 'a'),  // a line without an end
      "GET /" + std::string(5000, 'a') + " HTTP/1.1\r\nHost: localhost\r\n\r\n",
      start + "X-Long: " + std::string(1'000'000, 'a'),
      start + "Range: bytes=" + std::string(7000, '1') + "-\r\n\r\n",
      start + "Range: bytes=0-0" +
          [] {
            std::string more;
            while (more.size() < 7000) more += ",0-0";
            return more;
          }() +
          "\r\n\r\n",
      start + "Content-Length: 99999999999999999999\r\n\r\n",
      "POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n",
      "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n" + std::string(1'000'000, 'b'),
      many_headers,
  };
  for (const std::string& request : requests) {
    const int status = answered(server->port(), request).status;
    EXPECT_NE(status, 500) << request.substr(0, 60);
    EXPECT_EQ(get(server->port(), "/").body, "hello") << "after " << request.substr(0, 60);
  }
}

// A server without the limit would wait for the end of the line, for an hour.
TEST(BoundedServer, TakesNoMoreThanTheBytesOfARequest) {
  ServerLimits limits;
  limits.request_time = std::chrono::hours(1);
  const auto server = started(limits);
  const Connection endless(server->port());
  endless.send("GET / HTTP/1.1\r\nHost: localhost\r\nX-Long: " + std::string(limits.request_bytes, 'a'));
  EXPECT_THAT(endless.read_all(), ::testing::Not(HasSubstr("hello")));
  const auto fits = answered(server->port(), "GET / HTTP/1.1\r\nHost: localhost\r\nX-Long: " +
                                                 std::string(limits.request_bytes / 2, 'a') + "\r\n\r\n");
  EXPECT_EQ(fits.body, "hello");
}

TEST(BoundedServer, EndsRequestsThatNeverCome) {
  ServerLimits limits;
  limits.request_time = std::chrono::milliseconds(50);
  const auto server = started(limits);
  const Connection silent(server->port());
  EXPECT_EQ(silent.read_all(), "");  // returns, because the server closes
  const Connection slow(server->port());
  slow.send("GET / HTTP/1.1\r\nHost: local");
  EXPECT_THAT(slow.read_all(), ::testing::Not(HasSubstr("hello")));
}

TEST(BoundedServer, HasOnlySoManyConnectionsAtATime) {
  ServerLimits limits;
  limits.connections = 3;
  const auto server = started(limits);
  {
    std::vector<std::unique_ptr<Connection>> idle;
    for (int i = 0; i < 3; ++i) idle.push_back(std::make_unique<Connection>(server->port()));
    EXPECT_THAT(Connection(server->port()).read_all(), HasSubstr("503 Service Unavailable"));
  }
  // Their places are free again, once the server has seen that they are gone.
  int status = 0;
  while (status != 200) status = get(server->port(), "/").status;
}

TEST(BoundedServer, StopsAtOnceWhoeverIsConnected) {
  ServerLimits limits;
  limits.request_time = std::chrono::hours(1);
  limits.write_patience = std::chrono::hours(1);
  auto server = started(limits);
  const Connection silent(server->port());
  const Connection never_reads(server->port());
  never_reads.send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(never_reads.read_until("xxx"), HasSubstr("200 OK"));  // so both connections have been accepted
  server.reset();                                                   // would hang
  EXPECT_EQ(silent.read_all(), "");
}

TEST(BoundedServer, UrlsOpenInABrowser) {
  EXPECT_EQ(started()->url().substr(0, 17), "http://127.0.0.1:");
}

}  // namespace
}  // namespace cylpose::apps
