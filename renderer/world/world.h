// The World: the prepared, immutable scene.
// Rays are traced by its accelerator; hits become surfaces ready to shade.
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

#include <array>
#include <cassert>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// Ray::flags: partly transparent (BLEND) surfaces are hit wherever alpha is above 0, and
// SurfacePoint::alpha is their coverage. Without the flag coverage is decided stochastically during
// traversal, for occlusion rays.
inline constexpr uint32_t kHitPartlyTransparent = 1;
// Ray::flags: surfaces that transmit light in a straight line are not hit where they are smooth
// enough.
inline constexpr uint32_t kPassThinWalls = 2;
// Ray::flags: only such surfaces are hit, wherever their coverage is above 0, besides geometry that
// needs no filter.
inline constexpr uint32_t kHitThinWalls = 4;
// Ray::flags: a ray of the camera, or its straight continuation. Where a World hides backs
// (hides_backs()), such rays pass through them.
inline constexpr uint32_t kCameraRay = 8;
// Ray::flags: meets backs also where a World hides them.
inline constexpr uint32_t kEveryFace = 16;

// The place from which a World is seen, for the faces that are cut away (World::is_cut_away()).
struct ViewPoint {
  V3f position;
  V3f forward{0.0f, 0.0f, -1.0f}; // unit
  bool orthographic = false;
};

class TextureLookup;
class Contacts;

// The layers of a material at one point of its surface.
struct SurfaceLayers {
  LayerParameters bsdf;       // without eta and clearcoat_normal, which depend on path and frame
  V3f tangent{0.0f};          // world space, the direction of anisotropy; zero: none
  V3f clearcoat_normal{0.0f}; // world space, unit, on the side of wo; only with a coat
  bool boundary = false;      // of a medium: World::medium()
  bool entering = false;      // wo is on its outer side
  bool thin_wall = false;     // light may pass in a straight line: LayeredBsdf::straight_transmittance()
  bool transmits = false;     // transmits light in directions that can be evaluated
};

// A point on a surface, in world space, with all data for an integrator.
struct SurfacePoint {
  V3f position;
  float position_error = 0.0f; // bound of the distance between `position` and the true hit, meters
  V3f geometric_normal;        // unit, on the side of wo
  V3f shading_normal;          // unit, on the side of wo: normal-mapped, corrected where it would face away
  float alpha = 1.0f;          // coverage; below 1 only for BLEND materials
  Rgb emitted{0.0f};           // radiance towards wo where covered
  uint32_t emissive_triangle = accel::kNoId; // index in the LightSet: light sampling can reach it, so MIS applies
  bool unlit = false;                        // reflects nothing: only `emitted` counts
  bool guarded = false;                      // `origins` are valid: the hit is close to another wall, or may be
  bool layered = false;                      // `layers` is valid
  uint32_t material = 0;                     // index for reports, and for World::medium()
  std::array<V3f, 2> origins;                // of new rays: on the side of wo; beyond the surface, if light can pass it
  BsdfParameters bsdf;
  SurfaceLayers layers;

  [[nodiscard]] bool has_thin_wall() const { return layered && layers.thin_wall; }
  // Returns the normal for light sampling: zero if light from all directions counts.
  [[nodiscard]] V3f light_normal() const { return layered && layers.transmits ? V3f(0.0f) : geometric_normal; }
};

// The footprint of a ray on the surface that it hit.
struct RayFootprint {
  float width_m = 0.0f; // diameter of its cone at the hit; 0 reads textures at their finest level
  // True if emission is texture-filtered, for rays without competing light sampling. False if light
  // sampling must see the same emission: the finest level.
  bool filters_emission = false;
  float relative_area = -1.0f; // relative to twice the triangle, by SurfaceFootprint; below 0: not yet known
  float choice = 0.0f;         // likewise, valid if the area is known
};

// Statistics of motion while the shutter is open.
struct MotionStatistics {
  size_t moving_instance_count = 0;
  size_t deforming_mesh_count = 0;
  size_t max_keys = 0;  // maximum over all objects
  size_t key_bytes = 0; // matrices, and vertices after the opening
};

