// Surfaces at hits: interpolation, textures, normal maps and error bounds; the hit filter.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/hash.h"
#include "renderer/light/coated_emission.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/contacts.h"
#include "renderer/world/hit_records.h"
#include "renderer/world/moving_hit.h"
#include "renderer/world/normal_map.h"
#include "renderer/world/ray_origins.h"
#include "renderer/world/shading_normal.h"
#include "renderer/world/texture_lookup.h"
#include "renderer/world/world_view.h"

#include <optional>

namespace kindling {
namespace {

// Returns the slope variance of normals whose mean is 2 texel - 1, from its length r: 1 / kappa of
// a von Mises-Fisher distribution, about (1 - r) / r (Toksvig 2005, "Mipmapping Normal Maps").
// Vectors that 8 bits cannot distinguish from unit vectors count as unit.
float variance_of_normals(const Rgb& texel) {
  const float length = (texel * 2.0f - Rgb(1.0f)).length();
  constexpr float kRounding = 1.0f / 256.0f;
  return length > 0.0f ? std::max((1.0f - length) / std::max(length, 0.05f) - kRounding, 0.0f) : 0.0f;
}

// Returns the perceptual roughness of microfacets on such normals: squared alphas add, 2 / kappa in
// all (Han et al. 2007, "Frequency Domain Normal Map Filtering", with a lobe that is Gaussian in
// slopes).
float widened(float roughness, float slope_variance) {
  const float alpha2 = square(square(roughness)) + 2.0f * slope_variance;
  return std::sqrt(std::sqrt(std::min(alpha2, 1.0f)));
}

// Returns a bound of the width of the body of a point or line, from one of its triangles: its
// shortest edge is a side of a square cross-section.
float stroke_diameter(const V3f& p0, const V3f& p1, const V3f& p2) {
  const float shortest2 = std::min((p1 - p0).length2(), std::min((p2 - p1).length2(), (p0 - p2).length2()));
  return 1.5f * std::sqrt(shortest2);
}

// Returns alpha of the base color at the finest level, which rays are tested against.
float coverage(const ShadingMaterial& material, const HitRecords& records, const TextureLookup& textures) {
  float alpha = material.base_color_factor.w;
  if (material.base_color.present()) alpha *= textures.sample_channel_finest(material.base_color, 3);
  if (records.geometry.color_offset != GeometryView::kAbsent)
    alpha *= records.geometry.interpolate4(records.records, records.geometry.color_offset, records.barycentric).w;
  return alpha;
}

} // namespace

void WorldView::surface_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                           const RayFootprint& footprint) const {
  if (instances[hit.instance].moving) [[unlikely]]
    moving_surface_at(ray, hit, surface, footprint);
  else
    surface_of<false>(ray, hit, surface, footprint);
  if (surface.guarded) [[unlikely]]
    guard(ray, hit, surface);
}

void WorldView::moving_surface_at(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                  const RayFootprint& footprint) const {
  surface_of<true>(ray, hit, surface, footprint);
}

