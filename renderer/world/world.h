// The World: the prepared, immutable scene. Rays go to its accelerator, hits come back as surfaces ready to shade.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/frame.h"
#include "renderer/base/math.h"
#include "renderer/base/stopwatch.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/light/light_set.h"
#include "renderer/world/geometry.h"
#include "renderer/world/layer_material.h"
#include "renderer/world/procedural_lookup.h"
#include "renderer/world/shading_material.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// Ray::flags: partly transparent (BLEND) surfaces are hit wherever alpha is above 0, and SurfacePoint::alpha says how much. Without
// it their coverage is decided at random on the way, as occlusion needs it.
inline constexpr uint32_t kHitPartlyTransparent = 1;
// Ray::flags: surfaces that light passes in a straight line are not hit where they are smooth enough for it.
inline constexpr uint32_t kPassThinWalls = 2;
// Ray::flags: these alone are hit, wherever their coverage is above 0, and whatever else needs no filter.
inline constexpr uint32_t kHitThinWalls = 4;

class TextureLookup;

// The layers of a material at one point of its surface.
struct SurfaceLayers {
  LayerParameters bsdf;       // without what the path and the frame add: eta, clearcoat_normal
  V3f tangent{0.0f};          // world space, the direction of anisotropy; zero: there is none
  V3f clearcoat_normal{0.0f}; // world space, unit, on the side of wo; only where there is a coat
  bool boundary = false;      // of a medium: World::medium()
  bool entering = false;      // wo is on its outer side
  bool thin_wall = false;     // light may pass in a straight line: LayeredBsdf::straight_transmittance()
  bool transmits = false;     // light comes through it on other ways that can be evaluated
};

// A point on a surface, in world space, as an integrator needs it.
struct SurfacePoint {
  V3f position;
  float position_error = 0.0f;               // bound of the distance between `position` and the true hit, meters
  V3f geometric_normal;                      // unit, on the side of wo
  V3f shading_normal;                        // unit, on the side of wo: normal-mapped, bent where it would face away
  float alpha = 1.0f;                        // coverage, below 1 for BLEND materials alone
  Rgb emitted{0.0f};                         // towards wo where covered, all of it
  uint32_t emissive_triangle = accel::kNoId; // number in the LightSet: it can be sampled there, so MIS applies
  bool unlit = false;                        // reflects nothing: `emitted` is the whole of it
  bool layered = false;                      // `layers` are set
  uint32_t material = 0;                     // index for reports, and for World::medium()
  BsdfParameters bsdf;
  SurfaceLayers layers;

  [[nodiscard]] bool has_thin_wall() const { return layered && layers.thin_wall; }
  // For light sampling: zero where light from all around is wanted.
  [[nodiscard]] V3f light_normal() const { return layered && layers.transmits ? V3f(0.0f) : geometric_normal; }
};

// What the ray that met a surface stands for.
struct RayFootprint {
  float width_m = 0.0f; // diameter of its cone at the hit; 0 reads textures at their finest level
  // False where the emission of lights that are sampled as well has to be what their sampling sees: the finest level. True for rays
  // with which no light sampling competes.
  bool filters_emission = false;
  float share = -1.0f; // of twice the triangle, by SurfaceFootprint; below 0: not known yet
  float choice = 0.0f; // likewise, where the share is known
};

// What moves while the shutter is open.
struct MotionStatistics {
  size_t moving_instance_count = 0;
  size_t deforming_mesh_count = 0;
  size_t max_keys = 0;  // of any of them
  size_t key_bytes = 0; // of matrices, and of vertices after the opening
};

// What the steps of a build took.
struct BuildTimes {
  WorkTime textures; // their levels
  WorkTime geometry; // vertices packed
  WorkTime lights;   // collected, and their tree
  WorkTime accelerator;
};

struct WorldStatistics {
  double build_s = 0.0;
  BuildTimes times; // parts of it
  size_t geometry_bytes = 0;
  size_t texture_bytes = 0;
  size_t light_bytes = 0;
  size_t emissive_triangle_count = 0;
  MotionStatistics motion;
  accel::Statistics accelerator;
};

class World {
 public:
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  [[nodiscard]] const accel::Accelerator& accelerator() const { return *accelerator_; }
  // What it was built from: others can be built over the same geometry, as long as the World lives.
  [[nodiscard]] accel::BuildInput accelerator_input() const {
    return {accel_meshes_, accel_groups_, instances_, accel_motions_, {&World::accept_hit, this}};
  }
  [[nodiscard]] const LightSet& lights() const { return *lights_; }
  // Bounds of all geometry, over the shutter; a unit box around the origin if there is none.
  [[nodiscard]] const Box3f& bounds() const { return bounds_; }
  // Whether anything, or a light, moves while the shutter is open: only then does the time of a ray mean something.
  [[nodiscard]] bool has_motion() const { return has_motion_; }

