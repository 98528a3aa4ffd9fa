// One thread's memory for a batch of paths.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/photons/gathered_photon.h"
#include "renderer/integrator/photons/photon_maps.h"
#include "renderer/integrator/shade_group.h"
#include "renderer/integrator/shadow_queries.h"
#include "renderer/integrator/split_light.h"
#include "renderer/integrator/stages/path_stages.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace kindling {

class PathRecorder;
struct PathReuse;
struct CaughtPaths;

// One thread's batch of paths. A path keeps its slot until it ends; `active` lists the slots of
// unfinished paths, and rays and hits are parallel to it. Sized once and never grown: nothing
// allocates per sample.
class PathContext final : public ThreadContext {
 public:
  // `max_shadow_rays`: those of a path at a surface, IntegratorSettings::max_shadow_rays().
  PathContext(size_t batch_size, size_t max_shadow_rays, AovSet aovs);
  ~PathContext() override;

  // True if the paths of a batch are shared between pixels; those that train a guide are not.
  [[nodiscard]] bool reuses() const { return reuse && !recorder; }
  [[nodiscard]] PathInFlight path_at(uint32_t slot) {
    const CameraSample& sample = camera_samples[slot];
    return {slot,
            sample,
            states[slot],
            media[slot],
            surfaces.empty() ? nullptr : &surfaces[slot],
            level.value_or(sample.sample_index)};
  }

  std::vector<PixelRect> blocks;            // of a batch that has several
  std::vector<CameraSample> camera_samples; // by slot
  std::vector<BlockSample> listed;          // of a batch, if there are rates
  std::vector<PathState> states;            // by slot
  std::vector<MediumStack> media;           // by slot; only where the state is in_medium
  std::vector<FilmSurface> surfaces;        // by slot; empty if no AOV needs it
  std::vector<accel::Hit> first_hits;       // by slot: at `surfaces`; likewise
  std::vector<uint32_t> active, next_active;
  std::vector<accel::Ray> rays, next_rays;
  std::vector<accel::Hit> hits;
  std::vector<accel::Ray> shadow_rays;
  std::vector<ShadowRecord> shadow_records;
  std::vector<uint8_t> occluded;
  ShadowQueries shadow_queries; // of first surfaces that have several shadow rays
  // Unoccluded shadow rays, traced from thin wall to thin wall.
  std::vector<accel::Ray> thin_wall_rays;
  std::vector<accel::Hit> thin_wall_hits;
  std::vector<uint32_t> thin_wall_records; // index of the shadow ray
  std::unique_ptr<SplitLight> split_light; // null: neither light groups nor passes
  std::unique_ptr<PathReuse> reuse;        // null: paths are not shared between pixels
  std::unique_ptr<CaughtPaths> caught;     // null: no shadow catchers
  PathRecorder* recorder = nullptr;        // set while a guide is trained
  // The camera rays of a part of a block are traced without those of the rest: a pixel may differ
  // between crops. For pilots.
  bool traces_parts = false;
  LightPathContext light_paths;
  BatchPhotonMaps photon_maps;                     // of the batch's samples; empty: no photons
  std::vector<GatheredPhoton>* gathered = nullptr; // set while a pilot measures photons
  Film* indirect = nullptr; // likewise while a pilot measures the light of later reflections alone
  // The level of the batch, by which all its paths have their photon map; unset: each by its
  // sample.
  std::optional<uint32_t> level;
  uint32_t traced_slot = 0; // of the path that ThreadContext::trace records
  ShadeGroup group;
};

} // namespace kindling
