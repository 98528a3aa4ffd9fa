// Builds the tree over photons.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/photons/photon_map.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>

namespace kindling {

// `order` is a range of the tree that begins at `begin`: photons by their numbers.
void PhotonMap::divide(std::span<uint32_t> order, std::span<const Photon> photons, std::span<uint8_t> axes,
                       size_t begin) {
  if (order.size() < PhotonMapView::kLeaf) { // searched in the order of the photons' numbers
    std::sort(order.begin(), order.end());
    return;
  }
  Box3f bounds;
  for (const uint32_t number : order) bounds.extendBy(photons[number].position);
  const auto axis = static_cast<int>(bounds.majorAxis());
  const size_t middle = order.size() / 2;
  // Numbers decide between equal coordinates, so that the tree is unique.
  std::nth_element(order.begin(), order.begin() + static_cast<ptrdiff_t>(middle), order.end(),
                   [&](uint32_t a, uint32_t b) {
                     const float at_a = photons[a].position[axis], at_b = photons[b].position[axis];
                     return at_a != at_b ? at_a < at_b : a < b;
                   });
  axes[begin + middle] = static_cast<uint8_t>(axis);
  const auto below = [&] { divide(order.first(middle), photons, axes, begin); };
  const auto above = [&] { divide(order.subspan(middle + 1), photons, axes, begin + middle + 1); };
  if (order.size() > kParallel) {
    tbb::parallel_invoke(below, above);
  } else {
    below();
    above();
  }
}

PhotonMap::PhotonMap(std::vector<Photon> photons) {
  assert(photons.size() < std::numeric_limits<uint32_t>::max());
  std::vector<uint32_t> order(photons.size());
  std::iota(order.begin(), order.end(), 0U);
  std::vector<uint8_t> axes(photons.size(), 0);
  divide(order, photons, axes, 0);
  nodes_.resize(photons.size());
  photons_.resize(photons.size());
  tbb::parallel_for(size_t{0}, photons.size(), [&](size_t i) {
    photons_[i] = photons[order[i]];
    nodes_[i] = {photons_[i].position, axes[i]};
  });
}

} // namespace kindling