// Two instantiations, so that static geometry has no cost of motion.
template <bool kMoving>
inline void WorldView::surface_of(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface,
                                  const RayFootprint& footprint) const {
  const GeometryView& geometry = geometries[hit.mesh];
  const WorldInstance* placed = &instances[hit.instance];
  const ShadingMaterial& material = materials[geometry.material];
  HitRecords records(geometry, hit);
  const V3f wo = -ray.direction;

  // Position by barycentrics (more accurate than along the ray) with a bound of its rounding error.
  const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
  V3f p0 = geometry.positions[index[0]], p1 = geometry.positions[index[1]], p2 = geometry.positions[index[2]];
  std::optional<MovingHit> moving;
  if constexpr (kMoving) {
    placed = &move_hit(geometry, *placed, motions, hit.triangle, ray.time, moving).instance;
    p0 = moving->positions[0], p1 = moving->positions[1], p2 = moving->positions[2];
    records.records = moving->records;
  }
  const WorldInstance& instance = *placed;
  float magnitude = std::max(max_abs(p0), std::max(max_abs(p1), max_abs(p2)));
  float error = position_bound(magnitude);
  if (!instance.identity) {
    const M44f& m = instance.object_to_world;
    p0 = transform_point(m, p0);
    p1 = transform_point(m, p1);
    p2 = transform_point(m, p2);
    const float world_magnitude = std::max(max_abs(p0), std::max(max_abs(p1), max_abs(p2)));
    error = position_bound(m, magnitude, world_magnitude);
    if constexpr (kMoving) error += moving->error;
  }
  surface.position = p0 * records.barycentric.x + p1 * records.barycentric.y + p2 * records.barycentric.z;
  surface.position_error = error;

  const V3f edge1 = p1 - p0, edge2 = p2 - p0;
  const V3f triangle_normal = edge1.cross(edge2);
  V3f face_normal = instance.mirrored ? -triangle_normal : triangle_normal;
  const float face_length = face_normal.length();
  // A barycentric coordinate is a fraction of a height, which is twice the area over its edge.
  const float edges = std::abs(edge1.x) + std::abs(edge1.y) + std::abs(edge1.z) + std::abs(edge2.x) +
                      std::abs(edge2.y) + std::abs(edge2.z); // at least as long as each of the three
  surface.guarded = min_component(records.barycentric) * face_length < kEdgeMargin * error * edges ||
                    (!contacts.empty() && contacts.at(hit));
  face_normal = face_length > 0.0f ? face_normal / face_length : wo;
  bool front = face_normal.dot(wo) >= 0.0f;

  // The interpolated normal, on the side given by the file.
  V3f normal = face_normal;
  if (geometry.normal_offset != GeometryView::kAbsent) {
    V3f n = geometry.interpolate3(records.records, geometry.normal_offset, records.barycentric);
    if (!instance.identity) n = transform_normal_direction(instance.object_to_world, n);
    const float length = std::sqrt(n.length2());
    if (length > 0.0f && std::isfinite(length)) normal = n / length;
  }
  if (geometry.stroke == Stroke::lit) [[unlikely]] {
    // A point or line is lit as the surface that its normal belongs to, and does not shadow itself.
    face_normal = normal;
    front = face_normal.dot(wo) >= 0.0f;
    surface.position_error += stroke_diameter(p0, p1, p2);
  }

  // Back faces shade with the reversed normal (glTF 2.0, section 3.9.6). Vertex normals may
  // disagree with the winding: they follow the visible side of the face.
  const auto set_normals = [&](const V3f& shading_normal) {
    surface.geometric_normal = front ? face_normal : -face_normal;
    surface.shading_normal =
        with_valid_reflection(front ? shading_normal : -shading_normal, surface.geometric_normal, wo);
  };
  surface.material = geometry.material;
  surface.layered = false;
  surface.emissive_triangle = accel::kNoId;
  surface.emitted = Rgb(0.0f);
  if (material.constant && geometry.color_offset == GeometryView::kAbsent && geometry.stroke != Stroke::unlit) {
    set_normals(normal);
    surface.unlit = false;
    surface.alpha = 1.0f;
    surface.bsdf = material.constant_bsdf;
    return;
  }

  const SurfaceFootprint seen{ray, footprint, triangle_normal};
  const TextureLookup texels(textures, procedurals, records, seen);
  float slope_variance = 0.0f; // of the normals averaged by a coarse level
  const V3f vertex_normal = normal;
  V3f tangent, bitangent; // valid if has_tangent
  bool has_tangent = false;
  if (geometry.tangent_offset != GeometryView::kAbsent) {
    const V4f tangent4 = geometry.interpolate4(records.records, geometry.tangent_offset, records.barycentric);
    tangent = V3f(tangent4.x, tangent4.y, tangent4.z);
    if (!instance.identity) tangent = transform_vector(instance.object_to_world, tangent);
    const float handedness = (tangent4.w < 0.0f) != instance.mirrored ? -1.0f : 1.0f;
    const float tangent_length = std::sqrt(tangent.length2());
    has_tangent = tangent_length > 0.0f && std::isfinite(tangent_length);
    if (has_tangent) {
      tangent /= tangent_length;
      bitangent = normal.cross(tangent) * handedness;
    }
  }
  if (has_tangent && material.normal.present()) {
    const TextureLookup::Place at = texels.place(material.normal);
    const Rgb texel = texels.sample_rgb(material.normal, at);
    const V3f n = normal_from_map(texel, material.normal_scale, tangent, bitangent, normal);
    const float length = std::sqrt(n.length2());
    if (length > 0.0f && std::isfinite(length)) normal = n / length;
    if (at.level > 0) slope_variance = variance_of_normals(texel) * square(material.normal_scale);
  }
  set_normals(normal);
  surface.unlit = material.unlit || geometry.stroke == Stroke::unlit;

  V4f base = material.base_color_factor;
  if (material.base_color.present()) base *= texels.sample(material.base_color);
  if (geometry.color_offset != GeometryView::kAbsent)
    base *= geometry.interpolate4(records.records, geometry.color_offset, records.barycentric);
  surface.bsdf.base_color =
      Rgb(std::clamp(base.x, 0.0f, 1.0f), std::clamp(base.y, 0.0f, 1.0f), std::clamp(base.z, 0.0f, 1.0f));

  // Rays test coverage at the finest level, so alpha uses the same level here.
  if (material.alpha_mode == AlphaMode::blend && material.base_color.present() &&
      texels.is_filtered(material.base_color))
    base.w = coverage(material, records, texels);
  surface.alpha = material.alpha_mode == AlphaMode::blend ? std::clamp(base.w, 0.0f, 1.0f) : 1.0f;
  if (surface.unlit) {
    surface.emitted = surface.bsdf.base_color;
    if (material.emissive) // only points and lines have both
      surface.emitted += material.emission.present() ? material.emission_factor * texels.sample_rgb(material.emission)
                                                     : material.emission_factor;
    return;
  }

  surface.bsdf.metallic = material.metallic_factor;
  surface.bsdf.roughness = material.roughness_factor;
  if (material.metallic_roughness.present()) {
    const Rgb texel = texels.sample_rgb(material.metallic_roughness);
    surface.bsdf.roughness *= texel.y;
    surface.bsdf.metallic *= texel.z;
  }
  if (slope_variance > 0.0f) surface.bsdf.roughness = widened(surface.bsdf.roughness, slope_variance);
  surface.bsdf.ior = material.ior;
  surface.bsdf.specular = material.specular_factor;
  if (material.specular.present()) surface.bsdf.specular *= texels.sample_channel(material.specular, 3);
  surface.bsdf.specular_color = material.specular_color_factor;
  if (material.specular_color.present()) surface.bsdf.specular_color *= texels.sample_rgb(material.specular_color);

  if (material.specular_glossiness) {
    const float glossiness = 1.0f - material.roughness_factor;
    const bool textured = material.specular_color.present();
    surface.bsdf.roughness =
        1.0f - (textured ? glossiness * texels.sample_channel(material.specular_color, 3) : glossiness);
  }
  if (material.layers != kNone) {
    surface.layered = true;
    VertexFrame vertex{.normal = vertex_normal, .has_tangent = has_tangent, .front = front};
    if (has_tangent) vertex.tangent = tangent, vertex.bitangent = bitangent;
    layers_at(TextureLookup(textures, procedurals, records, seen), vertex, wo,
              surface); // a separate object, so that ours can stay in registers
  }

  if (material.emissive && (front || material.double_sided)) {
    surface.emitted = material.emission_factor;
    if (instance.emissive) {
      const uint32_t first = first_emissive[instance.emissive_begin + (hit.mesh - instance.first_mesh)];
      if (first != accel::kNoId) surface.emissive_triangle = first + hit.triangle;
    }
    if (material.emission.present()) {
      const bool filtered = footprint.filters_emission || surface.emissive_triangle == accel::kNoId;
      surface.emitted *= filtered ? texels.sample_rgb(material.emission) : texels.sample_rgb_finest(material.emission);
    }
    if (surface.layered)
      surface.emitted *= coat_transmittance(surface.layers.bsdf.clearcoat, surface.geometric_normal.dot(wo));
  }
}

