// Runs one function on several threads, with exceptions handed to the caller.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace kindling {

// Calls work(0) on this thread and work(1) to work(count - 1) on threads of their own, and returns
// when all have returned. If one throws, calls stop(), which must make the others return, and
// rethrows the first exception.
template <typename Work, typename Stop>
void run_workers(size_t count, const Work& work, const Stop& stop) {
  std::mutex mutex;
  std::exception_ptr failure;
  const auto guarded = [&](size_t i) {
    try {
      work(i);
    } catch (...) {
      {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
      }
      stop();
    }
  };
  {
    std::vector<std::jthread> threads;
    threads.reserve(count - 1);
    for (size_t i = 1; i < count; ++i) threads.emplace_back(guarded, i);
    guarded(0);
  }
  if (failure) std::rethrow_exception(failure);
}

} // namespace kindling
