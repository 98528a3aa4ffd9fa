// The part of a World that tracing and shading read: arrays, and surfaces at hits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/math.h"
#include "renderer/base/on_gpu.h"
#include "renderer/light/light_set_view.h"
#include "renderer/world/contacts.h"
#include "renderer/world/geometry.h"
#include "renderer/world/layer_material.h"
#include "renderer/world/opacity/opacity_micromaps.h"
#include "renderer/world/procedural_lookup.h"
#include "renderer/world/shading_material.h"
#include "renderer/world/surface_point.h"

#include <array>
#include <cassert>
#include <cstdint>
#include <optional>
#include <span>

namespace kindling::accel::kd {
struct StructureView;
}

namespace kindling {

// The place from which a World is seen, for the faces that are cut away (WorldView::is_cut_away()).
struct ViewPoint {
  V3f position;
  V3f forward{0.0f, 0.0f, -1.0f}; // unit
  bool orthographic = false;
};

class TextureLookup;

struct WorldView {
  [[nodiscard]] const accel::Accelerator& accelerator() const { return *traced; }

  // True if the ray meets the back of a single-sided face (doubleSided: false) at `hit`. Boundaries
  // of media have two sides.
  [[nodiscard]] bool is_hidden_back(const accel::Ray& ray, const accel::Hit& hit) const;
  // True if the ViewPoint, to which the face at `hit` turns its back, is in free sight of it. Such
  // places are open to all rays, so that light enters a room by the wall that the camera looks
  // through. Emitters are not cut away: light samples end on them.
  [[nodiscard]] bool is_cut_away(const accel::Ray& ray, const accel::Hit& hit) const;

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
    const GeometryView& geometry = geometries[hit.mesh];
    return geometry.color_offset == GeometryView::kAbsent && geometry.stroke == Stroke::none &&
           !materials[geometry.material].textured;
  }

  // Returns texture coordinate set 0 before any transform; (0, 0) if absent.
  [[nodiscard]] V2f texcoord_at(const accel::Hit& hit) const;

  // Returns the medium inside of meshes with this material (SurfacePoint::layers.boundary).
  [[nodiscard]] const Medium& medium(uint32_t material) const {
    assert(material < materials.size() && materials[material].layers != kNone);
    return media[static_cast<size_t>(materials[material].layers)];
  }
  // Decides whether a ray meets a candidate hit: by coverage, thin walls and hidden backs. For
  // accel::HitFilter.
  [[nodiscard]] bool accepts(const accel::Ray& ray, const accel::Hit& candidate) const {
    if (hides_backs) {
      const bool seen = (ray.flags & kEveryFace) != 0 ||
                        !((ray.flags & kCameraRay) != 0 ? is_hidden_back(ray, candidate) : is_cut_away(ray, candidate));
      if (!seen) return false;
      if (covers[candidate.mesh] != 0) return true;
    }
    return accepts_by_coverage(ray, candidate);
  }
  // The same without regard to the side of the face.
  [[nodiscard]] bool accepts_by_coverage(const accel::Ray& ray, const accel::Hit& candidate) const {
    const Opacity known = opacity.at(candidate);
    return known == Opacity::mixed ? reads_coverage(ray, candidate) : known == Opacity::opaque;
  }
  // The same by textures alone.
  [[nodiscard]] bool reads_coverage(const accel::Ray& ray, const accel::Hit& candidate) const;

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
  void layers_at(const TextureLookup& texels, const VertexFrame& vertex, const V3f& wo, SurfacePoint& surface) const;
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

  // Single rays (probes.cpp): those that shading itself traces, and on a device all.
  // sight_is_blocked() is for rays with kCameraRay.
  [[nodiscard]] KINDLING_CALLED_ON_GPU accel::Hit probe_hit(const accel::Ray& ray) const;
  [[nodiscard]] KINDLING_CALLED_ON_GPU bool probe_is_blocked(const accel::Ray& ray) const;
  [[nodiscard]] KINDLING_CALLED_ON_GPU bool sight_is_blocked(const accel::Ray& ray) const;

  const accel::Accelerator* traced = nullptr;
  const accel::Accelerator* probed = nullptr;     // the same one before wrapping, for rays that are no part of a path
  const accel::kd::StructureView* tree = nullptr; // on a device, in place of both
  LightSetView lights;
  std::span<const GeometryView> geometries; // one per accelerator mesh
  std::span<const ShadingMaterial> materials;
  std::span<const LayerMaterial> layer_materials; // by ShadingMaterial::layers
  std::span<const Medium> media;                  // likewise
  std::span<const TextureView> textures;
  ProceduralScene procedurals;
  std::span<const WorldInstance> instances;       // one per accelerator instance
  std::span<const std::span<const M44f>> motions; // by WorldInstance::motion: the matrices of all keys
  std::span<const uint32_t>
      first_emissive;              // per emissive instance and mesh: index of its first triangle in the LightSet
  std::span<const uint8_t> covers; // by mesh: 1 if it is opaque where it is hit
  OpacityMicromapsView opacity;    // of meshes that are not opaque everywhere
  ContactsView contacts;           // empty: no triangle is touched inside by another
  Box3f bounds;                    // of all geometry over the shutter; a unit box around the origin if there is none
  bool has_thin_walls = false;     // some surface may transmit light in a straight line
  bool has_motion = false;         // some object or light moves while the shutter is open; only then ray times matter
  bool exceeds_caches = false;     // prefetching pays
  bool filters_hits = false;       // some mesh is not opaque to the accelerator, which asks accepts() about its hits
  // Rays with kCameraRay do not hit the backs of single-sided faces, and others not where these are
  // cut away.
  bool hides_backs = false;
  std::optional<ViewPoint> view_point; // unset: nothing is cut away
};

} // namespace kindling