// Times of the build steps.
struct BuildTimes {
  WorkTime textures; // texture levels
  WorkTime geometry; // vertex packing
  WorkTime lights;   // collection and light tree
  WorkTime accelerator;
};

struct WorldStatistics {
  double build_s = 0.0;
  BuildTimes times; // of the steps
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
  // Returns the input of the accelerator: others can be built over the same geometry, as long as
  // the World lives.
  [[nodiscard]] accel::BuildInput accelerator_input() const {
    return {accel_meshes_, accel_groups_, instances_, accel_motions_, {&World::accept_hit, this, abandon_}};
  }
  // True once WorldOptions::abandon is set: answers of queries mean nothing any more, and no sample
  // that may depend on them is used.
  [[nodiscard]] bool abandoned() const { return abandon_ != nullptr && abandon_->load(std::memory_order_relaxed); }
  [[nodiscard]] const LightSet& lights() const { return *lights_; }
  // True if WorldOptions::studio is automatic and nothing but emissive surfaces lights the file's
  // scene: whether they suffice depends on the view (WorldSequence::light_by_studio()).
  [[nodiscard]] bool lit_by_emission_alone() const { return lit_by_emission_alone_; }
  // Returns the bounds of all geometry over the shutter; a unit box around the origin if there is
  // none.
  [[nodiscard]] const Box3f& bounds() const { return bounds_; }
  // True if rays with kCameraRay do not hit the backs of single-sided faces, and others not where
  // these are cut away.
  [[nodiscard]] bool hides_backs() const { return hides_backs_; }
  // True if the ray meets the back of a single-sided face (doubleSided: false) at `hit`. Boundaries
  // of media have two sides.
  [[nodiscard]] bool is_hidden_back(const accel::Ray& ray, const accel::Hit& hit) const;
  // True if the ViewPoint, to which the face at `hit` turns its back, is in free sight of it. Such
  // places are open to all rays, so that light enters a room by the wall that the camera looks
  // through. Emitters are not cut away: light samples end on them.
  [[nodiscard]] bool is_cut_away(const accel::Ray& ray, const accel::Hit& hit) const;
  // True if any object or light moves while the shutter is open; only then ray times matter.
  [[nodiscard]] bool has_motion() const { return has_motion_; }

