// Builds and traversal, measured in turn.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout_measure.h"

#include "renderer/app/process_info.h"
#include "renderer/base/flush_denormals.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

namespace kindling::app {

namespace {

// One build; with `threads` in all, the calling one among them.
std::unique_ptr<accel::Accelerator> build(const accel::BuildInput& input, const AcceleratorVariant& variant,
                                          int threads) {
  accel::BuildOptions options;
  options.quality = variant.quality;
  options.robust = variant.robust;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] { return accel::make_accelerator(variant.kind, input, options); });
}

float distance_tolerance(const accel::Ray& ray, float t) {
  const float largest =
      std::max({std::fabs(ray.origin.x), std::fabs(ray.origin.y), std::fabs(ray.origin.z)}) / ray.direction.length();
  return kDistanceTolerance * (t + largest);
}

// Of one ray after the other.
size_t chunk_of(const RaySet& set, CallForm form, uint32_t batch_size) {
  return form == CallForm::coherent ? set.coherent_group : batch_size;
}

} // namespace

Answers::Answers(const RaySet& set) {
  if (set.query == RayQuery::nearest)
    hits.resize(set.rays.size());
  else
    occluded.resize(set.rays.size());
}

std::vector<CallForm> call_forms(const RaySet& set) {
  if (set.rays.empty()) return {};
  if (set.query == RayQuery::nearest && set.coherent_group > 0)
    return {CallForm::single, CallForm::batch, CallForm::coherent};
  return {CallForm::single, CallForm::batch};
}

void trace(const accel::Accelerator& accelerator, const RaySet& set, CallForm form, uint32_t batch_size,
           Answers& answers) {
  const std::span<const accel::Ray> rays(set.rays);
  if (form == CallForm::single) {
    if (set.query == RayQuery::nearest)
      for (size_t i = 0; i < rays.size(); ++i) answers.hits[i] = accelerator.intersect(rays[i]);
    else
      for (size_t i = 0; i < rays.size(); ++i) answers.occluded[i] = accelerator.occluded(rays[i]) ? 1 : 0;
    return;
  }
  const size_t chunk = chunk_of(set, form, batch_size);
  for (size_t begin = 0; begin < rays.size(); begin += chunk) {
    const size_t count = std::min(chunk, rays.size() - begin);
    const std::span<const accel::Ray> part = rays.subspan(begin, count);
    if (set.query == RayQuery::any_hit)
      accelerator.occluded(part, std::span(answers.occluded).subspan(begin, count));
    else if (form == CallForm::coherent)
      accelerator.intersect_coherent(part, std::span(answers.hits).subspan(begin, count));
    else
      accelerator.intersect(part, std::span(answers.hits).subspan(begin, count));
  }
}

Disagreements count_disagreements(const RaySet& set, const Answers& expected, const Answers& found) {
  Disagreements result;
  const auto note = [&result](uint64_t& count, size_t ray, float expected_t, float found_t) {
    ++count;
    if (!result.first) result.first = {ray, expected_t, found_t};
  };
  for (size_t i = 0; i < expected.occluded.size(); ++i) {
    const bool a = expected.occluded[i] != 0, b = found.occluded[i] != 0;
    if (a != b) note(result.hit_or_miss, i, a ? 0.0f : kInfinity, b ? 0.0f : kInfinity);
  }
  for (size_t i = 0; i < expected.hits.size(); ++i) {
    const accel::Hit &a = expected.hits[i], &b = found.hits[i];
    if (a.is_hit() != b.is_hit())
      note(result.hit_or_miss, i, a.is_hit() ? a.t : kInfinity, b.is_hit() ? b.t : kInfinity);
    else if (a.is_hit() && !(std::fabs(a.t - b.t) <= distance_tolerance(set.rays[i], std::max(a.t, b.t))))
      note(result.distance, i, a.t, b.t);
  }
  return result;
}

