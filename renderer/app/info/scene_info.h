// The contents of a scene file, for the tables and the JSON of `kindling info`.
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
  uint64_t placed = 0;                 // instances in the scene
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
  uint64_t primitives = 0; // users of this material in the shown variant
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

// The light of a render with default settings.
struct LightingInfo {
  std::string by; // "environment", "image light", "lights", "emission", "studio" or "studio and emission"
  std::optional<double> lit_share; // SceneLight::lit_share
};

struct SceneInfo {
  std::string file;
  std::string generator;
  std::string copyright;
  uint64_t content_hash = 0;
  std::vector<std::string> scenes;
  int shown_scene = kNone; // the scene that the numbers describe
  SceneStatistics in_file;
  uint64_t outlines = 0; // primitives of lines that a render leaves out; set by the caller, as is in_file
  PosedStatistics in_scene;
  Box3f bounds; // bounds of the shown scene; empty for an empty scene
  std::vector<MeshInfo> meshes;
  std::vector<MaterialInfo> materials;
  std::vector<TextureInfo> textures;
  std::vector<CameraInfo> cameras; // in the shown scene, numbered as for --camera
  std::vector<LightInfo> lights;
  LightingInfo lighting; // set by the caller
  std::vector<AnimationInfo> animations;
  std::vector<std::string> variants;
  int shown_variant = kNone; // the applied variant; kNone: the primitives' own materials
  std::vector<ExtensionInfo> extensions;
  MemoryBudget memory;
};

[[nodiscard]] SceneInfo collect_scene_info(const Scene& scene, const PosedScene& posed, int shown_scene,
                                           int shown_variant = kNone, const MemoryRequest& request = {});

// Headings and tables for a terminal.
[[nodiscard]] std::string format_info_tables(const SceneInfo& info);
// README.md describes the keys.
[[nodiscard]] std::string format_info_json(const SceneInfo& info);

} // namespace kindling::app
