// Builds and traces accelerators of this library.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/contestant.h"

#include "accel/embree/embree_accelerator.h"
#include "renderer/app/shootout/measure_build.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace kindling::app {

std::unique_ptr<accel::Accelerator> build_variant(const accel::BuildInput& input, const AcceleratorVariant& variant,
                                                  int threads) {
  accel::BuildOptions options;
  options.quality = variant.quality;
  options.robust = variant.robust;
  options.simd = variant.simd;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] { return accel::make_accelerator(variant.kind, input, options); });
}

LocalContestant::LocalContestant(const accel::BuildInput& input, const AcceleratorVariant& variant,
                                 std::span<const RaySet> sets, bool embree_calls)
    : input_(input), variant_(variant), sets_(sets), embree_calls_(embree_calls) {}

LocalContestant::LocalContestant(const accel::Accelerator& accelerator, std::span<const RaySet> sets, bool embree_calls)
    : sets_(sets), embree_calls_(embree_calls) {
  adopt(accelerator);
}

void LocalContestant::adopt(const accel::Accelerator& accelerator) {
  accelerator_ = &accelerator;
  own_calls_.clear();
  if (!embree_calls_) return;
  using accel::EmbreeCall;
  for (const EmbreeCall call :
       {EmbreeCall::packet, EmbreeCall::coherent_packet, EmbreeCall::stream, EmbreeCall::coherent_stream})
    own_calls_.push_back(accel::with_embree_call(accelerator, call));
}

const accel::Accelerator* LocalContestant::by(CallForm form) const {
  if (every_accelerator_has(form)) return accelerator_;
  const size_t own = static_cast<size_t>(form) - static_cast<size_t>(CallForm::packet);
  return own < own_calls_.size() ? own_calls_[own].get() : nullptr;
}

std::optional<BuildMeasurement> LocalContestant::build(int threads, bool measures_memory) {
  own_calls_.clear();
  accelerator_ = nullptr;
  owned_.reset();
  BuildMeasurement result = measure_build(measures_memory, [&] { owned_ = build_variant(input_, variant_, threads); });
  adopt(*owned_);
  result.statistics = owned_->statistics();
  return result;
}

std::optional<WorkTime> LocalContestant::trace(size_t set, CallForm form, uint32_t batch_size, Answers& answers) {
  const accel::Accelerator& accelerator = *by(form);
  return measure(clock_s, [&] { app::trace(accelerator, sets_[set], form, batch_size, answers); });
}

std::vector<float> LocalContestant::time_singles(size_t set) {
  return time_single_calls(*accelerator_, sets_[set].rays);
}

} // namespace kindling::app
