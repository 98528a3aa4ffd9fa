// The Whitted tracer: local illumination at every hit, and a tree of reflected and refracted rays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/first_hits.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/whitted_shader.h"
#include "renderer/light/per_light_sampling.h"

#include <memory>

namespace kindling {

class WhittedContext;

// Whitted 1980, "An Improved Illumination Model for Shaded Display", for glTF materials, with the
// distribution of Cook, Porter and Carpenter 1984, "Distributed Ray Tracing". Ambient light
// replaces light transport between diffuse surfaces.
//
// A tree is traversed by recursion or by a work list. Both give the same bits: random numbers
// depend on the place in the tree, single and batched queries of an accelerator agree, and the sums
// of a sample do not depend on their order.
class WhittedIntegrator final : public Integrator {
 public:
  WhittedIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                    const Sampler& sampler, const PixelFilter& filter, AovSet aovs, const AovInputs& inputs);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;

 private:
  struct Sink;
  struct RecursiveSink;
  struct IterativeSink;

  void start_batch(const PixelRect& block, const SampleRange& samples, size_t count, WhittedContext& context) const;
  // Depth first, one node at a time, on the program's stack.
  void trace_recursively(WhittedNode& node, WhittedContext& context) const;
  // Traces the nodes of all trees of the batch, many at a time.
  void trace_iteratively(WhittedContext& context) const;
  void trace_batch(size_t count, WhittedContext& context) const;
  void trace_feelers(WhittedContext& context) const;
  [[nodiscard]] Rgb through_thin_walls(const accel::Ray& feeler, WhittedContext& context) const;
  void finish_batch(size_t count, WhittedContext& context, Film& film) const;

  IntegratorSettings settings_;
  const World& world_;
  const Camera& camera_;
  Sampler sampler_;
  PixelFilter filter_;
  AovSet aovs_;
  FirstHits first_hits_; // without mattes, which would need a part of a sample for each of its surfaces
  PerLightSampling lights_;
  std::unique_ptr<WhittedCache> cache_; // shared by all threads
  WhittedShader shader_;
};

} // namespace kindling