  // Asks for the memory that surface_at() will read for these hits, a few dozen of them: a request for one hides behind
  // those for others. One ray and one footprint for each hit, the ones surface_at() will be given: what it finds out of footprints is noted in them.
  void prefetch(std::span<const accel::Ray> rays, std::span<const accel::Hit> hits,
                std::span<RayFootprint> footprints) const;
  // The surface that `ray` met at `hit` (hit.is_hit()), wo = -direction, as it is at ray.time. `ray.direction` must be unit.
  void surface_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                  const RayFootprint& footprint = {}) const;

  // Whether the parameters of its BSDF and layers are the same all over the mesh that was hit: no textures, no colors at vertices.
  [[nodiscard]] bool is_uniform(const accel::Hit& hit) const {
    const Geometry& geometry = geometries_[hit.mesh];
    return geometry.color_offset == Geometry::kAbsent && !materials_[geometry.material].textured;
  }
  [[nodiscard]] size_t material_count() const { return materials_.size(); }

  // Texture coordinate set 0, before any transform; (0, 0) where there is none.
  [[nodiscard]] V2f texcoord_at(const accel::Hit& hit) const;

  // Inside of meshes with this material, SurfacePoint::layers.boundary.
  [[nodiscard]] const Medium& medium(uint32_t material) const {
    return media_[static_cast<size_t>(materials_[material].layers)];
  }
  // Whether any surface may let light pass in a straight line.
  [[nodiscard]] bool has_thin_walls() const { return has_thin_walls_; }

  [[nodiscard]] const std::string& material_name(uint32_t material) const;
  [[nodiscard]] const WorldStatistics& statistics() const { return statistics_; }

 private:
  friend class WorldBuilder;
  World() = default;

  // What the vertices of a hit give, in world space, as the file has it: on the front side.
  struct VertexFrame {
    V3f normal;
    V3f tangent{0.0f}, bitangent{0.0f};
    bool has_tangent = false;
    bool front = true; // wo is on the front side
  };
  // surface_at() of what moves, and of either.
  [[gnu::noinline]] void moving_surface_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                           const RayFootprint& footprint) const;
  template <bool kMoving>
  void surface_of(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                  const RayFootprint& footprint) const;
  void layers_at(const TextureLookup& textures, const VertexFrame& vertex, const V3f& wo, SurfacePoint& surface) const;
  static bool accept_hit(const void* world, const accel::Ray& ray, const accel::Hit& candidate);

  std::vector<Geometry> geometries_; // one per accelerator mesh
  std::vector<ShadingMaterial> materials_;
  std::vector<LayerMaterial> layer_materials_; // by ShadingMaterial::layers
  std::vector<Medium> media_;                  // likewise
  bool has_thin_walls_ = false;
  bool has_motion_ = false;
  std::vector<Texture> textures_;
  ProceduralScene procedurals_;
  std::vector<std::string> material_names_;
  std::vector<WorldInstance> instances_;   // one per accelerator instance
  std::vector<std::vector<M44f>> motions_; // by WorldInstance::motion: the matrices of all keys
  std::vector<uint32_t> first_emissive_; // per emissive instance and mesh: number of its first triangle in the LightSet
  std::vector<accel::TriangleMesh> accel_meshes_; // borrow from geometries_
  std::vector<accel::MeshGroup> accel_groups_;
  std::vector<std::span<const M44f>> accel_motions_; // likewise from motions_
  // Likewise from geometries_: one entry for each mesh that deforms.
  std::vector<std::vector<std::span<const V3f>>> accel_keys_;
  std::unique_ptr<accel::Accelerator> accelerator_;
  std::unique_ptr<LightSet> lights_;
  Box3f bounds_;
  WorldStatistics statistics_;
};

// Where a new ray may start so that it cannot meet the surface it leaves: off the surface on the side of `direction` by
// the error bound of the point (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th ed., section 6.8.6).
[[nodiscard]] V3f offset_ray_origin(const SurfacePoint& surface, const V3f& direction);

// The shadow ray from a surface to a light sample: starts off the surface, aims at the sampled point from there, and ends just
// before the light's own surface, by the error bounds of both. t counts in meters. `time`: of the ray that met the surface.
[[nodiscard]] accel::Ray make_shadow_ray(const SurfacePoint& surface, const LightSample& light, uint32_t key,
                                         uint32_t index, float time);

} // namespace kindling
