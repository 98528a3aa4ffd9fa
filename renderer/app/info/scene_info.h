// What is in a file, collected from its Scene: the one source of the tables and of the JSON of `kindling info`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/setup/memory_budget.h"
#include "renderer/import/load_gltf.h"
#include "renderer/scene/describe.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

struct MeshInfo {
  std::string name;
  uint64_t primitives = 0;
  uint64_t triangles = 0;
  uint64_t vertices = 0;
  uint64_t placed = 0;                 // times in the scene
  std::vector<std::string> attributes; // besides positions
};

struct ExtensionInfo {
  std::string name;
  std::string support; // "full", "partial", "ignored" or "unknown"
};

struct MaterialInfo {
  std::string name;
  std::string alpha_mode; // as glTF spells it
  bool double_sided = false;
  bool unlit = false;
  bool emissive = false;
  uint64_t textures = 0;   // slots in use
  uint64_t primitives = 0; // that have it, in the shown variant
  std::vector<ExtensionInfo> extensions;
};

struct TextureInfo {
  std::string name;
  int width = 0; // 0: the image could not be read
  int height = 0;
  std::string format; // "RGB 8 bit"
  uint64_t bytes = 0; // 0 for an image that an earlier texture holds
};

struct CameraInfo {
  std::string name;
  std::string kind;
  std::string lens;
};

struct LightInfo {
  std::string name;
  std::string kind;
  std::string intensity; // with its unit
  uint64_t placed = 0;
};

struct AnimationInfo {
  std::string name;
  uint64_t channels = 0;
  double duration_s = 0.0;
};

struct SceneInfo {
  std::string file;
  std::string generator;
  std::string copyright;
  uint64_t content_hash = 0;
  std::vector<std::string> scenes;
  int shown_scene = kNone; // which of them the numbers are about
  SceneStatistics in_file;
  PosedStatistics in_scene;
  Box3f bounds; // of the shown scene; empty if it shows nothing
  std::vector<MeshInfo> meshes;
  std::vector<MaterialInfo> materials;
  std::vector<TextureInfo> textures;
  std::vector<CameraInfo> cameras; // of the shown scene, as --camera counts them
  std::vector<LightInfo> lights;
  std::vector<AnimationInfo> animations;
  std::vector<std::string> variants;
  int shown_variant = kNone; // which of them the scene has been given; kNone: the primitives' own materials
  std::vector<ExtensionInfo> extensions;
  MemoryBudget memory;
};

[[nodiscard]] SceneInfo collect_scene_info(const Scene& scene, const PosedScene& posed, int shown_scene,
                                           int shown_variant = kNone, const MemoryRequest& request = {});

// Headings and tables.
[[nodiscard]] std::string format_info_tables(const SceneInfo& info);
// The keys are described in README.md.
[[nodiscard]] std::string format_info_json(const SceneInfo& info);

} // namespace kindling::app
