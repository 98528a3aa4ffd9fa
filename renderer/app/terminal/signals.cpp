// Signal handlers, which only touch lock-free atomics and _exit(), and the watcher of deadlines.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/signals.h"

#include "renderer/app/terminal/exit_code.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace kindling::app {

namespace {

std::atomic<CancelToken*> g_token{nullptr};
std::atomic<int> g_received{0};
static_assert(std::atomic<CancelToken*>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

void on_signal(int signal) {
  int none = 0;
  if (!g_received.compare_exchange_strong(none, signal)) _exit(exit_code_of_signal(signal));
  if (CancelToken* token = g_token.load()) token->cancel();
}

// Waits for the first signal and then takes the steps that are due.
void watch(const std::stop_token& stop, CancelToken& token, const StopEnforcement& enforcement) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kInterval = std::chrono::milliseconds(50); // a handler cannot notify
  std::optional<Clock::time_point> arrived;
  std::mutex mutex;
  std::condition_variable_any never;
  for (std::unique_lock lock(mutex); !stop.stop_requested();
       never.wait_for(lock, stop, kInterval, [] { return false; })) {
    if (g_received == 0) continue;
    if (!arrived) arrived = Clock::now();
    const double since_s = std::chrono::duration<double>(Clock::now() - *arrived).count();
    const StopStep step = stop_step(since_s, enforcement.storing && enforcement.storing(), enforcement.deadlines);
    if (step != StopStep::wait) token.abandon();
    if (step != StopStep::end) continue;
    enforcement.end(g_received);
    return;
  }
}

} // namespace

StopStep stop_step(double since_signal_s, bool storing, const StopDeadlines& deadlines) {
  if (since_signal_s >= deadlines.end_s && !storing) return StopStep::end;
  return since_signal_s >= deadlines.abandon_s ? StopStep::abandon : StopStep::wait;
}

SignalGuard::SignalGuard(CancelToken& token, StopEnforcement enforcement) : SignalGuard(token) {
  watcher_ =
      std::jthread([&token, own = std::move(enforcement)](const std::stop_token& stop) { watch(stop, token, own); });
}

SignalGuard::SignalGuard(CancelToken& token) {
  g_received = 0;
  g_token = &token;
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) {
    struct sigaction previous {};
    // nohup ignores SIGHUP, and background jobs of a script SIGINT; they stay ignored then.
    sigaction(signal, nullptr, &previous);
    if (previous.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
}

SignalGuard::~SignalGuard() {
  if (watcher_.joinable()) {
    watcher_.request_stop();
    watcher_.join();
  }
  for (const int signal : kSignals) {
    struct sigaction previous {};
    sigaction(signal, nullptr, &previous);
    if (previous.sa_handler == on_signal) ::signal(signal, SIG_DFL);
  }
  g_token = nullptr;
}

int SignalGuard::received() const { return g_received.load(); }

void ignore_signals_of_writing() {
  for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_IGN);
}

} // namespace kindling::app
