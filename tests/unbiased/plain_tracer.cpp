// A path tracer without next-event estimation that aims half of its directions at known lights.
// SPDX-License-Identifier: Apache-2.0
#include "tests/unbiased/plain_tracer.h"

#include "renderer/integrator/integrator.h"

#include "renderer/sampling/warp.h"

namespace kindling::test {
namespace {

V3f sample_aim(const AimRectangle& aim, const V3f& point, const V2f& u) {
  return (aim.corner + aim.edge_u * u.x + aim.edge_v * u.y - point).normalized();
}
V3f sample_aim(const AimCone& aim, const V3f& /*point*/, const V2f& u) {
  return Frame::around(aim.axis).to_world(sample_uniform_cone(u, aim.one_minus_cos)).normalized();
}

// Returns the cone of a sphere as seen from a point, or nothing if the point is inside.
std::optional<AimCone> cone_of(const AimSphere& aim, const V3f& point) {
  const V3f to_center = aim.center - point;
  const float sin2 = square(aim.radius) / to_center.length2();
  if (!(sin2 < 1.0f)) return std::nullopt;
  return AimCone{to_center.normalized(), sin2 / (1.0f + std::sqrt(1.0f - sin2))};
}
V3f sample_aim(const AimSphere& aim, const V3f& point, const V2f& u) {
  const std::optional<AimCone> cone = cone_of(aim, point);
  return cone ? sample_aim(*cone, point, u) : sample_uniform_sphere(u);
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
float density_of(const AimSphere& aim, const V3f& point, const V3f& wi) {
  const std::optional<AimCone> cone = cone_of(aim, point);
  return cone ? density_of(*cone, point, wi) : uniform_sphere_pdf(wi);
}

} // namespace

float PlainTracer::aim_density(const V3f& point, const V3f& wi) const {
  float sum = 0.0f;
  for (const Aim& aim : aims_) sum += std::visit([&](const auto& a) { return density_of(a, point, wi); }, aim);
  return sum / static_cast<float>(aims_.size());
}

PlainTracer::Direction PlainTracer::choose_direction(const SurfacePoint& surface, const Frame& frame,
                                                     const SurfaceBsdf& bsdf, Random& random) const {
  const float aimed = aims_.empty() ? 0.0f : 0.5f;
  Direction chosen;
  std::optional<BsdfSample> sample;
  if (random.next_1d() < aimed) {
    const auto index = static_cast<size_t>(random.next_1d() * static_cast<float>(aims_.size()));
    const V2f u = random.next_2d();
    chosen.wi = std::visit([&](const auto& a) { return sample_aim(a, surface.position, u); }, aims_[index]);
  } else {
    const float lobe = random.next_1d();
    sample = bsdf.sample(lobe, random.next_2d());
    if (!sample) return chosen;
    chosen.wi = frame.to_world(sample->wi);
  }
  const V3f local = sample ? sample->wi : frame.to_local(chosen.wi);
  chosen.crosses = local.z < 0.0f;
  if ((chosen.wi.dot(surface.geometric_normal) < 0.0f) != chosen.crosses) return chosen;
  if (sample && sample->pdf == 0.0f) { // a delta direction cannot be aimed at
    chosen.weight = sample->weight / (1.0f - aimed);
    return chosen;
  }
  const BsdfEval eval = bsdf.eval(local);
  float density = (1.0f - aimed) * eval.pdf;
  if (aimed > 0.0f) density += aimed * aim_density(surface.position, chosen.wi);
  if (density > 0.0f) chosen.weight = eval.value / density;
  return chosen;
}

Rgb PlainTracer::radiance(accel::Ray ray, Random& random) const {
  const int max_transmissions = IntegratorSettings{}.max_transmission_bounces;
  Rgb sum(0.0f), throughput(1.0f);
  SurfacePoint surface;
  const Medium* medium = nullptr; // around the ray
  int reflections = 0, transmissions = 0;
  V3f scattered_at(0.0f);
  float passed = 0.0f; // distance from there to the origin of the ray, which passes straight through surfaces
  while (!is_black(throughput)) {
    const accel::Hit hit = world_.accelerator().intersect(ray);
    if (reflections + transmissions > 0)
      sum += throughput * world_.lights.shape_radiance({.origin = scattered_at,
                                                        .direction = ray.direction,
                                                        .begin_m = passed,
                                                        .end_m = hit.is_hit() ? passed + hit.t : kInfinity,
                                                        .extinction = medium ? medium->extinction : Rgb(0.0f)});
    passed += hit.t;
    if (!hit.is_hit()) return sum + throughput * world_.lights.environment_radiance(ray.direction);
    world_.surface_at(ray, hit, surface);
    if (medium)
      for (unsigned c = 0; c < 3; ++c) throughput[c] *= std::exp(-medium->extinction[c] * hit.t);
    if (random.next_1d() >= surface.alpha) { // BLEND is coverage: hit the surface or pass it
      ray.origin = offset_ray_origin(surface, ray.direction);
      continue;
    }
    sum += throughput * surface.emitted;
    if (surface.unlit) return sum;
    SurfaceLayers& layers = surface.layers;
    const Frame frame = surface.layered ? Frame::with_tangent(surface.shading_normal, layers.tangent)
                                        : Frame::around(surface.shading_normal);
    if (surface.layered) {
      layers.bsdf.clearcoat_normal = frame.to_local(layers.clearcoat_normal);
      layers.bsdf.eta = layers.boundary && !layers.entering ? 1.0f / surface.bsdf.ior : surface.bsdf.ior;
    }
    const SurfaceBsdf bsdf(surface.bsdf, surface.layered ? &layers.bsdf : nullptr, frame.to_local(-ray.direction));
    if (surface.has_thin_wall()) { // half of the paths pass straight through
      throughput *= 2.0f;
      if (random.next_1d() < 0.5f) {
        throughput *= bsdf.straight_transmittance();
        ray.origin = offset_ray_origin(surface, ray.direction);
        continue;
      }
    }
    if (reflections > max_bounces_ || transmissions > max_transmissions) return sum;
    const Direction next = choose_direction(surface, frame, bsdf, random);
    throughput *= next.weight;
    ++(next.crosses ? transmissions : reflections);
    if (next.crosses && layers.boundary) medium = layers.entering ? &world_.medium(surface.material) : nullptr;
    ray.origin = offset_ray_origin(surface, next.wi);
    scattered_at = ray.origin;
    passed = 0.0f;
    ray.direction = next.wi;
  }
  return sum;
}

std::vector<float> PlainTracer::image(const Camera& camera, uint32_t samples, uint64_t seed) const {
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
