// Builds a kd-tree for a device, and lets the device trace.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/device_contestant.h"

#include "renderer/app/shootout/measure_build.h"
#include "renderer/device/failure_reason.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling::app {

DeviceContestant::DeviceContestant(Device& device, const accel::BuildInput& input, const AcceleratorVariant& tree,
                                   std::span<const RaySet> sets)
    : device_(device), input_(input), variant_(tree), sets_(sets), examiner_(input) {
  assert(variant_.kind == accel::Kind::kdtree && input_.filter.accept == nullptr);
}

std::optional<WorkTime> DeviceContestant::time(const std::function<void()>& work) {
  if (!fault_.empty()) return std::nullopt;
  try {
    const WorkTime measured = measure(clock_s, work);
    return WorkTime{measured.wall_s, measured.wall_s}; // this thread waits, but not for a processor
  } catch (const DeviceError& error) {
    fault_ = "failed: " + failure_reason(error.what());
    return std::nullopt;
  }
}

std::optional<BuildMeasurement> DeviceContestant::build(int threads, bool measures_memory) {
  on_device_.reset();
  tree_.reset();
  examiner_.forget();
  // A driver may compile for minutes, which is no part of a build.
  if (!time([&] { device_.prepare(std::array{Kernel::nearest_hit, Kernel::any_hit}); })) return std::nullopt;
  BuildMeasurement result = measure_build(measures_memory, [&] { tree_ = build_variant(input_, variant_, threads); });
  assert(check_device_rays(*tree_).ok());
  const std::optional<WorkTime> copied = time([&] { on_device_.emplace(device_, *tree_); });
  if (!copied) return std::nullopt;
  result.work += *copied;
  result.statistics = tree_->statistics();
  result.statistics.memory_bytes = tree_bytes();
  return result;
}

std::optional<WorkTime> DeviceContestant::trace(size_t set, CallForm form, uint32_t /*batch_size*/, Answers& answers) {
  const RaySet& rays = sets_[set];
  const bool nearest = rays.query == RayQuery::nearest;
  are_blocked_.resize(nearest ? 0 : rays.rays.size());
  const auto send = [&] { on_device_->set_rays(rays.rays); };
  const auto launch = [&] {
    if (nearest)
      on_device_->find_nearest_hits();
    else
      on_device_->find_any_hits();
  };
  const auto fetch = [&] {
    if (nearest)
      on_device_->copy_hits(answers.hits);
    else
      on_device_->copy_blocked(are_blocked_);
  };
  std::optional<WorkTime> measured;
  if (form == CallForm::launch_with_copies) {
    measured = time([&] {
      send();
      launch();
      fetch();
    });
  } else if (time(send)) {
    measured = time(launch);
    if (measured && !time(fetch)) measured.reset();
  }
  if (!measured) return std::nullopt;
  // Numbers that are neither 0 nor 1 remain such.
  for (size_t i = 0; i < are_blocked_.size(); ++i)
    answers.occluded[i] = static_cast<uint8_t>(std::min(are_blocked_[i], 255U));
  if (const std::string wrong = examiner_.examine(rays, set, form, answers); !wrong.empty()) {
    fault_ = fmt::format("lies while tracing {} by {}: {}", rays.name, call_form_name(form), wrong);
    return std::nullopt;
  }
  return measured;
}

} // namespace kindling::app
