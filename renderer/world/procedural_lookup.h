// Procedural textures at one hit: what their graphs read of the surface, and how it changes across the ray's footprint.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_texture.h"
#include "renderer/texture/texture.h"
#include "renderer/world/hit_records.h"

#include <span>
#include <vector>

namespace kindling {

struct SurfaceFootprint;

// All that is read of a World. Positions and normals are those of the moment at which the shutter opens, so that a pattern stays on what moves.
struct ProceduralScene {
  std::vector<ProceduralTexture> textures;
  std::span<const Texture> images;
  std::span<const WorldInstance> instances;

  // Texture number `number` at a hit: averaged over the footprint, or at the point alone.
  [[nodiscard]] V4f sample(int number, const HitRecords& records, const SurfaceFootprint& footprint,
                           bool filtered) const;
};

} // namespace kindling
