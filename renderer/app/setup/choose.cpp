// What a person picks from a scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/choose.h"

#include "renderer/app/text/parse_values.h"
#include "renderer/scene/variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kindling::app {

namespace {

// "0 (Front), 1 (Side) or 2", at most ten.
std::string list_choices(const std::vector<std::string>& names) {
  constexpr size_t kMax = 10;
  std::vector<std::string> choices;
  for (size_t i = 0; i < std::min(names.size(), kMax); ++i)
    choices.push_back(names[i].empty() ? fmt::format("{}", i) : fmt::format("{} ({})", i, names[i]));
  if (names.size() > kMax) choices.push_back(fmt::format("another of the {}", names.size()));
  return join_choices(choices);
}

float aspect_of(const SceneCamera& camera) {
  if (camera.kind == SceneCamera::Kind::orthographic) return camera.xmag / camera.ymag;
  return camera.aspect_ratio.value_or(0.0f);
}

} // namespace

std::optional<int> find_by_name_or_index(std::string_view text, const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end() && !text.empty()) return static_cast<int>(found - names.begin());
  const Result<int64_t> index = parse_integer(text, 0, static_cast<int64_t>(names.size()) - 1);
  if (!index.ok()) return std::nullopt;
  return static_cast<int>(index.value());
}

Result<int> choose_scene(const Scene& scene, const std::string& name) {
  if (name.empty()) return kNone;
  std::vector<std::string> names;
  for (const SceneRoot& root : scene.scenes) names.push_back(root.name);
  if (const std::optional<int> index = find_by_name_or_index(name, names)) return *index;
  if (names.empty()) return usage_error(fmt::format("--scene: {} has no scenes; leave the flag away", scene.source));
  return usage_error(fmt::format("--scene: {} has no scene '{}'; use {}", scene.source, name, list_choices(names)));
}

Result<int> show_variant(Scene& scene, const std::string& name) {
  if (name.empty()) return kNone;
  const std::optional<int> variant = find_by_name_or_index(name, scene.variants);
  if (!variant && scene.variants.empty())
    return usage_error(fmt::format("--variant: {} has no variants; leave the flag away", scene.source));
  if (!variant)
    return usage_error(
        fmt::format("--variant: {} has no variant '{}'; use {}", scene.source, name, list_choices(scene.variants)));
  apply_variant(scene, *variant);
  return *variant;
}

std::string camera_name(const Scene& scene, const PosedCamera& posed) {
  const std::string& node = scene.nodes[static_cast<size_t>(posed.node)].name;
  return node.empty() ? scene.cameras[static_cast<size_t>(posed.camera)].name : node;
}

std::vector<std::string> camera_names(const Scene& scene, const PosedScene& posed) {
  std::vector<std::string> names;
  for (const PosedCamera& camera : posed.cameras) names.push_back(camera_name(scene, camera));
  return names;
}

Result<std::optional<int>> choose_camera_index(const Scene& scene, const PosedScene& posed,
                                               const RenderOptions& options) {
  if (options.orbit) return std::optional<int>();
  if (options.camera.empty()) return posed.cameras.empty() ? std::optional<int>() : std::optional(0);
  const std::vector<std::string> names = camera_names(scene, posed);
  std::optional<int> found = find_by_name_or_index(options.camera, names);
  if (!found) { // a node's name hides that of its camera, which is as good a name
    const auto by_camera = std::find_if(posed.cameras.begin(), posed.cameras.end(), [&](const PosedCamera& camera) {
      return scene.cameras[static_cast<size_t>(camera.camera)].name == options.camera;
    });
    if (by_camera != posed.cameras.end()) found = static_cast<int>(by_camera - posed.cameras.begin());
  }
  if (found) return found;
  if (names.empty())
    return usage_error(fmt::format("--camera: {} has no cameras; leave the flag away or use --orbit", scene.source));
  return usage_error(
      fmt::format("--camera: {} has no camera '{}'; use {}", scene.source, options.camera, list_choices(names)));
}

Result<std::optional<PlacedCamera>> choose_camera(const Scene& scene, const PosedScene& posed,
                                                  const RenderOptions& options) {
  if (options.orbit) {
    const V3f& orbit = *options.orbit;
    return std::optional(orbit_camera(
        {orbit.x, orbit.y, orbit.z, options.target, static_cast<float>(options.yfov_deg.value_or(Orbit{}.yfov_deg))}));
  }
  const Result<std::optional<int>> index = choose_camera_index(scene, posed, options);
  if (!index.ok()) return index.error();
  if (!index.value()) return std::optional<PlacedCamera>();
  const PosedCamera& chosen = posed.cameras[static_cast<size_t>(*index.value())];
  PlacedCamera placed{scene.cameras[static_cast<size_t>(chosen.camera)], chosen.camera_to_world,
                      chosen.later_transforms};
  if (Result<void> overridden = override_fov(placed.camera, options); !overridden.ok()) return overridden.error();
  return std::optional(std::move(placed));
}

Result<void> override_fov(SceneCamera& camera, const RenderOptions& options) {
  if (!options.yfov_deg) return {};
  if (camera.kind == SceneCamera::Kind::orthographic)
    return usage_error("--fov: the camera is orthographic and has none; use a perspective one");
  camera.yfov_rad = static_cast<float>(*options.yfov_deg) * kPi / 180.0f;
  return {};
}

Result<V2i> choose_size(const SceneCamera* camera, const RenderOptions& options) {
  V2i size;
  if (options.size_px) {
    size = *options.size_px;
  } else {
    const float aspect = camera ? aspect_of(*camera) : 0.0f;
    const bool sane = std::isfinite(aspect) && aspect > 0.01f && aspect < 100.0f;
    size = default_image_size(sane ? std::optional(aspect) : std::nullopt);
  }
  for (int axis = 0; axis < 2; ++axis) {
    const double scaled = std::max(1.0, std::round(size[axis] * options.scale));
    if (scaled > kMaxSide)
      return usage_error(
          fmt::format("--scale: a side of {} pixels would be {:.0f}; use at most {}", size[axis], scaled, kMaxSide));
    size[axis] = static_cast<int>(scaled);
  }
  if (options.crop && (options.crop->max.x > size.x || options.crop->max.y > size.y))
    return usage_error(fmt::format("--crop: {},{},{},{} is not inside the image; use 0,0 to {},{}", options.crop->min.x,
                                   options.crop->min.y, options.crop->max.x, options.crop->max.y, size.x, size.y));
  if (options.replay_pixel && (options.replay_pixel->x >= size.x || options.replay_pixel->y >= size.y))
    return usage_error(fmt::format("--pixel: {},{} is not inside the image; use 0,0 to {},{}", options.replay_pixel->x,
                                   options.replay_pixel->y, size.x - 1, size.y - 1));
  return size;
}

} // namespace kindling::app
