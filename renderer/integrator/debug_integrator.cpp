// Colors of the debug views.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/debug_integrator.h"

#include "renderer/integrator/first_hit_context.h"
#include "renderer/integrator/stages/sample_cone.h"

#include <cassert>

namespace kindling {
namespace {

Rgb color_of_number(uint32_t number) {
  const uint32_t h = hash_u32(number + 1U);
  const auto channel = [h](int shift) { return 0.15f + 0.8f * static_cast<float>((h >> shift) & 0xffU) / 255.0f; };
  return {channel(0), channel(8), channel(16)};
}

} // namespace

DebugIntegrator::DebugIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                                 const Sampler& sampler, const PixelFilter& filter)
    : kind_(settings.kind), batch_size_(settings.batch_size), world_(world), camera_(camera), sampler_(sampler),
      filter_(filter) {}

std::unique_ptr<ThreadContext> DebugIntegrator::make_context() const {
  return std::make_unique<FirstHitContext>(batch_size_);
}

uint32_t DebugIntegrator::render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& thread,
                                       Film& film) const {
  assert(dynamic_cast<FirstHitContext*>(&thread));
  auto& context = static_cast<FirstHitContext&>(thread);
  return context.for_each_batch(world_, camera_, sampler_, filter_, block, samples, batch_size_, [&](size_t count) {
    if (world_.abandoned()) return false;
    for (size_t slot = 0; slot < count; ++slot) {
      const bool hit = context.hits[slot].is_hit();
      film.add(context.camera_samples[slot].pixel, {hit ? view_of(context.rays[slot], context.hits[slot]) : Rgb(0.0f),
                                                    hit ? 1.0f : 0.0f, context.camera_samples[slot].filter_weight});
    }
    return true;
  });
}

Rgb DebugIntegrator::view_of(const accel::Ray& ray, const accel::Hit& hit) const {
  SurfacePoint surface;
  const float width = sample_width(sampler_);
  const float cone_width = sample_cone(camera_, ray.direction, width).width_at(hit.t);
  world_.surface_at(ray, hit, surface, {first_footprint(camera_, ray, hit.t, cone_width, width), true});
  const auto wrapped = [](float x) { return x - std::floor(x); };
  switch (kind_) {
  case IntegratorKind::albedo: return surface.bsdf.base_color;
  case IntegratorKind::normal: return surface.shading_normal * 0.5f + V3f(0.5f);
  case IntegratorKind::geometric_normal: return surface.geometric_normal * 0.5f + V3f(0.5f);
  case IntegratorKind::depth: {
    const Box3f& bounds = world_.bounds;
    const float far_m = (bounds.center() - ray.origin).length() + bounds.size().length() * 0.5f;
    return Rgb(std::clamp(1.0f - hit.t / far_m, 0.0f, 1.0f));
  }
  case IntegratorKind::uv: {
    const V2f uv = world_.texcoord_at(hit);
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
