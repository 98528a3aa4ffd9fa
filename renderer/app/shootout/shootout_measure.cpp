// Measures builds and traversal of the accelerators in turn.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_measure.h"

#include "accel/embree/embree_accelerator.h"
#include "accel/rounding.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/base/standard_arithmetic.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kindling::app {

namespace {

// Builds once, with `threads` threads including the calling one.
std::unique_ptr<accel::Accelerator> build(const accel::BuildInput& input, const AcceleratorVariant& variant,
                                          int threads) {
  accel::BuildOptions options;
  options.quality = variant.quality;
  options.robust = variant.robust;
  options.simd = variant.simd;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] { return accel::make_accelerator(variant.kind, input, options); });
}

float distance_tolerance(const accel::Ray& ray, float t) {
  const float largest =
      std::max({std::fabs(ray.origin.x), std::fabs(ray.origin.y), std::fabs(ray.origin.z)}) / ray.direction.length();
  return kDistanceTolerance * (t + largest);
}

// Wall and CPU time of `work` by the readings of `clock`. The CPU interval encloses the other one,
// so that short work does not seem to have waited for a processor.
template <typename Work>
WorkTime measure(double (*clock)(ShootoutClock), const Work& work) {
  const double cpu_start = clock(ShootoutClock::cpu), wall_start = clock(ShootoutClock::wall);
  work();
  const double wall_s = clock(ShootoutClock::wall) - wall_start;
  return {wall_s, clock(ShootoutClock::cpu) - cpu_start};
}

double time_by(ShootoutClock clock, const WorkTime& work) {
  return clock == ShootoutClock::cpu ? work.cpu_s : work.wall_s;
}

// The number of rays of one call.
size_t chunk_of(const RaySet& set, CallForm form, uint32_t batch_size) {
  return form == CallForm::coherent && set.coherent_group > 0 ? set.coherent_group : batch_size;
}

bool is_at_edge(const accel::Hit& hit) { return std::min({hit.u, hit.v, 1.0f - hit.u - hit.v}) <= kEdge; }

// An accelerator, and for Embree the adapters that answer by each of its packet and stream calls.
class Racer {
 public:
  Racer(const accel::Accelerator& accelerator, bool embree_calls) : accelerator_(&accelerator) {
    if (!embree_calls) return;
    using accel::EmbreeCall;
    for (const EmbreeCall call :
         {EmbreeCall::packet, EmbreeCall::coherent_packet, EmbreeCall::stream, EmbreeCall::coherent_stream})
      own_calls_.push_back(accel::with_embree_call(accelerator, call));
  }
  [[nodiscard]] bool has_own_calls() const {
    return std::any_of(own_calls_.begin(), own_calls_.end(), [](const auto& call) { return call != nullptr; });
  }
  // The accelerator for a form of call; null if it does not have it.
  [[nodiscard]] const accel::Accelerator* by(CallForm form) const {
    if (every_accelerator_has(form)) return accelerator_;
    const size_t own = static_cast<size_t>(form) - static_cast<size_t>(CallForm::packet);
    return own < own_calls_.size() ? own_calls_[own].get() : nullptr;
  }

 private:
  const accel::Accelerator* accelerator_;
  std::vector<std::unique_ptr<accel::Accelerator>> own_calls_; // in the order of CallForm
};

// The kd-tree and brute force give the same hits to the bit (accel/triangle.h).
bool answers_exactly(const AcceleratorResult& result) { return result.variant.kind != accel::Kind::embree; }

} // namespace

Answers::Answers(const RaySet& set) {
  if (set.query == RayQuery::nearest)
    hits.resize(set.rays.size());
  else
    occluded.resize(set.rays.size());
}

std::vector<CallForm> call_forms(const RaySet& set, bool embree_calls) {
  if (set.rays.empty()) return {};
  std::vector<CallForm> forms{CallForm::single, CallForm::batch};
  if (set.query == RayQuery::any_hit || set.coherent_group > 0) forms.push_back(CallForm::coherent);
  if (embree_calls)
    for (const CallForm form : kCallForms)
      if (!every_accelerator_has(form)) forms.push_back(form);
  return forms;
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
    if (set.query == RayQuery::any_hit && form == CallForm::coherent)
      accelerator.occluded_coherent(part, std::span(answers.occluded).subspan(begin, count));
    else if (set.query == RayQuery::any_hit)
      accelerator.occluded(part, std::span(answers.occluded).subspan(begin, count));
    else if (form == CallForm::coherent)
      accelerator.intersect_coherent(part, std::span(answers.hits).subspan(begin, count));
    else
      accelerator.intersect(part, std::span(answers.hits).subspan(begin, count));
  }
}

