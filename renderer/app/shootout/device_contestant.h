// A device as a contestant of a race.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/answer_examiner.h"
#include "renderer/app/shootout/contestant.h"
#include "renderer/device/device.h"
#include "renderer/device/rays_on_device.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// Traces all rays of a set together, with a kd-tree that the processor builds. All its times are
// wall times. It has a fault once the device fails, or if its answers are
// impossible or change from pass to pass.
class DeviceContestant final : public Contestant {
 public:
  // Device, input and sets are borrowed. The input has no hit filter; `tree` is a kd-tree.
  DeviceContestant(Device& device, const accel::BuildInput& input, const AcceleratorVariant& tree,
                   std::span<const RaySet> sets);

  // Builds the tree and copies it; the memory is that on the device.
  std::optional<BuildMeasurement> build(int threads, bool measures_memory) override;
  bool has(CallForm form) const override { return is_device_call(form); }
  std::optional<WorkTime> trace(size_t set, CallForm form, uint32_t batch_size, Answers& answers) override;
  std::vector<float> time_singles(size_t /*set*/) override { return {}; }
  // The tree in the processor's memory.
  const accel::Accelerator& queries() const override { return *tree_; }
  std::string fault() const override { return fault_; }

  [[nodiscard]] size_t tree_bytes() const { return on_device_ ? on_device_->tree_bytes() : 0; }

 private:
  // Returns the wall time of `work`, nothing if the device fails.
  std::optional<WorkTime> time(const std::function<void()>& work);

  Device& device_;
  accel::BuildInput input_;
  AcceleratorVariant variant_;
  std::span<const RaySet> sets_;
  AnswerExaminer examiner_;
  std::string fault_;
  std::unique_ptr<accel::Accelerator> tree_;
  std::optional<RaysOnDevice> on_device_;
  std::vector<uint32_t> are_blocked_;
};

} // namespace kindling::app