V2f WorldView::texcoord_at(const accel::Hit& hit) const {
  return HitRecords(geometries[hit.mesh], hit).texcoord(uint8_t{0});
}

bool WorldView::is_single_sided(const ShadingMaterial& material) const {
  return !material.double_sided &&
         (material.layers == kNone || !layer_materials[static_cast<size_t>(material.layers)].volume);
}

// Decides as surface_of() does which side is seen.
WorldView::PosedFace WorldView::face_at(const accel::Ray& ray, const accel::Hit& hit) const {
  const GeometryView& geometry = geometries[hit.mesh];
  const WorldInstance* placed = &instances[hit.instance];
  const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
  PosedFace face{{geometry.positions[index[0]], geometry.positions[index[1]], geometry.positions[index[2]]}};
  std::optional<MovingHit> moving;
  if (placed->moving) {
    placed = &move_hit(geometry, *placed, motions, hit.triangle, ray.time, moving).instance;
    face.corners = moving->positions;
  }
  if (!placed->identity)
    for (V3f& corner : face.corners) corner = transform_point(placed->object_to_world, corner);
  face.mirrored = placed->mirrored;
  return face;
}

bool WorldView::is_hidden_back(const accel::Ray& ray, const accel::Hit& hit) const {
  return is_single_sided(materials[geometries[hit.mesh].material]) && face_at(ray, hit).is_back_for(ray.direction);
}

