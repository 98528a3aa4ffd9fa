// Launches of translated kernels: what fake_cuda.cpp runs instead of a GPU.
//
// Blocks of threads are taken by several threads of the host. A fault (machine.h) is printed with
// its place in the PTX, and the launch fails as on a GPU that is lost.
// SPDX-License-Identifier: Apache-2.0
#include "tests/device/ptx/machine.h"

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string_view>
#include <thread>

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

constexpr int kLaunchFailed = 719, kNotFound = 500;

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
  std::vector<Region> regions = regions_of_launch();
  std::atomic<unsigned> next_block = 0;
  std::atomic<bool> failed = false;
};

void run_blocks(Launch& launch) {
  std::fesetenv(FE_DFL_ENV); // no denormal number is flushed to zero, whatever the caller's thread does
  const auto thread = std::make_unique<Thread>(launch.regions);
  const unsigned blocks = launch.count / launch.threads_per_block + (launch.count % launch.threads_per_block > 0);
  thread->ntid_x = launch.threads_per_block;
  thread->nctaid_x = blocks;
  while (!launch.failed) {
    thread->ctaid_x = launch.next_block++;
    if (thread->ctaid_x >= blocks) return;
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
    }
  }
}

int run(const char* name, const void* argument, unsigned count, unsigned threads_per_block) {
  const auto entry = std::find_if(ptx_entries.begin(), ptx_entries.end(),
                                  [name](const Entry& one) { return std::string_view(one.name) == name; });
  if (entry == ptx_entries.end()) return kNotFound;
  Launch launch{*entry, argument, count, threads_per_block};
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i)
    threads.emplace_back([&launch] { run_blocks(launch); });
  for (std::thread& thread : threads) thread.join();
  return launch.failed ? kLaunchFailed : 0;
}

[[maybe_unused]] const bool is_installed = (fake_cuda_run = run, true);

} // namespace
} // namespace ptx
