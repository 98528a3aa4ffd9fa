// Integrators allocate nothing per sample, counted through the global operator new.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/guide.h"
#include "renderer/world/light_groups/light_groups.h"
#include "tests/integrator/test_scenes.h"
#include "tests/texture/graph_builder.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<long> allocations{0};
}

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto a = static_cast<std::size_t>(alignment);
  if (void* p = std::aligned_alloc(a, (size + a - 1) / a * a)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace kindling::test {
namespace {

TEST(Allocation, NonePerSample) {
  Material glossy;
  glossy.roughness_factor = 0.3f;
  glossy.metallic_factor = 0.5f;
  Material veil = diffuse_material(Rgb(0.5f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.5f;
  // Squared cell noise, which is sampled at many points of a footprint.
  GraphBuilder graph;
  const GraphBuilder::Node cells = graph.add(ProceduralKind::worleynoise3d, ProceduralType::float_);
  glossy.base_color_texture.procedural = 0;
  for (const accel::Kind kind : kAllKinds)
    for (const IntegratorKind integrator_kind : all_integrators()) {
      Scene scene = make_scene({glossy, emissive_material(Rgb(3.0f)), veil},
                               {sphere(V3f(0.0f), 1.0f, 16, 0), quad(V3f(-1, 2, -1), V3f(2, 0, 0), V3f(0, 0, 2), 1),
                                quad(V3f(-3, -1, 3), V3f(6, 0, 0), V3f(0, 0, -6), 2)});
      scene.lights.emplace_back().radius_m = 0.3f;
      scene.nodes[0].light = 0;
      scene.procedurals = {
          graph.graph(graph.add(ProceduralKind::power, ProceduralType::float_, {{"in1", cells}, {"in2", 2.0f}}))};
      const auto world = make_world(std::move(scene), kind, std::make_shared<Environment>(Rgb(0.3f)));
      const Camera camera(SceneCamera{}, look_at(V3f(1, 1, 4), V3f(0.0f)), V2i(8, 8));
      IntegratorSettings settings;
      settings.kind = integrator_kind;
      settings.whitted.light_strata = settings.whitted.glossy_strata = 2;
      settings.light_groups = LightGrouping::kind;
      AovSet aovs;
      for (const AovInfo& info : kAovs) aovs.insert(info.aov);
      const Sampler sampler(1);
      const PixelFilter filter;
      const BrightPatch above{V3f(0, 2, 0), V3f(1, 0, 1), 3, 10.0f};
      const Guide guide{BrightPatches(std::span(&above, 1)), {}};
      const auto integrator = make_integrator(settings, *world, camera, sampler, filter, aovs, &guide);
      const auto context = integrator->make_context();
      const PixelRect block{V2i(0, 0), V2i(8, 8)};
      Film film(V2i(8, 8), block, aovs);
      film.split_by_light_groups(make_light_groups(*world, settings.light_groups, false).value().names);
      integrator->render_block(block, {0, 4}, *context, film); // accelerator and context may allocate here
      const long before = allocations;
      integrator->render_block(block, {4, 20}, *context, film);
      EXPECT_EQ(allocations - before, 0) << integrator_name(integrator_kind) << " with " << accel::kind_name(kind);
    }
}

} // namespace
} // namespace kindling::test