  // Prefetches the memory that surface_at() reads for these hits, up to a few dozen: their
  // latencies overlap. There must be one ray and one footprint per hit, those passed to
  // surface_at() later; computed footprint values are stored in them.
  void prefetch(std::span<const accel::Ray> rays, std::span<const accel::Hit> hits,
                std::span<RayFootprint> footprints) const;
  // Computes the surface that `ray` hit at `hit` (hit.is_hit()), posed at ray.time; wo =
  // -direction. `ray.direction` must be unit.
  void surface_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                  const RayFootprint& footprint = {}) const;

  // True if BSDF and layer parameters are constant over the mesh that was hit: no textures, no
  // vertex colors.
  [[nodiscard]] bool is_uniform(const accel::Hit& hit) const {
    const Geometry& geometry = geometries_[hit.mesh];
    return geometry.color_offset == Geometry::kAbsent && geometry.stroke == Stroke::none &&
           !materials_[geometry.material].textured;
  }
  [[nodiscard]] size_t material_count() const { return materials_.size(); }

  // Returns texture coordinate set 0 before any transform; (0, 0) if absent.
  [[nodiscard]] V2f texcoord_at(const accel::Hit& hit) const;

  // Returns the medium inside of meshes with this material (SurfacePoint::layers.boundary).
  [[nodiscard]] const Medium& medium(uint32_t material) const {
    assert(material < materials_.size() && materials_[material].layers != kNone);
    return media_[static_cast<size_t>(materials_[material].layers)];
  }
  // True if any surface may transmit light in a straight line.
  [[nodiscard]] bool has_thin_walls() const { return has_thin_walls_; }

  [[nodiscard]] const std::string& material_name(uint32_t material) const;
  [[nodiscard]] const WorldStatistics& statistics() const { return statistics_; }

 private:
  friend class WorldBuilder;
  friend struct WorldChanges;
  World() = default;

  // The frame interpolated from the vertices of a hit, in world space, on the front side.
  struct VertexFrame {
    V3f normal;
    V3f tangent{0.0f}, bitangent{0.0f};
    bool has_tangent = false;
    bool front = true; // wo is on the front side
  };
  // surface_at() for moving objects, and the common template.
  [[gnu::noinline]] void moving_surface_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                           const RayFootprint& footprint) const;
  template <bool kMoving>
  void surface_of(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                  const RayFootprint& footprint) const;
  void layers_at(const TextureLookup& textures, const VertexFrame& vertex, const V3f& wo, SurfacePoint& surface) const;
  [[nodiscard]] bool is_single_sided(const ShadingMaterial& material) const;
  // A triangle in the world at the time of a ray.
  struct PosedFace {
    std::array<V3f, 3> corners;
    bool mirrored = false;

    // True if rays in this direction meet its back.
    [[nodiscard]] bool is_back_for(const V3f& direction) const {
      const float along = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(direction);
      return mirrored ? along < 0.0f : along > 0.0f;
    }
  };
  [[nodiscard]] PosedFace face_at(const accel::Ray& ray, const accel::Hit& hit) const;
  // Finds the origins of a guarded surface (ray_origins.cpp). Where there are none, it becomes
  // black.
  [[gnu::noinline, gnu::cold]] void guard(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface) const;
  static bool accept_hit(const void* world, const accel::Ray& ray, const accel::Hit& candidate);

  std::vector<Geometry> geometries_; // one per accelerator mesh
  std::vector<ShadingMaterial> materials_;
  std::vector<LayerMaterial> layer_materials_; // by ShadingMaterial::layers
  std::vector<Medium> media_;                  // likewise
  const std::atomic<bool>* abandon_ = nullptr;
  bool has_thin_walls_ = false;
  bool has_motion_ = false;
  bool hides_backs_ = false;
  std::optional<ViewPoint> view_point_; // unset: nothing is cut away
  bool lit_by_emission_alone_ = false;
  std::vector<Texture> textures_;
  ProceduralScene procedurals_;
  std::vector<std::string> material_names_;
  std::vector<WorldInstance> instances_;   // one per accelerator instance
  std::vector<std::vector<M44f>> motions_; // by WorldInstance::motion: the matrices of all keys
  std::vector<uint32_t> first_emissive_; // per emissive instance and mesh: index of its first triangle in the LightSet
  std::vector<accel::TriangleMesh> accel_meshes_; // borrow from geometries_
  std::vector<uint8_t> covers_;                   // by mesh: 1 if it is opaque where it is hit
  std::vector<accel::MeshGroup> accel_groups_;
  std::vector<std::span<const M44f>> accel_motions_; // borrow from motions_
  // Borrow from geometries_: one entry for each deforming mesh.
  std::vector<std::vector<std::span<const V3f>>> accel_keys_;
  std::unique_ptr<accel::Accelerator> accelerator_;
  const accel::Accelerator* probed_ = nullptr; // the same one before wrapping, for rays that are no part of a path
  std::unique_ptr<const Contacts> contacts_;   // null: no triangle is touched inside by another
  std::unique_ptr<LightSet> lights_;
  Box3f bounds_;
  WorldStatistics statistics_;
};

// Returns an origin for new rays that cannot hit the surface they leave: offset from the surface on
// the side of `direction` by the error bound of the point (Pharr, Jakob and Humphreys, "Physically
// Based Rendering", 4th ed., section 6.8.6). Near edges it is on the inner side of all walls around
// (ray_origins.cpp).
[[nodiscard]] V3f offset_ray_origin(const SurfacePoint& surface, const V3f& direction);

// Returns the shadow ray from a surface to a light sample: it starts off the surface, aims at the
// sampled point from there, and ends just before the light's own surface, by the error bounds of
// both. t is in meters. `time` is that of the ray that hit the surface.
[[nodiscard]] accel::Ray make_shadow_ray(const SurfacePoint& surface, const LightSample& light, uint32_t key,
                                         uint32_t index, float time);

} // namespace kindling
