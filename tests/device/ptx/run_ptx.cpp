// Launches of translated kernels: what fake_cuda.cpp runs instead of a GPU.
//
// Blocks of threads are taken by several threads of the host. A fault (machine.h) is printed with
// its place in the PTX, and the launch fails as on a GPU that is lost.
// SPDX-License-Identifier: Apache-2.0
#include "tests/device/ptx/count_steps.h"
#include "tests/device/ptx/machine.h"

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <cstdio>
#include <memory>
#include <string_view>
#include <thread>
#include <utility>

extern const std::vector<ptx::Region> ptx_variables;
extern const std::vector<ptx::Entry> ptx_entries;

extern "C" {
extern int (*fake_cuda_run)(const char* name, const void* argument, unsigned count, unsigned threads_per_block);
void fake_cuda_visit(void (*visit)(void* context, const void* address, size_t bytes), void* context);
}

namespace ptx {

void Thread::search(u64 address, u32 bytes, Place place) {
  const auto after = std::upper_bound(regions_->begin(), regions_->end(), address,
                                      [](u64 at, const Region& region) { return at < region.begin; });
  if (after == regions_->begin() || !std::prev(after)->contains(address, bytes))
    refuse("address outside of all memory", address, place);
  last_ = *std::prev(after);
}

void Thread::refuse(const char* what, u64 address, Place place) {
  std::array<char, 24> hex{};
  std::snprintf(hex.data(), hex.size(), "0x%llx", static_cast<unsigned long long>(address));
  fault(std::string(what) + " " + hex.data() + " in line " + std::to_string(place.line) + " of " +
        place.function->name);
}

namespace {

constexpr int kInvalidValue = 1, kNotFound = 500, kLaunchFailed = 719;

#ifdef PTX_COUNT
constexpr bool kCounts = true;
#else
constexpr bool kCounts = false;
#endif

// All memory of a launch, in the order of its addresses.
std::vector<Region> regions_of_launch() {
  std::vector<Region> regions = ptx_variables;
  fake_cuda_visit(
      [](void* context, const void* address, size_t bytes) {
        static_cast<std::vector<Region>*>(context)->push_back({reinterpret_cast<u64>(address), bytes});
      },
      &regions);
  std::sort(regions.begin(), regions.end(), [](const Region& a, const Region& b) { return a.begin < b.begin; });
  return regions;
}

struct Launch {
  const Entry& entry;
  const void* argument;
  unsigned count, threads_per_block;
  unsigned blocks = count / threads_per_block + (count % threads_per_block > 0 ? 1 : 0);
  std::vector<Region> regions = regions_of_launch();
  std::atomic<unsigned> next_block = 0;
  std::atomic<bool> failed = false;
};

// Counts warps of threads; each is given after it ran.
class WarpCounter {
 public:
  void add(Thread& thread) {
    count_.threads += 1;
    for (const Step& step : thread.steps) count_.instructions += step.function->blocks[step.block];
    count_.traffic.add(std::exchange(thread.traffic, {}));
    warp_.push_back(std::exchange(thread.steps, {}));
    if (warp_.size() == kWarp) count_.issued += issued_by_warp(std::exchange(warp_, {}));
  }
  // Their number is a multiple of a warp's.
  [[nodiscard]] const Count& count() const { return count_; }

 private:
  Count count_;
  std::vector<std::vector<Step>> warp_;
};

void run_blocks(Launch& launch) {
  std::fesetenv(FE_DFL_ENV); // no denormal number is flushed to zero, whatever the caller's thread does
  const auto thread = std::make_unique<Thread>(launch.regions);
  WarpCounter counter;
  thread->ntid_x = launch.threads_per_block;
  thread->nctaid_x = launch.blocks;
  while (!launch.failed) {
    thread->ctaid_x = launch.next_block++;
    if (thread->ctaid_x >= launch.blocks) break;
    for (thread->tid_x = 0; thread->tid_x < launch.threads_per_block; ++thread->tid_x) {
      alignas(8) std::array<char, 8> address{}, number{};
      put(address.data(), reinterpret_cast<u64>(launch.argument));
      put(number.data(), launch.count);
      thread->leave(0);
      try {
        launch.entry.run(*thread, address.data(), number.data());
      } catch (const Fault& why) {
        if (!launch.failed.exchange(true))
          std::fprintf(stderr, "kernels.ptx: %s, thread %u: %s\n", launch.entry.name,
                       thread->ctaid_x * thread->ntid_x + thread->tid_x, why.what());
        return;
      }
      if constexpr (kCounts) counter.add(*thread);
    }
  }
  if constexpr (kCounts) add_count(launch.entry.name, counter.count());
}

int run(const char* name, const void* argument, unsigned count, unsigned threads_per_block) {
  const auto entry = std::find_if(ptx_entries.begin(), ptx_entries.end(),
                                  [name](const Entry& one) { return std::string_view(one.name) == name; });
  if (entry == ptx_entries.end()) return kNotFound;
  if (threads_per_block > entry->max_threads) return kInvalidValue;
  Launch launch{*entry, argument, count, threads_per_block};
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::min(launch.blocks, std::max(1U, std::thread::hardware_concurrency())); ++i)
    threads.emplace_back([&launch] { run_blocks(launch); });
  for (std::thread& thread : threads) thread.join();
  if constexpr (kCounts) add_count(name, {.launches = 1});
  return launch.failed ? kLaunchFailed : 0;
}

[[maybe_unused]] const bool is_installed = (fake_cuda_run = run, true);

} // namespace
} // namespace ptx
