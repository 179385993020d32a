// How long a new process takes to its first result: once with nothing built before, once with what that left on disk.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "benchmarks.hpp"
#include "contender.hpp"
#include "scenes.hpp"

namespace cylpose::bench {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what) {
  throw Error(ErrorKind::kDevice, what);
}

// A home of its own for the process under test: whatever drivers and cylpose keep from run to run is in there.
class EmptyHome {
 public:
  EmptyHome() {
    std::string pattern = (fs::temp_directory_path() / "cylpose_bench_XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) fail("cannot make a folder like " + pattern);
    path_ = pattern;
  }
  ~EmptyHome() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  EmptyHome(const EmptyHome&) = delete;
  EmptyHome& operator=(const EmptyHome&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::vector<std::string> environment_at(const fs::path& home) {
  std::vector<std::string> variables;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::string_view name = text.substr(0, text.find('='));
    // Where drivers would look first, before the home.
    if (name == "HOME" || name == "XDG_CACHE_HOME" || name == "POCL_CACHE_DIR" || name == "CUDA_CACHE_PATH") continue;
    variables.emplace_back(text);
  }
  variables.push_back("HOME=" + home.string());
  variables.push_back("XDG_CACHE_HOME=" + (home / ".cache").string());
  return variables;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  result.reserve(texts.size() + 1);
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

std::string all_of(int file) {
  std::string text;
  std::array<char, 256> piece{};
  for (;;) {
    const ssize_t count = ::read(file, piece.data(), piece.size());
    if (count <= 0) return text;
    text.append(piece.data(), static_cast<std::size_t>(count));
  }
}

// This program again, for one backend's first result.
double first_result_ms(const std::string& backend, const fs::path& home) {
  std::vector<std::string> arguments{fs::read_symlink("/proc/self/exe").string(), "--first-result=" + backend};
  std::vector<std::string> environment = environment_at(home);
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail("no pipe for a new process");
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  pid_t process = 0;
  const int spawned = ::posix_spawn(&process, arguments[0].c_str(), &actions, nullptr, pointers(arguments).data(),
                                    pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  const std::string text = spawned == 0 ? all_of(ends[0]) : "";
  ::close(ends[0]);
  if (spawned != 0) fail("cannot run " + arguments[0] + " again");
  int status = 0;
  if (::waitpid(process, &status, 0) != process || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    fail("the process for the first result of " + backend + " failed");
  }
  return std::stod(text);
}

// Where a process with this backend ran before.
const fs::path& used_home(const std::string& backend) {
  static std::map<std::string, EmptyHome> homes;
  const auto [entry, added] = homes.try_emplace(backend);
  if (added) static_cast<void>(first_result_ms(backend, entry->second.path()));
  return entry->second.path();
}

void time_starts(const std::string& backend, bool warm, benchmark::State& state) {
  try {
    const EmptyHome empty;
    const fs::path& home = warm ? used_home(backend) : empty.path();
    for (auto _ : state) state.SetIterationTime(first_result_ms(backend, home) * 1e-3);
  } catch (const std::exception& error) {
    state.SkipWithError(error.what());
  }
}

}  // namespace

void register_start_benchmarks(const Register& add) {
  for (const BackendInfo& backend : backends()) {
    for (const bool warm : {false, true}) {
      benchmark::internal::Benchmark* added =
          add("start/" + backend.name + (warm ? "/warm" : "/cold"),
              [=, name = backend.name](benchmark::State& state) { time_starts(name, warm, state); });
      // A second iteration would not be cold; and building programs takes seconds, so there are few repetitions.
      if (added != nullptr) added->Iterations(1)->Repetitions(3)->UseManualTime();
    }
  }
}

void print_first_result_time(const std::string& backend) {
  const BenchScene scene = rectangle_scene();
  const auto start = std::chrono::steady_clock::now();
  const EdgeField field =
      make_backend(backend)->detect(scene.image(), scene.search, scene.parts, detect_options(scene));
  const auto taken = std::chrono::steady_clock::now() - start;
  if (field.parts.at(0).edges.empty()) fail(backend + " found no edge of a rectangle");
  fmt::print("{}\n", std::chrono::duration<double, std::milli>(taken).count());
}

}  // namespace cylpose::bench
