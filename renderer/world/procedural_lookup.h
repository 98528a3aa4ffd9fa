// Evaluates procedural textures at a hit, filtered over the ray's footprint.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_texture.h"
#include "renderer/texture/texture.h"
#include "renderer/world/hit_records.h"

#include <span>

namespace kindling {

struct SurfaceFootprint;

// The parts of a World that procedural textures read. Positions and normals are those at the
// opening of the shutter, so patterns move with their objects.
struct ProceduralScene {
  std::span<const ProceduralTextureView> textures;
  std::span<const TextureView> images;
  std::span<const WorldInstance> instances;

  // Returns the value of texture `number` at a hit, averaged over the footprint if `filtered`, else
  // at the point.
  [[nodiscard]] V4f sample(int number, const HitRecords& records, const SurfaceFootprint& footprint,
                           bool filtered) const;
};

} // namespace kindling
