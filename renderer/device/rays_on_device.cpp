// Copies a kd-tree and rays to a device, and launches the queries.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/rays_on_device.h"

#include "accel/kdtree/kdtree_accelerator.h"
#include "accel/kdtree/view_tables.h"
#include "renderer/device/arena.h"

#include <array>
#include <cassert>
#include <limits>
#include <memory>

namespace kindling {
namespace {

size_t bytes_of(accel::kd::StructureView tree) {
  Arena counter;
  counter.place_arrays(tree);
  return counter.bytes();
}

} // namespace

Result<void> check_device_rays(const accel::Accelerator& accelerator) {
  const auto tables = accel::view_of(accelerator);
  if (tables == nullptr)
    return Error{ErrorKind::usage, "a device traces rays with the kd-tree alone; use --accel kdtree"};
  if (tables->filter().accept != nullptr)
    return Error{ErrorKind::usage, "a device traces rays through opaque meshes alone, and this scene has cut-outs"};
  return {};
}

RaysOnDevice::RaysOnDevice(Device& device, const accel::Accelerator& accelerator) : device_(&device) {
  const auto tables = accel::view_of(accelerator);
  assert(tables != nullptr && tables->filter().accept == nullptr);
  batch_.tree = tables->view();
  tree_ = DeviceArray<std::byte>(device, bytes_of(batch_.tree));
  Arena arena(device, tree_.data());
  arena.place_arrays(batch_.tree);
  device.prepare(std::array{Kernel::nearest_hit, Kernel::any_hit});
}

void RaysOnDevice::set_rays(std::span<const accel::Ray> rays) {
  assert(rays.size() <= std::numeric_limits<uint32_t>::max());
  count_ = static_cast<uint32_t>(rays.size());
  if (rays_.size() < rays.size()) {
    rays_ = {}; // first, so that its memory can be taken again
    hits_ = {};
    are_blocked_ = {};
    rays_ = DeviceArray<accel::Ray>(*device_, rays.size());
    hits_ = DeviceArray<accel::Hit>(*device_, rays.size());
    are_blocked_ = DeviceArray<uint32_t>(*device_, rays.size());
  }
  rays_.upload(rays);
  batch_.rays = rays_.data();
  batch_.hits = hits_.data();
  batch_.are_blocked = are_blocked_.data();
}

void RaysOnDevice::find_nearest_hits() {
  device_->launch(Kernel::nearest_hit, std::as_bytes(std::span(&batch_, 1)), count_);
  std::array<accel::Hit, 1> first;
  if (count_ > 0) hits_.download(first); // waits
}

void RaysOnDevice::find_any_hits() {
  device_->launch(Kernel::any_hit, std::as_bytes(std::span(&batch_, 1)), count_);
  std::array<uint32_t, 1> first{};
  if (count_ > 0) are_blocked_.download(first); // waits
}

} // namespace kindling
