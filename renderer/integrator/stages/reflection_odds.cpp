// Reflection at clear glass, chosen more often where it shows a bright part of the environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/path_stages.h"

namespace kindling {

bool PathStages::favors_reflection(const SurfacePoint& surface, const PathState& state) const {
  const LayerParameters& layers = surface.layers.bsdf;
  return layers.transmission > 0.0f && surface.bsdf.roughness <= kStraightRoughness && !state.in_medium &&
         (layers.thin_walled || surface.layers.entering) && !state.emission_only && world->lights.has_environment &&
         world->lights.environment.width > 0;
}

// Glass reflects one path in twenty-five, seen from the front, so the image of a lamp in it is
// noisy, and so is the light that it throws on other surfaces. The mirrored direction is known and
// the environment's light there costs one lookup. Light from beyond the glass is not known; the
// mean of the environment stands for it. Inside of glass, both ways lead to places that are not
// known.
float PathStages::reflection_odds(const EnvironmentView::Location& mirrored) const {
  const EnvironmentView& environment = world->lights.environment;
  const float mean = luminance(environment.total_radiance) * (0.25f * kInvPi);
  const float here = luminance(environment.radiance_at(mirrored));
  return here > mean && mean > 0.0f ? here / mean : 1.0f;
}

} // namespace kindling