Disagreements count_disagreements(const RaySet& set, const accel::Accelerator& first, const Answers& expected,
                                  const accel::Accelerator& other, const Answers& found, const Excuse& excuse,
                                  bool to_the_bit) {
  Disagreements result;
  const auto note = [&](uint64_t& count, size_t ray, float expected_t, float found_t) {
    ++count;
    const bool expected_is_nearer = expected_t <= found_t;
    const accel::Hit hit = expected_is_nearer || found.hits.empty() ? first.intersect(set.rays[ray]) : found.hits[ray];
    result.at_edge += hit.is_hit() && is_at_edge(hit) ? 1 : 0;
    if (!result.first) result.first = {ray, expected_t, found_t};
  };
  for (size_t i = 0; i < expected.occluded.size(); ++i) {
    const bool a = expected.occluded[i] != 0, b = found.occluded[i] != 0;
    if (a == b) continue;
    const accel::Ray& ray = set.rays[i];
    if (!to_the_bit && excuse &&
        excuse(ray, a ? first.intersect(ray) : accel::Hit(), b ? other.intersect(ray) : accel::Hit()))
      continue;
    note(result.hit_or_miss, i, a ? 0.0f : kInfinity, b ? 0.0f : kInfinity);
  }
  for (size_t i = 0; i < expected.hits.size(); ++i) {
    const accel::Hit &a = expected.hits[i], &b = found.hits[i];
    const accel::Ray& ray = set.rays[i];
    const bool same_kind = a.is_hit() == b.is_hit();
    if (to_the_bit && std::memcmp(&a, &b, sizeof(accel::Hit)) == 0) continue;
    if (!to_the_bit && same_kind &&
        (!a.is_hit() || std::fabs(a.t - b.t) <= distance_tolerance(ray, std::max(a.t, b.t))))
      continue;
    if (!to_the_bit && excuse && excuse(ray, a, b)) continue;
    note(same_kind ? result.distance : result.hit_or_miss, i, a.is_hit() ? a.t : kInfinity,
         b.is_hit() ? b.t : kInfinity);
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
      const uint64_t resident_before = resident_bytes(), huge_before = huge_page_bytes();
      const double many_start = process_clock_s(ShootoutClock::wall);
      built[a] = build(input, results[a].variant, settings.build_threads);
      result.many_threads_s.push_back(process_clock_s(ShootoutClock::wall) - many_start);
      if (const uint64_t huge = huge_page_bytes(); round == 0)
        result.huge_page_bytes = huge - std::min(huge, huge_before);
      if (measures_memory) {
        const uint64_t peak = peak_resident_bytes();
        if (peak > 0) result.peak_growth_bytes = peak - std::min(peak, resident_before);
      }
      if (!progress(fmt::format("build of {} on one thread, {} of {}", name, round + 1, settings.build_repeat)))
        return {};
      built[a].reset();
      const WorkTime work = measure(process_clock_s, [&] { built[a] = build(input, results[a].variant, 1); });
      result.one_thread_s.push_back(time_by(settings.clock, work));
      result.one_thread_work += work;
      result.statistics = built[a]->statistics();
    }
  return built;
}

std::vector<MeanCost> measure_costs(const accel::Accelerator& accelerator, std::span<const RaySet> sets) {
  const StandardArithmetic standard_arithmetic;
  std::vector<MeanCost> costs;
  for (const RaySet& set : sets) {
    MeanCost& mean = costs.emplace_back();
    const size_t step = std::max<size_t>(1, set.rays.size() / kCostRays);
    size_t count = 0;
    for (size_t i = 0; i < set.rays.size(); i += step, ++count) {
      const auto cost = accelerator.traversal_cost(set.rays[i], set.query == RayQuery::any_hit);
      if (!cost) return {};
      mean.nodes += cost->nodes;
      mean.leaves += cost->leaves;
      mean.triangles += cost->triangles;
    }
    for (double* sum : {&mean.nodes, &mean.leaves, &mean.triangles})
      *sum = count > 0 ? *sum / static_cast<double>(count) : 0.0;
  }
  return costs;
}

bool race_traversal(std::span<const RaySet> sets, std::span<const accel::Accelerator* const> accelerators,
                    const RaceSettings& settings, const RaceProgress& progress, SceneResult& result) {
  const StandardArithmetic standard_arithmetic;
  const size_t count = accelerators.size();
  std::vector<Racer> racers;
  for (const accel::Accelerator* accelerator : accelerators) racers.emplace_back(*accelerator, settings.embree_calls);
  const bool own_calls = std::any_of(racers.begin(), racers.end(), [](const Racer& r) { return r.has_own_calls(); });
  Excuse excuse;
  if (settings.geometry != nullptr)
    excuse = [&](const accel::Ray& ray, const accel::Hit& expected, const accel::Hit& found) {
      return accel::rounding_explains(*settings.geometry, ray, expected, found);
    };

  // The first round is not timed. It warms up, and its answers are compared.
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
    for (const CallForm form : call_forms(set, own_calls))
      for (size_t a = 0; a < count; ++a) {
        TraversalResult& row = result.accelerators[a].traversal.emplace_back();
        row.set = s;
        row.form = form;
        const accel::Accelerator* racer = racers[a].by(form);
        if (racer == nullptr) continue;
        trace(*racer, set, form, settings.batch_size, found);
        const bool to_the_bit = answers_exactly(result.accelerators[0]) && answers_exactly(result.accelerators[a]);
        row.disagreements = count_disagreements(set, *accelerators[0], expected, *racer, found, excuse, to_the_bit);
      }
  }

  for (uint32_t round = 0; round < settings.repeat; ++round) {
    size_t row = 0;
    for (const RaySet& set : sets) {
      Answers answers(set);
      for (const CallForm form : call_forms(set, own_calls)) {
        if (!progress(
                fmt::format("round {} of {}: {}, {}", round + 1, settings.repeat, set.name, call_form_name(form))))
          return false;
        for (size_t turn = 0; turn < count; ++turn) {
          const size_t a = (turn + round) % count;
          const accel::Accelerator* racer = racers[a].by(form);
          if (racer == nullptr) continue;
          const WorkTime work = measure(clock_s, [&] { trace(*racer, set, form, settings.batch_size, answers); });
          result.accelerators[a].traversal[row].times_s.push_back(time_by(settings.clock, work));
          result.accelerators[a].traversal_work += work;
        }
        ++row;
      }
    }
  }
  const std::vector<TraversalResult>& first = result.accelerators[0].traversal;
  for (AcceleratorResult& accelerator : result.accelerators)
    for (size_t row = 0; row < first.size(); ++row)
      if (first[row].times_s.size() == accelerator.traversal[row].times_s.size())
        accelerator.traversal[row].ratio_to_first = speed_ratio(first[row].times_s, accelerator.traversal[row].times_s);
  return true;
}

} // namespace kindling::app
