// Runs the kernels on the processor's threads, path by path in a shuffled order.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/host_device.h"

#include "renderer/base/hash.h"
#include "renderer/base/standard_arithmetic.h"
#include "renderer/device/kernels/all_kernels.h"
#include "renderer/device/shuffled_numbers.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <array>
#include <cassert>
#include <chrono>
#include <cstring>

namespace kindling {
namespace {

using RunKernel = void (*)(const std::byte* argument, uint32_t number);

constexpr std::array<RunKernel, kKernelCount> kKernels{
#define KINDLING_RUN_KERNEL(name, argument)                                                                            \
  [](const std::byte* from, uint32_t number) { kernels::name(*reinterpret_cast<const argument*>(from), number); },
    KINDLING_KERNELS(KINDLING_RUN_KERNEL)
#undef KINDLING_RUN_KERNEL
};

#define KINDLING_CHECK_ARGUMENT(name, argument) static_assert(sizeof(argument) <= kMaxArgumentBytes);
KINDLING_KERNELS(KINDLING_CHECK_ARGUMENT)
#undef KINDLING_CHECK_ARGUMENT

class HostDevice final : public Device {
 public:
  explicit HostDevice(int threads) : arena_(threads) {}

  [[nodiscard]] std::string name() const override { return "host"; }
  [[nodiscard]] std::byte* allocate(size_t bytes) override {
    auto* memory = static_cast<std::byte*>(::operator new(bytes, kAlignment, std::nothrow));
    if (memory == nullptr) throw DeviceError("device host: no memory for " + std::to_string(bytes) + " bytes");
    return memory;
  }
  void release(std::byte* memory) noexcept override { ::operator delete(memory, kAlignment); }
  void upload(std::span<const std::byte> from, std::byte* to) override {
    if (!from.empty()) std::memcpy(to, from.data(), from.size());
  }
  void download(const std::byte* from, std::span<std::byte> to) override {
    if (!to.empty()) std::memcpy(to.data(), from, to.size());
  }
  void clear(std::byte* memory, size_t bytes) override { std::memset(memory, 0, bytes); }

  void launch(Kernel kernel, std::span<const std::byte> argument, uint32_t count) override {
    if (count == 0) return;
    const RunKernel run = kKernels[static_cast<size_t>(kernel)];
    const ShuffledNumbers numbers(count, hash_u32(++launches_));
    const auto began = std::chrono::steady_clock::now();
    arena_.execute([&] {
      constexpr uint32_t kGrain = 64;
      tbb::parallel_for(tbb::blocked_range<uint32_t>(0, count, kGrain), [&](const auto& range) {
        const StandardArithmetic standard_arithmetic;
        for (uint32_t i = range.begin(); i < range.end(); ++i) run(argument.data(), numbers[i]);
      });
    });
    KernelUse& use = uses_[static_cast<size_t>(kernel)];
    ++use.launches;
    use.threads += count;
    use.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  }

  [[nodiscard]] KernelUses kernel_uses() const override { return uses_; }
  [[nodiscard]] uint32_t wave_size() const override { return kWaveSize; }

 private:
  static constexpr std::align_val_t kAlignment{256};

  tbb::task_arena arena_;
  uint32_t launches_ = 0;
  KernelUses uses_{};
};

} // namespace

std::unique_ptr<Device> make_host_device(int threads) { return std::make_unique<HostDevice>(threads); }

} // namespace kindling
