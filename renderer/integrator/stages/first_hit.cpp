// Ambient occlusion and debug views of one sample.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/first_hit.h"

#include "renderer/base/hash.h"
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/sampling/warp.h"
#include "renderer/world/surface_point.h"

#include <algorithm>
#include <cmath>

namespace kindling {
namespace {

Rgb color_of_number(uint32_t number) {
  const uint32_t h = hash_u32(number + 1U);
  const auto channel = [h](int shift) { return 0.15f + 0.8f * static_cast<float>((h >> shift) & 0xffU) / 255.0f; };
  return {channel(0), channel(8), channel(16)};
}

} // namespace

FirstHitStages make_first_hit_stages(const IntegratorSettings& settings, const WorldView& world,
                                     const CameraView& camera, const Sampler& sampler) {
  const float distance_m = settings.ao_distance_m > 0.0f ? settings.ao_distance_m : world.bounds.size().length() * 0.1f;
  return {settings.kind, &world, &camera, sampler, distance_m};
}

std::optional<accel::Ray> FirstHitStages::occlusion_ray(const CameraSample& sample, const accel::Ray& ray,
                                                        const accel::Hit& hit) const {
  const RayCone cone = sample_cone(*camera, ray.direction, sample_width(sampler));
  SurfacePoint surface;
  world->surface_at(ray, hit, surface, {.width_m = cone.width_at(hit.t)});
  const V2f u = Sampler::sample_2d(sample.address, kFirstBounceDimension + kDirectionDimension);
  const V3f wi = Frame::around(surface.shading_normal).to_world(sample_cosine_hemisphere(u));
  if (wi.dot(surface.geometric_normal) <= 0.0f) return std::nullopt;
  return accel::Ray{.origin = offset_ray_origin(surface, wi),
                    .t_min = 0.0f,
                    .direction = wi,
                    .t_max = occlusion_distance_m,
                    .key = hash_combine(sample.address.key, kFirstBounceDimension),
                    .time = ray.time,
                    .index = sample.address.index};
}

Rgb FirstHitStages::color_of(const accel::Ray& ray, const accel::Hit& hit) const {
  SurfacePoint surface;
  const float width = sample_width(sampler);
  const float cone_width = sample_cone(*camera, ray.direction, width).width_at(hit.t);
  world->surface_at(ray, hit, surface, {first_footprint(*camera, ray, hit.t, cone_width, width), true});
  const auto wrapped = [](float x) { return x - std::floor(x); };
  switch (kind) {
  case IntegratorKind::albedo: return surface.bsdf.base_color;
  case IntegratorKind::normal: return surface.shading_normal * 0.5f + V3f(0.5f);
  case IntegratorKind::geometric_normal: return surface.geometric_normal * 0.5f + V3f(0.5f);
  case IntegratorKind::depth: {
    const Box3f& bounds = world->bounds;
    const float far_m = (bounds.center() - ray.origin).length() + bounds.size().length() * 0.5f;
    return Rgb(std::clamp(1.0f - hit.t / far_m, 0.0f, 1.0f));
  }
  case IntegratorKind::uv: {
    const V2f uv = world->texcoord_at(hit);
    return {wrapped(uv.x), wrapped(uv.y), 0.0f};
  }
  case IntegratorKind::barycentric: return {1.0f - hit.u - hit.v, hit.u, hit.v};
  case IntegratorKind::instance: return color_of_number(hash_combine(hit.instance, hit.mesh));
  case IntegratorKind::material: return color_of_number(surface.material);
  case IntegratorKind::path:
  case IntegratorKind::whitted:
  case IntegratorKind::ambient_occlusion: break; // make_integrator() makes other classes of these
  }
  return Rgb(0.0f);
}

} // namespace kindling
