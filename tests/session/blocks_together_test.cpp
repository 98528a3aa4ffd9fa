// Blocks that share a batch have the bits that each has by itself.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/tile_scheduler.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <vector>

namespace kindling::test {
namespace {

constexpr V2i kCutSize(43, 21); // blocks at two borders are cut

struct RenderedWork {
  Film film;
  RayCounters rays;
};

// The work in calls of `together` blocks. All blocks have one sample at first; after that every
// third one needs three, the others one.
RenderedWork render_work(const World& world, const Camera& camera, const RenderSettings& settings, size_t together,
                         bool counts_rays) {
  const PixelRect image{V2i(0), kCutSize};
  const Sampler sampler(settings.seed, settings.sampler, settings.planned());
  const std::unique_ptr<Integrator> integrator =
      make_integrator(settings.integrator, world, camera, sampler, settings.filter, settings.aovs);
  const std::unique_ptr<ThreadContext> context = integrator->make_context();
  RenderedWork rendered{Film(kCutSize, image, settings.aovs), {}};
  if (settings.integrator.light_paths > 0.0f) rendered.film.enable_splats();
  const std::vector<PixelRect> blocks = make_blocks(image);
  uint64_t rays = 0;
  for (const bool later : {false, true})
    for (size_t first = 0; first < blocks.size(); first += together) {
      std::vector<BlockWork> work;
      for (size_t i = first; i < std::min(first + together, blocks.size()); ++i) {
        const uint32_t end = !later ? 1 : i % 3 == 0 ? 4 : 2;
        work.push_back({blocks[i], {later ? 1U : 0U, end}, nullptr, counts_rays});
      }
      integrator->render_blocks(work, *context, rendered.film);
      for (const BlockWork& block : work) {
        EXPECT_EQ(block.added, block.samples.count());
        rays += block.rays;
      }
    }
  rendered.rays = context->counters;
  if (counts_rays) {
    EXPECT_EQ(rays, rendered.rays.total());
  }
  return rendered;
}

void expect_same_work(const World& world, const Camera& camera, const RenderSettings& settings) {
  const RenderedWork single = render_work(world, camera, settings, 1, true);
  for (const size_t together : {2, 5, 18}) {
    const std::string what = std::to_string(together) + " blocks in a call";
    for (const bool counts_rays : {false, true}) {
      const RenderedWork shared = render_work(world, camera, settings, together, counts_rays);
      expect_same_bits(shared.film, single.film, what);
      EXPECT_EQ(shared.rays.camera, single.rays.camera) << what;
      EXPECT_EQ(shared.rays.bounce, single.rays.bounce) << what;
      EXPECT_EQ(shared.rays.shadow, single.rays.shadow) << what;
      EXPECT_EQ(shared.rays.paths, single.rays.paths) << what;
    }
  }
}

TEST(BlocksTogether, HaveTheBitsOfEachByItself) {
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    const auto world = mixed_world(kind);
    RenderSettings settings = small_render(kCutSize, 4);
    for (const Aov aov : {Aov::albedo, Aov::normal, Aov::depth, Aov::direct, Aov::indirect, Aov::diffuse_indirect})
      settings.aovs.insert(aov);
    const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kCutSize);
    expect_same_work(*world, camera, settings);
    settings.integrator.batch_size = 64;
    expect_same_work(*world, camera, settings);
  }
}

TEST(BlocksTogether, HaveTheLightPathsAndThePhotonsOfEach) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = small_render(kCutSize, 4);
  settings.integrator.light_paths = 0.5f;
  expect_same_work(*world, glass_camera(kCutSize), settings);
  settings.integrator.light_paths = 0.0f;
  settings.integrator.photons = 0.5f;
  expect_same_work(*world, glass_camera(kCutSize), settings);
}

TEST(BlocksTogether, ShareThePathsOfEach) {
  const auto world = mixed_world(accel::Kind::kdtree);
  RenderSettings settings = small_render(kCutSize, 4);
  settings.integrator.path_reuse = 4;
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kCutSize);
  expect_same_work(*world, camera, settings);
}

} // namespace
} // namespace kindling::test
