// The memory budget without renders: its inputs, the available memory, and the warning.
// SPDX-License-Identifier: Apache-2.0
#include "accel/memory_estimate.h"
#include "renderer/app/setup/available_memory.h"
#include "renderer/app/setup/memory_budget.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

namespace kindling::app {
namespace {

constexpr uint64_t kMiB = 1ULL << 20;

uint64_t part(const MemoryBudget& budget, std::string_view name) {
  for (const MemoryBudget::Part& p : budget.parts)
    if (p.name == name) return p.bytes;
  ADD_FAILURE() << name;
  return 0;
}

TEST(MemoryBudget, GrowsWithTheRequest) {
  const MemoryDemand demand{.triangles = 1000000, .geometry_bytes = 30000000};
  const MemoryBudget plain = memory_budget(demand, {});
  const auto with = [&](auto change) {
    MemoryDemand more = demand;
    MemoryRequest request;
    change(more, request);
    return memory_budget(more, request);
  };
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    const auto grows = [&](auto change) { EXPECT_GT(with(change).of(kind).rendering, plain.of(kind).rendering); };
    grows([](MemoryDemand& d, MemoryRequest&) { d.triangles *= 2; });
    grows([](MemoryDemand& d, MemoryRequest&) { d.instances = 1000; });
    grows([](MemoryDemand& d, MemoryRequest&) { d.instance_keys = 1000; });
    grows([](MemoryDemand& d, MemoryRequest&) { d.emissive_triangles = 1000; });
    grows([](MemoryDemand& d, MemoryRequest&) { d.texture_bytes = kMiB; });
    grows([](MemoryDemand&, MemoryRequest& r) { r.threads = 8; });
    grows([](MemoryDemand&, MemoryRequest& r) { r.size_px = {1920, 1080}; });
    grows([](MemoryDemand&, MemoryRequest& r) { r.aovs.insert(Aov::normal); });
    grows([](MemoryDemand&, MemoryRequest& r) { r.trims_outliers = true; });
    grows([](MemoryDemand&, MemoryRequest& r) { r.light_paths = true; });
    grows([](MemoryDemand&, MemoryRequest& r) { r.photons = 0.25f; });
    grows([](MemoryDemand&, MemoryRequest& r) { r.denoising = Denoising::fast; });
    grows([](MemoryDemand&, MemoryRequest& r) { r.environment_texels = 1 << 19; });
    EXPECT_GE(plain.of(kind).peak, plain.of(kind).rendering);
    EXPECT_GE(plain.of(kind).peak, plain.loading);
  }
  const MemoryBudget photons = with([](MemoryDemand&, MemoryRequest& r) { r.photons = 0.25f; });
  EXPECT_EQ(plain.on_device.photons, 0U);
  EXPECT_EQ(photons.on_device.photons, part(photons, "photons") / 5); // of five maps
  EXPECT_GT(photons.on_device.waves, plain.on_device.waves);          // light paths, and the photons of a bounce
  EXPECT_GT(photons.on_device.min, plain.on_device.min + photons.on_device.photons);
}

// Light paths have sums for each group and for the passes that they add to.
TEST(MemoryBudget, CountsThePartsOfTheLight) {
  const auto film = [](bool light_paths, size_t groups, std::initializer_list<Aov> aovs) {
    MemoryRequest request{.light_groups = groups, .light_paths = light_paths};
    for (const Aov aov : aovs) request.aovs.insert(aov);
    return part(memory_budget({}, request), "film") / (1280 * 720);
  };
  EXPECT_EQ(film(false, 0, {}), 72U);
  EXPECT_EQ(film(true, 0, {}), 72U + 56);
  EXPECT_EQ(film(false, 3, {}), 72U + 3 * 48);
  EXPECT_EQ(film(true, 3, {}), 72U + 56 + 2 * 3 * 48);
  EXPECT_EQ(film(false, 0, {Aov::glossy_indirect, Aov::emit}), 72U + 2 * 48);
  EXPECT_EQ(film(true, 0, {Aov::glossy_indirect, Aov::emit}), 72U + 56 + 3 * 48);
}

TEST(MemoryBudget, TextureMemoryLimitsTextures) {
  const MemoryDemand demand{.texture_bytes = 300 * kMiB, .level_bytes = 100 * kMiB, .largest_image_bytes = 10 * kMiB};
  MemoryRequest request;
  EXPECT_EQ(part(memory_budget(demand, request), "textures"), 400 * kMiB);
  request.texture_memory_bytes = 400 * kMiB;
  EXPECT_EQ(part(memory_budget(demand, request), "textures"), 400 * kMiB);
  request.texture_memory_bytes = 64 * kMiB;
  EXPECT_EQ(part(memory_budget(demand, request), "textures"), 64 * kMiB);
  EXPECT_LT(memory_budget(demand, request).loading, memory_budget(demand, {}).loading);
}

// A mesh of `triangles` on `nodes` nodes.
Scene repeated(size_t triangles, size_t nodes) {
  Scene scene;
  scene.materials.emplace_back();
  Mesh mesh;
  Primitive primitive;
  primitive.material = 0;
  primitive.positions.resize(triangles + 2);
  primitive.normals.resize(triangles + 2, V3f(0, 0, 1));
  for (uint32_t t = 0; t < triangles; ++t) primitive.indices.insert(primitive.indices.end(), {t, t + 1, t + 2});
  mesh.primitives.push_back(std::move(primitive));
  scene.meshes.push_back(std::move(mesh));
  SceneRoot root;
  for (size_t n = 0; n < nodes; ++n) {
    Node node;
    node.mesh = 0;
    scene.nodes.push_back(node);
    root.nodes.push_back(static_cast<int>(n));
  }
  scene.scenes.push_back(root);
  return scene;
}

MemoryDemand demand_of(const Scene& scene) {
  const Result<PosedScene> posed = pose_scene(scene, {});
  EXPECT_TRUE(posed.ok());
  return memory_demand(scene, posed.value());
}

TEST(MemoryDemand, CountsCopiesAndInstances) {
  const MemoryDemand baked = demand_of(repeated(1000, 10)); // few enough to be copied
  EXPECT_EQ(baked.triangles, 10000U);
  EXPECT_EQ(baked.instances, 0U);
  EXPECT_EQ(baked.geometry_bytes, 10 * (1002 * 24 + 12000U));
  const MemoryDemand instanced = demand_of(repeated(1000, 400));
  EXPECT_EQ(instanced.triangles, 1000U);
  EXPECT_EQ(instanced.instances, 400U);
  EXPECT_EQ(instanced.placed_meshes, 400U);
  EXPECT_EQ(instanced.emissive_triangles, 0U);
  Scene lamps = repeated(1000, 400);
  lamps.materials[0].emissive_factor = Rgb(1.0f);
  EXPECT_EQ(demand_of(lamps).emissive_triangles, 400000U);
}

// Instances at one place without a transform are merged into the world's structure up to a budget.
TEST(MemoryDemand, CountsMergedInstances) {
  const MemoryDemand all = demand_of(repeated(1000, 400));
  EXPECT_EQ(all.triangles, 1000U);
  EXPECT_EQ(all.copied_triangles, 263U * 1000U); // the first, 262 copies, and those of the other instances
  Scene scene = repeated(300000, 2);
  scene.nodes[1].local.translation = V3f(1, 0, 0);
  EXPECT_EQ(demand_of(scene).copied_triangles, 300000U); // of the world's structure, beside the instance's
  scene.nodes[0].local.translation = V3f(2, 0, 0);
  EXPECT_EQ(demand_of(scene).copied_triangles, 0U);
  const auto peak = [](const MemoryDemand& demand) { return memory_budget(demand, {}).of(accel::Kind::embree).peak; };
  const uint64_t copies = all.copied_triangles * accel::memory_costs(accel::Kind::embree).triangle;
  EXPECT_GE(peak(all), peak(demand_of(repeated(1000, 1))) + copies);
}

TEST(MemoryDemand, CountsLevelsForEachUse) {
  Scene scene = repeated(1, 1);
  Image image;
  image.width = image.height = 30;
  image.channels = 3;
  image.pixels.resize(2700);
  scene.textures.push_back({.image = std::make_shared<const Image>(std::move(image))});
  scene.textures.push_back(scene.textures[0]);
  scene.materials[0].base_color_texture.texture = 0;
  scene.materials[0].emissive_texture.texture = 1;
  EXPECT_EQ(demand_of(scene).texture_bytes, 2700U);
  EXPECT_EQ(demand_of(scene).level_bytes, 900U);
  scene.materials[0].normal_texture.texture = 0;
  EXPECT_EQ(demand_of(scene).level_bytes, 1800U);
}

TEST(MemoryWarning, IsGivenIfThePeakDoesNotFit) {
  const MemoryBudget budget = memory_budget({.triangles = 10000000}, {});
  const uint64_t peak = budget.of(accel::Kind::kdtree).peak;
  const auto warn = [&](uint64_t resident, std::optional<uint64_t> available) {
    return warn_of_memory(budget, accel::Kind::kdtree, resident, available);
  };
  EXPECT_FALSE(warn(0, peak));
  EXPECT_FALSE(warn(kMiB, peak - kMiB));
  EXPECT_FALSE(warn(0, std::nullopt));
  ASSERT_TRUE(warn(0, peak - 1));
  EXPECT_NE(warn(0, peak - 1)->find("of memory"), std::string::npos);
}

class AvailableMemory : public test::SceneFolder {
 protected:
  void write(const std::string& name, const std::string& contents) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    write_file(name, contents);
  }
};

