// Recorded rays have the kinds, counts, ends and directions of the path tracer's.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/record_rays.h"
#include "tests/integrator/test_scenes.h"

#include <algorithm>
#include <cstring>

namespace kindling::test {
namespace {

const V2i kRecordedSize(100, 60); // whole blocks: 96 x 56
constexpr size_t kRays = 3000;

struct Stage {
  std::unique_ptr<const World> world;
  RecordingAccelerator* recorder = nullptr;
};

// A closed gray room of side 4 around the origin with a lamp under its ceiling: every path
// continues, every surface is lit.
Stage make_stage() {
  Stage stage;
  WorldOptions options;
  options.wrap_accelerator = [&stage](std::unique_ptr<accel::Accelerator> inner) {
    auto recorder = std::make_unique<RecordingAccelerator>(std::move(inner));
    stage.recorder = recorder.get();
    return recorder;
  };
  const std::vector<Primitive> room{
      quad(V3f(-2, -2, -2), V3f(4, 0, 0), V3f(0, 4, 0), 0),  quad(V3f(-2, -2, 2), V3f(4, 0, 0), V3f(0, 4, 0), 0),
      quad(V3f(-2, -2, -2), V3f(0, 4, 0), V3f(0, 0, 4), 0),  quad(V3f(2, -2, -2), V3f(0, 4, 0), V3f(0, 0, 4), 0),
      quad(V3f(-2, -2, -2), V3f(4, 0, 0), V3f(0, 0, 4), 0),  quad(V3f(-2, 2, -2), V3f(4, 0, 0), V3f(0, 0, 4), 0),
      quad(V3f(-1, 1.9f, -1), V3f(2, 0, 0), V3f(0, 0, 2), 1)};
  Scene scene = make_scene({diffuse_material(Rgb(0.8f)), emissive_material(Rgb(1.0f))}, room);
  Result<PosedScene> posed = pose_scene(scene, {});
  EXPECT_TRUE(posed.ok());
  stage.world = std::move(build_world(std::move(scene), std::move(posed).value(), options, nullptr, nullptr)).value();
  return stage;
}

Camera recording_camera() { return {SceneCamera{}, look_at(V3f(0.3f, 0.2f, 1.8f), V3f(0.0f)), kRecordedSize}; }

std::vector<RaySet> record(size_t rays = kRays) {
  const Stage stage = make_stage();
  RecordSettings settings;
  settings.rays_per_kind = rays;
  return record_rays(*stage.world, *stage.recorder, recording_camera(), settings, nullptr);
}

const RaySet& find(const std::vector<RaySet>& sets, const std::string& name) {
  return *std::find_if(sets.begin(), sets.end(), [&](const RaySet& set) { return set.name == name; });
}

TEST(RecordRays, EveryKindHasRays) {
  const std::vector<RaySet> sets = record();
  ASSERT_EQ(sets.size(), 7U);
  for (const RaySet& set : sets) {
    SCOPED_TRACE(set.name);
    EXPECT_EQ(set.rays.size(), kRays);
    const bool any_hit = set.name.starts_with("shadow") || set.name == "ambient-occlusion";
    EXPECT_EQ(set.query == RayQuery::any_hit, any_hit);
    EXPECT_EQ(set.coherent_group, set.name == "camera" ? 64U : 0U);
    for (const accel::Ray& ray : set.rays) {
      // A shadow ray's direction is normalized in single precision.
      ASSERT_NEAR(ray.direction.length(), 1.0f, 1e-5f);
      ASSERT_EQ(ray.t_min, 0.0f);
      for (int k = 0; k < 3; ++k) ASSERT_LE(std::fabs(ray.origin[k]), 2.0f); // within the room
      if (!any_hit)
        ASSERT_EQ(ray.t_max, kInfinity);
      else
        ASSERT_LT(ray.t_max, 4.0f * std::sqrt(3.0f)); // its diagonal
    }
  }
}

TEST(RecordRays, RaysStartOnSurfacesOfTheirKind) {
  const std::vector<RaySet> sets = record();
  const V3f eye = recording_camera().position();
  for (const accel::Ray& ray : find(sets, "camera").rays) ASSERT_EQ(ray.origin, eye);
  // Every other ray leaves a wall or the lamp: one coordinate of it is that of a surface.
  const auto on_surface = [](const V3f& p) {
    const float wall = std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    return std::fabs(wall - 2.0f) < 1e-4f || std::fabs(p.y - 1.9f) < 1e-4f;
  };
  for (const char* name : {"bounce1", "bounce3", "shadow1", "shadow3", "ambient-occlusion"})
    for (const accel::Ray& ray : find(sets, name).rays) ASSERT_TRUE(on_surface(ray.origin)) << name;
  // Shadow rays aim at the lamp.
  for (const char* name : {"shadow1", "shadow3"})
    for (const accel::Ray& ray : find(sets, name).rays)
      ASSERT_NEAR(ray.origin.y + ray.direction.y * ray.t_max, 1.9f, 1e-3f) << name;
  for (const accel::Ray& ray : find(sets, "ambient-occlusion").rays)
    ASSERT_NEAR(ray.t_max, 0.4f * std::sqrt(3.0f), 1e-3f); // a tenth of the diagonal

  // The first surface is what the camera sees, in front of it; the third may be anywhere.
  const auto behind = [&](const RaySet& set) {
    return std::count_if(set.rays.begin(), set.rays.end(),
                         [&](const accel::Ray& ray) { return ray.origin.z > eye.z + 0.1f; });
  };
  EXPECT_EQ(behind(find(sets, "bounce1")), 0);
  EXPECT_EQ(behind(find(sets, "shadow1")), 0);
  EXPECT_GT(behind(find(sets, "bounce3")), 0);
  EXPECT_GT(behind(find(sets, "shadow3")), 0);
}

TEST(RecordRays, ShuffledRaysArePermutation) {
  const std::vector<RaySet> sets = record();
  const auto words = [](const RaySet& set) {
    std::vector<std::string> rays;
    for (const accel::Ray& ray : set.rays) rays.emplace_back(reinterpret_cast<const char*>(&ray), sizeof ray);
    return rays;
  };
  std::vector<std::string> in_order = words(find(sets, "bounce1"));
  std::vector<std::string> shuffled = words(find(sets, "bounce1-shuffled"));
  size_t in_place = 0;
  for (size_t i = 0; i < kRays; ++i) in_place += in_order[i] == shuffled[i] ? 1 : 0;
  EXPECT_LT(in_place, 10U); // of a random permutation: 1 on average, Poisson; 10 has a probability of 1e-7
  std::sort(in_order.begin(), in_order.end());
  std::sort(shuffled.begin(), shuffled.end());
  EXPECT_EQ(in_order, shuffled);
}

TEST(RecordRays, IsDeterministic) {
  const std::vector<RaySet> a = record(500), b = record(500);
  ASSERT_EQ(a.size(), b.size());
  for (size_t s = 0; s < a.size(); ++s) {
    SCOPED_TRACE(a[s].name);
    EXPECT_GT(a[s].rays.size(), 400U); // of the camera whole groups of 64
    ASSERT_EQ(a[s].rays.size(), b[s].rays.size());
    EXPECT_EQ(std::memcmp(a[s].rays.data(), b[s].rays.data(), a[s].rays.size() * sizeof(accel::Ray)), 0);
  }
}

TEST(RecordRays, CameraRaysFormWholeBlocks) {
  const std::vector<RaySet> sets = record(64 * 20);
  const std::vector<accel::Ray>& rays = find(sets, "camera").rays;
  const Camera camera = recording_camera();
  for (size_t group = 0; group < rays.size(); group += 64) {
    V2f low(1e9f), high(-1e9f);
    for (size_t i = group; i < group + 64; ++i) {
      const std::optional<V2f> px = camera.project(rays[i].origin + rays[i].direction);
      ASSERT_TRUE(px.has_value());
      for (int k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], (*px)[k]);
        high[k] = std::max(high[k], (*px)[k]);
      }
    }
    EXPECT_LT(high.x - low.x, 8.0f + 1.5f); // a block and the pixel filter
    EXPECT_LT(high.y - low.y, 8.0f + 1.5f);
  }
}

