// Compares settings of views and places their cameras.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/view_settings.h"

#include <algorithm>
#include <array>

namespace kindling {

namespace {

constexpr int kLongerSide = 64;

bool same_view(const PlacedCamera& a, const PlacedCamera& b) {
  return a.camera_to_world == b.camera_to_world && a.camera.kind == b.camera.kind &&
         (a.camera.kind == SceneCamera::Kind::orthographic ? a.camera.ymag == b.camera.ymag
                                                           : a.camera.yfov_rad == b.camera.yfov_rad);
}

bool same_axis(const std::optional<CameraTurn>& a, const std::optional<CameraTurn>& b) {
  return a.has_value() == b.has_value() && (!a || (a->axis == b->axis && a->around == b->around));
}

} // namespace

ViewSettings::ViewSettings(const ImageSettings& image, const V2i& image_size_px)
    : camera(image.camera), own_camera(image.own_camera), orbit(image.own_camera ? std::nullopt : image.orbit),
      target(image.target), orthographic_m(image.orthographic_m), turn(image.turn), yfov_deg(image.yfov_deg),
      backfaces(image.backfaces), size_px(image_size_px) {}

bool ViewSettings::operator==(const ViewSettings& other) const {
  const bool same_own_camera = own_camera.has_value() == other.own_camera.has_value() &&
                               (!own_camera || same_view(*own_camera, *other.own_camera));
  return same_own_camera && camera == other.camera && orbit == other.orbit && target == other.target &&
         orthographic_m == other.orthographic_m && same_axis(turn, other.turn) && yfov_deg == other.yfov_deg &&
         backfaces == other.backfaces && size_px == other.size_px;
}

std::vector<PlacedCamera> decisive_views(const PlacedCamera& camera, const ViewSettings& settings, const V3f& around) {
  constexpr std::array<float, 4> kSides{0.0f, 90.0f, 180.0f, 270.0f};
  std::vector<PlacedCamera> views;
  if (settings.turn) {
    PlacedCamera view = camera;
    view.camera.lens = CameraLens{};
    view.later_transforms.clear();
    for (const float angle_deg : kSides) views.push_back(turn_camera(view, angle_deg, settings.turn->axis, around));
    return views;
  }
  if (!settings.orbit) {
    views.push_back(camera);
    views.back().camera.lens = CameraLens{};
    views.back().later_transforms.clear();
    return views;
  }
  const V3f& orbit = *settings.orbit;
  for (const float theta_deg : kSides) {
    views.push_back(orbit_camera({theta_deg, orbit.y, orbit.z, settings.target,
                                  static_cast<float>(settings.yfov_deg.value_or(Orbit{}.yfov_deg))}));
    if (settings.orthographic_m) {
      views.back().camera.kind = SceneCamera::Kind::orthographic;
      views.back().camera.xmag = views.back().camera.ymag = static_cast<float>(0.5 * *settings.orthographic_m);
    }
  }
  return views;
}

V2i coarse_size(const V2i& size_px) {
  const float aspect = static_cast<float>(size_px.x) / static_cast<float>(size_px.y);
  return default_image_size(std::clamp(aspect, 1.0f / kLongerSide, 1.0f * kLongerSide), kLongerSide);
}

} // namespace kindling
