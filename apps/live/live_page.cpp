#include "live_page.hpp"

#include <thread>

#include "live_files.hpp"
#include "live_text.hpp"

namespace cylpose::apps {
namespace {

const HttpHeaders kHeaders{
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; base-uri 'none'; "
     "form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cache-Control", "no-store"},
};

HttpAnswer not_found() {
  constexpr int kNotFound = 404;
  return {kNotFound, "text/plain", "not here; the page is /\n"};
}

}  // namespace

LivePage::LivePage(const LiveState& state, const std::string& address, int port, const ServerLimits& limits)
    : state_(state),
      picture_(state),
      server_(
          address, port, [this](const std::string& path) { return answer(path); }, kHeaders, limits) {}

void LivePage::finish() {
  const auto end = std::chrono::steady_clock::now() + kPartingTime;
  while (streams_ > 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  server_.stop();
}

HttpAnswer LivePage::answer(const std::string& path) {
  constexpr int kOk = 200;
  if (path == "/") return {kOk, "text/html; charset=utf-8", live_files::page_html()};
  if (path == "/live.css") return {kOk, "text/css; charset=utf-8", live_files::base_css() + live_files::page_css()};
  if (path == "/live.js") return {kOk, "text/javascript; charset=utf-8", live_files::page_js()};
  if (path == "/icon.svg") return {kOk, "image/svg+xml", live_files::icon_svg()};
  if (path == "/metrics") return {kOk, "text/plain; version=0.0.4; charset=utf-8", to_metrics(*state_.view())};
  if (path == "/events") return events();
  if (path != "/picture.jpg") return not_found();
  const auto picture = picture_.latest();
  if (!picture) return not_found();
  return {kOk, "image/jpeg", picture->bytes, {{"X-Frame", std::to_string(picture->frame)}}};
}

HttpAnswer LivePage::events() {
  constexpr int kBusy = 503;
  const std::shared_ptr<void> counted(nullptr, [this](void*) { --streams_; });
  if (streams_.fetch_add(1) >= kMostStreams) return {kBusy, "text/plain", "too many viewers\n"};
  HttpAnswer answer{200, "text/event-stream", ""};
  answer.stream = [this, counted](const WriteChunk& write) {
    if (!write("data: " + to_json(*state_.view(), state_.facts()) + "\n\n")) return false;
    if (state_.has_ended()) {
      std::this_thread::sleep_for(kEventPeriod);  // until the viewer, or finish(), closes
    } else {
      state_.wait_for_end(kEventPeriod);
    }
    return true;
  };
  return answer;
}

}  // namespace cylpose::apps
