// The calls of Open Image Denoise, by a stand-in, and its absence.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/denoise/denoiser.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <limits>

#include <dlfcn.h>

namespace kindling::test {
namespace {

class Denoise : public testing::Test {
 protected:
  void SetUp() override {
    setenv("KINDLING_OIDN", KINDLING_FAKE_OIDN, 1);
    setenv("FAKE_OIDN", "", 1);
    library_ = dlopen(KINDLING_FAKE_OIDN, RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library_, nullptr) << dlerror();
    (void)log();
  }
  void TearDown() override {
    EXPECT_EQ(reinterpret_cast<int (*)()>(dlsym(library_, "fake_oidn_alive"))(), 0) << "devices and filters are left";
    dlclose(library_);
  }
  std::string log() { return reinterpret_cast<const char* (*)()>(dlsym(library_, "fake_oidn_log"))(); }

  static constexpr V2i kSize{2, 1};
  // An opaque pixel, and one without coverage that a light shows through.
  std::vector<float> rgba_{8.0f, 4.0f, 2.0f, 1.0f, 3.0f, 3.0f, 3.0f, 0.0f};
  std::vector<float> albedo_{0.5f, 0.5f, 0.5f, 0.0f, 0.0f, 0.0f};
  std::vector<float> normal_{0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f};

