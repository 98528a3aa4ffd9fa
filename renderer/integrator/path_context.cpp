// Makes a thread's memory for a batch of paths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_context.h"

#include "renderer/integrator/caught_paths.h"
#include "renderer/integrator/path_reuse.h"

namespace kindling {

PathContext::PathContext(size_t batch_size, size_t max_shadow_rays, AovSet aovs)
    : camera_samples(batch_size), listed(batch_size), states(batch_size), media(batch_size),
      surfaces(aovs.needs_film_surface() ? batch_size : 0), first_hits(aovs.needs_first_hit() ? batch_size : 0),
      active(batch_size), next_active(batch_size), rays(batch_size), next_rays(batch_size), hits(batch_size),
      shadow_rays(batch_size * max_shadow_rays), shadow_records(shadow_rays.size()), occluded(shadow_rays.size()),
      thin_wall_rays(shadow_rays.size()), thin_wall_hits(shadow_rays.size()), thin_wall_records(shadow_rays.size()) {
  blocks.reserve(batch_size); // of one pixel at least
}

PathContext::~PathContext() = default;

} // namespace kindling
