// Poses cameras and surfaces one frame before and after an image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/frame_neighbors.h"

#include "renderer/facade/choose.h"
#include "renderer/scene/animated_members.h"
#include "renderer/scene/animated_nodes.h"
#include "renderer/scene/motion_probe.h"

#include <utility>

namespace kindling {
namespace {

Result<FrameNeighbors::Neighbor> find_neighbor(RenderScene& scene, const std::vector<PosedCamera>& cameras,
                                               const ImageSettings& image, const std::optional<double>& now_s,
                                               double step_s) {
  FrameNeighbors::Neighbor neighbor;
  PosedScene posed;
  posed.cameras = cameras;
  if (now_s && step_s != 0.0) {
    const double then_s = *now_s + step_s;
    scene.as_loaded->restore(scene.scene);
    animate_members(scene.scene, then_s);
    neighbor.surfaces = SurfaceMotion(scene.scene, *now_s, then_s);
    const AnimatedNodes nodes(scene.scene, then_s);
    for (PosedCamera& camera : posed.cameras) camera.camera_to_world = without_scale(nodes.to_world(camera.node));
  }
  for (PosedCamera& camera : posed.cameras) camera.later_transforms.clear();
  Result<std::optional<PlacedCamera>> camera = choose_camera(scene.scene, posed, image);
  if (!camera.ok()) return camera.error();
  neighbor.camera = std::move(camera).value();
  return neighbor;
}

Camera turned(PlacedCamera camera, double step_deg, const ImageSettings& image, const V2i& size_px,
              const std::function<V3f(const PlacedCamera&)>& turn_center) {
  if (image.turn) {
    const V3f around = turn_center(camera);
    camera = turn_camera(std::move(camera), image.turn->angle_deg + step_deg, image.turn->axis, around);
  }
  return {camera.camera, camera.camera_to_world, size_px};
}

} // namespace

Result<FrameNeighbors> find_frame_neighbors(RenderScene& scene, const std::vector<PosedCamera>& cameras,
                                            const ImageSettings& image, const std::optional<double>& time_s) {
  const FrameStep& step = image.frame_step;
  ImageSettings before = image, after = image;
  if (step.previous_camera) before.own_camera = step.previous_camera;
  if (step.next_camera) after.own_camera = step.next_camera;
  Result<FrameNeighbors::Neighbor> previous = find_neighbor(scene, cameras, before, time_s, -step.time_s);
  Result<FrameNeighbors::Neighbor> next = find_neighbor(scene, cameras, after, time_s, step.time_s);
  if (time_s && step.time_s != 0.0) {
    scene.as_loaded->restore(scene.scene);
    animate_members(scene.scene, *time_s);
  }
  if (!previous.ok()) return previous.error();
  if (!next.ok()) return next.error();
  return FrameNeighbors{std::move(previous).value(), std::move(next).value()};
}

FrameMotion frame_motion(FrameNeighbors neighbors, const PlacedCamera& fitted, const ImageSettings& image,
                         const V2i& size_px, const std::function<V3f(const PlacedCamera&)>& turn_center) {
  const auto frame = [&](FrameNeighbors::Neighbor&& neighbor, double step_deg) {
    return FrameMotion::Frame{std::move(neighbor.surfaces), turned(neighbor.camera ? *neighbor.camera : fitted,
                                                                   step_deg, image, size_px, turn_center)};
  };
  return {frame(std::move(neighbors.previous), -image.frame_step.turn_deg),
          frame(std::move(neighbors.next), image.frame_step.turn_deg)};
}

} // namespace kindling
