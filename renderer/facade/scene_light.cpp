// Renders coarse views and counts what emission lights in them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/scene_light.h"

#include "renderer/facade/view_settings.h"
#include "renderer/film/exposure.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <utility>
#include <vector>

namespace kindling {

namespace {

constexpr uint32_t kPaths = 16;
constexpr uint32_t kExposurePaths = 64;
constexpr float kDim = 0.02f; // an eighth of middle gray: 15 % of the screen's signal in sRGB
constexpr float kMinAlbedo = 0.05f;

Rgb pixel_of(const std::vector<float>& values, size_t pixel) {
  return {values[3 * pixel], values[3 * pixel + 1], values[3 * pixel + 2]};
}

LitPixels count(const Film& film) {
  LitPixels pixels;
  const std::vector<float> beauty = film.resolve(Aov::beauty), emission = film.resolve(Aov::emission),
                           albedo = film.resolve(Aov::albedo), alpha = film.resolve(Aov::alpha);
  for (size_t i = 0; i < alpha.size(); ++i) {
    if (alpha[i] < 0.5f) continue;
    const float glow = luminance(pixel_of(emission, i));
    if (glow >= kDim) {
      ++pixels.glowing;
      continue;
    }
    ++pixels.reflecting;
    const float reflected = luminance(pixel_of(beauty, i)) - glow;
    if (reflected >= kDim * std::max(luminance(pixel_of(albedo, i)), kMinAlbedo)) ++pixels.lit;
  }
  return pixels;
}

Result<Film> render_coarse(const World& world, const PlacedCamera& view, RenderSettings settings, const V2i& size_px,
                           const CancelToken* cancel, const char* what) {
  settings.size_px = coarse_size(size_px);
  settings.threads = tbb::this_task_arena::max_concurrency();
  const Camera camera(view.camera, view.camera_to_world, settings.size_px);
  Result<RenderOutcome> outcome = render(world, camera, settings, cancel, nullptr);
  if (!outcome.ok()) return outcome.error();
  if (outcome.value().interrupted)
    return Error{ErrorKind::render_failed, fmt::format("cancelled while the {} of the scene was measured", what)};
  return std::move(outcome.value().film);
}

} // namespace

LitPixels& LitPixels::operator+=(const LitPixels& other) {
  reflecting += other.reflecting;
  lit += other.lit;
  glowing += other.glowing;
  return *this;
}

double LitPixels::lit_share() const {
  if (reflecting == 0) return glowing > 0 ? 1.0 : 0.0;
  return static_cast<double>(lit) / static_cast<double>(reflecting);
}

Result<LitPixels> count_lit_pixels(const World& world, const PlacedCamera& view, const V2i& size_px,
                                   const CancelToken* cancel) {
  assert(!world.lights.has_environment);
  RenderSettings settings;
  settings.samples_per_pixel = kPaths;
  settings.integrator.transparent_background = true;
  for (const Aov aov : {Aov::emission, Aov::albedo}) settings.aovs.insert(aov);
  const Result<Film> film = render_coarse(world, view, settings, size_px, cancel, "light");
  if (!film.ok()) return film.error();
  return count(film.value());
}

Result<double> measure_exposure(const World& world, const PlacedCamera& view, const ImageSettings& image,
                                const V2i& size_px, const CancelToken* cancel) {
  RenderSettings settings;
  settings.integrator = image.integrator;
  settings.samples_per_pixel = kExposurePaths;
  const Result<Film> film = render_coarse(world, view, settings, size_px, cancel, "brightness");
  if (!film.ok()) return film.error();
  return auto_exposure_stops(measure_brightness(film.value()));
}

std::string describe(const SceneLight& light) {
  if (!light.lit_share) return {};
  const double percent = 100.0 * *light.lit_share;
  if (light.studio)
    return fmt::format("emissive surfaces light {:.0f} % of what the camera sees: lit by the built-in neutral studio "
                       "as well (by them alone with --studio off)",
                       percent);
  return fmt::format("lit by emissive surfaces, {:.0f} % of what the camera sees (by the built-in neutral studio as "
                     "well with --studio on)",
                     percent);
}

} // namespace kindling
