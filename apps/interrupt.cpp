#include "interrupt.hpp"

#include <csignal>

namespace cylpose::apps {
namespace {

// A signal handler may touch nothing else.
volatile std::sig_atomic_t interrupted = 0;

void on_signal(int) {
  interrupted = 1;
}

void handle(int signal, void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupted = 0;
  // A write under way goes on: it would otherwise fail with EINTR and look like an output error.
  constexpr int kOnceAndRestart = static_cast<int>(SA_RESETHAND | SA_RESTART);
  handle(SIGINT, on_signal, kOnceAndRestart);
  handle(SIGTERM, on_signal, kOnceAndRestart);
  handle(SIGPIPE, SIG_IGN, 0);
}

InterruptGuard::~InterruptGuard() {
  handle(SIGINT, SIG_DFL, 0);
  handle(SIGTERM, SIG_DFL, 0);
  handle(SIGPIPE, SIG_DFL, 0);
}

bool InterruptGuard::requested() {
  return interrupted != 0;
}

}  // namespace cylpose::apps
