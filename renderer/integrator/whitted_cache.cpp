// Looks terms of local illumination up in the cache of materials.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_shader.h"

namespace kindling {

WhittedTerms WhittedShader::cached_terms(const accel::Hit& hit, const SurfacePoint& surface,
                                         WhittedCounters& counters) const {
  // Layers outside of a medium are missing when seen from within, and anisotropy depends on the
  // mesh's tangents.
  const bool varies = surface.layered &&
                      ((surface.layers.boundary && !surface.layers.entering) || surface.layers.bsdf.anisotropy > 0.0f);
  if (varies || !world->is_uniform(hit)) {
    ++counters.cache_bypasses;
    return whitted_terms(surface, ambient);
  }
  if (const WhittedTerms* const known = cache->find(surface.material)) {
    ++counters.cache_hits;
    return *known;
  }
  ++counters.cache_misses;
  const WhittedTerms terms = whitted_terms(surface, ambient);
  cache->store(surface.material, terms);
  return terms;
}

} // namespace kindling
