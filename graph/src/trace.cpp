#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <cylpose/graph/trace.hpp>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace cylpose::graph {

class Trace::File {
 public:
  explicit File(const std::filesystem::path& path) : name_(path.string()), file_(std::fopen(name_.c_str(), "wb")) {
    if (file_ == nullptr) fail();
    put("[\n");
  }

  ~File() {
    if (file_ != nullptr) std::fclose(file_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void thread_span(std::string_view name, std::int64_t frame, Clock::time_point start, Clock::time_point end) {
    const std::scoped_lock lock(mutex_);
    const auto [row, is_new] = threads_.try_emplace(std::this_thread::get_id(), threads_.size() + 1);
    if (is_new) put_name(row->second, fmt::format("thread {}", row->second));
    put_span(row->second, name, frame, start, end);
  }

  void lane_span(std::string_view group, std::uint64_t lane, std::string_view name, std::int64_t frame,
                 Clock::time_point start, Clock::time_point end) {
    constexpr std::size_t kFirstLane = 1'000'000;  // behind the threads
    const std::scoped_lock lock(mutex_);
    const auto [row, is_new] = lanes_.try_emplace({std::string(group), lane}, kFirstLane + lanes_.size());
    if (is_new) put_name(row->second, fmt::format("{} {}", group, lane));
    put_span(row->second, name, frame, start, end);
  }

  void close() {
    const std::scoped_lock lock(mutex_);
    put("\n]\n");
    std::FILE* file = std::exchange(file_, nullptr);
    const bool good = std::ferror(file) == 0;
    if (std::fclose(file) != 0 || !good) fail();
  }

 private:
  void put(std::string_view text) { std::fwrite(text.data(), 1, text.size(), file_); }

  void put_event(const std::string& event) { put(std::exchange(first_, false) ? event : ",\n" + event); }

  void put_name(std::size_t row, const std::string& name) {
    put_event(fmt::format(R"({{"ph":"M","name":"thread_name","pid":1,"tid":{},"args":{{"name":"{}"}}}})", row, name));
  }

  void put_span(std::size_t row, std::string_view name, std::int64_t frame, Clock::time_point start,
                Clock::time_point end) {
    const auto microseconds = [](Clock::duration d) { return std::chrono::duration<double, std::micro>(d).count(); };
    put_event(fmt::format(R"({{"ph":"X","name":"{}","pid":1,"tid":{},"ts":{:.3f},"dur":{:.3f},"args":{{"frame":{}}}}})",
                          name, row, microseconds(start - begin_), microseconds(end - start), frame));
  }

  [[noreturn]] void fail() const {
    throw Error(ErrorKind::kOutput,
                fmt::format("{}: cannot be written: {}; choose a place that exists, is writable and has room", name_,
                            std::strerror(errno)));
  }

  std::string name_;
  std::FILE* file_;
  Clock::time_point begin_ = Clock::now();
  std::mutex mutex_;
  bool first_ = true;
  std::map<std::thread::id, std::size_t> threads_;
  std::map<std::pair<std::string, std::uint64_t>, std::size_t> lanes_;
};

Trace::Trace(const std::filesystem::path& file) : file_(std::make_unique<File>(file)) {}

Trace::~Trace() = default;

void Trace::span(std::string_view name, std::int64_t frame, Clock::time_point start, Clock::time_point end) {
  file_->thread_span(name, frame, start, end);
}

void Trace::span(std::string_view group, std::uint64_t lane, std::string_view name, std::int64_t frame,
                 Clock::time_point start, Clock::time_point end) {
  file_->lane_span(group, lane, name, frame, start, end);
}

void Trace::close() {
  file_->close();
}

}  // namespace cylpose::graph