TEST(RecordingAccelerator, ReportsCallsAndForwardsAnswers) {
  const Stage stage = make_stage();
  using Call = RecordingAccelerator::Call;
  std::vector<std::pair<Call, size_t>> calls;
  stage.recorder->listen([&](Call call, std::span<const accel::Ray> rays) { calls.emplace_back(call, rays.size()); });
  // From the room's middle: every ray hits a wall 2 away, and none of those that end before.
  std::vector<accel::Ray> rays(10);
  for (size_t i = 0; i < rays.size(); ++i) {
    rays[i].origin = V3f(0.01f * static_cast<float>(i), 0.1f, 0.0f);
    rays[i].direction = V3f(0.0f, -1.0f, 0.0f);
    rays[i].t_max = i % 2 == 0 ? 10.0f : 1.0f;
  }
  std::vector<accel::Hit> hits(rays.size()), coherent(rays.size());
  std::vector<uint8_t> blocked(rays.size(), 7), blocked_coherent(rays.size(), 7);
  const accel::Accelerator& accelerator = *stage.recorder;
  accelerator.intersect(rays, hits);
  accelerator.intersect_coherent(rays, coherent);
  accelerator.occluded(rays, blocked);
  accelerator.occluded_coherent(rays, blocked_coherent);
  for (size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(accelerator.intersect(rays[i]).is_hit(), i % 2 == 0);
    EXPECT_EQ(accelerator.occluded(rays[i]), i % 2 == 0);
    EXPECT_EQ(hits[i].is_hit(), i % 2 == 0);
    EXPECT_EQ(coherent[i].is_hit(), i % 2 == 0);
    EXPECT_EQ(blocked[i], i % 2 == 0 ? 1 : 0);
    EXPECT_EQ(blocked_coherent[i], i % 2 == 0 ? 1 : 0);
  }
  ASSERT_EQ(calls.size(), 4 + 2 * rays.size());
  const Call batches[] = {Call::nearest, Call::coherent, Call::any_hit, Call::coherent_any_hit};
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(calls[i], std::pair(batches[i], rays.size()));
  EXPECT_EQ(calls[4], std::pair(Call::nearest, size_t{1}));
  EXPECT_EQ(calls[5], std::pair(Call::any_hit, size_t{1}));
}

