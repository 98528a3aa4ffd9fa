// The memory budget: what a render of a scene takes, told before it begins. One model for `info`, for the warning of `render`, and for
// the tests that hold renders to it.
//
// Every figure is an upper bound, so that a machine that has the peak can render the scene; by how much it may be above what is measured
// is in README.md.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"
#include "renderer/film/aov.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// How the scene will be rendered.
struct MemoryRequest {
  V2i size_px{1280, 720};
  AovSet aovs;
  int threads = 1;
  std::optional<uint64_t> texture_memory_bytes; // --texture-memory
  uint64_t environment_texels = 0;              // of --env; 0: none, or an even one
  bool decodes_hdr = false;                     // an image that OpenImageIO's module has to read
};

// What a scene asks for: everything that the budget depends on, and nothing else.
struct MemoryDemand {
  uint64_t file_bytes = 0;  // of the file itself
  uint64_t scene_bytes = 0; // arrays of vertices and indices as they are read
  uint64_t nodes = 0;
  uint64_t gpu_instances = 0;  // EXT_mesh_gpu_instancing
  uint64_t placed_meshes = 0;  // as they are posed
  uint64_t deformed_bytes = 0; // vertices of skins and morph targets, at all keys
  uint64_t triangles = 0;      // in accelerators: each mesh once, and copies that are baked
  uint64_t vertices = 0;       // likewise
  uint64_t geometry_bytes = 0; // likewise: of vertices and indices as shading reads them
  uint64_t largest_primitive_bytes = 0;
  uint64_t instances = 0;          // of what is not baked
  uint64_t instance_keys = 0;      // matrices of moving instances
  uint64_t emissive_triangles = 0; // that are sampled, each instance counted
  uint64_t texture_bytes = 0;      // decoded images
  uint64_t level_bytes = 0;        // of their coarser levels
  uint64_t largest_image_bytes = 0;
  uint64_t light_texels = 0; // of EXT_lights_image_based
};
// Of a scene that has been loaded, its images included, and posed.
[[nodiscard]] MemoryDemand memory_demand(const Scene& scene, const PosedScene& posed);

// What one thing of its kind takes, in bytes: the constants of the model that are not sizes of the program's own structs.
struct MemoryCosts {
  static constexpr uint64_t kProgram = 34U << 20;       // code and libraries, the allocator's slack
  static constexpr uint64_t kImageLibrary = 120U << 20; // OpenImageIO and what it loads, once it is asked
  static constexpr uint64_t kThread = 3U << 20;         // a thread's context, stack and arenas
  static constexpr uint64_t kGuide = 24U << 20;         // at most
  static constexpr uint64_t kPixelOfImage = 48;         // while it is written: the film resolved, and encoded
  static constexpr uint64_t kEmissiveTriangle = 90;     // held
  static constexpr uint64_t kEmissiveTriangleInBuild = 260;
  static constexpr uint64_t kEnvironmentTexel = 16;        // held
  static constexpr uint64_t kEnvironmentTexelInBuild = 48; // while it is read
  static constexpr uint64_t kNode = 2600;                  // of the file, while it is read: JSON, tinygltf's and ours
  static constexpr uint64_t kInstanceKey = 160; // a matrix in World and accelerator, a box, a share of its level
};

struct MemoryBudget {
  struct Part {
    std::string_view name;
    uint64_t bytes = 0;
    std::string basis; // how it comes about: "7000000 triangles, 4.8 M vertices"
  };
  struct OfAccelerator {
    accel::Kind kind = accel::Kind::kdtree;
    uint64_t held = 0;           // by the accelerator
    uint64_t building = 0;       // likewise, at the peak of its build
    uint64_t rendering = 0;      // by everything, while it renders
    uint64_t peak = 0;           // of everything
    std::string_view peak_phase; // "loading", "building" or "rendering"
  };
  MemoryRequest request;
  uint64_t loading = 0;                      // everything, while the file is read
  std::vector<Part> parts;                   // held while it renders, whichever accelerator
  std::array<OfAccelerator, 2> accelerators; // kd-tree, Embree

  [[nodiscard]] const OfAccelerator& of(accel::Kind kind) const {
    return accelerators[kind == accel::Kind::embree ? 1 : 0];
  }
};
[[nodiscard]] MemoryBudget memory_budget(const MemoryDemand& demand, const MemoryRequest& request);

// Tables of the parts and of the accelerators.
[[nodiscard]] std::string format_memory_budget(const MemoryBudget& budget);

// Nothing if the peak fits into what this process has, `resident_bytes`, and what is available; else the warning.
[[nodiscard]] std::optional<std::string> warn_of_memory(const MemoryBudget& budget, accel::Kind kind,
                                                        uint64_t resident_bytes, std::optional<uint64_t> available);

} // namespace kindling::app
