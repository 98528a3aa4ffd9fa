// Tests that Embree's packets and streams match its single rays, on each instruction set.
// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_accelerator.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace kindling::accel::testing {
namespace {

constexpr EmbreeCall kCalls[] = {EmbreeCall::packet, EmbreeCall::coherent_packet, EmbreeCall::stream,
                                 EmbreeCall::coherent_stream};

// Refuses a third of all candidates, depending on the ray's key, so a wrong ray is detected.
bool accept_by_key(const void*, const Ray& ray, const Hit& candidate) {
  return (ray.key * 2654435761U ^ candidate.triangle * 40503U) % 3 != 0;
}

// Returns soups with and without a transform, one of them with cut-outs.
TestScene mixed_scene() {
  Rng rng(211);
  TestScene scene;
  Mesh leaves = triangle_soup(rng, 300, 1.0f, 0.3f);
  leaves.opaque = false;
  const uint32_t tree = scene.add_group({leaves, triangle_soup(rng, 100, 1.0f, 0.2f)});
  M44f moved;
  moved.setTranslation(V3f(1.5f, 0.2f, 0.0f));
  scene.add_instance(tree, M44f());
  scene.add_instance(tree, moved);
  scene.set_filter({accept_by_key, nullptr});
  return scene;
}

// Returns random rays, every seventh of which misses by definition.
std::vector<Ray> rays_through(Rng& rng, const TestScene& scene, int count) {
  std::vector<Ray> rays = random_rays(rng, scene.bounds(), count);
  for (size_t i = 0; i < rays.size(); ++i) {
    rays[i].key = static_cast<uint32_t>(i);
    if (i % 7 != 3) continue;
    switch (i % 5) {
    case 0: rays[i].direction = V3f(0); break;
    case 1: rays[i].t_max = rays[i].t_min; break;
    case 2: rays[i].origin.y = std::numeric_limits<float>::quiet_NaN(); break;
    case 3: rays[i].t_min = std::numeric_limits<float>::quiet_NaN(); break;
    default: rays[i].t_max = -1.0f; break;
    }
  }
  return rays;
}

class EmbreeCalls : public ::testing::TestWithParam<SimdTarget> {};

TEST_P(EmbreeCalls, MatchSingleRayCalls) {
  const TestScene scene = mixed_scene();
  for (const bool robust : {true, false}) {
    BuildOptions options;
    options.robust = robust;
    options.simd = GetParam();
    const auto embree = build(Kind::embree, scene, options);
    Rng rng(223);
    const std::vector<Ray> rays = rays_through(rng, scene, 3000);
    for (const EmbreeCall call : kCalls) {
      SCOPED_TRACE(static_cast<int>(call));
      const auto by_call = with_embree_call(*embree, call);
      if (by_call == nullptr) continue; // Embree 4 has no streams
      EXPECT_EQ(by_call->statistics().memory_bytes, embree->statistics().memory_bytes);
      size_t hit_count = 0, size = 0;
      for (size_t first = 0; first < rays.size(); first += size) {
        size = std::min<size_t>(rng() % 4 == 0 ? rng() % 6 : rng() % 300, rays.size() - first);
        const std::span<const Ray> part = std::span(rays).subspan(first, size);
        const BatchAnswers got(*by_call, part);
        for (size_t i = 0; i < size; ++i) {
          const Hit single = embree->intersect(part[i]);
          ASSERT_EQ(disagreement(scene, part[i], single, got.hits[i]), "");
          ASSERT_EQ(disagreement(scene, part[i], single, got.coherent[i]), "");
          ASSERT_EQ(disagreement_any(scene, *embree, part[i], single, got.blocked[i] != 0), "");
          ASSERT_EQ(got.blocked[i], got.blocked_coherent[i]);
          hit_count += single.is_hit() ? 1 : 0;
        }
      }
      EXPECT_GT(hit_count, 500U);
    }
  }
}

TEST(WithEmbreeCall, RejectsOtherAccelerators) {
  const TestScene scene = mixed_scene();
  for (const Kind kind : {Kind::brute_force, Kind::kdtree})
    for (const EmbreeCall call : kCalls) EXPECT_EQ(with_embree_call(*build(kind, scene), call), nullptr);
}

INSTANTIATE_TEST_SUITE_P(All, EmbreeCalls, ::testing::ValuesIn(embree_simd_targets()), simd_label);

} // namespace
} // namespace kindling::accel::testing
