// The kernels of ambient occlusion and of the debug views.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/kernels/first_hit_wave.h"
#include "renderer/device/kernels/wave_kernels.h"

#include <cstdint>
#include <optional>

namespace kindling::kernels {

// Computes the color of a sample.
inline void show_first_hit(const FirstHitWave& wave, uint32_t launched) {
  const uint32_t slot = number_of(wave.tiles, launched);
  const FirstHitStages& stages = wave.scene->first_hit;
  const WorldView& world = wave.scene->world;
  const accel::Ray ray = begin_sample(wave, slot);
  const accel::Hit hit = world.probe_hit(ray);
  SampleColor& color = wave.colors[slot];
  color = {Rgb(0.0f), hit.is_hit() ? 1.0f : 0.0f};
  if (wave.first_hits != nullptr) wave.first_hits[slot].hit = hit;
  if (!hit.is_hit()) return;
  begin_look_ups(wave.tiles);
  if (stages.kind != IntegratorKind::ambient_occlusion) {
    color.rgb = stages.color_of(ray, hit);
    if (waits_for_tiles(wave.tiles, slot)) return; // and computes all of this again
    return;
  }
  const std::optional<accel::Ray> occlusion = stages.occlusion_ray(wave.samples[slot], ray, hit);
  if (waits_for_tiles(wave.tiles, slot) || !occlusion) return; // what waits begins its sample again
  ++wave.rays[slot].shadows;
  if (!world.probe_is_blocked(*occlusion)) color.rgb = Rgb(1.0f);
}

// Adds the samples of a pixel to its sums.
inline void finish_first_hit_pixel(const FirstHitWave& wave, uint32_t pixel) {
  add_pixel(wave, pixel, [&](uint32_t slot) { return FinishedSample{wave.colors[slot].rgb, wave.colors[slot].alpha}; });
}

} // namespace kindling::kernels
