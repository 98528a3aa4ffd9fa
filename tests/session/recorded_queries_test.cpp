// All queries of kd-trees give the same answers, to the bit, to the rays of a render.
//
// Single rays, streams and packets, by each instruction set, through trees of each quality.
// KINDLING_RAY_SCENES: further scenes with a camera, separated by colons, in place of the shipped
// one. KINDLING_RAYS: rays of each kind [2000]; KINDLING_ORACLE_RAYS: of these, the number that
// brute force traces as well [50].
// SPDX-License-Identifier: Apache-2.0
#include "accel/make_accelerator.h"
#include "accel/simd_target.h"
#include "renderer/import/load_gltf.h"
#include "renderer/session/record_rays.h"
#include "renderer/world/build_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string>

namespace kindling::test {
namespace {

size_t number_of(const char* variable, size_t otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::strtoul(text, nullptr, 10) : otherwise;
}

std::vector<std::string> scenes() {
  const char* list = std::getenv("KINDLING_RAY_SCENES");
  std::istringstream paths(list != nullptr ? list : KINDLING_SOURCE_DIR "/scenes/interior.glb");
  std::vector<std::string> found;
  for (std::string path; std::getline(paths, path, ':');) found.push_back(path);
  return found;
}

struct Recorded {
  std::unique_ptr<const World> world;
  std::vector<RaySet> sets;
};

Recorded record(const std::string& path) {
  Result<Scene> loaded = load_gltf(path, {}, nullptr);
  EXPECT_TRUE(loaded.ok()) << path;
  Scene scene = std::move(loaded).value();
  PosedScene posed = pose_scene(scene, {}).value();
  const PosedCamera place = posed.cameras.at(0);
  const Camera camera(scene.cameras.at(static_cast<size_t>(place.camera)), place.camera_to_world, V2i(640, 360));
  RecordingAccelerator* recorder = nullptr;
  WorldOptions options;
  options.accelerator = accel::Kind::kdtree;
  options.wrap_accelerator = [&recorder](std::unique_ptr<accel::Accelerator> inner) {
    auto wrapped = std::make_unique<RecordingAccelerator>(std::move(inner));
    recorder = wrapped.get();
    return wrapped;
  };
  Recorded recorded;
  recorded.world = std::move(build_world(std::move(scene), std::move(posed), options, nullptr, nullptr)).value();
  RecordSettings settings;
  settings.rays_per_kind = number_of("KINDLING_RAYS", 2000);
  recorded.sets = record_rays(*recorded.world, *recorder, camera, settings, nullptr);
  return recorded;
}

// Answers of single queries, which all others are compared with.
struct Answers {
  std::vector<accel::Hit> hits;
  std::vector<uint8_t> blocked;
};

Answers single_answers(const accel::Accelerator& accelerator, std::span<const accel::Ray> rays) {
  Answers answers;
  for (const accel::Ray& ray : rays) {
    answers.hits.push_back(accelerator.intersect(ray));
    answers.blocked.push_back(accelerator.occluded(ray) ? 1 : 0);
  }
  return answers;
}

bool is_same(const accel::Hit& a, const accel::Hit& b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

void expect_same(const Answers& expected, const Answers& found, const char* form) {
  size_t other = 0;
  for (size_t i = 0; i < found.hits.size(); ++i)
    other += is_same(expected.hits[i], found.hits[i]) && expected.blocked[i] == found.blocked[i] ? 0 : 1;
  EXPECT_EQ(other, 0U) << form << ": rays with other answers, of " << found.hits.size();
}

void expect_same_in_all_forms(const Answers& expected, const accel::Accelerator& accelerator, const RaySet& set) {
  const size_t count = set.rays.size();
  expect_same(expected, single_answers(accelerator, set.rays), "single");
  Answers found{std::vector<accel::Hit>(count), std::vector<uint8_t>(count)};
  accelerator.intersect(set.rays, found.hits);
  accelerator.occluded(set.rays, found.blocked);
  expect_same(expected, found, "stream");
  // In other batches, and as packets whatever their directions are.
  for (size_t i = 0; i < count;) {
    const size_t batch = std::min<size_t>(1 + i * 7 % 300, count - i);
    const std::span<const accel::Ray> rays(set.rays.data() + i, batch);
    accelerator.intersect_coherent(rays, std::span(found.hits).subspan(i, batch));
    accelerator.occluded_coherent(rays, std::span(found.blocked).subspan(i, batch));
    i += batch;
  }
  expect_same(expected, found, "coherent");
}

TEST(RecordedQueries, AllFormsAndTreesAgreeToTheBit) {
  for (const std::string& path : scenes()) {
    SCOPED_TRACE(path);
    const Recorded recorded = record(path);
    const accel::BuildInput input = recorded.world->accelerator_input();
    std::vector<Answers> expected;
    size_t rays = 0, hits = 0;
    const auto compare = [&](const accel::BuildOptions& options, const std::string& name) {
      SCOPED_TRACE(name);
      const auto accelerator = accel::make_accelerator(accel::Kind::kdtree, input, options);
      if (expected.empty())
        for (const RaySet& set : recorded.sets) {
          expected.push_back(single_answers(*accelerator, set.rays));
          rays += set.rays.size();
          for (const accel::Hit& hit : expected.back().hits) hits += hit.is_hit() ? 1 : 0;
        }
      for (size_t i = 0; i < recorded.sets.size(); ++i)
        expect_same_in_all_forms(expected[i], *accelerator, recorded.sets[i]);
    };
    for (const accel::SimdTarget target : accel::simd_targets()) {
      accel::BuildOptions options;
      options.simd = target;
      compare(options, std::string(accel::simd_target_name(target)));
    }
    for (const accel::Quality quality : {accel::Quality::fast, accel::Quality::best}) {
      accel::BuildOptions options;
      options.quality = quality;
      compare(options, quality == accel::Quality::fast ? "fast" : "best");
    }
    EXPECT_GT(hits, rays / 20);
    // Brute force, for rays that are spread over each kind.
    const auto oracle = accel::make_accelerator(accel::Kind::brute_force, input, {});
    const size_t wanted = number_of("KINDLING_ORACLE_RAYS", 50);
    size_t traced = 0, other = 0;
    for (size_t set = 0; set < recorded.sets.size(); ++set) {
      const std::vector<accel::Ray>& of = recorded.sets[set].rays;
      for (size_t k = 0; k < std::min(wanted, of.size()); ++k, ++traced) {
        const size_t i = k * of.size() / std::min(wanted, of.size());
        other += is_same(oracle->intersect(of[i]), expected[set].hits[i]) ? 0 : 1;
      }
    }
    EXPECT_EQ(other, 0U) << "rays with other answers by brute force";
    std::printf("%s: %zu rays, %zu hit; %zu by brute force\n", path.c_str(), rays, hits, traced);
    std::fflush(stdout);
  }
}

} // namespace
} // namespace kindling::test
