// Finds scenes, variants and cameras by name or index; lists the choices for unknown names.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/choose.h"

#include "renderer/base/text.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace kindling {

namespace {

// Returns "0 (Front), 1 (Side) or 2", with at most ten entries.
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

constexpr const char* kOutOfReach = "a number beyond 1e+18 in size, expected numbers from -1e+18 to 1e+18";

bool is_within_reach(const PlacedCamera& camera) {
  return kindling::is_within_reach(camera.camera_to_world) &&
         std::all_of(camera.later_transforms.begin(), camera.later_transforms.end(), kindling::is_within_reach);
}

} // namespace

std::optional<int> find_by_name_or_index(std::string_view text, const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end() && !text.empty()) return static_cast<int>(found - names.begin());
  size_t index = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc{} || end != text.data() + text.size() || index >= names.size()) return std::nullopt;
  return static_cast<int>(index);
}

Result<int> choose_scene(const Scene& scene, const std::string& name) {
  if (name.empty()) return kNone;
  std::vector<std::string> names;
  for (const SceneRoot& root : scene.scenes) names.push_back(root.name);
  if (const std::optional<int> index = find_by_name_or_index(name, names)) return *index;
  if (names.empty()) return usage_error(fmt::format("--scene: {} has no scenes; leave out the flag", scene.source));
  return usage_error(fmt::format("--scene: {} has no scene '{}'; use {}", scene.source, name, list_choices(names)));
}

Result<int> show_variant(Scene& scene, const std::string& name) {
  if (name.empty()) return kNone;
  const std::optional<int> variant = find_by_name_or_index(name, scene.variants);
  if (!variant && scene.variants.empty())
    return usage_error(fmt::format("--variant: {} has no variants; leave out the flag", scene.source));
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
                                               const ImageSettings& image) {
  if (image.own_camera || image.orbit) return std::optional<int>();
  if (image.camera.empty()) return posed.cameras.empty() ? std::optional<int>() : std::optional(0);
  const std::vector<std::string> names = camera_names(scene, posed);
  std::optional<int> found = find_by_name_or_index(image.camera, names);
  if (!found) { // the name of the camera itself, where its node has another one
    const auto by_camera = std::find_if(posed.cameras.begin(), posed.cameras.end(), [&](const PosedCamera& camera) {
      return scene.cameras[static_cast<size_t>(camera.camera)].name == image.camera;
    });
    if (by_camera != posed.cameras.end()) found = static_cast<int>(by_camera - posed.cameras.begin());
  }
  if (found) return found;
  if (names.empty())
    return usage_error(fmt::format("--camera: {} has no cameras; leave out the flag or use --orbit", scene.source));
  return usage_error(
      fmt::format("--camera: {} has no camera '{}'; use {}", scene.source, image.camera, list_choices(names)));
}

Result<std::optional<PlacedCamera>> choose_camera(const Scene& scene, const PosedScene& posed,
                                                  const ImageSettings& image) {
  if (image.own_camera) {
    PlacedCamera placed = *image.own_camera;
    if (Result<void> overridden = override_fov(placed.camera, image); !overridden.ok()) return overridden.error();
    if (!is_within_reach(placed)) return usage_error(fmt::format("the camera's own transform has {}", kOutOfReach));
    return std::optional(std::move(placed));
  }
  if (image.orbit) {
    const V3f& orbit = *image.orbit;
    PlacedCamera placed = orbit_camera(
        {orbit.x, orbit.y, orbit.z, image.target, static_cast<float>(image.yfov_deg.value_or(Orbit{}.yfov_deg))});
    if (image.orthographic_m) {
      placed.camera.kind = SceneCamera::Kind::orthographic;
      placed.camera.xmag = placed.camera.ymag = static_cast<float>(0.5 * *image.orthographic_m);
    }
    if (!is_within_reach(placed))
      return usage_error(fmt::format("--orbit and --target: the position of the camera has {}", kOutOfReach));
    return std::optional(std::move(placed));
  }
  const Result<std::optional<int>> index = choose_camera_index(scene, posed, image);
  if (!index.ok()) return index.error();
  if (!index.value()) return std::optional<PlacedCamera>();
  const PosedCamera& chosen = posed.cameras[static_cast<size_t>(*index.value())];
  PlacedCamera placed{scene.cameras[static_cast<size_t>(chosen.camera)], chosen.camera_to_world,
                      chosen.later_transforms};
  if (Result<void> overridden = override_fov(placed.camera, image); !overridden.ok()) return overridden.error();
  if (!is_within_reach(placed))
    return Error{ErrorKind::scene_invalid,
                 fmt::format("{}: /nodes/{}: with those of its parents, the transform of the camera has {}",
                             scene.source, chosen.node, kOutOfReach)};
  return std::optional(std::move(placed));
}

Result<void> override_fov(SceneCamera& camera, const ImageSettings& image) {
  if (!image.yfov_deg) return {};
  if (camera.kind == SceneCamera::Kind::orthographic)
    return usage_error("--fov: the camera is orthographic and has none; use a perspective one");
  camera.yfov_rad = static_cast<float>(*image.yfov_deg) * kPi / 180.0f;
  return {};
}

Result<V2i> choose_size(const SceneCamera* camera, const ImageSettings& image) {
  V2i size;
  if (image.size_px) {
    size = *image.size_px;
  } else {
    const float aspect = camera ? aspect_of(*camera) : 0.0f;
    const bool sane = std::isfinite(aspect) && aspect > 0.01f && aspect < 100.0f;
    size = default_image_size(sane ? std::optional(aspect) : std::nullopt);
  }
  for (int axis = 0; axis < 2; ++axis) {
    const double scaled = std::max(1.0, std::round(size[axis] * image.scale));
    if (scaled > kMaxImageSide)
      return usage_error(fmt::format("--scale: a side of {} pixels would be {:.0f}; use at most {}", size[axis], scaled,
                                     kMaxImageSide));
    size[axis] = static_cast<int>(scaled);
  }
  if (image.crop && (image.crop->max.x > size.x || image.crop->max.y > size.y))
    return usage_error(fmt::format("--crop: {},{},{},{} is not inside the image; use 0,0 to {},{}", image.crop->min.x,
                                   image.crop->min.y, image.crop->max.x, image.crop->max.y, size.x, size.y));
  return size;
}

} // namespace kindling
