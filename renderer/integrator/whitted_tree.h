// Records of the Whitted tracer: tree nodes, sample sums, shadow feelers, and the thread context.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/ray_cone.h"
#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/stages/medium_stack.h"
#include "renderer/integrator/whitted_sum.h"

#include <cstdint>
#include <vector>

namespace kindling {

// A node of the ray tree of one sample. Its random numbers depend on its place in the tree alone.
struct WhittedNode {
  accel::Ray ray; // its key is the sampler's, a hash of the node's place in the tree
  Rgb weight{1.0f};
  uint32_t slot = 0;                // of the sample
  RayCone cone{.spread = -1.0f};    // spread below 0: not set yet
  float wavelength_nm = 0.0f;       // set once the light is dispersed; 0: all wavelengths
  uint8_t depth = 1;                // rays in a row with this one; continuations through coverage do not count
  uint8_t reflections = 0;          // among them
  uint8_t transparent_surfaces = 0; // passed in a row
  bool seen = true;                 // a camera ray or its straight continuation
  bool split = false;               // below a rough mirror or rough glass that was split into strata
  bool in_medium = false;           // `media` is valid and not empty
  MediumStack media;
};
static_assert(sizeof(WhittedNode) == 128);

// The sums of a sample. They do not depend on the order of their terms, so trees may be traversed
// in any order.
struct WhittedSample {
  WhittedRgbSum radiance;
  WhittedSum transparency; // 1 - alpha
};
// The sums of a sample's components, for AOVs.
struct WhittedComponents {
  WhittedRgbSum emission, direct;
};

// A light sample whose shadow feeler is not traced yet.
struct WhittedFeeler {
  Rgb contribution;
  uint32_t slot = 0;
  bool seen = true; // WhittedNode::seen of the lit surface
};

// Sized for a batch. The lists grow with the largest trees so far and keep their memory.
class WhittedContext final : public ThreadContext {
 public:
  WhittedContext(size_t batch_size, bool with_surfaces)
      : camera_samples(batch_size), camera_rays(batch_size), samples(batch_size),
        components(with_surfaces ? batch_size : 0), surfaces(with_surfaces ? batch_size : 0), nodes(batch_size),
        rays(batch_size), hits(batch_size) {
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
