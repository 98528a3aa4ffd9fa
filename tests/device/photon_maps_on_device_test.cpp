// Photon maps in a device's memory: those of the photons that its light paths have left.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/host_device.h"
#include "renderer/device/photon_maps_on_device.h"
#include "renderer/integrator/photons/photon_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

namespace kindling::test {
namespace {

constexpr PhotonMapSizes kSizes{.paths = 1500, .samples = 2};

// The photon of a light path; its density is the path's number.
Photon photon_of(uint64_t path) {
  return {.position = V3f(static_cast<float>(path % 97), static_cast<float>(path % 89), 0.0f),
          .to_light = V3f(0.0f, 0.0f, 1.0f),
          .normal = V3f(0.0f, 0.0f, 1.0f),
          .power = Rgb(1.0f),
          .density = static_cast<float>(path)};
}

// A third of the light paths leave photons. Light paths are traced in rounds, and their photons
// come in any order.
class PhotonMapsOnHost : public testing::Test {
 protected:
  void build(PhotonMapsOnDevice& maps, const PhotonMapsOnDevice::Maps& wanted) {
    constexpr uint64_t kRound = 1100;
    maps.begin(wanted);
    const uint64_t begin = wanted.first * kSizes.paths, count = wanted.count() * kSizes.paths;
    for (uint64_t first = 0; first < count; first += kRound) {
      std::vector<WavePhoton> found;
      for (uint64_t path = first; path < std::min(first + kRound, count); ++path)
        if ((begin + path) % 3 == 0) found.push_back({photon_of(begin + path), static_cast<uint32_t>(path - first)});
      std::shuffle(found.begin(), found.end(), random_);
      maps.add(first, 1, found);
    }
    maps.build();
  }

  // The maps of these numbers are those that the CPU builds.
  static void expect_maps(const WavePhotonMaps& maps, uint32_t first, uint32_t end) {
    for (uint32_t sample = first * kSizes.samples; sample < end * kSizes.samples; ++sample) {
      const uint64_t begin = sample / kSizes.samples * kSizes.paths;
      std::vector<Photon> photons;
      for (uint64_t path = begin; path < begin + kSizes.paths; ++path)
        if (path % 3 == 0) photons.push_back(photon_of(path));
      const PhotonMap expected(std::move(photons));
      const PhotonMapView& view = maps.of_sample(sample); // the host device has the host's memory
      ASSERT_EQ(view.photons.size(), expected.photons().size());
      for (size_t i = 0; i < view.photons.size(); ++i)
        ASSERT_EQ(view.photons[i].density, expected.photons()[i].density) << "sample " << sample << ", photon " << i;
    }
  }

  std::unique_ptr<Device> device_ = make_host_device(2);
  std::mt19937 random_{7};
};

TEST_F(PhotonMapsOnHost, FillTheWave) {
  EXPECT_EQ(PhotonMapsOnDevice::filling(1000, {.paths = 1, .samples = 2}, 100), 5U);
  EXPECT_EQ(PhotonMapsOnDevice::filling(1000, {.paths = 1, .samples = 2}, 501), 1U); // which is more than the wave
  EXPECT_EQ(PhotonMapsOnDevice::filling(1000, {.paths = 1, .samples = 1}, 1), PhotonMapsOnDevice::kMaxStored);
}

TEST_F(PhotonMapsOnHost, HaveThePhotonsOfTheirLightPathsInTheOrderOfTheCpu) {
  PhotonMapsOnDevice maps(*device_, kSizes, 3);
  build(maps, maps.absent({0, 6}));
  expect_maps(maps.of_samples({0, 6}), 0, 3);
  expect_maps(maps.of_samples({3, 5}), 1, 3);
}

TEST_F(PhotonMapsOnHost, ReplaceThoseThatSamplesDoNotNeed) {
  PhotonMapsOnDevice maps(*device_, kSizes, 3);
  const auto expect_absent = [&](const SampleRange& samples, uint32_t first, uint32_t end) {
    const PhotonMapsOnDevice::Maps absent = maps.absent(samples);
    ASSERT_EQ(absent.count(), end - first);
    if (absent.empty()) return;
    EXPECT_EQ(absent.first, first);
    build(maps, absent);
    EXPECT_TRUE(maps.absent(samples).empty());
  };
  expect_absent({1, 4}, 0, 2);
  expect_absent({0, 4}, 0, 0);
  expect_absent({2, 7}, 2, 4); // the fourth map takes the place of the first one
  expect_maps(maps.of_samples({2, 7}), 1, 4);
  expect_absent({1, 6}, 0, 1);
  expect_absent({7, 11}, 3, 6);
  expect_maps(maps.of_samples({7, 11}), 3, 6);
}

TEST_F(PhotonMapsOnHost, ForgetMapsWhoseBuildingHasNotEnded) {
  PhotonMapsOnDevice maps(*device_, kSizes, 2);
  build(maps, maps.absent({0, 4}));
  maps.begin({0, 1});
  maps.add(0, 1, std::vector<WavePhoton>{{photon_of(0), 0}});
  ASSERT_EQ(maps.absent({0, 4}).count(), 1U);
  build(maps, maps.absent({0, 4}));
  expect_maps(maps.of_samples({0, 4}), 0, 2);
}

} // namespace
} // namespace kindling::test
