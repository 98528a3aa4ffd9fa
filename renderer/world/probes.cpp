// Single rays of shading: by the accelerator, or by the tree that a device has instead.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/probes.h"

namespace kindling {

accel::Hit WorldView::probe_hit(const accel::Ray& ray) const {
  return tree != nullptr ? compact_probe_hit(*this, ray) : probed->intersect(ray);
}

bool WorldView::probe_is_blocked(const accel::Ray& ray) const {
  return tree != nullptr ? compact_probe_is_blocked(*this, ray) : probed->occluded(ray);
}

bool WorldView::sight_is_blocked(const accel::Ray& ray) const {
  return tree != nullptr ? compact_sight_is_blocked(*this, ray) : traced->occluded(ray);
}

} // namespace kindling
