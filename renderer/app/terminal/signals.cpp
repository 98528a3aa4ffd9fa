// Signal handlers, which only touch lock-free atomics and _exit().
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/signals.h"

#include "renderer/app/terminal/exit_code.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>

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

} // namespace

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
