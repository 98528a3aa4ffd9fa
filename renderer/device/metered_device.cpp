// Counts a device's memory.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/metered_device.h"

#include "renderer/device/mebibytes.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace kindling {

MeteredDevice::MeteredDevice(std::unique_ptr<Device> inner, std::optional<uint64_t> max_bytes)
    : inner_(std::move(inner)), max_bytes_(max_bytes) {}

std::byte* MeteredDevice::allocate(size_t bytes) {
  if (max_bytes_ && bytes_ + bytes > *max_bytes_)
    throw DeviceError(name() + ": no room for " + mebibytes(bytes) + ": " + mebibytes(bytes_) + " of the " +
                      mebibytes(*max_bytes_) + " of --device-memory are taken; use --device cpu");
  std::byte* const memory = inner_->allocate(bytes);
  allocated_.emplace(memory, bytes);
  bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, bytes_);
  return memory;
}

void MeteredDevice::release(std::byte* memory) noexcept {
  const auto found = allocated_.find(memory);
  assert(found != allocated_.end());
  bytes_ -= found->second;
  allocated_.erase(found);
  inner_->release(memory);
}

uint64_t MeteredDevice::free_bytes() const {
  const uint64_t free = inner_->free_bytes();
  return max_bytes_ ? std::min(free, *max_bytes_ - std::min(bytes_, *max_bytes_)) : free;
}

} // namespace kindling
