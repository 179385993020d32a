// Frames that the program pushes: NumPy arrays in, results in order out.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cylpose/error.hpp>
#include <cylpose/estimator.hpp>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "frame_results.hpp"
#include "images.hpp"
#include "models.hpp"

namespace cylpose::python {
namespace {

/// References to Python's objects that threads without the GIL let go of, until a thread with the GIL comes by.
class LetGo : public std::enable_shared_from_this<LetGo> {
 public:
  /// Keeps `object` until the last copy of the result ends, on whatever thread.
  std::shared_ptr<const void> keep(py::object object) {
    return {object.release().ptr(), [self = shared_from_this()](PyObject* let_go) {
              const std::scoped_lock lock(self->mutex_);
              self->objects_.push_back(let_go);
            }};
  }

  /// Drops them. With the GIL.
  void drop() {
    std::vector<PyObject*> objects;
    {
      const std::scoped_lock lock(mutex_);
      objects.swap(objects_);
    }
    for (PyObject* object : objects) Py_DECREF(object);
  }

 private:
  std::mutex mutex_;
  std::vector<PyObject*> objects_;
};

class PushPipeline {
 public:
  PushPipeline(const py::object& camera, const py::iterable& parts, const std::string& backend,
               const std::string& device, bool filter, bool live, int lag)
      : camera_(camera_of(camera)),
        pipeline_(make_pipeline({camera, parts, backend, device, filter, live, lag}, queue_, false)) {}
  // NOLINTNEXTLINE(bugprone-exception-escape): a mutex that cannot be locked leaves nothing to go on with
  ~PushPipeline() { close(); }
  PushPipeline(const PushPipeline&) = delete;
  PushPipeline& operator=(const PushPipeline&) = delete;

  std::int64_t put(const py::object& image, double timestamp_s, std::string_view color_order) {
    const ImageView view = view_of_array(image, color_order);
    require_usable(view);
    require_calibrated_size(camera_, view);
    if (!std::isfinite(timestamp_s)) throw Error(ErrorKind::kInput, "timestamp_s is not finite; give seconds");
    let_go_->drop();
    graph::SharedImage shared{view, let_go_->keep(image)};
    const py::gil_scoped_release no_gil;
    const std::scoped_lock lock(pipeline_mutex_);
    if (finished_ || !pipeline_->put({next_, timestamp_s, "", std::move(shared), {}})) {
      throw Error(ErrorKind::kInput, "the pipeline takes no frames after finish or close; make another one");
    }
    return next_++;
  }

  py::object next() {
    const graph::FramePtr frame = next_frame(queue_);
    let_go_->drop();
    if (!frame) throw py::stop_iteration();
    return result_of(*frame, false);
  }

  py::object try_next() {
    const std::optional<graph::FramePtr> frame = queue_.take(std::chrono::milliseconds(0));
    let_go_->drop();
    return frame && *frame ? py::object(result_of(**frame, false)) : py::none();
  }

  void finish() {
    const py::gil_scoped_release no_gil;
    const std::scoped_lock lock(pipeline_mutex_);
    if (!pipeline_) return;
    finished_ = true;
    pipeline_->wait_for_all();
    queue_.end();
  }

  // Gives back threads and memory.
  void close() {
    {
      const py::gil_scoped_release no_gil;
      const std::scoped_lock lock(pipeline_mutex_);
      queue_.close();
      finished_ = true;
      pipeline_.reset();
    }
    let_go_->drop();
  }

 private:
  CameraModel camera_;
  std::shared_ptr<LetGo> let_go_ = std::make_shared<LetGo>();
  ResultQueue queue_{std::numeric_limits<std::size_t>::max()};
  std::mutex pipeline_mutex_;  ///< numbers are given in the order of acceptance
  std::int64_t next_ = 0;
  bool finished_ = false;
  std::unique_ptr<graph::Pipeline> pipeline_;  ///< null once closed
};

}  // namespace

void bind_pipeline(py::module_& module) {
  py::class_<PushPipeline>(module, "Pipeline")
      .def(py::init<const py::object&, const py::iterable&, const std::string&, const std::string&, bool, bool, int>(),
           py::arg("camera"), py::arg("parts"), py::arg("backend"), py::arg("device"), py::arg("filter"),
           py::arg("live"), py::arg("lag"))
      .def("put", &PushPipeline::put, py::arg("image"), py::arg("timestamp_s"), py::arg("color_order"))
      .def("next", &PushPipeline::next)
      .def("try_next", &PushPipeline::try_next)
      .def("finish", &PushPipeline::finish)
      .def("close", &PushPipeline::close);
}

}  // namespace cylpose::python
