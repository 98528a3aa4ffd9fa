// All strategies and an independent plain tracer have the same mean on every scene.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/motion_scenes.h"
#include "tests/session/same_bits.h"
#include "tests/unbiased/render_images.h"
#include "tests/unbiased/scenes.h"

#include <cstdio>

namespace kindling::test {
namespace {

// Seeds of the base start at 0, those of strategies with other random numbers here.
constexpr uint32_t kOtherSeeds = 10000;
constexpr uint32_t kBaseSeeds = 48;
constexpr uint32_t kTracerSeeds = 48;
constexpr uint32_t kPartSeeds = 32;
constexpr uint32_t kBiasedSeeds = 24;

class Unbiased : public testing::TestWithParam<NamedScene> {
 protected:
  Unbiased() : scene_(GetParam().make()) {
    for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree})
      worlds_.push_back(world_of(scene_.whole, kind));
    guide_ = train_one_guide(*worlds_[0], scene_.make_camera(), base(scene_.max_bounces));
    family_.comparisons =
        strategy_count(scene_.casters, moves()) + scene_.traced_bounces.size() + (scene_.parts.empty() ? 0 : 1);
  }

  [[nodiscard]] bool moves() const { return scene_.shutter.has_value(); }
  [[nodiscard]] std::unique_ptr<const World> world_of(const Part& part, accel::Kind kind) const {
    return make_posed_world(part.scene, {.shutter = scene_.shutter}, kind, part.environment);
  }

  [[nodiscard]] Images rendered(const World& world, const RenderSettings& settings, uint32_t first_seed, uint32_t seeds,
                                const Guide* guide = nullptr) const {
    return render_images(world, scene_.make_camera(), settings, first_seed, seeds, guide);
  }
  [[nodiscard]] Images rendered_by(const Strategy& strategy) const {
    RenderSettings settings = base(scene_.max_bounces);
    strategy.apply(settings);
    if (settings.sampler == SamplerKind::independent)
      settings.samples_per_pixel += scene_.samples / 2; // they are noisier
    return rendered(*worlds_[strategy.accelerator == accel::Kind::embree ? 0 : 1], settings,
                    strategy.same_numbers ? 0 : kOtherSeeds, strategy.seeds, strategy.guided ? guide_.get() : nullptr);
  }
  // Renders the lights separately, with different light trees and selection probabilities, and adds
  // the images up.
  [[nodiscard]] Images rendered_by_parts() const {
    Images sum(scene_.size_px);
    for (size_t i = 0; i < scene_.parts.size(); ++i)
      sum.add_light(rendered(*world_of(scene_.parts[i], accel::Kind::embree), base(scene_.max_bounces),
                             static_cast<uint32_t>(2 + i) * kOtherSeeds, kPartSeeds));
    return sum;
  }
  [[nodiscard]] Images traced(int max_bounces) const {
    Images images(scene_.size_px);
    const PlainTracer tracer(*worlds_[0], scene_.aims, max_bounces);
    for (uint32_t seed = 0; seed < kTracerSeeds; ++seed)
      images.add(tracer.image(scene_.make_camera(), scene_.traced_samples, seed));
    return images;
  }
  [[nodiscard]] RenderSettings base(int max_bounces) const {
    return base_settings(scene_.size_px, max_bounces, scene_.samples);
  }

  // Compares, prints and returns the verdict.
  [[nodiscard]] Verdict judge(const std::string& name, const Images& tested, const Images& base,
                              bool paired = false) const {
    const Verdict verdict = compare(tested, base, paired, family_);
    std::printf("  %-24s %s\n", name.c_str(), verdict.text().c_str());
    return verdict;
  }
  void expect_agreement(const std::string& name, const Images& tested, const Images& base, bool paired = false) const {
    const Verdict verdict = judge(name, tested, base, paired);
    EXPECT_TRUE(verdict.agrees) << name << ": " << verdict.text();
    EXPECT_GE(verdict.power, Verdict::kMinPower) << name << " is too noisy";
  }

  TestScene scene_;
  std::vector<std::unique_ptr<const World>> worlds_; // with Embree, with the kd-tree
  std::unique_ptr<const Guide> guide_;               // for all seeds
  Family family_;
};

