// A thread in place of the main thread, whose stack cannot grow beyond the limit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/thread_stack.h"

#include <fmt/format.h>

#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstring>

namespace kindling::app {

namespace {

constexpr size_t kStackBytes = size_t{8} << 20;

struct Call {
  const std::function<int()>* work;
  sigset_t signals; // mask of the calling thread
  int value = 0;
};

void* run(void* argument) {
  Call& call = *static_cast<Call*>(argument);
  pthread_sigmask(SIG_SETMASK, &call.signals, nullptr);
  call.value = (*call.work)();
  return nullptr;
}

} // namespace

Result<int> call_with_enough_stack(const std::function<int()>& work) {
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= kStackBytes)
    return work();
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_setattr_default_np(&attributes); // else later threads get the limit as their size
  Call call{&work, {}, 0};
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &call.signals); // this thread only waits
  pthread_t thread{};
  const int error = pthread_create(&thread, &attributes, run, &call);
  pthread_attr_destroy(&attributes);
  if (error == 0) {
    pthread_join(thread, nullptr);
    return call.value;
  }
  pthread_sigmask(SIG_SETMASK, &call.signals, nullptr);
  return Error{ErrorKind::render_failed,
               fmt::format("the stack limit is {} KiB, and no thread with {} KiB can be started: {}; raise it with "
                           "'ulimit -s {}'",
                           limit.rlim_cur >> 10, kStackBytes >> 10, std::strerror(error), kStackBytes >> 10)};
}

} // namespace kindling::app
