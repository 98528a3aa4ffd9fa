// Fits the strengths of patches by gradient steps on the second moment of the records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/learn_guide.h"

#include <tbb/parallel_for.h>

namespace kindling {
namespace {

// Returns the density of a record's direction with the guide, relative to the original one.
double density_ratio(const GuideRecord& r, const BrightPatches& patches) {
  BrightPatches::Chances chances;
  patches.chances(r.position, r.normal, chances);
  V3f wi = r.hit - r.position;
  wi *= 1.0f / wi.length();
  return static_cast<double>(r.base - chances.sum * r.replaced + r.allowed * patches.density(chances, r.position, wi));
}

// Data of a record for the fit: the geometric factors of all patches, and the patches that the
// direction crosses.
struct Row {
  std::array<float, BrightPatches::kMax> factors; // at strength 1
  float moment;
  float base, replaced;
  uint32_t crossed_count;
  std::array<uint8_t, 4> crossed;         // patches; further ones are ignored
  std::array<float, 4> crossed_densities; // of a direction sampled from that patch, relative
};

// Derivative of a row's moment by density, common to all patches.
struct Slope {
  float weight = -1.0f; // negative: the row is ignored
  float lost = 0.0f;    // density that all other techniques lose
};

Slope slope_of(const Row& row, std::span<const BrightPatch> patches) {
  float sum = 0.0f;
  for (size_t j = 0; j < patches.size(); ++j) sum += patches[j].strength * row.factors[j];
  const float inverse = 1.0f / std::max(1.0f + sum, sum / (1.0f - BrightPatches::kMinRest));
  float p = row.base - sum * inverse * row.replaced;
  for (size_t k = 0; k < row.crossed_count; ++k)
    p += patches[row.crossed[k]].strength * row.factors[row.crossed[k]] * inverse * row.crossed_densities[k];
  if (!(p > 0.0f)) return {};
  const float weight = row.moment / (p * p) * inverse;
  return {weight, weight * std::max(p - row.base + row.replaced, 0.0f)};
}

constexpr size_t kAtOnce = 4; // patches

// Accumulates the sums of patches `first` to first + kAtOnce - 1, in the order of the rows.
void add_up(std::span<const Row> rows, std::span<const Slope> slopes, size_t first,
            std::array<double, BrightPatches::kMax>& gain, std::array<double, BrightPatches::kMax>& loss) {
  static_assert(BrightPatches::kMax % kAtOnce == 0);
  std::array<double, kAtOnce> gains{}, losses{};
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const Slope& slope = slopes[i];
    if (slope.weight < 0.0f) continue;
    for (size_t k = 0; k < row.crossed_count; ++k) {
      const size_t j = row.crossed[k];
      if (j - first < kAtOnce) // wraps below
        gains[j - first] += static_cast<double>(slope.weight * row.factors[j] * row.crossed_densities[k]);
    }
    for (size_t j = 0; j < kAtOnce; ++j) losses[j] += static_cast<double>(slope.lost * row.factors[first + j]);
  }
  for (size_t j = 0; j < kAtOnce; ++j) {
    gain[first + j] = gains[j];
    loss[first + j] = losses[j];
  }
}

} // namespace

double second_moment(std::span<const GuideRecord> records, const BrightPatches& patches) {
  std::vector<double> ratios(records.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, records.size(), 512), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) ratios[i] = density_ratio(records[i], patches);
  });
  double without = 0.0, with = 0.0; // summed in order
  for (size_t i = 0; i < records.size(); ++i) {
    without += static_cast<double>(records[i].contribution2 / records[i].base);
    with += static_cast<double>(records[i].contribution2) / ratios[i];
  }
  return without > 0.0 ? with / without : 1.0;
}

BrightPatches fit_strengths(std::span<const GuideRecord> records, std::vector<BrightPatch> patches) {
  const size_t count = patches.size();
  std::vector<Row> rows(records.size());
  // A guide of one patch, so that its probability is a function of its form factor F: F / (1 + F),
  // bounded.
  std::vector<BrightPatches> alone;
  for (const BrightPatch& patch : patches) {
    BrightPatch unit = patch;
    unit.strength = 1e-3f; // small enough for probability = factor
    alone.emplace_back(std::span(&unit, 1));
  }
  const auto fill = [&](const GuideRecord& r, Row& row) {
    BrightPatches::Chances chances;
    row.moment = r.contribution2;
    row.base = r.base;
    row.replaced = r.replaced;
    row.crossed_count = 0;
    V3f wi = r.hit - r.position;
    wi *= 1.0f / wi.length();
    for (size_t j = 0; j < count; ++j) {
      alone[j].chances(r.position, r.normal, chances);
      const float probability = chances.of[0];
      row.factors[j] = probability / (1.0f - chances.sum) * 1e3f;
      if (!(probability > 0.0f) || row.crossed_count == row.crossed.size()) continue;
      const float density = alone[j].density(chances, r.position, wi) / probability;
      if (!(density > 0.0f)) continue;
      row.crossed[row.crossed_count] = static_cast<uint8_t>(j);
      row.crossed_densities[row.crossed_count++] = density * r.allowed;
    }
  };
  tbb::parallel_for(tbb::blocked_range<size_t>(0, records.size(), 256), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) fill(records[i], rows[i]);
  });
  // d p / d s_j = F_j / D (density_j - replaced - (p - base)): increases where the gain exceeds the
  // loss.
  constexpr int kSteps = 40;
  std::array<double, BrightPatches::kMax> use{}; // effect of each patch at its strength
  std::vector<Slope> slopes(rows.size());
  for (int step = 0; step < kSteps; ++step) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, rows.size(), 1024), [&](const auto& range) {
      for (size_t i = range.begin(); i != range.end(); ++i) slopes[i] = slope_of(rows[i], patches);
    });
    std::array<double, BrightPatches::kMax> gain{}, loss{};
    tbb::parallel_for(size_t{0}, (count + kAtOnce - 1) / kAtOnce,
                      [&](size_t group) { add_up(rows, slopes, group * kAtOnce, gain, loss); });
    for (size_t j = 0; j < count; ++j) {
      use[j] = gain[j] * static_cast<double>(patches[j].strength);
      const double ratio = loss[j] > 0.0 ? gain[j] / loss[j] : 1.0;
      patches[j].strength *= static_cast<float>(std::clamp(std::sqrt(ratio), 0.25, 4.0));
    }
  }
  // Every patch costs time at every point.
  constexpr double kMinUse = 0.005; // of the total
  double all = 0.0;
  for (const double u : use) all += u;
  std::vector<BrightPatch> useful;
  for (size_t j = 0; j < count; ++j)
    if (use[j] > kMinUse * all) useful.push_back(patches[j]);
  return BrightPatches(useful);
}

} // namespace kindling
