// Every sampler gives the same mean, the same bits for any division, and samples that replay.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

#include <cmath>
#include <cstring>

namespace kindling::test {
namespace {

constexpr SamplerKind kKinds[] = {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::jittered,
                                  SamplerKind::independent};
const V2i kSamplerSize(40, 30);

std::unique_ptr<const World> lit_sphere() {
  return make_world(sphere_lamp_and_veil(0.4f), accel::Kind::embree,
                    std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
}

Camera camera() { return {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSamplerSize}; }

RenderSettings settings_of(SamplerKind kind, uint32_t samples, uint32_t seed) {
  RenderSettings settings = small_render(kSamplerSize, samples);
  settings.sampler = kind;
  settings.seed = seed;
  return settings;
}

Film film_of(const World& world, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, camera(), settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value().film;
}

double mean_of(const Film& film) {
  double sum = 0.0;
  const std::vector<float> rgb = film.resolve(Aov::beauty);
  for (const float v : rgb) sum += static_cast<double>(v);
  return sum / static_cast<double>(rgb.size());
}

// Means over images of several seeds; their spread is the standard error, whatever correlates
// pixels. 6 samples: no power of two.
TEST(SamplerRender, AllHaveSameMean) {
  const auto world = lit_sphere();
  constexpr uint32_t kSeeds = 16;
  std::array<double, 4> means{}, errors{};
  for (size_t k = 0; k < 4; ++k) {
    double squares = 0.0;
    for (uint32_t seed = 0; seed < kSeeds; ++seed) {
      const double mean = mean_of(film_of(*world, settings_of(kKinds[k], 6, seed)));
      means[k] += mean / kSeeds;
      squares += mean * mean / kSeeds;
    }
    errors[k] = std::sqrt((squares - means[k] * means[k]) / (kSeeds - 1));
  }
  for (const size_t k : {size_t{0}, size_t{1}, size_t{2}}) {
    const double error = std::hypot(errors[k], errors[3]);
    EXPECT_LT(error / means[3], 0.002); // else the next line would be too weak
    EXPECT_NEAR(means[k], means[3], 4.5 * error) << sampler_name(kKinds[k]);
  }
}

TEST(SamplerRender, SameBitsForThreadsTilesAndCrops) {
  const auto world = lit_sphere();
  for (const SamplerKind kind : kKinds) {
    RenderSettings settings = settings_of(kind, 5, 1);
    settings.threads = 1;
    const std::vector<float> whole = film_of(*world, settings).resolve_rgba();
    settings.threads = 3;
    settings.tile_size_px = 8;
    settings.crop = PixelRect{V2i(3, 5), V2i(29, 22)};
    const std::vector<float> crop = film_of(*world, settings).resolve_rgba();
    const auto width = static_cast<size_t>(settings.crop->width());
    for (int y = settings.crop->min.y; y < settings.crop->max.y; ++y)
      ASSERT_EQ(std::memcmp(crop.data() + static_cast<size_t>(y - 5) * width * 4,
                            whole.data() + (static_cast<size_t>(y) * static_cast<size_t>(kSamplerSize.x) + 3) * 4,
                            width * 4 * sizeof(float)),
                0)
          << sampler_name(kind) << " row " << y;
  }
}

// The mean of the replayed samples is the pixel.
TEST(SamplerRender, SamplesReplay) {
  const auto world = lit_sphere();
  for (const SamplerKind kind : kKinds) {
    const RenderSettings settings = settings_of(kind, 3, 9);
    const V2i pixel(17, 14);
    double sum = 0.0;
    for (uint32_t s = 0; s < 3; ++s) {
      const Result<ReplayedSample> replayed = replay_sample(*world, camera(), settings, pixel, s);
      ASSERT_TRUE(replayed.ok());
      sum += static_cast<double>(replayed.value().radiance.y);
    }
    const std::vector<float> rgb = film_of(*world, settings).resolve(Aov::beauty);
    EXPECT_NEAR(sum / 3.0, rgb[static_cast<size_t>(pixel.y * kSamplerSize.x + pixel.x) * 3 + 1], 1e-5 * (1.0 + sum))
        << sampler_name(kind);
  }
}

} // namespace
} // namespace kindling::test
