// Functions that a device has in place of the processor's.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_shader.h"
#include "renderer/texture/texture.h"
#include "renderer/world/probes.h"

#include <array>
#include <cstddef>

namespace kindling {

// A device has no accelerator but the tree.
accel::Hit WorldView::probe_hit(const accel::Ray& ray) const { return compact_probe_hit(*this, ray); }
bool WorldView::probe_is_blocked(const accel::Ray& ray) const { return compact_probe_is_blocked(*this, ray); }
bool WorldView::sight_is_blocked(const accel::Ray& ray) const { return compact_sight_is_blocked(*this, ray); }
// A device has no pages. GPUs read texels in place.
void TextureView::fetch(int level, const std::array<int, 2>& x, const std::array<int, 2>& y, std::byte* texels) const {
  tiles->fetch(level, x, y, pixel_bytes, texels);
}

// The cache is the processor's: its threads fill it while they render.
WhittedTerms WhittedShader::cached_terms(const accel::Hit& /*hit*/, const SurfacePoint& /*surface*/,
                                         WhittedCounters& /*counters*/) const {
  __builtin_trap();
}

} // namespace kindling