TEST_P(Unbiased, EveryStrategyHasTheSameMean) {
  const Images reference = rendered(*worlds_[0], base(scene_.max_bounces), 0, kBaseSeeds);
  std::printf(
      "  seeds from 0 and, where random numbers differ, from %u on; z of a whole image up to %.2f, of a block %.2f\n",
      kOtherSeeds, family_.whole_threshold(), family_.block_threshold(reference.blocks()));
  EXPECT_TRUE(guide_ || scene_.max_bounces == 0) << "no guide was learned, so guiding is not tested here";
  for (const Strategy& strategy : kStrategies)
    if (strategy.suits(scene_.casters, moves()))
      expect_agreement(strategy.name, rendered_by(strategy), reference, strategy.same_numbers);
  if (!scene_.parts.empty()) expect_agreement("part by part", rendered_by_parts(), reference);
  for (const int bounces : scene_.traced_bounces)
    expect_agreement("plain tracer, " + std::to_string(bounces) + " bounces", traced(bounces),
                     bounces == scene_.max_bounces ? reference : rendered(*worlds_[0], base(bounces), 0, kBaseSeeds));

  // A biased setting must be detected.
  RenderSettings biased = base(scene_.max_bounces);
  scene_.bias(biased.integrator);
  const Verdict verdict = judge("(biased)", rendered(*worlds_[0], biased, kOtherSeeds, kBiasedSeeds), reference);
  EXPECT_FALSE(verdict.agrees) << verdict.text();
}

class OnADevice : public testing::TestWithParam<NamedScene> {};

TEST_P(OnADevice, HasTheBitsOfTheCpu) {
  const TestScene scene = GetParam().make();
  const auto world =
      make_posed_world(scene.whole.scene, {.shutter = scene.shutter}, accel::Kind::kdtree, scene.whole.environment);
  for (const IntegratorKind kind : {IntegratorKind::path, IntegratorKind::whitted}) {
    // The Whitted tracer samples all lamps at each of its nodes.
    RenderSettings settings = base_settings(scene.size_px, scene.max_bounces, kind == IntegratorKind::whitted ? 1 : 16);
    settings.integrator.kind = kind;
    settings.guiding = Guiding::on;
    std::vector<Film> films;
    for (const DeviceKind device : {DeviceKind::cpu, DeviceKind::host}) {
      settings.device = device;
      Result<RenderOutcome> outcome = render(*world, scene.make_camera(), settings, nullptr, nullptr);
      ASSERT_TRUE(outcome.ok()) << outcome.error().message;
      films.push_back(std::move(outcome).value().film);
    }
    expect_same_bits(films[1], films[0], std::string(integrator_name(kind)));
  }
}

// Adaptive sampling is biased towards darkness (renderer/session/README.md), by a bounded amount.
class AdaptiveBias : public testing::TestWithParam<int> {};

TEST_P(AdaptiveBias, IsBounded) {
  constexpr double kBound = 0.01;
  const TestScene scene = cornell_box();
  const auto world = make_world(scene.whole.scene, accel::Kind::embree);
  std::array<Images, 2> images{Images(scene.size_px), Images(scene.size_px)};
  for (uint32_t i = 0; i < 24; ++i) {
    const bool adaptive = i % 2 == 1;
    RenderSettings settings = base_settings(scene.size_px, scene.max_bounces, adaptive ? 256 : 32);
    settings.integrator.path_reuse = GetParam();
    if (adaptive) settings.adaptive = {GetParam() > 1 ? 0.05 : 0.1, 32};
    settings.seed = i;
    const Result<RenderOutcome> outcome = render(*world, scene.make_camera(), settings, nullptr, nullptr);
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.value().statistics.converged_share > 0.5, adaptive);
    images[i % 2].add(outcome.value().film.resolve(Aov::beauty));
  }
  const Family family;
  const Verdict verdict = compare(images[1], images[0], false, family);
  std::printf("  %s\n", verdict.text().c_str());
  EXPECT_LT(verdict.relative, 4.0 * verdict.error);
  EXPECT_GT(verdict.relative, -kBound - 4.0 * verdict.error); // false alarms: 1 in 30,000 for each side
  EXPECT_LT(4.0 * verdict.error, kBound);                     // power of the test
}
INSTANTIATE_TEST_SUITE_P(PathReuse, AdaptiveBias, testing::Values(1, 8));

const auto kScenes = testing::ValuesIn(all_scenes().begin(), all_scenes().end());
std::string name_of(const testing::TestParamInfo<NamedScene>& scene) { return scene.param.name; }
INSTANTIATE_TEST_SUITE_P(Scenes, Unbiased, kScenes, name_of);
INSTANTIATE_TEST_SUITE_P(Scenes, OnADevice, kScenes, name_of);

} // namespace
} // namespace kindling::test