bool WorldView::is_cut_away(const accel::Ray& ray, const accel::Hit& hit) const {
  const ShadingMaterial& material = materials[geometries[hit.mesh].material];
  if (!view_point || material.emissive || !is_single_sided(material)) return false;
  const PosedFace face = face_at(ray, hit);
  const V3f point = face.corners[0] * (1.0f - hit.u - hit.v) + face.corners[1] * hit.u + face.corners[2] * hit.v;
  V3f sight = point - view_point->position;
  if (view_point->orthographic) {
    const float depth = sight.dot(view_point->forward);
    if (!(depth > 0.0f)) return false;
    sight = view_point->forward * depth;
  }
  if (!face.is_back_for(sight)) return false;
  constexpr float kBeforeTheFace = 1.0f - 1e-4f;
  return !sight_is_blocked({.origin = point - sight,
                            .direction = sight,
                            .t_max = kBeforeTheFace,
                            .key = ray.key,
                            .time = ray.time,
                            .index = ray.index,
                            .flags = kHitPartlyTransparent | kPassThinWalls | kCameraRay});
}

bool WorldView::reads_coverage(const accel::Ray& ray, const accel::Hit& candidate) const {
  const GeometryView& geometry = geometries[candidate.mesh];
  const ShadingMaterial& material = materials[geometry.material];
  const HitRecords records(geometry, candidate);
  const RayFootprint none;
  const SurfaceFootprint point{ray, none};
  const TextureLookup texels(textures, procedurals, records, point);
  const float alpha = coverage(material, records, texels);

  if (material.alpha_mode == AlphaMode::mask && alpha < material.alpha_cutoff) return false;
  if (material.thin_wall && (ray.flags & (kPassThinWalls | kHitThinWalls)) != 0) {
    float roughness = material.roughness_factor;
    if (material.metallic_roughness.present()) roughness *= texels.sample_channel(material.metallic_roughness, 1);
    if (roughness <= kStraightRoughness) return (ray.flags & kHitThinWalls) != 0;
  }
  if (material.alpha_mode != AlphaMode::blend) return true;
  if ((ray.flags & kHitPartlyTransparent) != 0) return alpha > 0.0f;
  // Stochastic transparency: the decision depends on the ray and the triangle alone, never on the
  // traversal order. Over the samples of a pixel the numbers of one triangle are stratified, those
  // of different triangles independent.
  if (alpha >= 1.0f) return true;
  const uint32_t h = hash_combine(hash_combine(ray.key, candidate.instance), candidate.mesh);
  return Sampler::sample_1d(h, ray.index, candidate.triangle) < alpha;
}

V3f offset_ray_origin(const SurfacePoint& surface, const V3f& direction) {
  const bool beyond = direction.dot(surface.geometric_normal) < 0.0f;
  if (surface.guarded) [[unlikely]]
    return surface.origins[beyond ? 1 : 0];
  return origin_beside(surface, beyond);
}

accel::Ray make_shadow_ray(const SurfacePoint& surface, const LightSample& light, uint32_t key, uint32_t index,
                           float time) {
  const V3f origin = offset_ray_origin(surface, light.wi);
  const WayToLight<float> way = way_to_light(surface.position, origin, light.wi, light.distance, light.normal);
  return {.origin = origin,
          .t_min = 0.0f,
          .direction = way.direction,
          .t_max = way.length,
          .key = key,
          .time = time,
          .index = index};
}

} // namespace kindling
