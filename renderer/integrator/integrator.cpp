// The integrators' names and their factory; merging of ray counters.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/integrator.h"

#include "renderer/integrator/ambient_occlusion_integrator.h"
#include "renderer/integrator/debug_integrator.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/whitted_integrator.h"

#include <tuple>

namespace kindling {
namespace {

struct NamedKind {
  IntegratorKind kind;
  std::string_view name;
};
constexpr std::array<NamedKind, 11> kNames{{
    {IntegratorKind::path, "path"},
    {IntegratorKind::whitted, "whitted"},
    {IntegratorKind::ambient_occlusion, "ambient-occlusion"},
    {IntegratorKind::albedo, "albedo"},
    {IntegratorKind::normal, "normal"},
    {IntegratorKind::geometric_normal, "geometric-normal"},
    {IntegratorKind::depth, "depth"},
    {IntegratorKind::uv, "uv"},
    {IntegratorKind::barycentric, "barycentric"},
    {IntegratorKind::instance, "instance"},
    {IntegratorKind::material, "material"},
}};
constexpr std::array<IntegratorKind, 11> kKinds = [] {
  std::array<IntegratorKind, 11> kinds{};
  for (size_t i = 0; i < kinds.size(); ++i) kinds[i] = kNames[i].kind;
  return kinds;
}();

} // namespace

std::string_view integrator_name(IntegratorKind kind) {
  for (const NamedKind& named : kNames)
    if (named.kind == kind) return named.name;
  return "unknown";
}

std::optional<IntegratorKind> integrator_from_name(std::string_view name) {
  for (const NamedKind& named : kNames)
    if (named.name == name) return named.kind;
  return std::nullopt;
}

std::span<const IntegratorKind> all_integrators() { return kKinds; }

void RayCounters::add(const RayCounters& other) {
  camera += other.camera;
  bounce += other.bounce;
  shadow += other.shadow;
  photon += other.photon;
  paths += other.paths;
  outside += other.outside;
  whitted.reflection += other.whitted.reflection;
  whitted.transmission += other.whitted.transmission;
  whitted.cache_hits += other.whitted.cache_hits;
  whitted.cache_misses += other.whitted.cache_misses;
  whitted.cache_bypasses += other.whitted.cache_bypasses;
  if (other.first_non_finite) add_non_finite(other.first_non_finite->first, other.first_non_finite->second);
  // add_non_finite() has counted one of them already.
  non_finite += other.non_finite - (other.first_non_finite ? 1 : 0);
}

void RayCounters::add_non_finite(const V2i& pixel, uint32_t sample_index) {
  ++non_finite;
  const auto order = [](const std::pair<V2i, uint32_t>& at) { return std::tuple(at.second, at.first.y, at.first.x); };
  const std::pair<V2i, uint32_t> here(pixel, sample_index);
  if (!first_non_finite || order(here) < order(*first_non_finite)) first_non_finite = here;
}

void Integrator::render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const {
  const auto rays_inside = [&context] { return context.counters.total() - context.counters.outside; };
  for (BlockWork& block : work) {
    const uint64_t rays_before = rays_inside();
    block.added = block.rates ? render_levels(block.block, block.samples, *block.rates, context, film)
                              : render_block(block.block, block.samples, context, film);
    block.rays = rays_inside() - rays_before;
  }
}

std::unique_ptr<Integrator> make_integrator(const IntegratorSettings& settings, const World& world,
                                            const Camera& camera, const Sampler& sampler, const PixelFilter& filter,
                                            AovSet aovs, const Guide* guide, const AovInputs& inputs) {
  switch (settings.kind) {
  case IntegratorKind::path:
    return std::make_unique<PathIntegrator>(settings, world, camera, sampler, filter, aovs, guide, inputs);
  case IntegratorKind::whitted:
    return std::make_unique<WhittedIntegrator>(settings, world, camera, sampler, filter, aovs, inputs);
  case IntegratorKind::ambient_occlusion:
    return std::make_unique<AmbientOcclusionIntegrator>(settings, world, camera, sampler, filter, aovs, inputs);
  default: return std::make_unique<DebugIntegrator>(settings, world, camera, sampler, filter, aovs, inputs);
  }
}

} // namespace kindling
