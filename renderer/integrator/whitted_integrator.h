// The Whitted tracer: local illumination at every hit, and a tree of mirrored and refracted rays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/whitted_shader.h"

namespace kindling {

// Whitted 1980, "An Improved Illumination Model for Shaded Display", for glTF materials, with the distribution of Cook, Porter and Carpenter
// 1984, "Distributed Ray Tracing". No light is transported from diffuse surface to diffuse surface: ambient light stands for it.
//
// A tree is walked by recursion or by a work list. Both give the same bits: what is drawn depends on the place in the tree, single and
// batched queries of an accelerator agree, and the sums of a sample do not depend on the order of their terms.
class WhittedIntegrator final : public Integrator {
 public:
  WhittedIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                    const Sampler& sampler, const PixelFilter& filter, AovSet aovs);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  void render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                    Film& film) const override;

 private:
  struct Sink;
  struct RecursiveSink;
  struct IterativeSink;

  void start_batch(const PixelRect& block, const SampleRange& samples, size_t count, WhittedContext& context) const;
  [[nodiscard]] WhittedNode root(size_t slot, const WhittedContext& context) const;
  // The node's light is dimmed by the medium that its ray went through; true: it has met something to shade.
  bool arrive(WhittedNode& node, const accel::Hit& hit, WhittedContext& context) const;
  // Point, spot and directional lights with a size that the node's ray has met.
  void add_shapes(const WhittedNode& node, const accel::Hit& hit, WhittedContext& context) const;
  [[nodiscard]] RayFootprint footprint_of(const WhittedNode& node, const accel::Hit& hit) const;

  // One node after the other: the program's stack remembers what is left to do.
  void trace_recursively(WhittedNode& node, WhittedContext& context) const;
  // The nodes of all trees of the wave, batch by batch.
  void trace_iteratively(WhittedContext& context) const;
  void trace_batch(size_t count, WhittedContext& context) const;
  void trace_feelers(WhittedContext& context) const;
  void finish_batch(size_t count, WhittedContext& context, Film& film) const;

  IntegratorSettings settings_;
  const World& world_;
  const Camera& camera_;
  Sampler sampler_;
  PixelFilter filter_;
  float sample_width_; // of the cone of a sample, relative to its pixel's
  AovSet aovs_;
  WhittedShader shader_;
};

} // namespace kindling
