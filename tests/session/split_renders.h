// The renders that are compared whole and in pieces: tracers, options and accelerators.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <random>
#include <string>
#include <utility>
#include <vector>

namespace kindling::test {

enum class SplitKind {
  path,     // all AOVs, outliers trimmed
  jittered, // the same with a pattern that the number of samples shapes
  whitted,
  adaptive, // blocks that stop early, and others
  guided,
  moving,             // with a lens
  rates,              // pixels with different numbers of samples
  light_paths,        // as many as a pilot chooses
  moving_light_paths, // clamped
  photons,
  moving_photons,
  photons_by_rates,
  path_reuse,
  manifolds,
};

struct SplitCase {
  SplitKind kind = SplitKind::path;
  accel::Kind accelerator = accel::Kind::kdtree;
};

inline std::vector<SplitCase> all_split_cases() {
  std::vector<SplitCase> cases;
  for (const SplitKind kind :
       {SplitKind::path, SplitKind::jittered, SplitKind::whitted, SplitKind::adaptive, SplitKind::guided,
        SplitKind::moving, SplitKind::rates, SplitKind::light_paths, SplitKind::moving_light_paths, SplitKind::photons,
        SplitKind::moving_photons, SplitKind::photons_by_rates, SplitKind::path_reuse, SplitKind::manifolds})
    for (const accel::Kind accelerator : {accel::Kind::kdtree, accel::Kind::embree})
      cases.push_back({kind, accelerator});
  return cases;
}

inline std::string split_case_name(const testing::TestParamInfo<SplitCase>& info) {
  constexpr const char* kNames[] = {
      "path",        "jittered",           "whitted", "adaptive",       "guided",           "moving",     "rates",
      "light_paths", "moving_light_paths", "photons", "moving_photons", "photons_by_rates", "path_reuse", "manifolds"};
  return std::string(kNames[static_cast<size_t>(info.param.kind)]) + "_" +
         std::string(accel::kind_name(info.param.accelerator));
}

class SplitScene {
 public:
  explicit SplitScene(const SplitCase& what)
      : kind_(what.kind), world_(what.kind == SplitKind::moving ? moving_world(what.accelerator)
                                 : what.kind == SplitKind::light_paths || what.kind == SplitKind::photons ||
                                         what.kind == SplitKind::photons_by_rates
                                     ? glass_world(what.accelerator)
                                 : what.kind == SplitKind::manifolds ? smooth_glass_world(what.accelerator)
                                 : what.kind == SplitKind::moving_light_paths || what.kind == SplitKind::moving_photons
                                     ? moving_glass_world(what.accelerator)
                                     : mixed_world(what.accelerator)) {
    WorldOptions options;
    options.accelerator = what.accelerator;
    std::vector<uint8_t> nodes(16, 0);
    nodes[1] = 1; // the floor
    catchers_ = ShadowCatchers::make(*world_, {std::move(nodes), {}}, options, nullptr);
    const auto beside = [](float x) { return Camera(SceneCamera{}, look_at(V3f(x, 1.2f, 6), V3f(0.0f)), kSize); };
    motion_ = std::make_shared<const FrameMotion>(FrameMotion{{{}, beside(1.4f)}, {{}, beside(1.7f)}});
  }

  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] Camera camera() const {
    if (kind_ == SplitKind::light_paths || kind_ == SplitKind::photons || kind_ == SplitKind::photons_by_rates ||
        kind_ == SplitKind::manifolds)
      return glass_camera(kSize);
    if (kind_ == SplitKind::moving_light_paths || kind_ == SplitKind::moving_photons) return moving_glass_camera(kSize);
    SceneCamera camera;
    if (kind_ == SplitKind::moving) {
      camera.lens.f_stop = 2.0f;
      camera.lens.focus_distance_m = 6.0f;
    }
    return {camera, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize, CameraMotion{.shutter_open = world_->has_motion}};
  }