 private:
  void* library_ = nullptr;
};

TEST_F(Denoise, FastFiltersTheColorAlone) {
  const Denoiser denoiser = Denoiser::open(2).value();
  EXPECT_EQ(denoiser.version(), "2.99.7");
  const std::vector<float> result =
      denoiser.denoise({kSize, rgba_, albedo_, normal_}, Denoising::fast, nullptr).value();
  EXPECT_EQ(result, (std::vector<float>{4.125f, 2.125f, 1.25f, 1.0f, 3.0f, 3.0f, 3.0f, 0.0f}));
  EXPECT_EQ(log(), "albedo color normal output cleanAux=0 hdr=1 maxMemoryMB=2048 quality=4 \n");
}

TEST_F(Denoise, BestFiltersAlbedoAndNormalFirst) {
  const Denoiser denoiser = Denoiser::open(0).value();
  std::vector<double> fractions;
  const std::vector<float> result = denoiser
                                        .denoise({kSize, rgba_, albedo_, normal_}, Denoising::best,
                                                 [&](double fraction) {
                                                   fractions.push_back(fraction);
                                                   return true;
                                                 })
                                        .value();
  EXPECT_EQ(result, (std::vector<float>{4.0625f, 2.0625f, 1.125f, 1.0f, 3.0f, 3.0f, 3.0f, 0.0f}));
  EXPECT_EQ(log(), "albedo output maxMemoryMB=2048 quality=6 \nnormal output maxMemoryMB=2048 quality=6 \n"
                   "albedo color normal output cleanAux=1 hdr=1 maxMemoryMB=2048 quality=6 \n");
  ASSERT_EQ(fractions.size(), 6U);
  EXPECT_DOUBLE_EQ(fractions[0], 0.5 / 3.0);
  EXPECT_DOUBLE_EQ(fractions[5], 1.0);
}

TEST_F(Denoise, ImagesMayLackAlbedoAndNormal) {
  const Denoiser denoiser = Denoiser::open(0).value();
  const std::vector<float> result = denoiser.denoise({kSize, rgba_, {}, {}}, Denoising::best, nullptr).value();
  EXPECT_EQ(result[0], 4.0f);
  EXPECT_EQ(log(), "color output cleanAux=0 hdr=1 maxMemoryMB=2048 quality=6 \n");
}

TEST_F(Denoise, NumbersThatAreNotFiniteCountAsTheirNeighbors) {
  rgba_[1] = std::numeric_limits<float>::infinity(); // its neighbor has 3
  albedo_[0] = std::numeric_limits<float>::quiet_NaN();
  rgba_[6] = std::numeric_limits<float>::quiet_NaN(); // without alpha
  const Denoiser denoiser = Denoiser::open(0).value();
  const std::vector<float> result =
      denoiser.denoise({kSize, rgba_, albedo_, normal_}, Denoising::fast, nullptr).value();
  EXPECT_EQ(result, (std::vector<float>{4.0f, 1.625f, 1.25f, 1.0f, 3.0f, 3.0f, 0.0f, 0.0f}));
}

TEST_F(Denoise, ImagesWithoutAFiniteNumberBecomeBlack) {
  rgba_.assign(8, std::numeric_limits<float>::quiet_NaN());
  rgba_[3] = 1.0f;
  const Denoiser denoiser = Denoiser::open(0).value();
  const std::vector<float> result = denoiser.denoise({kSize, rgba_, {}, {}}, Denoising::fast, nullptr).value();
  EXPECT_EQ(result, (std::vector<float>{0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f}));
}

TEST_F(Denoise, ScratchMemoryIsLimited) {
  const Denoiser denoiser = Denoiser::open(0).value();
  ASSERT_TRUE(denoiser.denoise({kSize, rgba_, {}, {}}, Denoising::fast, nullptr, 300U << 20).ok());
  EXPECT_EQ(log(), "color output cleanAux=0 hdr=1 maxMemoryMB=300 quality=4 \n");
}

TEST(DenoiseMemory, GrowsWithTheImageUpToTiles) {
  EXPECT_EQ(denoise_memory_bytes({640, 360}, Denoising::off), 0U);
  EXPECT_GT(denoise_memory_bytes({640, 360}, Denoising::best), denoise_memory_bytes({640, 360}, Denoising::fast));
  const V2i large(8192, 8192), larger(8192, 16384);
  const uint64_t planes = denoise_memory_bytes(larger, Denoising::best) - denoise_memory_bytes(large, Denoising::best);
  EXPECT_EQ(planes, 64ULL * 8192 * 8192) << "scratch memory grows beyond its limit";
}

// Open Image Denoise itself, where it is installed.
class RealDenoise : public testing::Test {
 protected:
  void SetUp() override {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the library loads oneTBB in a way (RTLD_DEEPBIND) that ends programs with sanitizers";
#endif
    unsetenv("KINDLING_OIDN");
    const Result<Denoiser> opened = Denoiser::open(0);
    if (!opened.ok()) GTEST_SKIP() << opened.error().message;
  }
  static constexpr V2i kSize{300, 260};
  // A bright half beside a dark one, both with noise.
  static std::vector<float> noisy(float bright) {
    std::vector<float> rgba;
    uint32_t state = 1;
    for (int i = 0; i < kSize.x * kSize.y; ++i) {
      for (int c = 0; c < 3; ++c) {
        state = state * 1664525U + 1013904223U;
        const float noise = 0.5f + static_cast<float>(state >> 8) / static_cast<float>(1U << 24);
        rgba.push_back((i % kSize.x < kSize.x / 2 ? bright : 0.25f) * noise);
      }
      rgba.push_back(1.0f);
    }
    return rgba;
  }
};

TEST_F(RealDenoise, HighDynamicRangeIsNotClamped) {
  const std::vector<float> rgba = noisy(10000.0f);
  const std::vector<float> result =
      Denoiser::open(0).value().denoise({kSize, rgba, {}, {}}, Denoising::fast, nullptr).value();
  const size_t row = static_cast<size_t>(kSize.x) * 130 * 4;
  EXPECT_NEAR(result[row + 4 * 40], 10000.0f, 1500.0f);
  EXPECT_NEAR(result[row + 4 * 260], 0.25f, 0.05f);
}

TEST_F(RealDenoise, OneBadPixelDoesNotSpread) {
  std::vector<float> rgba = noisy(1.0f);
  const std::vector<float> clean =
      Denoiser::open(0).value().denoise({kSize, rgba, {}, {}}, Denoising::fast, nullptr).value();
  for (size_t c = 0; c < 3; ++c) rgba[(130 * 300 + 40) * 4 + c] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> result =
      Denoiser::open(0).value().denoise({kSize, rgba, {}, {}}, Denoising::fast, nullptr).value();
  for (size_t i = 0; i < result.size(); ++i) ASSERT_NEAR(result[i], clean[i], 0.15f) << i;
}

TEST_F(RealDenoise, TilesAndThreadsGiveTheSameBits) {
  const std::vector<float> rgba = noisy(2.0f);
  const NoisyImage image{kSize, rgba, {}, {}};
  const std::vector<float> whole = Denoiser::open(1).value().denoise(image, Denoising::fast, nullptr).value();
  EXPECT_EQ(whole, Denoiser::open(1).value().denoise(image, Denoising::fast, nullptr, 1).value()) << "tiles";
  EXPECT_EQ(whole, Denoiser::open(2).value().denoise(image, Denoising::fast, nullptr).value()) << "threads";
}

TEST_F(Denoise, ErrorsAndCancellationAreReported) {
  const Denoiser denoiser = Denoiser::open(0).value();
  const NoisyImage image{kSize, rgba_, albedo_, normal_};
  const Result<std::vector<float>> cancelled =
      denoiser.denoise(image, Denoising::fast, [](double fraction) { return fraction < 1.0; });
  ASSERT_FALSE(cancelled.ok());
  EXPECT_EQ(cancelled.error().message, "denoising was cancelled");
  setenv("FAKE_OIDN", "execute=4", 1);
  const Result<std::vector<float>> failed = denoiser.denoise(image, Denoising::fast, nullptr);
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "Open Image Denoise: a reason (error 4)");
  EXPECT_TRUE(denoiser.denoise(image, Denoising::fast, nullptr).error().message.find("error 4") != std::string::npos);
  setenv("FAKE_OIDN", "new=5", 1);
  EXPECT_EQ(Denoiser::open(0).error().message, "Open Image Denoise: a reason (error 5)");
}

TEST_F(Denoise, TheLibraryIsFoundInAFolder) {
  const std::filesystem::path file = KINDLING_FAKE_OIDN;
  setenv("KINDLING_OIDN", file.parent_path().c_str(), 1);
  EXPECT_TRUE(Denoiser::open(0).ok());
}

TEST_F(Denoise, ErrorsWithoutTheLibraryNameTheScriptThatInstallsIt) {
  setenv("KINDLING_OIDN", "/nowhere", 1);
  const Result<Denoiser> missing = Denoiser::open(0);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().kind, ErrorKind::render_failed);
  EXPECT_NE(missing.error().message.find("/nowhere"), std::string::npos) << missing.error().message;
  EXPECT_NE(missing.error().message.find("cmake/get_oidn.sh"), std::string::npos) << missing.error().message;
  // A library that is another one: it lacks the functions.
  setenv("KINDLING_OIDN", "libm.so.6", 1);
  const Result<Denoiser> other = Denoiser::open(0);
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().message.find("lacks the function oidnNewDevice"), std::string::npos) << other.error().message;
}

TEST(DenoisingNames, AreThoseOfTheFlag) {
  for (const Denoising denoising : {Denoising::off, Denoising::fast, Denoising::best})
    EXPECT_EQ(denoising_from_name(denoising_name(denoising)), denoising);
  EXPECT_FALSE(denoising_from_name("on"));
}

} // namespace
} // namespace kindling::test
