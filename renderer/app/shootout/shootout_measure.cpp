// Races contestants in turn, and compares their answers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_measure.h"

#include "accel/make_accelerator.h"
#include "accel/rounding.h"
#include "renderer/base/standard_arithmetic.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kindling::app {

namespace {

float distance_tolerance(const accel::Ray& ray, float t) {
  const float largest =
      std::max({std::fabs(ray.origin.x), std::fabs(ray.origin.y), std::fabs(ray.origin.z)}) / ray.direction.length();
  return kDistanceTolerance * (t + largest);
}

double time_by(ShootoutClock clock, const WorkTime& work) {
  return clock == ShootoutClock::cpu ? work.cpu_s : work.wall_s;
}

bool is_at_edge(const accel::Hit& hit) { return std::min({hit.u, hit.v, 1.0f - hit.u - hit.v}) <= kEdge; }

// The kd-tree and brute force give the same hits to the bit (accel/triangle.h), on devices too.
bool answers_exactly(const AcceleratorResult& result) {
  return result.device || result.is(accel::Kind::kdtree) || result.is(accel::Kind::brute_force);
}

Excuse rounding_in(const accel::BuildInput* geometry) {
  if (geometry == nullptr) return {};
  return [geometry](const accel::Ray& ray, const accel::Hit& expected, const accel::Hit& found) {
    return accel::rounding_explains(*geometry, ray, expected, found);
  };
}

// The forms of call that some of the contestants have and others do not.
std::vector<CallForm> other_forms(std::span<Contestant* const> contestants) {
  std::vector<CallForm> forms;
  for (const CallForm form : kCallForms)
    if (!every_accelerator_has(form) &&
        std::any_of(contestants.begin(), contestants.end(), [form](const Contestant* c) { return c->has(form); }))
      forms.push_back(form);
  return forms;
}

// Takes a contestant out of the race: its times would be of a part of it.
void retire(const Contestant& contestant, AcceleratorResult& result) {
  result.fault = contestant.fault();
  for (TraversalResult& row : result.traversal) row.times_s.clear();
  result.traversal_work = {};
}

size_t count_hits(const Answers& answers) {
  return static_cast<size_t>(
      std::count_if(answers.hits.begin(), answers.hits.end(), [](const accel::Hit& h) { return h.is_hit(); }) +
      std::count_if(answers.occluded.begin(), answers.occluded.end(), [](uint8_t blocked) { return blocked != 0; }));
}

// The answers by single calls, by all threads.
Answers oracle_answers(const accel::Accelerator& oracle, const RaySet& set) {
  Answers answers(set);
  tbb::parallel_for(size_t{0}, set.rays.size(), [&](size_t i) {
    const StandardArithmetic standard_arithmetic;
    if (set.query == RayQuery::nearest)
      answers.hits[i] = oracle.intersect(set.rays[i]);
    else
      answers.occluded[i] = oracle.occluded(set.rays[i]) ? 1 : 0;
  });
  return answers;
}

} // namespace

