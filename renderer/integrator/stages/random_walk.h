// The way of one path through a medium: absorption, and a random walk that may be guided.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/sampling/warp.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

namespace kindling {

inline constexpr uint32_t kMaxScatterEvents = 1024; // longer walks are absorbed
inline constexpr uint32_t kFirstRouletteEvent = 16;

// Each event of a walk has its own key for its draws: this one plus its number.
inline constexpr uint32_t kWalkKey = 0x5ca77e2bU;

[[nodiscard]] inline Rgb exp_negative(const Rgb& optical_depth) {
  return {elementary::exp(-optical_depth.x), elementary::exp(-optical_depth.y), elementary::exp(-optical_depth.z)};
}

// Returns the share of a region's bright directions in what is scattered into a direction: lobes of
// mean cosines g and h give one of mean cosine g h.
[[nodiscard]] inline float guided_share(const VolumeGuideView::Region& region, const V3f& direction, float g) {
  if (!(region.share > 0.0f)) return 0.0f;
  const float length = region.mean.length();
  const float cosine = length > 0.0f ? direction.dot(region.mean) / length : 0.0f;
  const float bright = region.share * henyey_greenstein_pdf({0.0f, 0.0f, cosine}, g * length) * (4.0f * kPi);
  return bright / (bright + (1.0f - region.share));
}

// Samples the direction of a scattering event.
inline V3f PathStages::scatter_direction(const V3f& direction, const V3f& position, float g,
                                         const SampleAddress& address, PathState& state) const {
  const V2f u = Sampler::sample_2d(address.key, address.index, 2);
  const Frame frame = Frame::around(direction);
  if (!volumes) return frame.to_world(sample_henyey_greenstein(u, g));
  const VolumeGuideView::Region& region = volumes->find(position);
  const float share = guided_share(region, direction, g);
  if (!(share > 0.0f)) return frame.to_world(sample_henyey_greenstein(u, g));
  const V3f wi = Sampler::sample_1d(address.key, address.index, 3) < share
                     ? volumes->sample(region.root, u)
                     : frame.to_world(sample_henyey_greenstein(u, g));
  const float phase = henyey_greenstein_pdf({0.0f, 0.0f, direction.dot(wi)}, g);
  const float density = phase + share * (volumes->pdf(region.root, wi) - phase);
  state.throughput *= phase / density;
  state.guiding *= density / phase;
  return wi;
}

// Returns the key of the draws of a walk's next step. Each segment of a path in a medium has its
// own: after an event, a reflection inside, or a surface that it passes straight through.
[[nodiscard]] inline uint32_t walk_key(const PathInFlight& path) {
  const PathState& state = path.state;
  return hash_combine(hash_combine(path.sample.address.key, kWalkKey + state.scatter_events),
                      (static_cast<uint32_t>(state.bounce) << 8) + state.transparent_surfaces);
}

// Returns the probabilities with which the channels draw a distance: by the throughput. Its density
// is the mean over the channels (Wilkie et al. 2014, "Hero Wavelength Spectral Sampling", with
// three channels).
[[nodiscard]] inline Rgb channel_probabilities(const PathState& state) {
  return state.throughput / (state.throughput.x + state.throughput.y + state.throughput.z);
}

[[nodiscard]] inline float sum_of(const Rgb& c) { return c.x + c.y + c.z; }

inline std::optional<float> PathStages::scatter_distance(float hit_distance, const PathInFlight& path) const {
  const PathState& state = path.state;
  if (!state.in_medium || is_black(state.throughput)) return std::nullopt;
  const Medium& medium = world->medium(*path.media.innermost());
  if (is_black(medium.scattering)) return std::nullopt;
  const Rgb choice = channel_probabilities(state);
  const V2f u = Sampler::sample_2d(walk_key(path), path.sample.address.index, 0);
  const unsigned channel = u.x < choice.x ? 0 : u.x < choice.x + choice.y ? 1 : 2;
  const float chosen = medium.extinction[channel];
  const float distance = chosen > 0.0f ? -elementary::log(1.0f - u.y) / chosen : kInfinity;
  return distance < hit_distance ? std::optional(distance) : std::nullopt;
}

inline bool PathStages::cross_medium(float distance, const PathInFlight& path) const {
  PathState& state = path.state;
  assert(state.in_medium && !path.media.empty());
  if (is_black(state.throughput)) return false;
  const Medium& medium = world->medium(*path.media.innermost());
  const Rgb through = exp_negative(medium.extinction * distance);
  if (is_black(medium.scattering)) {
    state.throughput *= through;
  } else {
    state.light_path_scale = 0.0f;
    state.throughput *= through / sum_of(channel_probabilities(state) * through);
  }
  return !is_black(state.throughput);
}

template <typename Sink>
inline void PathStages::scatter_in_medium(const accel::Ray& ray, float distance, const PathInFlight& path,
                                          Sink& sink) const {
  PathState& state = path.state;
  const Medium& medium = world->medium(*path.media.innermost());
  const SampleAddress& address = path.sample.address;
  const uint32_t key = walk_key(path);
  const Rgb through = exp_negative(medium.extinction * distance);
  state.light_path_scale = 0.0f;
  state.throughput *= medium.scattering * through / sum_of(channel_probabilities(state) * medium.extinction * through);
  if (++state.scatter_events > kMaxScatterEvents || is_black(state.throughput)) return;
  if (state.scatter_events >= kFirstRouletteEvent) {
    const float survival = std::min(1.0f, std::sqrt(max_component(state.throughput) * state.guiding));
    if (Sampler::sample_1d(key, address.index, 1) >= survival) return;
    state.throughput /= survival;
  }
  sink.arrive(path, nullptr);

  state.bsdf_pdf = 0.0f; // no light sampling inside media
  state.cone = scattered_cone(state.cone, 0.25f * kInvPi);
  state.specular_cone.spread = -1.0f;
  const V3f position = ray.origin + ray.direction * distance;
  state.previous_position = position;
  const V3f wi = scatter_direction(ray.direction, position, medium.scatter_anisotropy, {key, address.index}, state);
  sink.scatter_event(ray, distance, position, state);
  sink.extend(path, {.origin = position,
                     .t_min = 0.0f,
                     .direction = wi,
                     .t_max = kInfinity,
                     .key = key,
                     .time = ray.time,
                     .index = address.index,
                     .flags = kHitPartlyTransparent});
}

} // namespace kindling
