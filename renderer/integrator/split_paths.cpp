// The path tracer's loops over a batch whose light is split by light group and first event.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/shade_batch.h"
#include "renderer/integrator/splitting_sink.h"

#include <algorithm>

namespace kindling {

void PathIntegrator::shade_split(PathContext& context) const {
  SplittingSink sink{{{context, world_, stages_}}, context.split_light->view};
  const size_t count = context.active.size();
  const size_t together = ShadeGroup::size_for(stages_.settings.direct_samples);
  for (size_t first = 0; first < count; first += together) {
    const size_t end = std::min(first + together, count);
    shade_group(first, end, context, sink);
    if (!context.first_hits.empty()) note_first_hits(first, end, context);
  }
}

void PathIntegrator::split_shadows(PathContext& context) const {
  const SplitView& split = context.split_light->view;
  for (size_t i = 0; i < context.shadow_records.size(); ++i)
    if (!context.occluded[i]) split.add_shadow(context.shadow_records[i], split.shadows[i]);
}

} // namespace kindling
