// Measures how much of a view emission lights.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/scene_light.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace kindling {

namespace {

constexpr int kLongerSide = 64;
constexpr uint32_t kPaths = 16;
constexpr float kDim = 0.02f; // an eighth of middle gray: 15 % of the screen's signal in sRGB
constexpr float kMinAlbedo = 0.05f;

V2i small_size(const V2i& size_px) {
  const float aspect = static_cast<float>(size_px.x) / static_cast<float>(size_px.y);
  return default_image_size(std::clamp(aspect, 1.0f / kLongerSide, 1.0f * kLongerSide), kLongerSide);
}

Rgb pixel_of(const std::vector<float>& values, size_t pixel) {
  return {values[3 * pixel], values[3 * pixel + 1], values[3 * pixel + 2]};
}

struct PixelCount {
  size_t reflecting = 0; // pixels of surfaces that do not glow
  size_t lit = 0;        // among them
  size_t glowing = 0;

  void add(const Film& film) {
    const std::vector<float> beauty = film.resolve(Aov::beauty), emission = film.resolve(Aov::emission),
                             albedo = film.resolve(Aov::albedo), alpha = film.resolve(Aov::alpha);
    for (size_t i = 0; i < alpha.size(); ++i) {
      if (alpha[i] < 0.5f) continue;
      const float glow = luminance(pixel_of(emission, i));
      if (glow >= kDim) {
        ++glowing;
        continue;
      }
      ++reflecting;
      const float reflected = luminance(pixel_of(beauty, i)) - glow;
      if (reflected >= kDim * std::max(luminance(pixel_of(albedo, i)), kMinAlbedo)) ++lit;
    }
  }
};

bool same_view(const PlacedCamera& a, const PlacedCamera& b) {
  return a.camera_to_world == b.camera_to_world && a.camera.kind == b.camera.kind &&
         (a.camera.kind == SceneCamera::Kind::orthographic ? a.camera.ymag == b.camera.ymag
                                                           : a.camera.yfov_rad == b.camera.yfov_rad);
}

} // namespace

LightViewSettings::LightViewSettings(const ImageSettings& image, const V2i& image_size_px)
    : camera(image.camera), own_camera(image.own_camera), orbit(image.own_camera ? std::nullopt : image.orbit),
      target(image.target), yfov_deg(image.yfov_deg), size_px(image_size_px) {}

bool LightViewSettings::operator==(const LightViewSettings& other) const {
  const bool same_own_camera = own_camera.has_value() == other.own_camera.has_value() &&
                               (!own_camera || same_view(*own_camera, *other.own_camera));
  return same_own_camera && camera == other.camera && orbit == other.orbit && target == other.target &&
         yfov_deg == other.yfov_deg && size_px == other.size_px;
}

std::vector<PlacedCamera> light_views(const PlacedCamera& camera, const LightViewSettings& settings) {
  std::vector<PlacedCamera> views;
  if (!settings.orbit) {
    views.push_back(camera);
    views.back().camera.lens = CameraLens{};
    views.back().later_transforms.clear();
    return views;
  }
  const V3f& orbit = *settings.orbit;
  for (const float theta_deg : {0.0f, 90.0f, 180.0f, 270.0f})
    views.push_back(orbit_camera({theta_deg, orbit.y, orbit.z, settings.target,
                                  static_cast<float>(settings.yfov_deg.value_or(Orbit{}.yfov_deg))}));
  return views;
}

Result<double> measure_lit_share(const World& world, std::span<const PlacedCamera> views, const V2i& size_px,
                                 const CancelToken* cancel) {
  assert(world.lights().environment() == nullptr);
  RenderSettings settings;
  settings.size_px = small_size(size_px);
  settings.samples_per_pixel = kPaths;
  settings.integrator.transparent_background = true;
  settings.threads = tbb::this_task_arena::max_concurrency();
  for (const Aov aov : {Aov::emission, Aov::albedo}) settings.aovs.insert(aov);
  PixelCount count;
  for (const PlacedCamera& view : views) {
    const Camera camera(view.camera, view.camera_to_world, settings.size_px);
    const Result<RenderOutcome> outcome = render(world, camera, settings, cancel, nullptr);
    if (!outcome.ok()) return outcome.error();
    if (outcome.value().interrupted)
      return Error{ErrorKind::render_failed, "cancelled while the light of the scene was measured"};
    count.add(outcome.value().film);
  }
  if (count.reflecting == 0) return count.glowing > 0 ? 1.0 : 0.0;
  return static_cast<double>(count.lit) / static_cast<double>(count.reflecting);
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
