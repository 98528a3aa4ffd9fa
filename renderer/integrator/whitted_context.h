// One thread's memory for a batch of the Whitted tracer's trees.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film_surface.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/stages/camera_sample.h"
#include "renderer/integrator/whitted_tree.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

// A light sample whose shadow feeler is not traced yet.
struct WhittedFeeler {
  Rgb contribution;
  uint32_t slot = 0;
  bool seen = true; // WhittedNode::seen of the lit surface
};

// Sized for a batch. The lists grow with the largest trees so far and keep their memory.
class WhittedContext final : public ThreadContext {
 public:
  WhittedContext(size_t batch_size, AovSet aovs)
      : camera_samples(batch_size), camera_rays(batch_size), samples(batch_size),
        components(aovs.needs_film_surface() ? batch_size : 0), surfaces(aovs.needs_film_surface() ? batch_size : 0),
        first_hits(aovs.needs_first_hit() ? batch_size : 0), nodes(batch_size), rays(batch_size), hits(batch_size) {
    waiting.reserve(8 * batch_size);
    feelers.reserve(kFeelerBatch);
    feeler_rays.reserve(kFeelerBatch);
    occluded.reserve(kFeelerBatch);
  }

  static constexpr size_t kFeelerBatch = 1024; // number of feelers that are traced together

  std::vector<CameraSample> camera_samples;  // by slot
  std::vector<accel::Ray> camera_rays;       // likewise
  std::vector<WhittedSample> samples;        // likewise
  std::vector<WhittedComponents> components; // likewise; empty if no AOV needs them
  std::vector<FilmSurface> surfaces;         // likewise
  std::vector<accel::Hit> first_hits;        // likewise: at `surfaces`
  // The work list of the iterative form, and the nodes being traced.
  std::vector<WhittedNode> waiting;
  std::vector<WhittedNode> nodes;
  std::vector<accel::Ray> rays;
  std::vector<accel::Hit> hits;
  std::vector<WhittedFeeler> feelers;
  std::vector<accel::Ray> feeler_rays;
  std::vector<uint8_t> occluded;
};

} // namespace kindling
