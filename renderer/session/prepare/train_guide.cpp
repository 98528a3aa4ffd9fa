// Turns a render's settings into those of its guide's training.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/train_guide.h"

#include "renderer/session/prepare/pilot_integrator.h"
#include "renderer/session/tile_scheduler.h"

#include <algorithm>

namespace kindling {
namespace {

constexpr uint64_t kMinRenderPerTraining = 16; // the render takes at least this many times the samples of its training
constexpr uint64_t kMaxTrainingPaths = 1U << 18; // more paths teach a guide nothing new
constexpr double kMaxTrainingShare = 0.1;        // of a time limit

} // namespace

uint64_t training_paths(const RenderSettings& settings) {
  if (settings.guiding == Guiding::off || settings.integrator.kind != IntegratorKind::path) return 0;
  if (settings.training_paths) return *settings.training_paths;
  const uint64_t pixels = static_cast<uint64_t>(settings.size_px.x) * static_cast<uint64_t>(settings.size_px.y);
  return std::min(pixels * settings.planned() / kMinRenderPerTraining, kMaxTrainingPaths);
}

std::optional<double> max_training_s(const RenderSettings& settings) {
  if (!settings.time_limit_s || settings.training_paths) return std::nullopt;
  return kMaxTrainingShare * *settings.time_limit_s;
}

TrainedGuide train_guide(const World& world, const Camera& camera, const RenderSettings& settings,
                         const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done) {
  GuideTrainingSettings training{.integrator = pilot_integrator(settings),
                                 .filter = settings.filter,
                                 .seed = settings.seed,
                                 .max_paths = training_paths(settings),
                                 .samples = static_cast<uint32_t>(settings.planned()),
                                 .max_training_s = max_training_s(settings),
                                 .only_if_worthwhile = settings.guiding == Guiding::automatic,
                                 .blocks = make_blocks(PixelRect{V2i(0, 0), settings.size_px})};
  training.integrator.direct_samples = 1; // a record of light is of one sample
  training.integrator.reflection_samples = 0;
  training.integrator.presamples_environment = false; // too few to pay for a table
  return train_guide(world, camera, training, stopped, on_done);
}

} // namespace kindling
