// The records of the Whitted tracer: a ray of the tree that waits to be traced, and the memory of one thread.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/ray_cone.h"
#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/medium_stack.h"
#include "renderer/integrator/whitted_sum.h"

#include <cstdint>
#include <vector>

namespace kindling {

// A node of the tree of rays of one sample. Where it is in the tree alone decides what is drawn for it.
struct WhittedNode {
  accel::Ray ray; // key: of the sampler, a hash of the place in the tree
  Rgb weight{1.0f};
  uint32_t slot = 0;                // of the sample
  RayCone cone{.spread = -1.0f};    // spread below 0: as the camera has it
  float wavelength_nm = 0.0f;       // of light that was dispersed; 0: all of it
  uint8_t depth = 1;                // rays in a row, this one included, what goes straight through coverage not
  uint8_t reflections = 0;          // among them
  uint8_t transparent_surfaces = 0; // passed in a row
  bool seen = true;                 // by the camera, itself or through what it passes straight
  bool split = false;               // into strata, at a rough mirror or rough glass before
  bool in_medium = false;           // `media` is not empty; else it is not up to date
  MediumStack media;
};
static_assert(sizeof(WhittedNode) == 128);

// What a sample has gathered. Sums that do not depend on the order of their terms: trees may be walked in any.
struct WhittedSample {
  WhittedRgbSum radiance;
  WhittedSum transparency; // 1 - alpha
};
// For AOVs.
struct WhittedComponents {
  WhittedRgbSum emission, direct;
};

// A light sample that waits for its shadow feeler.
struct WhittedFeeler {
  Rgb contribution;
  uint32_t slot = 0;
  bool seen = true; // the surface that it lights, WhittedNode::seen
};

// Sized for a batch; the lists grow with the largest trees met, and keep their memory.
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

  static constexpr size_t kFeelerBatch = 1024; // traced together, once so many wait

  std::vector<CameraSample> camera_samples;  // by slot
  std::vector<accel::Ray> camera_rays;       // likewise
  std::vector<WhittedSample> samples;        // likewise
  std::vector<WhittedComponents> components; // likewise; empty if no AOV needs them
  std::vector<FilmSurface> surfaces;         // likewise
  // The iterative form's work list, and the part of it that is being traced.
  std::vector<WhittedNode> waiting;
  std::vector<WhittedNode> nodes;
  std::vector<accel::Ray> rays;
  std::vector<accel::Hit> hits;
  std::vector<WhittedFeeler> feelers;
  std::vector<accel::Ray> feeler_rays;
  std::vector<uint8_t> occluded;
};

} // namespace kindling
