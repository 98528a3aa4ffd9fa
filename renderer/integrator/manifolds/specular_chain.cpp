// One surface of glass after the other: hit, Fresnel's terms, absorption and derivatives.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/manifolds/specular_chain.h"

#include "renderer/integrator/stages/random_walk.h"
#include "renderer/world/hit_records.h"

#include <array>
#include <cmath>

namespace kindling {

namespace {

constexpr float kMaxNormalDifference2 = 1e-6f; // squared, between unit normals

// Returns the triangle of a hit by the normals of its vertices. Empty if the surface has another
// normal there, by a map or because it would mirror the viewer into the surface.
std::optional<SpecularFace> face_of(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface) {
  const GeometryView& geometry = world.geometries[hit.mesh];
  const WorldInstance& instance = world.instances[hit.instance];
  const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
  std::array<V3f, 3> corners{geometry.positions[index[0]], geometry.positions[index[1]], geometry.positions[index[2]]};
  if (!instance.identity)
    for (V3f& corner : corners) corner = transform_point(instance.object_to_world, corner);
  const V3f edge1 = corners[1] - corners[0], edge2 = corners[2] - corners[0];
  SpecularFace face;
  face.plane_normal = edge1.cross(edge2);
  const float length2 = face.plane_normal.length2();
  if (!(length2 > 0.0f)) return std::nullopt;
  face.barycentric_change[1] = edge2.cross(face.plane_normal) / length2;
  face.barycentric_change[2] = face.plane_normal.cross(edge1) / length2;
  face.barycentric_change[0] = -(face.barycentric_change[1] + face.barycentric_change[2]);
  face.normal = surface.shading_normal;
  face.corner_normals.fill(surface.shading_normal);
  V3f normal = surface.geometric_normal;
  if (geometry.normal_offset != GeometryView::kAbsent) {
    const HitRecords records(geometry, hit);
    for (size_t i = 0; i < 3; ++i) {
      const float* n = records.records[i] + geometry.normal_offset;
      face.corner_normals[i] = V3f(n[0], n[1], n[2]);
      if (!instance.identity)
        face.corner_normals[i] = transform_normal_direction(instance.object_to_world, face.corner_normals[i]);
    }
    normal = face.corner_normals[0] * records.barycentric.x + face.corner_normals[1] * records.barycentric.y +
             face.corner_normals[2] * records.barycentric.z;
    face.normal_length = normal.length();
    if (!(face.normal_length > 0.0f)) return std::nullopt;
    normal /= face.normal_length;
    if (normal.dot(surface.shading_normal) < 0.0f) {
      normal = -normal;
      for (V3f& corner : face.corner_normals) corner = -corner;
    }
  }
  if (!((normal - surface.shading_normal).length2() <= kMaxNormalDifference2)) return std::nullopt;
  return face;
}

} // namespace

std::optional<ChainEnd> trace_chain(const PathStages& stages, const PathStages::Vertex& from, const PathInFlight& path,
                                    const V3f& direction, bool reflects, uint32_t& rays) {
  const WorldView& world = *stages.world;
  PathState state;
  state.in_medium = path.state.in_medium;
  state.wavelength_nm = path.state.wavelength_nm;
  MediumStack media = state.in_medium ? path.media : MediumStack{};
  const Frame around = Frame::around(direction);
  std::optional<ChainEnd> end(std::in_place);
  end->ray = {.origin = from.surface.position,
              .direction = direction,
              .origin_change = {V3f(0.0f), V3f(0.0f)},
              .direction_change = {around.tangent, around.bitangent}};
  accel::Ray ray{.origin = offset_ray_origin(from.surface, direction),
                 .t_min = 0.0f,
                 .direction = direction,
                 .t_max = kInfinity,
                 .key = path.sample.address.key,
                 .time = from.time,
                 .index = path.sample.address.index,
                 .flags = kHitPartlyTransparent};
  for (uint32_t surfaces = 1; surfaces <= kMaxSpecularSurfaces; ++surfaces) {
    ++rays;
    const accel::Hit hit = world.probe_hit(ray);
    if (!hit.is_hit() || world.instances[hit.instance].moving) return std::nullopt;
    SurfacePoint& surface = end->surface;
    world.surface_at(ray, hit, surface);
    if (surface.unlit || surface.alpha < 1.0f || !surface.layered || stages.samples_light(surface)) return std::nullopt;
    if (!surface.layers.entering && state.in_medium && media.covered(surface.material)) return std::nullopt;
    const float distance = (surface.position - end->ray.origin).length();
    if (state.in_medium) {
      const Medium& medium = world.medium(*media.innermost());
      if (!is_black(medium.scattering)) return std::nullopt;
      end->transmittance *= exp_negative(medium.extinction * distance);
    }
    const Frame frame = Frame::with_tangent(surface.shading_normal, surface.layers.tangent);
    const PathStages::LayersHere layers = stages.resolve_layers(surface, frame, state, media, 0.5f);
    if (layers.wavelength_nm != state.wavelength_nm) return std::nullopt;
    const LayeredBsdf bsdf(surface.bsdf, *layers.parameters, frame.to_local(-ray.direction));
    if (!bsdf.glass()) return std::nullopt;
    const float reflected = bsdf.glass()->reflection_probability(V2f(0.5f));
    const std::optional<BsdfSample> scattered = bsdf.sample(reflects ? 0.0f : kOneMinusEpsilon, V2f(0.5f));
    if (!scattered || scattered->pdf > 0.0f || (scattered->wi.z < 0.0f) == reflects) return std::nullopt;
    end->transmittance *= scattered->weight * (reflects ? reflected : 1.0f - reflected);
    const std::optional<SpecularFace> face = face_of(world, hit, surface);
    if (!face) return std::nullopt;
    end->ray.transfer(*face, surface.position, distance);
    if (reflects)
      end->ray.reflect(*face);
    else if (!end->ray.refract(*face, layers.parameters->eta))
      return std::nullopt;
    const V3f wi = frame.to_world(scattered->wi);
    if ((wi.dot(surface.geometric_normal) < 0.0f) == reflects) return std::nullopt;
    if (!reflects) {
      PathStages::pass_boundary(surface, state, media);
      end->refractions = surfaces;
    }
    end->ray.direction = wi;
    if (!state.in_medium) return end;
    if (reflects) return std::nullopt;
    ray.origin = offset_ray_origin(surface, wi);
    ray.direction = wi;
  }
  return std::nullopt;
}

} // namespace kindling
