#include "live_viewer.hpp"

#include <httplib.h>

namespace cylpose::bench {

LiveViewer::LiveViewer(int port)
    : thread_([this, port] {
        httplib::Client events("localhost", port);
        httplib::Client pictures("localhost", port);
        events.Get("/events", [&](const char* /*data*/, std::size_t /*size*/) {
          static_cast<void>(pictures.Get("/picture.jpg"));
          looking_ = true;
          return !gone_;
        });
        looking_ = true;  // or there is no such page, and the bench shows no pictures made
      }) {
  while (!looking_) std::this_thread::yield();
}

LiveViewer::~LiveViewer() {
  gone_ = true;
  thread_.join();
}

}  // namespace cylpose::bench
