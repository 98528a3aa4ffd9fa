// A device whose memory is counted, and may have a limit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>

namespace kindling {

class MeteredDevice final : public Device {
 public:
  // `max_bytes`: of everything that allocate() has given out; unset: what `inner` has.
  MeteredDevice(std::unique_ptr<Device> inner, std::optional<uint64_t> max_bytes);

  [[nodiscard]] std::string name() const override { return inner_->name(); }
  // Throws DeviceError beyond the limit.
  [[nodiscard]] std::byte* allocate(size_t bytes) override;
  void release(std::byte* memory) noexcept override;
  void upload(std::span<const std::byte> from, std::byte* to) override { inner_->upload(from, to); }
  void download(const std::byte* from, std::span<std::byte> to) override { inner_->download(from, to); }
  void clear(std::byte* memory, size_t bytes) override { inner_->clear(memory, bytes); }
  void lock(std::span<std::byte> memory) noexcept override { inner_->lock(memory); }
  void unlock(std::span<std::byte> memory) noexcept override { inner_->unlock(memory); }
  void prepare(std::span<const Kernel> kernels) override { inner_->prepare(kernels); }
  void launch(Kernel kernel, std::span<const std::byte> argument, uint32_t count) override {
    inner_->launch(kernel, argument, count);
  }
  [[nodiscard]] KernelUses kernel_uses() const override { return inner_->kernel_uses(); }
  [[nodiscard]] uint32_t wave_size() const override { return inner_->wave_size(); }
  [[nodiscard]] uint64_t free_bytes() const override;

  [[nodiscard]] uint64_t peak_bytes() const { return peak_bytes_; } // allocated at a time

 private:
  std::unique_ptr<Device> inner_;
  std::optional<uint64_t> max_bytes_;
  std::map<std::byte*, size_t> allocated_;
  uint64_t bytes_ = 0, peak_bytes_ = 0;
};

} // namespace kindling
