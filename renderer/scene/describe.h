// Statistics of scenes and poses, for reports and `info`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"

#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

// Counts the file's contents; objects that are used several times count once.
struct SceneStatistics {
  uint64_t scenes = 0;
  uint64_t nodes = 0;
  uint64_t meshes = 0;
  uint64_t primitives = 0;
  uint64_t triangles = 0;
  uint64_t vertices = 0;
  uint64_t geometry_bytes = 0; // all vertex attributes, morph targets and indices
  uint64_t materials = 0;
  uint64_t textures = 0;
  uint64_t images = 0;              // distinct decoded images
  uint64_t unreadable_textures = 0; // without an image: unreadable, or not loaded on request
  uint64_t texture_bytes = 0;       // of the distinct images
  uint64_t skins = 0;
  uint64_t joints = 0;
  uint64_t morph_targets = 0;
  uint64_t animations = 0;
  uint64_t animation_channels = 0;
  std::optional<double> first_key_s; // unset: no keys
  std::optional<double> last_key_s;
  uint64_t cameras = 0;
  uint64_t lights = 0;
  uint64_t variants = 0;
};

// Counts the contents of a posed scene.
struct PosedStatistics {
  uint64_t mesh_instances = 0;
  uint64_t distinct_meshes = 0;
  uint64_t deformed_meshes = 0; // with vertices of their own
  uint64_t triangles = 0;       // counts every instance
  uint64_t deformed_bytes = 0;
  uint64_t cameras = 0;
  uint64_t lights = 0;
};

[[nodiscard]] SceneStatistics describe(const Scene& scene);
[[nodiscard]] PosedStatistics describe(const Scene& scene, const PosedScene& posed);

// Names for reports.
[[nodiscard]] std::string_view name_of(AlphaMode mode);              // OPAQUE, MASK, BLEND
[[nodiscard]] std::string_view name_of(SceneCamera::Kind kind);      // perspective, orthographic
[[nodiscard]] std::string_view name_of(PunctualLight::Kind kind);    // directional, point, spot
[[nodiscard]] std::string_view name_of(Interpolation interpolation); // STEP, LINEAR, CUBICSPLINE

} // namespace kindling
