// SPDX-License-Identifier: Apache-2.0
#include "tests/unbiased/plain_tracer.h"

#include "renderer/sampling/warp.h"

namespace kindling::test {
namespace {

V3f sample_aim(const AimRectangle& aim, const V3f& point, const V2f& u) {
  return (aim.corner + aim.edge_u * u.x + aim.edge_v * u.y - point).normalized();
}
V3f sample_aim(const AimCone& aim, const V3f& /*point*/, const V2f& u) {
  return Frame::around(aim.axis).to_world(sample_uniform_cone(u, aim.one_minus_cos)).normalized();
}

float density_of(const AimRectangle& aim, const V3f& point, const V3f& wi) {
  const V3f area_normal = aim.edge_u.cross(aim.edge_v); // its length is the area
  const float projected = area_normal.dot(wi);
  if (projected == 0.0f) return 0.0f;
  const float distance = (aim.corner - point).dot(area_normal) / projected;
  if (!(distance > 0.0f)) return 0.0f;
  const V3f on_plane = point + wi * distance - aim.corner;
  const float x = on_plane.dot(aim.edge_u) / aim.edge_u.length2();
  const float y = on_plane.dot(aim.edge_v) / aim.edge_v.length2();
  if (x < 0.0f || x > 1.0f || y < 0.0f || y > 1.0f) return 0.0f;
  return square(distance) / std::fabs(projected);
}
float density_of(const AimCone& aim, const V3f& /*point*/, const V3f& wi) {
  return 1.0f - wi.dot(aim.axis) <= aim.one_minus_cos ? 1.0f / (2.0f * kPi * aim.one_minus_cos) : 0.0f;
}

} // namespace

float PlainTracer::aim_density(const V3f& point, const V3f& wi) const {
  float sum = 0.0f;
  for (const Aim& aim : aims_) sum += std::visit([&](const auto& a) { return density_of(a, point, wi); }, aim);
  return sum / static_cast<float>(aims_.size());
}

PlainTracer::Direction PlainTracer::choose_direction(const SurfacePoint& surface, const V3f& wo, Random& random) const {
  const Frame frame = Frame::around(surface.shading_normal);
  const GltfBsdf bsdf(surface.bsdf, frame.to_local(wo));
  const float aimed = aims_.empty() ? 0.0f : 0.5f;
  Direction chosen;
  if (random.next_1d() < aimed) {
    const auto index = static_cast<size_t>(random.next_1d() * static_cast<float>(aims_.size()));
    const V2f u = random.next_2d();
    chosen.wi = std::visit([&](const auto& a) { return sample_aim(a, surface.position, u); }, aims_[index]);
  } else {
    const float lobe = random.next_1d();
    const std::optional<BsdfSample> sample = bsdf.sample(lobe, random.next_2d());
    if (!sample) return chosen;
    chosen.wi = frame.to_world(sample->wi);
  }
  if (chosen.wi.dot(surface.geometric_normal) <= 0.0f) return chosen;
  const BsdfEval eval = bsdf.eval(frame.to_local(chosen.wi));
  float density = (1.0f - aimed) * eval.pdf;
  if (aimed > 0.0f) density += aimed * aim_density(surface.position, chosen.wi);
  if (density > 0.0f) chosen.weight = eval.value / density;
  return chosen;
}

Rgb PlainTracer::radiance(accel::Ray ray, Random& random) const {
  Rgb sum(0.0f), throughput(1.0f);
  SurfacePoint surface;
  for (int bounce = 0;;) {
    const accel::Hit hit = world_.accelerator().intersect(ray);
    if (!hit.is_hit()) return sum + throughput * world_.lights().environment_radiance(ray.direction);
    world_.surface_at(ray, hit, surface);
    if (random.next_1d() >= surface.alpha) { // BLEND is coverage: the surface is there, or it is not
      ray.origin = offset_ray_origin(surface, ray.direction);
      continue;
    }
    sum += throughput * surface.emitted;
    if (surface.unlit || bounce++ > max_bounces_) return sum;
    const Direction next = choose_direction(surface, -ray.direction, random);
    throughput *= next.weight;
    if (is_black(throughput)) return sum;
    ray.origin = offset_ray_origin(surface, next.wi);
    ray.direction = next.wi;
  }
}

std::vector<float> PlainTracer::picture(const Camera& camera, uint32_t samples, uint64_t seed) const {
  Random random(seed * 0x2545f4914f6cdd1dULL + 0x9e3779b97f4a7c15ULL);
  std::vector<float> rgb;
  for (int y = 0; y < camera.size_px().y; ++y)
    for (int x = 0; x < camera.size_px().x; ++x) {
      Rgb sum(0.0f);
      for (uint32_t s = 0; s < samples; ++s) {
        const V2f within = random.next_2d();
        const CameraRay start =
            camera.generate_ray(V2f(static_cast<float>(x), static_cast<float>(y)) + within, V2f(0.5f), 0.0f);
        sum += radiance({.origin = start.origin,
                         .t_min = 0.0f,
                         .direction = start.direction,
                         .t_max = kInfinity,
                         .flags = kHitPartlyTransparent},
                        random);
      }
      for (unsigned c = 0; c < 3; ++c) rgb.push_back(sum[c] / static_cast<float>(samples));
    }
  return rgb;
}

} // namespace kindling::test