std::vector<CallForm> call_forms(const RaySet& set, std::span<const CallForm> others) {
  if (set.rays.empty()) return {};
  std::vector<CallForm> forms{CallForm::single, CallForm::batch};
  if (set.query == RayQuery::any_hit || set.coherent_group > 0) forms.push_back(CallForm::coherent);
  forms.insert(forms.end(), others.begin(), others.end());
  return forms;
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

bool race_builds(std::span<Contestant* const> contestants, std::span<AcceleratorResult> results,
                 const RaceSettings& settings, const RaceProgress& progress) {
  for (uint32_t round = 0; round < settings.build_repeat; ++round)
    for (size_t a = 0; a < contestants.size(); ++a) {
      BuildResult& result = results[a].build;
      const std::string name = results[a].name();
      const auto build = [&](int threads) -> std::optional<BuildMeasurement> {
        if (!results[a].fault.empty()) return std::nullopt;
        auto built = contestants[a]->build(threads, round == 0 && result.many_threads_s.empty());
        if (!built) retire(*contestants[a], results[a]);
        return built;
      };
      if (!progress(fmt::format("build of {}, {} of {}", name, round + 1, settings.build_repeat))) return false;
      if (const auto many = build(settings.build_threads)) {
        result.many_threads_s.push_back(many->work.wall_s);
        if (round == 0) {
          result.huge_page_bytes = many->huge_page_bytes;
          result.peak_growth_bytes = many->peak_growth_bytes;
        }
      }
      if (!progress(fmt::format("build of {} on one thread, {} of {}", name, round + 1, settings.build_repeat)))
        return false;
      if (const auto one = build(1)) {
        result.one_thread_s.push_back(time_by(settings.clock, one->work));
        result.one_thread_work += one->work;
        result.statistics = one->statistics;
      }
    }
  return true;
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

namespace {

// The round that is not timed: it warms up, and its answers are compared.
bool check_answers(std::span<const RaySet> sets, std::span<Contestant* const> contestants,
                   std::span<const CallForm> others, const RaceSettings& settings, const RaceProgress& progress,
                   SceneResult& result) {
  const Excuse excuse = rounding_in(settings.geometry);
  for (size_t s = 0; s < sets.size(); ++s) {
    const RaySet& set = sets[s];
    Answers expected(set), found(set);
    if (!progress(fmt::format("check of {}", set.name))) return false;
    if (!contestants[0]->trace(s, CallForm::single, settings.batch_size, expected)) return false;
    result.sets.push_back({set.name, set.query, set.coherent_group, set.rays.size(), count_hits(expected)});
    for (const CallForm form : call_forms(set, others))
      for (size_t a = 0; a < contestants.size(); ++a) {
        AcceleratorResult& accelerator = result.accelerators[a];
        TraversalResult& row = accelerator.traversal.emplace_back();
        row.set = s;
        row.form = form;
        if (!accelerator.fault.empty() || !contestants[a]->has(form)) continue;
        const bool to_the_bit = answers_exactly(result.accelerators[0]) && answers_exactly(accelerator);
        if (contestants[a]->trace(s, form, settings.batch_size, found))
          row.disagreements = count_disagreements(set, contestants[0]->queries(), expected, contestants[a]->queries(),
                                                  found, excuse, to_the_bit);
        if (!contestants[a]->fault().empty()) retire(*contestants[a], accelerator);
      }
  }
  return true;
}

} // namespace

bool race_traversal(std::span<const RaySet> sets, std::span<Contestant* const> contestants,
                    const RaceSettings& settings, const RaceProgress& progress, SceneResult& result) {
  const StandardArithmetic standard_arithmetic;
  const size_t count = contestants.size();
  const std::vector<CallForm> others = other_forms(contestants);
  if (!check_answers(sets, contestants, others, settings, progress, result)) return false;

  for (uint32_t round = 0; round < settings.repeat; ++round) {
    size_t row = 0;
    for (size_t s = 0; s < sets.size(); ++s) {
      Answers answers(sets[s]);
      for (const CallForm form : call_forms(sets[s], others)) {
        if (!progress(
                fmt::format("round {} of {}: {}, {}", round + 1, settings.repeat, sets[s].name, call_form_name(form))))
          return false;
        for (size_t turn = 0; turn < count; ++turn) {
          const size_t a = (turn + round) % count;
          AcceleratorResult& accelerator = result.accelerators[a];
          if (!accelerator.fault.empty() || !contestants[a]->has(form)) continue;
          if (const auto work = contestants[a]->trace(s, form, settings.batch_size, answers)) {
            accelerator.traversal[row].times_s.push_back(time_by(settings.clock, *work));
            accelerator.traversal_work += *work;
          } else {
            retire(*contestants[a], accelerator);
          }
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

bool race_traversal(std::span<const RaySet> sets, std::span<const accel::Accelerator* const> accelerators,
                    const RaceSettings& settings, const RaceProgress& progress, SceneResult& result) {
  std::vector<std::unique_ptr<Contestant>> owned;
  std::vector<Contestant*> contestants;
  for (const accel::Accelerator* accelerator : accelerators) {
    owned.push_back(std::make_unique<LocalContestant>(*accelerator, sets, settings.embree_calls));
    contestants.push_back(owned.back().get());
  }
  return race_traversal(sets, contestants, settings, progress, result);
}

std::vector<RaySet> oracle_sets(std::span<const RaySet> sets, size_t triangle_count) {
  constexpr size_t kTests = size_t{1} << 28;
  constexpr size_t kFewest = 16; // fewer prove little
  const size_t affordable = kTests / std::max<size_t>(triangle_count, 1);
  std::vector<RaySet> chosen;
  for (const RaySet& set : sets) {
    RaySet& some = chosen.emplace_back(RaySet{set.name, set.query, 0, {}});
    const size_t count = affordable < kFewest ? 0 : std::min({affordable, kOracleRays, set.rays.size()});
    for (size_t i = 0; i < count; ++i) some.rays.push_back(set.rays[i * set.rays.size() / count]);
  }
  return chosen;
}

bool check_against_oracle(std::span<const RaySet> sets, size_t first_set, std::span<Contestant* const> contestants,
                          const accel::BuildInput& geometry, const RaceProgress& progress, SceneResult& result) {
  const StandardArithmetic standard_arithmetic;
  const auto oracle = accel::make_accelerator(accel::Kind::brute_force, geometry);
  const Excuse excuse = rounding_in(&geometry);
  for (AcceleratorResult& accelerator : result.accelerators) accelerator.oracle.emplace();
  for (size_t s = 0; s < sets.size(); ++s) {
    if (sets[s].rays.empty()) continue;
    if (!progress(fmt::format("check of {} by brute force", sets[s].name))) return false;
    const Answers expected = oracle_answers(*oracle, sets[s]);
    Answers found(sets[s]);
    for (size_t a = 0; a < contestants.size(); ++a) {
      AcceleratorResult& accelerator = result.accelerators[a];
      if (!accelerator.fault.empty()) continue;
      if (contestants[a]->trace(first_set + s, CallForm::single, 1, found)) {
        accelerator.oracle->ray_count += sets[s].rays.size();
        accelerator.oracle->disagreements.add(count_disagreements(sets[s], *oracle, expected, contestants[a]->queries(),
                                                                  found, excuse, answers_exactly(accelerator)));
      }
      if (!contestants[a]->fault().empty()) retire(*contestants[a], accelerator);
    }
  }
  return true;
}

bool check_device(std::span<const RaySet> sets, Contestant& contestant, const RaceProgress& progress,
                  AcceleratorResult& result) {
  for (size_t s = 0; s < sets.size() && result.fault.empty(); ++s) {
    if (sets[s].rays.empty()) continue;
    if (!progress(fmt::format("check of {} by {}", sets[s].name, result.name()))) return false;
    Answers found(sets[s]);
    if (contestant.trace(s, CallForm::launch, 0, found)) {
      const Answers expected = oracle_answers(contestant.queries(), sets[s]);
      result.device->check.ray_count += sets[s].rays.size();
      result.device->check.disagreements.add(
          count_disagreements(sets[s], contestant.queries(), expected, contestant.queries(), found, {}, true));
    } else {
      retire(contestant, result);
    }
  }
  return true;
}

} // namespace kindling::app
