// The memory budget: an upper bound of the memory that a render takes, known before it starts.
//
// One model serves `info`, the warning of `render`, and the tests that compare it with renders.
// Every figure is an upper bound; renderer/app/README.md states by how much it may exceed
// measurements.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"
#include "renderer/denoise/denoising.h"
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

// The render that memory is estimated for.
struct MemoryRequest {
  V2i size_px{1280, 720};
  AovSet aovs;
  size_t light_groups = 0; // maximum
  bool trims_outliers = false;
  uint32_t max_shadow_rays = 1; // IntegratorSettings::max_shadow_rays()
  uint32_t path_reuse = 1;
  bool light_paths = false;
  float photons = 0.0f; // IntegratorSettings::photons
  int threads = 1;
  std::optional<uint64_t> texture_memory_bytes; // --texture-memory
  uint64_t environment_texels = 0;              // of --env; 0: none, or a constant one
  Denoising denoising = Denoising::off;
};

// Counts of a scene: everything that the budget depends on.
struct MemoryDemand {
  uint64_t file_bytes = 0;  // size of the file
  uint64_t scene_bytes = 0; // arrays of vertices and indices as read
  uint64_t nodes = 0;
  uint64_t gpu_instances = 0;    // EXT_mesh_gpu_instancing
  uint64_t placed_meshes = 0;    // after posing
  uint64_t deformed_bytes = 0;   // vertices of skins and morph targets at all keys
  uint64_t triangles = 0;        // in accelerators: each mesh once, and baked copies
  uint64_t copied_triangles = 0; // further copies in accelerators: instances merged by accel::MergedInstances
  uint64_t lone_vertices = 0;    // of them, those of accel::lone_vertices()
  uint64_t vertices = 0;         // likewise
  uint64_t geometry_bytes = 0;   // likewise: vertices and indices for shading
  uint64_t largest_primitive_bytes = 0;
  uint64_t instances = 0;          // not baked
  uint64_t instance_keys = 0;      // matrices of moving instances
  uint64_t emissive_triangles = 0; // sampled; each instance counts
  uint64_t texture_bytes = 0;      // decoded images
  uint64_t level_bytes = 0;        // their coarser levels
  uint64_t largest_image_bytes = 0;
  uint64_t light_texels = 0; // of EXT_lights_image_based
  // Texels that a device cannot page, and the maximum number of images of a material.
  uint64_t unpaged_texture_bytes = 0;
  uint64_t max_images_of_material = 0;
};
// Returns the counts of a scene that has been loaded, images included, and posed.
[[nodiscard]] MemoryDemand memory_demand(const Scene& scene, const PosedScene& posed);

// Bytes per item: constants of the model that are not sizes of structs.
struct MemoryCosts {
  static constexpr uint64_t kProgram = 34U << 20;       // code and libraries, the allocator's slack
  static constexpr uint64_t kImageLibrary = 120U << 20; // OpenImageIO and its libraries, once loaded
  static constexpr uint64_t kThread = 3U << 20;         // a thread's context, stack and arenas
  static constexpr uint64_t kGuide = 24U << 20;         // maximum
  static constexpr uint64_t kPixelOfImage = 48;         // while writing: the resolved and the encoded film
  static constexpr uint64_t kFurtherMattes = 3 * 24;    // a pixel's terms of MatteSums after the first
  static constexpr uint64_t kPixelOfMatte = 48;         // while writing: six ranks
  static constexpr uint64_t kEmissiveTriangle = 90;     // held
  static constexpr uint64_t kEmissiveTriangleInBuild = 260;
  static constexpr uint64_t kEnvironmentTexel = 16;            // held
  static constexpr uint64_t kEnvironmentTexelInBuild = 48;     // while reading
  static constexpr uint64_t kPresampledEnvironment = 2U << 20; // held, of any image
  static constexpr uint64_t kNode = 2600;              // of the file, while reading: JSON, tinygltf's and our nodes
  static constexpr uint64_t kInstanceKey = 160;        // matrix in World and accelerator, box, part of its level
  static constexpr uint64_t kTexelsOfTableByte = 1024; // bytes of texels for each byte of their page table
  static constexpr uint64_t kWaitingPath = 24;         // of a device, that waits for a tile
};

struct MemoryBudget {
  struct Part {
    std::string_view name;
    uint64_t bytes = 0;
    std::string basis; // origin of the figure: "7000000 triangles, 4.8 M vertices"
  };
  struct OfAccelerator {
    accel::Kind kind = accel::Kind::kdtree;
    uint64_t held = 0;           // by the accelerator
    uint64_t building = 0;       // by the accelerator, at the peak of its build
    uint64_t rendering = 0;      // by everything, while rendering
    uint64_t peak = 0;           // maximum over all phases
    std::string_view peak_phase; // "loading", "building" or "rendering"
  };
  // In the memory of a device (--device), with the path tracer.
  struct OnDevice {
    uint64_t scene = 0;
    uint64_t waves = 0;   // of paths
    uint64_t photons = 0; // of a map
    uint64_t min = 0;     // of everything, with paged textures and the smallest waves
  };
  MemoryRequest request;
  uint64_t loading = 0;                      // everything, while loading
  std::vector<Part> parts;                   // held while rendering, with any accelerator
  std::array<OfAccelerator, 2> accelerators; // kd-tree, Embree
  OnDevice on_device;

  [[nodiscard]] const OfAccelerator& of(accel::Kind kind) const {
    return accelerators[kind == accel::Kind::embree ? 1 : 0];
  }
};
[[nodiscard]] MemoryBudget memory_budget(const MemoryDemand& demand, const MemoryRequest& request);

// Returns tables of the parts and of the accelerators.
[[nodiscard]] std::string format_memory_budget(const MemoryBudget& budget);

// Returns a warning if the peak exceeds the memory of this process, `resident_bytes`, plus the
// available memory.
[[nodiscard]] std::optional<std::string> warn_of_memory(const MemoryBudget& budget, accel::Kind kind,
                                                        uint64_t resident_bytes, std::optional<uint64_t> available);

} // namespace kindling::app
