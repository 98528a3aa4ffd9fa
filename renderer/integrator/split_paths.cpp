// The path tracer's loops over a batch whose light is split by light group and first event.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/shade_batch.h"
#include "renderer/integrator/splitting_sink.h"

#include <cassert>

namespace kindling {

void PathIntegrator::shade_split(PathContext& context) const {
  context.split_light->shadows.clear();
  SplittingSink sink{{context, world_, stages_}, light_groups_};
  const size_t count = context.active.size();
  for (size_t first = 0; first < count; first += ShadeGroup::kSize) {
    const size_t end = std::min(first + ShadeGroup::kSize, count);
    shade_group(first, end, context, sink);
    if (!context.first_hits.empty()) note_first_hits(first, end, context);
  }
}

// Paths of one reflection have their first event at the vertex of the light sample, all others had
// it before.
void PathIntegrator::split_shadows(PathContext& context) const {
  SplitLight& split = *context.split_light;
  assert(split.shadows.size() == context.shadow_records.size());
  for (size_t i = 0; i < context.shadow_records.size(); ++i) {
    if (context.occluded[i]) continue;
    const ShadowRecord& record = context.shadow_records[i];
    const SplitLight::Shadow& shadow = split.shadows[i];
    if (record.light_class == kReusedLight) {
      split.second_groups[record.slot] = shadow.group;
      continue;
    }
    split.add(record.slot, shadow.group, record.light_class,
              record.light_class == kDirect ? shadow.first : split.firsts[record.slot], LightPass::emit,
              record.contribution);
  }
}

// The clamps scale all parts of a sample's direct, or indirect, light alike.
void PathIntegrator::add_split(size_t slot, const Rgb& radiance, PathContext& context, Film& film) const {
  SplitLight& split = *context.split_light;
  const CameraSample& camera_sample = context.camera_samples[slot];
  const V2i& pixel = camera_sample.pixel;
  const FilmSample sample{radiance, context.states[slot].alpha, camera_sample.filter_weight,
                          camera_sample.sample_index};
  std::array<float, 3> factors{1.0f, 1.0f, 1.0f};
  const IntegratorSettings& settings = stages_.settings;
  if (settings.clamp_direct < kInfinity || settings.clamp_indirect < kInfinity) {
    Rgb direct(0.0f), indirect(0.0f);
    for (size_t p = 0; p < static_cast<size_t>(LightPass::emit); ++p)
      (p % 2 == 0 ? direct : indirect) += split.passes[slot][p];
    const auto factor = [](const Rgb& light, float largest) {
      const float peak = max_component(light);
      return peak > largest ? largest / peak : 1.0f;
    };
    factors[kDirect] = factor(direct, settings.clamp_direct);
    factors[kIndirect] = factor(indirect, settings.clamp_indirect);
  }
  if (!film.light_groups().empty()) film.add_light_groups(pixel, split.by_group(slot, factors), sample);
  if (film.aovs().needs_light_passes()) film.add_light_passes(pixel, split.by_pass(slot, factors), sample);
  if (film.aovs().needs_lobe_colors()) film.add_lobe_colors(pixel, split.colors[slot], sample.weight);
}

} // namespace kindling
