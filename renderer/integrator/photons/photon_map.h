// A tree over photons.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/photon_view.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Photons in a kd-tree (Jensen 2001, "Realistic Image Synthesis Using Photon Mapping", chapter 6),
// whose inner nodes are photons: that in the middle of a range divides it along an axis. Immutable
// and thread-safe. The tree depends on the photons and their order alone.
class PhotonMap {
 public:
  // Builds the tree on the threads of the current TBB arena.
  explicit PhotonMap(std::vector<Photon> photons);

  static constexpr size_t kBytes = sizeof(Photon) + sizeof(PhotonMapView::Node); // of each photon

  [[nodiscard]] PhotonMapView view() const { return {nodes_, photons_}; }
  [[nodiscard]] std::span<const Photon> photons() const { return photons_; } // in the order of the tree

 private:
  static constexpr size_t kParallel = 8192; // ranges of more are divided by several threads

  static void divide(std::span<uint32_t> order, std::span<const Photon> photons, std::span<uint8_t> axes, size_t begin);

  std::vector<PhotonMapView::Node> nodes_;
  std::vector<Photon> photons_; // parallel to nodes_
};

} // namespace kindling