TEST(RecordRays, CancelledRecordingEnds) {
  const Stage stage = make_stage();
  CancelToken cancel;
  cancel.cancel();
  for (const RaySet& set : record_rays(*stage.world, *stage.recorder, recording_camera(), {}, &cancel))
    EXPECT_TRUE(set.rays.empty());
}

TEST(GeometryHash, DependsOnEveryInput) {
  std::vector<V3f> positions{V3f(0), V3f(1, 0, 0), V3f(0, 1, 0), V3f(0)}; // the last one is padding
  std::vector<uint32_t> indices{0, 1, 2};
  std::vector<accel::TriangleMesh> meshes{{std::span(positions).first(3), indices, true}};
  std::vector<accel::MeshGroup> groups{{0, 1}};
  std::vector<accel::Instance> instances{{0, M44f()}};
  const auto hash = [&] { return hash_geometry({meshes, groups, instances, {}}); };
  const uint64_t before = hash();
  EXPECT_EQ(hash(), before);
  positions[2].z = 1e-30f;
  EXPECT_NE(hash(), before);
  positions[2].z = 0.0f;
  positions[3].x = 9.0f;
  EXPECT_EQ(hash(), before);
  std::swap(indices[0], indices[1]);
  EXPECT_NE(hash(), before);
  std::swap(indices[0], indices[1]);
  meshes[0].opaque = false;
  EXPECT_NE(hash(), before);
  meshes[0].opaque = true;
  instances[0].object_to_world[3][0] = 0.5f;
  EXPECT_NE(hash(), before);
}

} // namespace
} // namespace kindling::test
