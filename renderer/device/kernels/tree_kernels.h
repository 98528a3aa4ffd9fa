// The kernels of the Whitted tracer, each for one sample, one node or one pixel of a wave.
//
// The order of the nodes does not matter: random numbers depend on a node's place in its tree, and
// the sums of a sample are exact. A node traces its own shadow feelers, so that none have to be
// stored: there may be thousands for each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/kernels/tree_wave.h"
#include "renderer/device/kernels/wave_kernels.h"
#include "renderer/integrator/whitted_shader.h"

#include <cstdint>
#include <utility>

namespace kindling::kernels {

// Starts a sample: the root of its tree.
inline void begin_tree(const TreeWave& wave, uint32_t slot) {
  const accel::Ray ray = begin_sample(wave, slot);
  wave.waiting[slot] = wave.scene->shader.root(ray, slot);
  wave.sums[slot] = WhittedSample{};
  if (wave.components != nullptr) wave.components[slot] = WhittedComponents{};
}

// Takes one of the newest nodes, whose place is free from then on.
inline void take_node(const TreeWave& wave, uint32_t number) {
  wave.nodes[number] = wave.waiting[wave.first_taken + number];
}

inline void count(uint32_t& rays, uint64_t more) {
  if (more > 0) __atomic_fetch_add(&rays, static_cast<uint32_t>(more), __ATOMIC_RELAXED);
}

// Takes the results of shading a node.
struct TreeSink {
  const TreeWave& wave;
  const accel::Hit& hit; // at the node
  WhittedCounters counted{};
  uint32_t shadows = 0;

  [[nodiscard]] WhittedCounters& counters() { return counted; }
  void add(const WhittedNode& node, WhittedPart part, const Rgb& radiance) {
    wave.sums[node.slot].radiance.add_atomically(radiance);
    if (wave.components == nullptr || !node.seen) return;
    if (part == WhittedPart::emission) wave.components[node.slot].emission.add_atomically(radiance);
    if (part == WhittedPart::direct) wave.components[node.slot].direct.add_atomically(radiance);
  }
  void add_transparency(const WhittedNode& node, float part) { wave.sums[node.slot].transparency.add_atomically(part); }
  // Further surfaces that the camera sees through this one come in later rounds.
  void surface(const WhittedNode& node, const WhittedVertex& vertex) {
    if (wave.surfaces == nullptr || wave.surfaces[node.slot].hit) return;
    wave.scene->shader.record_surface(vertex, wave.surfaces[node.slot]);
    if (wave.first_hits != nullptr) wave.first_hits[node.slot].hit = hit;
  }
  void feel(const WhittedNode& node, const accel::Ray& feeler, const Rgb& contribution) {
    const DeviceScene& scene = *wave.scene;
    ++shadows;
    if (scene.world.probe_is_blocked(feeler)) return;
    Rgb through(1.0f);
    if (scene.world.has_thin_walls)
      through = scene.shader.through_thin_walls(feeler, [&](const accel::Ray& ray) {
        ++shadows;
        return scene.world.probe_hit(ray);
      });
    add(node, WhittedPart::direct, contribution * through);
  }
  void follow(WhittedNode&& node) {
    const uint32_t place = __atomic_fetch_add(wave.waiting_count, 1U, __ATOMIC_RELAXED);
    wave.waiting[place] = node;
  }
};

// Traces the ray of a node and shades what it hits.
inline void trace_node(const TreeWave& wave, uint32_t launched) {
  const uint32_t number = number_of(wave.tiles, launched);
  const DeviceScene& scene = *wave.scene;
  WhittedNode& node = wave.nodes[number];
  const bool bounces = !node.seen || node.transparent_surfaces > 0;
  const accel::Hit hit = scene.world.probe_hit(node.ray);
  SurfacePoint surface;
  if (hit.is_hit()) {
    begin_look_ups(wave.tiles);
    scene.world.surface_at(node.ray, hit, surface, WhittedShader::footprint_of(node, hit));
    if (waits_for_tiles(wave.tiles, number)) return;
  }
  TreeSink sink{wave, hit};
  if (scene.shader.arrive(node, hit, sink)) scene.shader.shade(node, hit, surface, sink);
  WaveRays<uint32_t>& rays = wave.rays[node.slot];
  count(rays.bounces, bounces ? 1 : 0);
  count(rays.shadows, sink.shadows);
  count(rays.reflections, sink.counted.reflection);
  count(rays.refractions, sink.counted.transmission);
}

// Adds the samples of a pixel to its sums.
inline void finish_tree_pixel(const TreeWave& wave, uint32_t pixel) {
  add_pixel(wave, pixel, [&](uint32_t slot) {
    const WhittedSample& sample = wave.sums[slot];
    FinishedSample done{sample.radiance.value(), 1.0f - sample.transparency.value()};
    if (wave.components != nullptr) {
      done.emission = wave.components[slot].emission.value();
      done.direct = wave.components[slot].direct.value();
    }
    return done;
  });
}

} // namespace kindling::kernels