std::vector<std::unique_ptr<accel::Accelerator>> race_builds(const accel::BuildInput& input,
                                                             std::span<AcceleratorResult> results,
                                                             const RaceSettings& settings,
                                                             const RaceProgress& progress) {
  std::vector<std::unique_ptr<accel::Accelerator>> built(results.size());
  for (uint32_t round = 0; round < settings.build_repeat; ++round)
    for (size_t a = 0; a < results.size(); ++a) {
      BuildResult& result = results[a].build;
      const std::string name = results[a].variant.name();
      if (!progress(fmt::format("build of {}, {} of {}", name, round + 1, settings.build_repeat))) return {};
      built[a].reset();
      const bool measures_memory = round == 0 && restart_peak_resident();
      const uint64_t resident_before = resident_bytes();
      const double many_start = process_clock_s(ShootoutClock::wall);
      built[a] = build(input, results[a].variant, settings.build_threads);
      result.many_threads_s.push_back(process_clock_s(ShootoutClock::wall) - many_start);
      if (measures_memory) {
        const uint64_t peak = restarted_peak_resident_bytes();
        if (peak > 0) result.peak_growth_bytes = peak - std::min(peak, resident_before);
      }
      if (!progress(fmt::format("build of {} on one thread, {} of {}", name, round + 1, settings.build_repeat)))
        return {};
      built[a].reset();
      const double one_start = process_clock_s(settings.clock);
      built[a] = build(input, results[a].variant, 1);
      result.one_thread_s.push_back(process_clock_s(settings.clock) - one_start);
      result.statistics = built[a]->statistics();
    }
  return built;
}

bool race_traversal(std::span<const RaySet> sets, std::span<const accel::Accelerator* const> accelerators,
                    const RaceSettings& settings, const RaceProgress& progress, SceneResult& result) {
  const FlushDenormals flush_denormals;
  const size_t count = accelerators.size();

  // The first round is not timed: it warms up, and is checked.
  for (size_t s = 0; s < sets.size(); ++s) {
    const RaySet& set = sets[s];
    Answers expected(set);
    Answers found(set);
    if (!progress(fmt::format("check of {}", set.name))) return false;
    trace(*accelerators[0], set, CallForm::single, settings.batch_size, expected);
    const auto hits =
        std::count_if(expected.hits.begin(), expected.hits.end(), [](const accel::Hit& h) { return h.is_hit(); }) +
        std::count_if(expected.occluded.begin(), expected.occluded.end(), [](uint8_t blocked) { return blocked != 0; });
    result.sets.push_back({set.name, set.query, set.coherent_group, set.rays.size(), static_cast<size_t>(hits)});
    for (const CallForm form : call_forms(set))
      for (size_t a = 0; a < count; ++a) {
        trace(*accelerators[a], set, form, settings.batch_size, found);
        result.accelerators[a].traversal.push_back({s, form, {}, 0.0, count_disagreements(set, expected, found)});
      }
  }

  for (uint32_t round = 0; round < settings.repeat; ++round) {
    size_t row = 0;
    for (const RaySet& set : sets) {
      Answers answers(set);
      for (const CallForm form : call_forms(set)) {
        if (!progress(
                fmt::format("round {} of {}: {}, {}", round + 1, settings.repeat, set.name, call_form_name(form))))
          return false;
        for (size_t turn = 0; turn < count; ++turn) {
          const size_t a = (turn + round) % count;
          const double start = clock_s(settings.clock);
          trace(*accelerators[a], set, form, settings.batch_size, answers);
          result.accelerators[a].traversal[row].times_s.push_back(clock_s(settings.clock) - start);
        }
        ++row;
      }
    }
  }
  const std::vector<TraversalResult>& first = result.accelerators[0].traversal;
  for (AcceleratorResult& accelerator : result.accelerators)
    for (size_t row = 0; row < first.size(); ++row)
      accelerator.traversal[row].ratio_to_first = speed_ratio(first[row].times_s, accelerator.traversal[row].times_s);
  return true;
}

} // namespace kindling::app
