// Frames that cylpose reads itself: files, videos and cameras in, results in order out.
#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cylpose/frame_source.hpp>
#include <cylpose/graph/nodes.hpp>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bindings.hpp"
#include "frame_results.hpp"

namespace cylpose::python {
namespace {

using graph::Clock;

/// Reads on a thread of its own, so that a live camera is emptied while Python is busy. Results that nobody takes hold
/// the pipeline up: a recording waits, frames of a live stream grow stale there and are dropped.
class Stream {
 public:
  Stream(const std::vector<std::string>& inputs, double fps, bool images, const PipelineArguments& arguments)
      : live_(arguments.live), images_(images) {
    {
      const py::gil_scoped_release no_gil;
      source_ = open_frames(inputs, {fps});
    }
    pipeline_ = make_pipeline(arguments, queue_, images);
    reader_ = std::thread([this] { read(); });
  }
  // NOLINTNEXTLINE(bugprone-exception-escape): a mutex that cannot be locked leaves nothing to go on with
  ~Stream() { close(); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  py::object next() {
    const graph::FramePtr frame = next_frame(queue_);
    if (!frame) throw py::stop_iteration();
    return result_of(*frame, images_);
  }

  // Gives back threads, memory and cameras; who comes second waits until that is done.
  void close() {
    const py::gil_scoped_release no_gil;
    const std::scoped_lock lock(close_mutex_);
    if (!pipeline_) return;
    {
      const std::scoped_lock stop_lock(stop_mutex_);
      stop_ = true;
      stopped_.notify_all();
    }
    queue_.close();
    pipeline_->cancel();
    reader_.join();
    dropped_ = pipeline_->statistics().dropped;
    pipeline_.reset();
    warnings_ = source_->warnings();
    source_.reset();
  }

  [[nodiscard]] std::uint64_t dropped() {
    const py::gil_scoped_release no_gil;
    const std::scoped_lock lock(close_mutex_);
    return pipeline_ ? pipeline_->statistics().dropped : dropped_;
  }

  // None before all frames have been read: a source is not made to be asked meanwhile.
  [[nodiscard]] std::vector<std::string> warnings() {
    const py::gil_scoped_release no_gil;
    const std::scoped_lock lock(close_mutex_);
    return source_ && read_ ? source_->warnings() : warnings_;
  }

 private:
  void read() {
    std::exception_ptr failure;
    try {
      put_frames();
    } catch (...) {
      failure = std::current_exception();
    }
    pipeline_->wait_for_all();
    read_ = true;
    queue_.end(failure);
  }

  void put_frames() {
    const Clock::time_point start = Clock::now();
    while (std::optional<Frame> frame = source_->next()) {
      if (live_ && !wait_until(start + seconds(frame->timestamp_s))) return;
      if (!pipeline_->put(graph::input_of(std::move(*frame)))) return;
    }
  }

  static Clock::duration seconds(double value) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
  }

  // False when the stream was closed before.
  bool wait_until(Clock::time_point time) {
    std::unique_lock lock(stop_mutex_);
    return !stopped_.wait_until(lock, time, [this] { return stop_; });
  }

  const bool live_;
  const bool images_;
  std::unique_ptr<FrameSource> source_;
  ResultQueue queue_{1};
  std::unique_ptr<graph::Pipeline> pipeline_;
  std::mutex stop_mutex_;
  std::condition_variable stopped_;
  bool stop_ = false;
  std::atomic<bool> read_ = false;
  std::thread reader_;
  std::mutex close_mutex_;
  std::uint64_t dropped_ = 0;          ///< once closed
  std::vector<std::string> warnings_;  ///< once closed
};

std::unique_ptr<Stream> make_stream(const std::vector<std::string>& inputs, const py::object& camera,
                                    const py::iterable& parts, const std::string& backend, const std::string& device,
                                    bool filter, bool live, int lag, double fps, bool images) {
  return std::make_unique<Stream>(inputs, fps, images,
                                  PipelineArguments{camera, parts, backend, device, filter, live, lag});
}

}  // namespace

void bind_stream(py::module_& module) {
  py::class_<Stream>(module, "Stream")
      .def(py::init(&make_stream), py::arg("inputs"), py::arg("camera"), py::arg("parts"), py::arg("backend"),
           py::arg("device"), py::arg("filter"), py::arg("live"), py::arg("lag"), py::arg("fps"), py::arg("images"))
      .def("next", &Stream::next)
      .def("dropped", &Stream::dropped)
      .def("warnings", &Stream::warnings)
      .def("close", &Stream::close);
}

}  // namespace cylpose::python
