// The memory of a wave of the path tracer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/device/kernels/take_places.h"
#include "renderer/device/kernels/wave.h"
#include "renderer/integrator/stages/light_path_stages.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/path_state.h"
#include "renderer/integrator/stages/photon_view.h"
#include "renderer/integrator/stages/reuse_paths.h"
#include "renderer/integrator/stages/split_view.h"

#include <cstdint>

namespace kindling {

// A list that kernels append to, in any order.
struct WaveQueue {
  uint32_t* count = nullptr;
  uint32_t* paths = nullptr;

  // Returns the first place of new entries.
  [[nodiscard]] uint32_t take_places(uint32_t entries) const { return kernels::take_places(*count, entries, entries); }
  void append(uint32_t path) const { paths[take_places(1)] = path; }
};

// A shadow ray's light. One thread adds the light of all shadow rays of a path in this bounce, so
// that their sum has one order.
struct WaveShadow {
  ShadowRecord record;
  uint32_t count = 0;   // of the path's rays from this one on; 0: none, or they belong to one before
  bool is_ray = false;  // false: the place is empty
  bool visible = false; // set by trace_shadow_opaque() where the path has several
};

// The number of kinds of hits by which paths are sorted: one for all rays that leave the scene, the
// others by the material's number.
inline constexpr uint32_t kHitKinds = 64;

// A light path.
struct WaveLightPath {
  LightPathState state;
  uint32_t block = 0; // of the samples that it belongs to; the number of blocks if its pixel is outside of the crop
};

// Light that a light path brings to the image.
struct WaveSplat {
  V2f film_px;
  Rgb radiance; // times square pixels; black: something is in between
};

// A photon, and the slot of the light path that has left it.
struct WavePhoton {
  Photon photon;
  uint32_t slot = 0;
};

// The photon maps of a wave, by number.
struct WavePhotonMaps {
  const PhotonMapView* views = nullptr; // null: there are none
  uint32_t first = 0;                   // number of the first map
  uint32_t samples_per_map = 1;         // PhotonMapSizes::samples
  uint32_t level = 0;                   // with sample rates: of all samples of the wave, which have one map

  [[nodiscard]] const PhotonMapView& of_sample(uint32_t map_sample) const {
    return views[map_sample / samples_per_map - first];
  }
};

// The argument of the kernels of path_kernels.h and light_path_kernels.h. A path keeps its number,
// its slot, until the end of the wave: that of its sample.
struct PathWave : Wave {
  // By path.
  PathState* states = nullptr;
  MediumStack* media = nullptr; // where the state is in_medium
  accel::Ray* path_rays = nullptr;
  accel::Hit* hits = nullptr;
  // Paths that continue, and those of the next bounce.
  WaveQueue active, next;
  // For paths that are sorted by the kind of their hit, before they are shaded.
  uint8_t* kinds = nullptr;         // by place in `active`; null: they are not
  uint32_t* kind_counts = nullptr;  // kHitKinds numbers of paths
  uint32_t* kind_places = nullptr;  // likewise, the next place of a path of each
  uint32_t* sorted_paths = nullptr; // receives `active`, sorted
  // Shadow rays of this bounce: consecutive places for each path, as many as it has light samples.
  WaveQueue shadows; // without `paths`
  accel::Ray* shadow_rays = nullptr;
  WaveShadow* shadow_records = nullptr;
  SplitView split;       // null by_pass: light is not split; its groups are the scene's
  ReuseView reuse;       // null paths: none are shared between pixels
  WaveQueue reuse_links; // numbers of the links whose rays are traced, as ReuseView::links counts them
  WavePhotonMaps photons;
  // Light paths follow those of the camera, in rounds, and take over their rays, hits and queues.
  // The shadow rays are those of the camera to the ends of light paths then.
  uint64_t first_light_path = 0;        // of the round, among those of the wave
  WaveLightPath* light_paths = nullptr; // of the round
  WaveSplat* splats = nullptr;          // by shadow ray
  SplatParts* splat_parts = nullptr;    // likewise, if light is split
  // The light paths of photon maps are traced before the samples that gather from them, in rounds
  // of at most kPhotonPaths.
  static constexpr uint32_t kPhotonPaths = 1U << 20;
  WaveQueue photons_left;             // without `paths`
  WavePhoton* left_photons = nullptr; // of one bounce
};

} // namespace kindling
