// A timeline of frames, nodes and device commands for Perfetto (ui.perfetto.dev) or chrome://tracing.
#pragma once

#include <cstdint>
#include <cylpose/graph/frame_task.hpp>
#include <filesystem>
#include <memory>
#include <string_view>

namespace cylpose::graph {

/// Writes the Chrome trace event format (a JSON array), event by event, so that the file of an interrupted run can be
/// used and memory does not grow. Any thread.
class Trace {
 public:
  /// Replaces the file. Throws Error(kOutput).
  explicit Trace(const std::filesystem::path& file);
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  /// Something the calling thread did with a frame.
  void span(std::string_view name, std::int64_t frame, Clock::time_point start, Clock::time_point end);

  /// Something that no thread did: on the row `lane` of the group `group`. Spans of one lane must not overlap.
  void span(std::string_view group, std::uint64_t lane, std::string_view name, std::int64_t frame,
            Clock::time_point start, Clock::time_point end);

  /// Ends the file. Throws Error(kOutput) when the disk was full.
  void close();

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace cylpose::graph
