// Prepares a LightSet: powers of lights, and the distribution that chooses among them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"

#include "renderer/sampling/quantized_cdf.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

namespace kindling {

namespace {

// Of the power of a light, only what is finite and positive counts.
double accepted_power(double power) { return power > 0.0 && std::isfinite(power) ? power : 0.0; }

double point_power(const PointLight& light) {
  return 4.0 * std::numbers::pi * static_cast<double>(luminance(light.intensity));
}

// As if the falloff between the cones were a step halfway.
double spot_power(const SpotLight& light) {
  const double mean_cos = 0.5 * (static_cast<double>(light.cos_inner) + static_cast<double>(light.cos_outer));
  return 2.0 * std::numbers::pi * (1.0 - mean_cos) * static_cast<double>(luminance(light.intensity));
}

// Half of the choices go by power; the other half evenly to the groups, and by power within a group.
std::vector<float> choice_weights(std::span<const double> powers, std::span<const uint32_t> groups, double sum) {
  std::vector<double> group_power;
  double total = 0.0;
  for (size_t i = 0; i < powers.size(); ++i) {
    group_power.resize(std::max(group_power.size(), size_t{groups[i]} + 1), 0.0);
    group_power[groups[i]] += powers[i];
    total += powers[i];
  }
  const auto group_count =
      static_cast<double>(std::ranges::count_if(group_power, [](double power) { return power > 0.0; }));
  std::vector<float> weights(powers.size(), 0.0f);
  for (size_t i = 0; i < powers.size(); ++i) {
    if (!(powers[i] > 0.0)) continue;
    const double weight = 0.5 * powers[i] / total + 0.5 * powers[i] / group_power[groups[i]] / group_count;
    // Too faint for a float is not without power.
    weights[i] = std::max(static_cast<float>(sum * weight), std::numeric_limits<float>::min());
  }
  return weights;
}

} // namespace

float environment_share(double environment_power, double other_power) {
  if (!(environment_power > 0.0)) return 0.0f;
  if (!(other_power > 0.0)) return 1.0f;
  const double decades = std::log10(environment_power) - std::log10(other_power);
  const double beyond = std::clamp(std::fabs(decades) - 2.0, 0.0, 1.0);
  return static_cast<float>(0.5 + std::copysign(0.45 * beyond, decades));
}

LightSet::LightSet(LightSetInput input)
    : emissions_(std::move(input.emissions)), environment_(std::move(input.environment)) {
  assert(input.triangle_uvs.empty() || input.triangle_uvs.size() == 3 * input.triangles.size());
  if (environment_ && environment_->is_black()) environment_ = nullptr;

  triangles_.reserve(input.triangles.size());
  bool textured = false;
  for (const EmissiveTriangle& t : input.triangles) {
    triangles_.push_back({t.p0, t.emission, t.p1, 0.0f, t.p2, 0.0f});
    textured = textured || emissions_[t.emission].texture != nullptr;
  }
  if (textured) uvs_ = std::move(input.triangle_uvs);

  const double disc = std::numbers::pi * static_cast<double>(square(input.scene_radius_m));
  std::vector<double> powers(triangles_.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, triangles_.size(), 256),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t i = range.begin(); i < range.end(); ++i) {
                        const Triangle& t = triangles_[i];
                        const V3f normal = (t.p1 - t.p0).cross(t.p2 - t.p0);
                        const double area = 0.5 * static_cast<double>(normal.length());
                        if (!(area > 0.0) || !std::isfinite(area)) continue;
                        const double sides = emissions_[t.emission].two_sided ? 2.0 : 1.0;
                        const double mean = static_cast<double>(luminance(mean_emission(static_cast<uint32_t>(i))));
                        powers[i] = accepted_power(std::numbers::pi * sides * area * mean);
                      }
                    });
  std::vector<uint32_t> groups(triangles_.size()); // one per emission, then one per punctual light
  for (size_t i = 0; i < triangles_.size(); ++i) groups[i] = triangles_[i].emission;
  for (const PointLight& light : input.points) {
    Punctual p{Punctual::Kind::point, light.position, V3f(0.0f), light.intensity};
    p.inverse_range = light.range_m && *light.range_m > 0.0f ? 1.0f / *light.range_m : 0.0f;
    punctuals_.push_back(p);
    powers.push_back(accepted_power(point_power(light)));
  }
  for (const SpotLight& light : input.spots) {
    Punctual p{Punctual::Kind::spot, light.position, light.axis, light.intensity};
    p.inverse_range = light.range_m && *light.range_m > 0.0f ? 1.0f / *light.range_m : 0.0f;
    p.angle_scale = 1.0f / std::max(0.001f, light.cos_inner - light.cos_outer);
    p.angle_offset = -light.cos_outer * p.angle_scale;
    punctuals_.push_back(p);
    powers.push_back(accepted_power(spot_power(light)));
  }
  for (const DirectionalLight& light : input.directionals) {
    punctuals_.push_back({Punctual::Kind::directional, V3f(0.0f), light.direction, light.irradiance});
    powers.push_back(accepted_power(disc * static_cast<double>(luminance(light.irradiance))));
  }

  while (groups.size() < powers.size()) {
    groups.push_back(static_cast<uint32_t>(emissions_.size() + groups.size() - triangles_.size()));
  }

  double other_power = 0.0;
  for (const double power : powers) {
    other_power += power;
    light_count_ += power > 0.0 ? 1 : 0;
  }
  double share = 0.0;
  if (environment_) {
    const double environment_power = disc * static_cast<double>(luminance(environment_->total_radiance()));
    // An environment of, say, subnormal radiance is still there.
    share = static_cast<double>(environment_share(std::max(environment_power, 1e-300), other_power));
    ++light_count_;
  }
  if (light_count_ == 0) return;

  std::vector<float> weights = choice_weights(powers, groups, 1.0 - share);
  if (environment_) weights.push_back(static_cast<float>(share));
  build_distribution(weights);
}

