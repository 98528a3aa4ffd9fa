// Ambient occlusion and the debug views, which show the first hit of a camera ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/camera/camera.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/stages/camera_sample.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/world_view.h"

#include <optional>

namespace kindling {

struct FirstHitStages {
  // Returns the color of a debug view. Normals map [-1, 1] to [0, 1]; depth is 1 at the camera and
  // falls to 0 at the far end of the scene; instances and materials have a color hashed from their
  // number.
  [[nodiscard]] Rgb color_of(const accel::Ray& ray, const accel::Hit& hit) const;
  // Returns the occlusion ray of a sample; none if its direction is below the surface.
  [[nodiscard]] std::optional<accel::Ray> occlusion_ray(const CameraSample& sample, const accel::Ray& ray,
                                                        const accel::Hit& hit) const;

  IntegratorKind kind = IntegratorKind::albedo;
  const WorldView* world = nullptr;
  const CameraView* camera = nullptr;
  Sampler sampler;
  float occlusion_distance_m = 0.0f;
};

// References must outlive the stages.
[[nodiscard]] FirstHitStages make_first_hit_stages(const IntegratorSettings& settings, const WorldView& world,
                                                   const CameraView& camera, const Sampler& sampler);

} // namespace kindling
