// The light of a batch of paths, split by light group and by the first event of each path.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/film/aov.h"
#include "renderer/film/film_surface.h"
#include "renderer/integrator/stages/path_state.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

// One thread's sums of the paths of a batch, by slot. Sized once.
struct SplitLight {
  using Classes = std::array<Rgb, 3>; // by LightClass

  // The light of a shadow ray; parallel to PathContext::shadow_records.
  struct Shadow {
    uint8_t group = 0;
    FirstEvent first;
  };

  SplitLight(size_t batch_size, size_t shadow_rays, size_t light_groups)
      : groups(batch_size * light_groups), passes(batch_size), firsts(batch_size), colors(batch_size),
        group_count(light_groups), parts(std::max(light_groups, kLightPassCount)) {
    shadows.reserve(shadow_rays);
  }

  void start(size_t path_count) {
    std::fill_n(groups.begin(), path_count * group_count, Classes{Rgb(0.0f), Rgb(0.0f), Rgb(0.0f)});
    std::array<Rgb, kLightPassCount> black;
    black.fill(Rgb(0.0f));
    std::fill_n(passes.begin(), path_count, black);
    std::fill_n(firsts.begin(), path_count, FirstEvent{});
    std::fill_n(colors.begin(), path_count, LobeColors{});
  }

  // Adds light that has come to the camera by that first event; `seen` is the pass of light that
  // was not reflected at all.
  void add(size_t slot, uint8_t group, uint32_t light_class, const FirstEvent& first, LightPass seen,
           const Rgb& light) {
    if (group_count > 0) groups[slot * group_count + group][light_class] += light;
    std::array<Rgb, kLightPassCount>& by_pass = passes[slot];
    const auto pass_of = [&](LightPass direct) -> Rgb& {
      return by_pass[static_cast<size_t>(direct) + (light_class == kIndirect ? 1 : 0)];
    };
    if (light_class == kEmission) {
      by_pass[static_cast<size_t>(seen)] += light;
    } else if (first.kind == FirstEvent::Kind::transmission) {
      pass_of(LightPass::transmission_direct) += light;
    } else if (first.kind == FirstEvent::Kind::volume) {
      pass_of(LightPass::volume_direct) += light;
    } else {
      pass_of(LightPass::diffuse_direct) += light * first.diffuse;
      pass_of(LightPass::glossy_direct) += light * (Rgb(1.0f) - first.diffuse);
    }
  }

  // Returns the path's light by group, and by pass, with these factors by LightClass. Each call
  // invalidates the last result.
  std::span<const Rgb> by_group(size_t slot, const std::array<float, 3>& factors) {
    for (size_t g = 0; g < group_count; ++g) {
      const Classes& light = groups[slot * group_count + g];
      parts[g] = light[0] * factors[0] + light[1] * factors[1] + light[2] * factors[2];
    }
    return std::span(parts).first(group_count);
  }
  std::span<const Rgb> by_pass(size_t slot, const std::array<float, 3>& factors) {
    for (size_t p = 0; p < kLightPassCount; ++p) {
      const bool seen = p >= static_cast<size_t>(LightPass::emit);
      parts[p] = passes[slot][p] * factors[seen ? kEmission : p % 2 == 0 ? kDirect : kIndirect];
    }
    return std::span(parts).first(kLightPassCount);
  }

  std::vector<Classes> groups; // by slot, then by group
  std::vector<std::array<Rgb, kLightPassCount>> passes;
  std::vector<FirstEvent> firsts;
  std::vector<LobeColors> colors;
  std::vector<Shadow> shadows;
  // Only if paths are shared between pixels: their tails by slot and light group, and the groups of
  // their light samples at the second surface.
  std::vector<Rgb> tails;
  std::vector<uint8_t> second_groups;
  size_t group_count = 0;
  std::vector<Rgb> parts; // results
};

} // namespace kindling
