// A render whose batches are abandoned in the middle keeps whole samples only, and can be resumed.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <atomic>
#include <string>
#include <utility>

namespace kindling::test {
namespace {

// When to abandon: at the n-th call of a query, counted over all threads.
struct Alarm {
  std::atomic<bool> abandon{false};
  std::atomic<int> calls_left{1 << 30};

  void count() {
    if (calls_left.fetch_sub(1) == 1) abandon = true;
  }
};

// Counts the calls of another accelerator.
class Counting final : public accel::Accelerator {
 public:
  Counting(std::unique_ptr<accel::Accelerator> other, Alarm& alarm) : other_(std::move(other)), alarm_(alarm) {}

  [[nodiscard]] accel::Hit intersect(const accel::Ray& ray) const override {
    alarm_.count();
    return other_->intersect(ray);
  }
  [[nodiscard]] bool occluded(const accel::Ray& ray) const override {
    alarm_.count();
    return other_->occluded(ray);
  }
  void intersect(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const override {
    alarm_.count();
    other_->intersect(rays, hits);
  }
  void occluded(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const override {
    alarm_.count();
    other_->occluded(rays, occluded);
  }
  [[nodiscard]] Box3f bounds() const override { return other_->bounds(); }
  [[nodiscard]] accel::Statistics statistics() const override { return other_->statistics(); }

 private:
  std::unique_ptr<accel::Accelerator> other_;
  Alarm& alarm_;
};

std::unique_ptr<const World> make_alarmed_world(accel::Kind kind, Alarm& alarm) {
  Scene scene = mixed_scene();
  Result<PosedScene> posed = pose_scene(scene, {});
  EXPECT_TRUE(posed.ok());
  WorldOptions options;
  options.accelerator = kind;
  options.environment = std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f));
  options.abandon = &alarm.abandon;
  options.wrap_accelerator = [&](std::unique_ptr<accel::Accelerator> built) {
    return std::make_unique<Counting>(std::move(built), alarm);
  };
  Result<std::unique_ptr<const World>> world =
      build_world(std::move(scene), std::move(posed).value(), options, nullptr, nullptr);
  EXPECT_TRUE(world.ok());
  return std::move(world).value();
}

struct Case {
  IntegratorKind integrator;
  bool adaptive = false;
  WhittedForm form = WhittedForm::iterative;
};

class Abandoned : public testing::TestWithParam<accel::Kind> {
 protected:
  static inline const V2i kSize{43, 29};

  [[nodiscard]] Result<RenderOutcome> render(const Case& what, RenderContinuity continuity) {
    RenderSettings settings = small_render(kSize, what.adaptive ? 70 : 9);
    settings.integrator.kind = what.integrator;
    settings.integrator.whitted.form = what.form;
    settings.threads = 2;
    if (what.adaptive) settings.adaptive = {.noise_threshold = 0.06, .min_samples_per_pixel = 20};
    const Camera camera({}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize, {});
    return kindling::render(*world_, camera, settings, nullptr, nullptr, std::move(continuity));
  }

  Alarm alarm_;
  std::unique_ptr<const World> world_ = make_alarmed_world(GetParam(), alarm_);
};

// No token is cancelled: a World that is abandoned ends the render by itself.
TEST_P(Abandoned, ResumedRenderIsTheUndisturbedOne) {
  for (const Case& what : {Case{IntegratorKind::path}, Case{IntegratorKind::path, true}, Case{IntegratorKind::whitted},
                           Case{IntegratorKind::whitted, false, WhittedForm::recursive},
                           Case{IntegratorKind::ambient_occlusion}, Case{IntegratorKind::normal}}) {
    SCOPED_TRACE(static_cast<int>(what.integrator));
    const Result<RenderOutcome> whole = render(what, {});
    ASSERT_TRUE(whole.ok());
    std::optional<RenderState> saved;
    for (const int calls : {1, 2, 7, 50, 333, 2000}) {
      alarm_.calls_left = calls;
      const Result<RenderOutcome> part =
          render(what, {.resume_from = saved, .save = [&](const RenderState& state) { saved = state; }});
      ASSERT_TRUE(part.ok());
      EXPECT_EQ(part.value().interrupted, alarm_.abandon.load()) << calls;
      alarm_.abandon = false;
      if (!part.value().interrupted) break;
    }
    alarm_.calls_left = 1 << 30;
    const Result<RenderOutcome> rest = render(what, {.resume_from = saved});
    ASSERT_TRUE(rest.ok());
    EXPECT_FALSE(rest.value().interrupted);
    expect_same_bits(rest.value().film, whole.value().film, "abandoned batches");
  }
}

TEST_P(Abandoned, NoSampleIsTakenAfterwards) {
  alarm_.abandon = true;
  const Result<RenderOutcome> outcome = render({IntegratorKind::path}, {});
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome.value().interrupted);
  EXPECT_EQ(outcome.value().statistics.samples_per_pixel, 0U);
  EXPECT_EQ(outcome.value().film.total_samples(), 0U);
}

std::string kind_label(const testing::TestParamInfo<accel::Kind>& kind) {
  return std::string(accel::kind_name(kind.param));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Abandoned, testing::Values(accel::Kind::kdtree, accel::Kind::embree), kind_label);

} // namespace
} // namespace kindling::test
