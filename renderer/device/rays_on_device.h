// Batches of rays traced by a device, with the kd-tree that the processor has built.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/ray.h"
#include "renderer/base/result.h"
#include "renderer/device/device.h"
#include "renderer/device/kernels/ray_batch.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// Fails (usage) if no device can trace rays with the accelerator: it is no kd-tree, or it has a
// filter of hits.
[[nodiscard]] Result<void> check_device_rays(const accel::Accelerator& accelerator);

// Answers are those of Accelerator::intersect() and occluded(), bit for bit. All calls may throw
// DeviceError. The device must outlive it; the accelerator need not.
class RaysOnDevice {
 public:
  // Copies the tree. The accelerator has passed check_device_rays().
  RaysOnDevice(Device& device, const accel::Accelerator& accelerator);

  [[nodiscard]] size_t tree_bytes() const { return tree_.size(); }
  // Copies rays, at most 2^32 - 1, for the queries that follow. Memory is taken for the largest
  // number of rays so far.
  void set_rays(std::span<const accel::Ray> rays);
  // Traces all rays, and returns when that is done.
  void find_nearest_hits();
  void find_any_hits();
  // Copy the answers of the last query, as many as there are rays.
  void copy_hits(std::span<accel::Hit> hits) const { hits_.download(hits); }
  void copy_blocked(std::span<uint32_t> are_blocked) const { are_blocked_.download(are_blocked); }

 private:
  Device* device_;
  uint32_t count_ = 0; // of rays
  DeviceArray<std::byte> tree_;
  DeviceArray<accel::Ray> rays_;
  DeviceArray<accel::Hit> hits_;
  DeviceArray<uint32_t> are_blocked_;
  RayBatch batch_;
};

} // namespace kindling