  [[nodiscard]] RenderSettings settings() const {
    RenderSettings settings = small_render(kSize, 9);
    settings.integrator.roulette_start_bounce = 2;
    for (const AovInfo& info : kAovs)
      if (is_possible(info.aov)) settings.aovs.insert(info.aov);
    settings.motion = motion_;
    if (settings.aovs.contains(Aov::shadow_catcher)) settings.catchers = catchers_;
    if (kind_ != SplitKind::whitted && kind_ != SplitKind::manifolds)
      settings.integrator.light_groups = LightGrouping::name;
    settings.outliers = Outliers::trim;
    if (kind_ != SplitKind::whitted) add_mattes(settings);
    switch (kind_) {
    case SplitKind::path: break;
    case SplitKind::jittered: settings.sampler = SamplerKind::jittered; break;
    case SplitKind::whitted:
      settings.integrator.kind = IntegratorKind::whitted;
      settings.integrator.whitted.trace_depth = 5;
      break;
    case SplitKind::adaptive:
      settings.samples_per_pixel = 70;
      settings.adaptive = {.noise_threshold = 0.06, .min_samples_per_pixel = 20};
      break;
    case SplitKind::guided:
      settings.guiding = Guiding::on;
      settings.planned_samples = 64; // enough to train a guide
      break;
    case SplitKind::moving: settings.sampler = SamplerKind::sobol; break;
    case SplitKind::rates:
      settings.samples_per_pixel = 24;
      settings.sample_rates = SampleRateKind::noise;
      settings.min_rates_gain = 1.0;
      break;
    case SplitKind::light_paths:
      settings.chooses_light_paths = true;
      settings.planned_samples = 1024; // enough for a pilot
      settings.outliers = Outliers::keep;
      break;
    case SplitKind::moving_light_paths:
      settings.integrator.light_paths = 0.4f;
      settings.integrator.clamp_indirect = 2.0f;
      settings.outliers = Outliers::keep;
      break;
    case SplitKind::photons:
    case SplitKind::moving_photons:
      settings.samples_per_pixel = 40; // of three maps
      settings.integrator.photons = 1.0f;
      break;
    case SplitKind::photons_by_rates:
      settings.samples_per_pixel = 40;
      settings.integrator.photons = 1.0f;
      settings.sample_rates = SampleRateKind::noise;
      settings.min_rates_gain = 1.0;
      break;
    case SplitKind::path_reuse: settings.integrator.path_reuse = 8; break;
    case SplitKind::manifolds: settings.integrator.manifold_samples = 2; break;
    }
    return settings;
  }

  RenderOutcome render(const RenderSettings& settings, RenderContinuity continuity = {},
                       const CancelToken* cancel = nullptr) const {
    Result<RenderOutcome> outcome =
        kindling::render(*world_, camera(), settings, cancel, nullptr, std::move(continuity));
    EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
    return std::move(outcome).value();
  }

  [[nodiscard]] bool has_light_paths() const {
    return kind_ == SplitKind::light_paths || kind_ == SplitKind::moving_light_paths;
  }

 private:
  static inline const V2i kSize{43, 29}; // not a multiple of anything

  [[nodiscard]] bool moves() const {
    return kind_ == SplitKind::moving || kind_ == SplitKind::moving_light_paths || kind_ == SplitKind::moving_photons;
  }
  [[nodiscard]] bool has_photons() const {
    return kind_ == SplitKind::photons || kind_ == SplitKind::moving_photons || kind_ == SplitKind::photons_by_rates;
  }
  [[nodiscard]] bool is_possible(Aov aov) const {
    if ((kind_ == SplitKind::whitted || kind_ == SplitKind::manifolds) && is_light_pass(aov)) return false;
    if (kind_ == SplitKind::manifolds && aov == Aov::shadow_catcher) return false;
    if (moves() && is_motion(aov)) return false;
    if (has_light_paths() && aov == Aov::shadow_catcher) return false;
    if (has_photons() && aov == Aov::shadow_catcher) return false;
    return aov != Aov::shadow_catcher || (kind_ != SplitKind::path_reuse && kind_ != SplitKind::whitted &&
                                          kind_ != SplitKind::adaptive && kind_ != SplitKind::rates);
  }

  SplitKind kind_;
  std::unique_ptr<const World> world_;
  std::shared_ptr<const ShadowCatchers> catchers_;
  std::shared_ptr<const FrameMotion> motion_;
};

// Other threads, tiles, batches and schedules.
inline void vary_work(RenderSettings& settings, std::mt19937& random) {
  constexpr int kThreads[] = {1, 2, 7};
  settings.threads = kThreads[random() % 3];
  settings.tile_size_px = random() % 2 == 0 ? 8 : 32;
  settings.integrator.batch_size = random() % 2 == 0 ? 64 : 256;
  settings.schedule = random() % 4 == 0 ? Schedule::regions : Schedule::tiles;
}

} // namespace kindling::test