void LightSet::build_distribution(std::span<const float> weights) {
  while (((weights.size() - 1) >> run_shift_) >= kMaxCdfCells) ++run_shift_;
  const size_t run = size_t{1} << run_shift_;
  std::vector<float> cells((weights.size() + run - 1) >> run_shift_, 0.0f);
  for (size_t i = 0; i < weights.size(); ++i) cells[i >> run_shift_] += weights[i];
  cdf_.resize(cells.size() + 1);
  guide_size_ = guide_size(cells.size());
  guide_.resize(guide_size_ + 1);
  (void)build_quantized_cdf(cells, cdf_);
  build_cdf_guide(cdf_, guide_);
  for (size_t i = 0; i < weights.size(); ++i) {
    const size_t cell = i >> run_shift_;
    const float cell_probability = cdf_[cell + 1] - cdf_[cell];
    const float p = run_shift_ == 0     ? cell_probability
                    : weights[i] > 0.0f ? cell_probability * (weights[i] / cells[cell])
                                        : 0.0f;
    set_probability(static_cast<uint32_t>(i), p);
  }
}

void LightSet::set_probability(uint32_t light, float value) {
  const size_t punctual = size_t{light} - triangles_.size();
  if (light < triangles_.size()) {
    triangles_[light].probability = value;
  } else if (punctual < punctuals_.size()) {
    punctuals_[punctual].probability = value;
  } else {
    environment_probability_ = value;
  }
}

Rgb LightSet::mean_emission(uint32_t index) const {
  const Emission& emission = emissions_[triangles_[index].emission];
  if (emission.texture == nullptr || uvs_.empty()) return emission.factor;
  // A grid as fine as the texels that the triangle covers, between 2 and 32 steps along an edge. What it misses is not
  // lost: light that is never sampled is found by rays that happen to hit it.
  const V2f* uv = uvs_.data() + size_t{index} * 3;
  const V2f size(emission.texture->size_px());
  const float longest = std::max(((uv[1] - uv[0]) * size).length(),
                                 std::max(((uv[2] - uv[1]) * size).length(), ((uv[0] - uv[2]) * size).length()));
  const int steps = longest < 32.0f ? std::max(static_cast<int>(longest), 2) : 32; // NaN: 32
  V3d sum(0.0);
  int count = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps - i; ++j) {
      // Centroids of the small triangles, upright and (but for the last of a row) inverted.
      const float third = 1.0f / (3.0f * static_cast<float>(steps));
      sum += V3d(emission_at(index, static_cast<float>(3 * i + 1) * third, static_cast<float>(3 * j + 1) * third));
      ++count;
      if (j + 1 >= steps - i) continue;
      sum += V3d(emission_at(index, static_cast<float>(3 * i + 2) * third, static_cast<float>(3 * j + 2) * third));
      ++count;
    }
  }
  sum /= static_cast<double>(count);
  return {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z)};
}

size_t LightSet::memory_bytes() const {
  return sizeof(*this) + emissions_.size() * sizeof(Emission) + triangles_.size() * sizeof(Triangle) +
         uvs_.size() * sizeof(V2f) + punctuals_.size() * sizeof(Punctual) + cdf_.size() * sizeof(float) +
         guide_.size() * sizeof(uint32_t) + (environment_ ? environment_->memory_bytes() : 0);
}

} // namespace kindling
