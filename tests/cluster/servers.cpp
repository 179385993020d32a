#include "servers.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace cylpose::testing {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

bool is_free(int port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int reuse = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof reuse);
  const sockaddr_in address = loopback(port);
  const bool bound = ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return bound;
}

bool answers(int port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(port);
  const bool open = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return open;
}

}  // namespace

Port::Port() {
  std::random_device random;
  std::uniform_int_distribution<int> any(kFirst, kLast);
  for (int attempt = 0; attempt < kLast - kFirst; ++attempt) {
    number_ = any(random);
    sockaddr_un name{};  // a name without a file: gone with the process
    name.sun_family = AF_UNIX;
    const std::string text = "cylpose-test-port-" + std::to_string(number_);
    std::copy(text.begin(), text.end(), name.sun_path + 1);
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
    claim_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::bind(claim_, reinterpret_cast<const sockaddr*>(&name), size) == 0 && is_free(number_)) return;
    ::close(claim_);
  }
  throw std::runtime_error("no free port");
}

Port::~Port() {
  ::close(claim_);
}

Process::Process(const std::vector<std::string>& words, std::filesystem::path output) : output_(std::move(output)) {
  std::vector<std::string> copies = words;
  std::vector<char*> argv;
  for (std::string& word : copies) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  const int error = posix_spawnp(&id_, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start " + words.at(0));
}

Process::~Process() {
  kill();
}

Process::Process(Process&& other) noexcept : output_(std::move(other.output_)), id_(std::exchange(other.id_, -1)) {}

Process& Process::operator=(Process&& other) noexcept {
  if (this != &other) {
    kill();
    output_ = std::move(other.output_);
    id_ = std::exchange(other.id_, -1);
  }
  return *this;
}

std::string Process::output() const {
  return text_of(output_);
}

void Process::send(int signal) const {
  if (id_ > 0) ::kill(id_, signal);
}

bool Process::has_ended() const {
  siginfo_t ended{};
  return id_ <= 0 ||
         (::waitid(P_PID, static_cast<id_t>(id_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == id_);
}

int Process::wait() {
  if (id_ <= 0) return -1;
  int status = 0;
  ::waitpid(std::exchange(id_, -1), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void Process::kill() {
  send(SIGKILL);
  wait();
}

NatsServer::NatsServer(const std::filesystem::path& folder, const std::string& configuration)
    : folder_(folder), configuration_(configuration) {
  start();
}

std::string NatsServer::url(const std::string& scheme) const {
  return scheme + "://127.0.0.1:" + std::to_string(port());
}

void NatsServer::restart() {
  start();
}

void NatsServer::start() {
  const std::filesystem::path file = folder_ / "server.conf";
  std::ofstream(file) << "listen: \"127.0.0.1:" << port() << "\"\n" << configuration_;
  process_ = Process({"nats-server", "-c", file.string()}, folder_ / "server.log");
  if (!eventually([this] { return answers(port()); })) {
    throw std::runtime_error("nats-server does not start: " + process_.output());
  }
}

}  // namespace cylpose::testing
