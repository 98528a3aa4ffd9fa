// The parts of the light that light paths bring.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/light_path_stages.h"
#include "renderer/integrator/stages/seen_surface.h"
#include "renderer/integrator/stages/split_view.h"

namespace kindling {

SplatParts LightPathStages::parts_of(const PathStages& paths, const LightGroupsView& groups,
                                     const SurfacePoint& surface, const accel::Hit& hit, const accel::Ray& ray,
                                     const LightPathState& path, const LightJoint& joint) const {
  SplatParts parts;
  parts.group = group_of(groups, path);
  SurfacePoint scratch;
  const SeenSurface seen = SeenSurface::from_camera(paths, surface.position, joint.direction, hit, ray.time, scratch);
  const V3f local = seen.frame.to_local(-ray.direction);
  const FirstEvent event = event_towards(*seen.bsdf, local, local.z < 0.0f);
  if (event.kind == FirstEvent::Kind::transmission)
    parts.passes = {Rgb(0.0f), Rgb(0.0f), Rgb(1.0f)};
  else
    parts.passes = {event.diffuse, Rgb(1.0f) - event.diffuse, Rgb(0.0f)};
  return parts;
}

} // namespace kindling
