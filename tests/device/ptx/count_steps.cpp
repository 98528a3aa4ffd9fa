// Counts of launches, by kernel.
// SPDX-License-Identifier: Apache-2.0
#include "tests/device/ptx/count_steps.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <tuple>

namespace ptx {
namespace {

class Counts {
 public:
  ~Counts() {
    const char* const path = std::getenv("PTX_COUNTS");
    std::FILE* const file = path != nullptr ? std::fopen(path, "a") : nullptr;
    if (file == nullptr) return;
    for (const auto& [name, count] : by_kernel_) {
      std::string line = name;
      for (const u64 value :
           {count.launches, count.threads, count.instructions, count.issued, count.traffic.global.loaded,
            count.traffic.global.stored, count.traffic.local.loaded, count.traffic.local.stored})
        (line += ' ') += std::to_string(value);
      std::fprintf(file, "%s\n", line.c_str());
    }
    std::fclose(file);
  }
  void add(const std::string& name, const Count& count) {
    const std::lock_guard lock(mutex_);
    Count& sum = by_kernel_[name];
    sum.launches += count.launches;
    sum.threads += count.threads;
    sum.instructions += count.instructions;
    sum.issued += count.issued;
    sum.traffic.add(count.traffic);
  }

 private:
  std::mutex mutex_;
  std::map<std::string, Count> by_kernel_;
};
Counts counts;

// Returns true if a warp executes `a` before `b`.
bool precedes(const Step& a, const Step& b) {
  return std::tuple(~a.depth, a.function, a.block) < std::tuple(~b.depth, b.function, b.block);
}

} // namespace

u64 issued_by_warp(const std::vector<std::vector<Step>>& threads) {
  std::vector<size_t> at(threads.size(), 0);
  u64 issued = 0;
  while (true) {
    const Step* next = nullptr;
    for (size_t i = 0; i < threads.size(); ++i)
      if (at[i] < threads[i].size() && (next == nullptr || precedes(threads[i][at[i]], *next)))
        next = &threads[i][at[i]];
    if (next == nullptr) return issued;
    const Step step = *next;
    issued += step.function->blocks[step.block];
    for (size_t i = 0; i < threads.size(); ++i)
      if (at[i] < threads[i].size() && !precedes(step, threads[i][at[i]])) ++at[i];
  }
}

void add_count(const std::string& name, const Count& count) { counts.add(name, count); }

} // namespace ptx