TEST_F(AvailableMemory, IsTheMinimumOfMachineAndGroups) {
  EXPECT_EQ(available_memory_bytes(folder_), std::nullopt);
  write("proc/meminfo", "MemTotal:       24000 kB\nMemFree:  9 kB\nMemAvailable:   20000 kB\n");
  EXPECT_EQ(available_memory_bytes(folder_), 20000U * 1024);
  write("proc/self/cgroup", "0::/batch/job\n");
  write("sys/fs/cgroup/batch/job/memory.max", "max\n");
  write("sys/fs/cgroup/batch/job/memory.current", "5000000\n");
  EXPECT_EQ(available_memory_bytes(folder_), 20000U * 1024);
  write("sys/fs/cgroup/batch/memory.max", "8000000\n");
  write("sys/fs/cgroup/batch/memory.current", "6000000\n");
  write("sys/fs/cgroup/batch/memory.stat", "anon 5\ninactive_file 500000\nfile 9\n");
  EXPECT_EQ(available_memory_bytes(folder_), 2500000U);
  write("sys/fs/cgroup/batch/job/memory.max", "5100000\n");
  EXPECT_EQ(available_memory_bytes(folder_), 100000U);
  write("sys/fs/cgroup/batch/job/memory.current", "5200000\n"); // above its limit for a moment
  EXPECT_EQ(available_memory_bytes(folder_), 0U);
}

TEST_F(AvailableMemory, ReadsVersionOneOfControlGroups) {
  write("proc/meminfo", "MemAvailable:   20000 kB\n");
  write("proc/self/cgroup", "5:cpu,cpuacct:/\n4:memory:/docker/1\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9000000\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "2000000\n");
  write("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 1000000\n");
  EXPECT_EQ(available_memory_bytes(folder_), 8000000U);
}

TEST(AvailableMemoryHere, IsKnown) { EXPECT_GT(available_memory_bytes().value_or(0), kMiB); }

} // namespace
} // namespace kindling::app
