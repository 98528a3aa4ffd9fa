// The light of paths, split by light group and by the first event of each path.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/film/aov.h"
#include "renderer/film/film_surface.h"
#include "renderer/film/film_view.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/path_state.h"
#include "renderer/world/light_groups/light_groups_view.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

// The part of a path's light that was reflected diffusely at its first surface. The rest
// was reflected specularly, unless `event` says that all was transmitted or scattered in a medium.
struct FirstEvent {
  enum class Kind : uint8_t { none, reflection, transmission, volume };
  Kind kind = Kind::none;
  Rgb diffuse{0.0f}; // fraction by channel
};

// Returns the event of light that a surface scatters from a local direction, on its other side if
// `beyond`: it is split like the BSDF's value.
[[nodiscard]] inline FirstEvent event_towards(const SurfaceBsdf& bsdf, const V3f& wi, bool beyond) {
  if (beyond) return {FirstEvent::Kind::transmission, Rgb(0.0f)};
  const Rgb all = bsdf.eval(wi).value, diffuse = bsdf.diffuse_value(wi);
  FirstEvent event{FirstEvent::Kind::reflection, Rgb(0.0f)};
  for (int c = 0; c < 3; ++c)
    if (all[c] > 0.0f) event.diffuse[c] = std::min(diffuse[c] / all[c], 1.0f);
  return event;
}

// The light of a shadow ray, if nothing is in between.
struct SplitShadow {
  uint8_t group = 0;
  FirstEvent first;
};

// The arrays of a batch of paths, here or on a device, and what is done with them. A path has a
// slot.
struct SplitView {
  using Classes = std::array<Rgb, 3>; // by LightClass
  using Passes = std::array<Rgb, kLightPassCount>;

  const LightGroupsView* groups = nullptr;
  uint32_t group_count = 0;    // LightGroupsView::count
  Classes* by_group = nullptr; // by path, then by group
  Passes* by_pass = nullptr;   // by path; null: light is not split
  FirstEvent* firsts = nullptr;
  LobeColors* colors = nullptr;
  SplitShadow* shadows = nullptr; // by shadow ray
  // Only if paths are shared between pixels: their tails by path and group, at least one, and the
  // groups of their light samples at the second surface.
  Rgb* tails = nullptr;
  uint8_t* second_groups = nullptr;

  void start(size_t slot) const {
    for (size_t g = 0; g < group_count; ++g) by_group[slot * group_count + g].fill(Rgb(0.0f));
    by_pass[slot].fill(Rgb(0.0f));
    firsts[slot] = FirstEvent{};
    colors[slot] = LobeColors{};
  }

  // Adds light that has come to the camera by that first event; `seen` is the pass of light that
  // was not reflected at all.
  void add(size_t slot, uint8_t group, uint32_t light_class, const FirstEvent& first, LightPass seen,
           const Rgb& light) const {
    if (group_count > 0) by_group[slot * group_count + group][light_class] += light;
    Passes& passes = by_pass[slot];
    const auto pass_of = [&](LightPass direct) -> Rgb& {
      return passes[static_cast<size_t>(direct) + (light_class == kIndirect ? 1 : 0)];
    };
    if (light_class == kEmission) {
      passes[static_cast<size_t>(seen)] += light;
    } else if (first.kind == FirstEvent::Kind::transmission) {
      pass_of(LightPass::transmission_direct) += light;
    } else if (first.kind == FirstEvent::Kind::volume) {
      pass_of(LightPass::volume_direct) += light;
    } else {
      pass_of(LightPass::diffuse_direct) += light * first.diffuse;
      pass_of(LightPass::glossy_direct) += light * (Rgb(1.0f) - first.diffuse);
    }
  }
  // Adds the light of a shadow ray that nothing blocks. Paths of one reflection have their first
  // event at the vertex of the light sample, all others had it before.
  void add_shadow(const ShadowRecord& record, const SplitShadow& shadow) const {
    if (record.light_class == kReusedLight)
      second_groups[record.slot] = shadow.group;
    else
      add(record.slot, shadow.group, record.light_class,
          record.light_class == kDirect ? shadow.first : firsts[record.slot], LightPass::emit, record.contribution);
  }

  // Adds the parts of a finished sample to the sums of a pixel. The clamps scale all parts of its
  // direct, or indirect, light alike.
  void add_to(const FilmView& film, size_t pixel, size_t slot, const FilmSample& sample,
              const IntegratorSettings& settings) const {
    std::array<float, 3> factors{1.0f, 1.0f, 1.0f};
    if (settings.clamp_direct < kInfinity || settings.clamp_indirect < kInfinity) {
      Rgb direct(0.0f), indirect(0.0f);
      for (size_t p = 0; p < static_cast<size_t>(LightPass::emit); ++p)
        (p % 2 == 0 ? direct : indirect) += by_pass[slot][p];
      const auto factor = [](const Rgb& light, float largest) {
        const float peak = max_component(light);
        return peak > largest ? largest / peak : 1.0f;
      };
      factors[kDirect] = factor(direct, settings.clamp_direct);
      factors[kIndirect] = factor(indirect, settings.clamp_indirect);
    }
    film.add_light_groups(pixel, sample, [&](size_t group) {
      const Classes& light = by_group[slot * group_count + group];
      return light[0] * factors[0] + light[1] * factors[1] + light[2] * factors[2];
    });
    film.add_light_passes(pixel, sample, [&](size_t pass) {
      const bool seen = pass >= static_cast<size_t>(LightPass::emit);
      return by_pass[slot][pass] * factors[seen ? kEmission : pass % 2 == 0 ? kDirect : kIndirect];
    });
    film.add_lobe_colors(pixel, colors[slot], sample.weight);
  }
};

} // namespace kindling
