// TBB tasks for the thread sanitizer.
//
// `tasks ordered` shares data in all ways that Kindling uses and TBB orders; `tasks race` has a
// race.
// SPDX-License-Identifier: Apache-2.0
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <vector>

namespace {

// Runs tasks of every kind that Kindling uses, each of which reads data that others have written
// before.
bool ordered() {
  bool right = true;
  for (int round = 0; round < 50; ++round) {
    std::vector<int> values(5000);
    tbb::parallel_for(size_t{0}, values.size(), [&](size_t i) { values[i] = static_cast<int>(i * 7919 % 5000); });
    tbb::enumerable_thread_specific<std::vector<int>> seen;
    tbb::parallel_for(tbb::blocked_range<size_t>(0, values.size(), 16), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t i = range.begin(); i < range.end(); ++i) seen.local().push_back(values[values.size() - 1 - i]);
    });
    size_t count = 0;
    for (const std::vector<int>& some : seen) count += some.size();
    const int sum = tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, values.size()), 0,
        [&](const tbb::blocked_range<size_t>& range, int before) {
          return std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(range.begin()),
                                 values.begin() + static_cast<std::ptrdiff_t>(range.end()), before);
        },
        std::plus<>());
    tbb::parallel_sort(values.begin(), values.end());
    int first = 0, second = 0, third = 0;
    tbb::parallel_invoke([&] { first = values[1]; }, [&] { second = values[2]; });
    tbb::task_group group;
    group.run([&] {
      std::vector<int> more(100, first);
      tbb::parallel_for(0, 100, [&](int i) { more[static_cast<size_t>(i)] += second; });
      third = std::accumulate(more.begin(), more.end(), 0);
    });
    group.wait();
    tbb::task_arena(3).execute(
        [&] { tbb::parallel_for(0, 100, [&](int i) { values[static_cast<size_t>(i)] += third; }); });
    std::vector<int> thrown(100);
    try {
      tbb::parallel_for(0, 100, [&](int i) {
        thrown[static_cast<size_t>(i)] = 1;
        if (i == 77) throw std::runtime_error("77");
      });
    } catch (const std::runtime_error&) {
      thrown.assign(1, third);
    }
    right = right && count == 5000 && sum == 4999 * 2500 && third == 300 && values[99] == 399 && thrown.at(0) == 300;
  }
  // Threads that enter one arena, which admits one at a time.
  tbb::task_arena arena(1);
  std::vector<int> entered(4);
  {
    std::vector<std::jthread> threads;
    for (size_t t = 0; t < entered.size(); ++t)
      threads.emplace_back([&, t] {
        for (int i = 1; i <= 100; ++i) {
          const int before = entered[t];
          arena.execute([&] { entered[t] = before + 1; });
        }
      });
  }
  return right && entered == std::vector<int>(4, 100);
}

// Two tasks on two threads write the same variable, in no order: relaxed counts do not order them.
void race() {
  volatile int unprotected = 0;
  std::atomic<int> started{0};
  const auto write = [&] {
    started.fetch_add(1, std::memory_order_relaxed);
    for (int i = 0; i < 10'000'000 && started.load(std::memory_order_relaxed) < 2; ++i) std::this_thread::yield();
    // Many times, since the sanitizer may miss accesses at the same instant.
    for (int i = 0; i < 1000; ++i) unprotected = unprotected + 1;
  };
  tbb::parallel_invoke(write, write);
  std::printf("%d\n", static_cast<int>(unprotected));
}

} // namespace

int main(int argc, char** argv) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 4);
  const std::string_view mode = argc == 2 ? argv[1] : "";
  if (mode == "ordered") return ordered() ? 0 : 1;
  if (mode == "race") race();
  return 0;
}
