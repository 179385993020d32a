#include <algorithm>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <mutex>
#include <utility>

#include "builtin_backends.hpp"

namespace cylpose {
namespace {

// Built on first use, so that libraries may register from their static initialisers whatever the order.
class Registry {
 public:
  static Registry& instance() {
    static Registry registry;
    return registry;
  }

  std::vector<BackendInfo> all() const {
    const std::scoped_lock lock(mutex_);
    return infos_;
  }

  void add(BackendInfo info) {
    const std::scoped_lock lock(mutex_);
    if (std::ranges::find(infos_, info.name, &BackendInfo::name) != infos_.end()) {
      throw Error(ErrorKind::kInput, "a backend named '" + info.name + "' is registered already; choose another name");
    }
    infos_.push_back(std::move(info));
  }

 private:
  Registry()
      : infos_{{"serial", "plain C++ on one thread; defines the right answer", make_serial_backend},
               {"opencv", "OpenCV's functions on all threads; the peer to compare with", make_opencv_backend}} {
#ifdef CYLPOSE_WITH_OPENCL
    infos_.push_back({"opencl", "OpenCL kernels on a CPU, GPU or accelerator", make_default_opencl_backend});
#endif
  }

  mutable std::mutex mutex_;
  std::vector<BackendInfo> infos_;
};

class WholeDetection final : public DetectionEnd {
 public:
  WholeDetection(Backend& backend, const DetectRequest& request) : backend_(backend), request_(request) {}

  [[nodiscard]] EdgeField field() override {
    return backend_.detect(request_.image, request_.search, request_.parts, request_.options);
  }

 private:
  Backend& backend_;
  DetectRequest request_;
};

}  // namespace

bool DetectOptions::is_valid(std::string* why) const {
  const auto refuse = [why](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  if (edge_high < 1 || edge_high > 255) {
    return refuse("edge_high is " + std::to_string(edge_high) + "; it must be 1 to 255 levels per pixel");
  }
  if (edge_low < 1 || edge_low > edge_high) {
    return refuse("edge_low is " + std::to_string(edge_low) + "; it must be 1 to edge_high (" +
                  std::to_string(edge_high) + ") levels per pixel");
  }
  if (rows.first < 0 || rows.end < rows.first) {
    return refuse("rows are " + std::to_string(rows.first) + " to " + std::to_string(rows.end) +
                  "; the first must be at least 0 and at most the end");
  }
  if (with_mask && rows != Rows()) {
    return refuse("a mask was asked for together with a choice of rows; ask for one of the two");
  }
  return true;
}

void Backend::detect_async(const DetectRequest& request, const OnDetected& done) {
  done(std::make_shared<WholeDetection>(*this, request));
}

Roi usable_search(const ImageView& image, const Roi& search, const DetectOptions& options) {
  require_usable(image);
  if (std::string why; !options.is_valid(&why)) {
    throw Error(ErrorKind::kInput, "options of the edge detection: " + why);
  }
  return intersection(search, image.bounds());
}

std::vector<BackendInfo> backends() {
  return Registry::instance().all();
}

void register_backend(BackendInfo info) {
  Registry::instance().add(std::move(info));
}

std::unique_ptr<Backend> make_backend(std::string_view name) {
  // The copy lets make() run without the lock: it may take long (a device) or register backends itself.
  const std::vector<BackendInfo> known = backends();
  const auto found = std::ranges::find(known, name, &BackendInfo::name);
  if (found == known.end()) {
    std::string names;
    for (const BackendInfo& info : known) {
      names += (names.empty() ? "" : ", ") + info.name;
    }
    throw Error(ErrorKind::kInput, "there is no backend '" + std::string(name) + "'; known are: " + names);
  }
  return found->make();
}

}  // namespace cylpose
