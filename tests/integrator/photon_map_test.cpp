// Photon maps: searches against all photons one by one, and maps that several threads build.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/photons/photon_maps.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <stdexcept>
#include <thread>

namespace kindling::test {
namespace {

// Random photons; many share coordinates, as those on a wall do. Their densities are their numbers.
std::vector<Photon> random_photons(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  const auto coordinate = [&] { return static_cast<float>(random() % 1024) / 1024.0f; };
  std::vector<Photon> photons(count);
  for (size_t i = 0; i < count; ++i) {
    photons[i].position = V3f(coordinate(), random() % 4 == 0 ? 0.5f : coordinate(), coordinate());
    if (i > 0 && random() % 16 == 0) photons[i].position = photons[i - 1].position;
    photons[i].density = static_cast<float>(i);
  }
  return photons;
}

std::vector<float> near(const PhotonMap& map, const V3f& point, float radius2) {
  std::vector<float> found;
  map.view().for_each_near(point, radius2, [&](const Photon& photon) { found.push_back(photon.density); });
  return found;
}

TEST(PhotonMap, FindsThePhotonsNearAPoint) {
  for (const size_t count : {0, 1, 7, 8, 9, 100, 5000, 40000}) {
    const std::vector<Photon> photons = random_photons(count, static_cast<uint32_t>(count));
    const PhotonMap map(photons);
    ASSERT_EQ(map.photons().size(), count);
    std::mt19937 random(3);
    for (int search = 0; search < 200; ++search) {
      const auto coordinate = [&] { return static_cast<float>(random() % 1100) / 1024.0f - 0.03f; };
      const V3f point(coordinate(), coordinate(), coordinate());
      const float radius2 = std::pow(static_cast<float>(random() % 100) / 400.0f, 2.0f);
      std::vector<float> expected;
      for (const Photon& photon : photons)
        if ((photon.position - point).length2() < radius2) expected.push_back(photon.density);
      std::vector<float> found = near(map, point, radius2);
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected) << count << " photons, search " << search;
    }
  }
}

// Threads divide large maps; sums of light follow the order of the photons.
TEST(PhotonMap, HasOneOrder) {
  const std::vector<Photon> photons = random_photons(60000, 1);
  const PhotonMap first(photons);
  for (int repeat = 0; repeat < 4; ++repeat)
    EXPECT_EQ(near(PhotonMap(photons), V3f(0.5f), 0.1f), near(first, V3f(0.5f), 0.1f));
}

// Each light path leaves a photon whose density is its number.
void trace_numbers(uint64_t first, uint64_t count, std::vector<Photon>& photons) {
  for (uint64_t i = first; i < first + count; ++i) {
    photons.push_back({.position = V3f(static_cast<float>(i % 97), static_cast<float>(i % 89), 0.0f),
                       .to_light = V3f(0.0f),
                       .normal = V3f(0.0f),
                       .power = Rgb(0.0f),
                       .density = static_cast<float>(i)});
  }
}
const auto kNeverStopped = [] { return false; };

TEST(PhotonMaps, SmallImagesShareMaps) {
  EXPECT_EQ(PhotonMapSizes::of(1).samples, 16U);
  EXPECT_EQ(PhotonMapSizes::of(100'000).samples, 2U);
  EXPECT_EQ(PhotonMapSizes::of(1'000'000).samples, 1U);
  EXPECT_EQ(PhotonMapSizes::of(100'000).paths, 200'000U);
}

// Chunks, then surfaces, then paths.
TEST(PhotonMaps, PhotonsOfAnyTracerHaveOneOrder) {
  constexpr uint64_t kChunk = PhotonMapSizes::kChunk;
  uint64_t before = 0;
  for (uint64_t chunk = 0; chunk < 3; ++chunk)
    for (uint32_t surfaces = 0; surfaces < 300; ++surfaces)
      for (const uint64_t path : {uint64_t{0}, uint64_t{1}, kChunk - 1}) {
        const uint64_t order = PhotonMapSizes::order_of(chunk * kChunk + path, surfaces);
        if (chunk + surfaces + path > 0) {
          EXPECT_GT(order, before);
        }
        before = order;
      }
}

TEST(PhotonMaps, ThreadsBuildAMapTogether) {
  constexpr uint64_t kPaths = 5000; // 80,000 for a map
  PhotonMaps alone({kPaths * 16, 16});
  const PhotonMaps::Map expected = alone.of_sample(17, trace_numbers, kNeverStopped); // of the second map
  ASSERT_EQ(expected->photons().size(), 16 * kPaths);
  EXPECT_EQ(near(*expected, V3f(0, 0, 0), 1e9f).size(), 16 * kPaths);
  const auto in_second_map = [](const Photon& p) { return p.density >= 16 * kPaths && p.density < 32 * kPaths; };
  EXPECT_TRUE(std::all_of(expected->photons().begin(), expected->photons().end(), in_second_map));
  PhotonMaps together({kPaths * 16, 16});
  std::vector<PhotonMaps::Map> maps(6);
  {
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < maps.size(); ++i)
      threads.emplace_back(
          [&, i] { maps[i] = together.of_sample(16 + static_cast<uint32_t>(i), trace_numbers, kNeverStopped); });
  }
  for (const PhotonMaps::Map& map : maps) {
    ASSERT_EQ(map, maps[0]); // built once
    EXPECT_EQ(near(*map, V3f(40, 40, 0), 500.0f), near(*expected, V3f(40, 40, 0), 500.0f));
  }
}

// A thread that builds a tree may take other tasks meanwhile, but none that waits for the map.
TEST(PhotonMaps, TasksOfOneArenaBuildAMapTogether) {
  PhotonMaps maps({200'000, 2});
  std::vector<PhotonMaps::Map> found(256);
  tbb::parallel_for(size_t{0}, found.size(),
                    [&](size_t i) { found[i] = maps.of_sample(0, trace_numbers, kNeverStopped); });
  EXPECT_EQ(found[0]->photons().size(), 200'000U);
  for (const PhotonMaps::Map& map : found) EXPECT_EQ(map, found[0]);
}

TEST(PhotonMaps, OldMapsAreBuiltAgain) {
  PhotonMaps maps({160, 16});
  const std::vector<float> first = near(*maps.of_sample(0, trace_numbers, kNeverStopped), V3f(40, 40, 0), 500.0f);
  std::atomic<int> built{0};
  const auto counting = [&](uint64_t begin, uint64_t count, std::vector<Photon>& photons) {
    ++built;
    trace_numbers(begin, count, photons);
  };
  for (uint32_t sample = 0; sample < 64 * 16; sample += 16) (void)maps.of_sample(sample, counting, kNeverStopped);
  EXPECT_EQ(built, 63); // not the first one
  EXPECT_EQ(near(*maps.of_sample(0, counting, kNeverStopped), V3f(40, 40, 0), 500.0f), first);
  EXPECT_EQ(built, 64);
}

TEST(PhotonMaps, StoppedMapsAreMissing) {
  PhotonMaps maps({80'000, 16});
  EXPECT_EQ(maps.of_sample(0, trace_numbers, [] { return true; }), nullptr);
  BatchPhotonMaps batch;
  EXPECT_FALSE(batch.take(0, 4, maps, trace_numbers, [] { return true; }));
  EXPECT_TRUE(batch.empty());
}

TEST(PhotonMaps, FailuresReachAllThreads) {
  PhotonMaps maps({250'000, 5});
  std::atomic<int> failures{0};
  const auto failing = [&](uint64_t first, uint64_t, std::vector<Photon>&) {
    if (first > 0) throw std::runtime_error("out of memory");
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i)
      threads.emplace_back([&] {
        try {
          (void)maps.of_sample(0, failing, kNeverStopped);
        } catch (const std::runtime_error&) {
          ++failures;
        }
      });
  }
  EXPECT_EQ(failures, 4);
}

TEST(BatchPhotonMaps, HasTheMapOfEachSample) {
  PhotonMaps maps({200'000, 2}); // two samples share a map
  BatchPhotonMaps batch;
  ASSERT_TRUE(batch.take(3, 7, maps, trace_numbers, kNeverStopped));
  for (uint32_t sample = 3; sample < 7; ++sample)
    EXPECT_EQ(&batch.of_sample(sample), maps.of_sample(sample, trace_numbers, kNeverStopped).get()) << sample;
}

} // namespace
} // namespace kindling::test
