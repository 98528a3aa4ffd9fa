// Finds where geometry is opaque and where rays pass it, ahead of all rays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_texture.h"
#include "renderer/texture/texture.h"
#include "renderer/world/geometry.h"
#include "renderer/world/opacity/opacity_micromaps.h"
#include "renderer/world/shading_material.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

struct OpacityInput {
  std::span<const GeometryView> geometries; // one per accelerator mesh
  std::span<const ShadingMaterial> materials;
  std::span<const TextureView> textures;
  std::span<const ProceduralTextureView> procedurals;
};

// Returns by mesh 1 if rays can skip the hit filter, because coverage is complete everywhere and
// there is no thin wall, else 0.
[[nodiscard]] std::vector<uint8_t> find_covering_meshes(const OpacityInput& input);

// The arrays of an OpacityMicromapsView.
struct OpacityMicromaps {
  std::vector<uint32_t> first, entries, words;

  // The origins of maps: triangles, the materials whose textures may have alpha, and
  // AlphaClasses::bytes() of these.
  struct Demand {
    uint64_t triangles = 0, materials = 0, class_bytes = 0;
  };
  // Returns an upper bound of the bytes in use while they are made.
  [[nodiscard]] static uint64_t max_bytes(const Demand& demand);
};

// Makes micromaps of the meshes whose coverage one texture decides: MASK or BLEND with an image in
// memory that has alpha; vertex colors must be opaque and the material MASK. Where textures are in
// pages, or decide too many triangles differently, rays read them. Parallel with TBB; independent
// of the number of threads. `covers` is from find_covering_meshes().
[[nodiscard]] OpacityMicromaps make_opacity_micromaps(const OpacityInput& input, std::span<const uint8_t> covers);

} // namespace kindling
