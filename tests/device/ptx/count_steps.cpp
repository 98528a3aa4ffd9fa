// Counts of launches, by kernel.
// SPDX-License-Identifier: Apache-2.0
#include "tests/device/ptx/count_steps.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <utility>

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

// The threads of a warp on their ways.
class Warp {
 public:
  explicit Warp(const std::vector<std::vector<Step>>& threads) : threads_(threads), at_(threads.size(), 0) {}

  u64 run() {
    Group all;
    for (u32 i = 0; i < threads_.size(); ++i)
      if (!threads_[i].empty()) all.push_back(i);
    run(std::move(all), 0, kNowhere);
    return issued_;
  }

 private:
  using Group = std::vector<u32>;
  static constexpr u32 kNowhere = ~0U;

  // The thread's next step in a function at this depth; null if it has returned.
  [[nodiscard]] const Step* next(u32 thread, u32 depth) const {
    const std::vector<Step>& steps = threads_[thread];
    return at_[thread] < steps.size() && steps[at_[thread]].depth >= depth ? &steps[at_[thread]] : nullptr;
  }
  void leave_out_returned(Group& group, u32 depth) const {
    std::erase_if(group, [&](u32 thread) { return next(thread, depth) == nullptr; });
  }

  // Executes what threads that are at one block do until they come to the block `until` of the same
  // call, or return from it.
  void run(Group group, u32 depth, u32 until) {
    while (true) {
      leave_out_returned(group, depth);
      if (group.empty()) return;
      const Step step = *next(group.front(), depth);
      if (step.block == until) return;
      issued_ += step.function->blocks[step.block];
      for (const u32 thread : group) ++at_[thread];
      leave_out_returned(group, depth);
      if (!group.empty() && next(group.front(), depth)->depth > depth) run(group, depth + 1, kNowhere);
      leave_out_returned(group, depth);
      std::map<u32, Group> ways; // by block
      for (const u32 thread : group) ways[next(thread, depth)->block].push_back(thread);
      if (ways.size() < 2) continue;
      const u32 meeting = step.function->meetings[step.block];
      for (auto& [block, way] : ways) run(std::move(way), depth, meeting);
    }
  }

  const std::vector<std::vector<Step>>& threads_;
  std::vector<size_t> at_;
  u64 issued_ = 0;
};

} // namespace

u64 issued_by_warp(const std::vector<std::vector<Step>>& threads) { return Warp(threads).run(); }

void add_count(const std::string& name, const Count& count) { counts.add(name, count); }

} // namespace ptx
