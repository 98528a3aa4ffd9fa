// Unidirectional, batched path tracer with multiple importance sampling of lights and BSDFs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/first_hits.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/manifolds/manifolds.h"
#include "renderer/integrator/path_context.h"
#include "renderer/integrator/photons/photon_maps.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/world/light_groups/light_groups.h"

#include <memory>

namespace kindling {

// Returns the stages of the paths of a camera; `guide` may be null. They refer to all arguments but
// the settings and the sampler.
[[nodiscard]] PathStages make_path_stages(const IntegratorSettings& settings, const World& world, const Camera& camera,
                                          const Sampler& sampler, const Guide* guide);
// Returns the table for PathStages::presampled; null if the paths are to draw their samples of the
// environment.
[[nodiscard]] std::unique_ptr<const PresampledEnvironment>
presample_environment(const IntegratorSettings& settings, const LightSetView& lights, uint32_t seed);

// Estimates the rendering equation (Kajiya 1986) with next-event estimation and the power heuristic
// (Veach 1997, section 9.2). Unbiased up to the bounce limits, as long as no clamp is set, caustics
// are full and no photons are gathered. What happens to a path is in stages/; this class leads
// batches of them.
class PathIntegrator final : public Integrator {
 public:
  PathIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera, const Sampler& sampler,
                 const PixelFilter& filter, AovSet aovs, const Guide* guide = nullptr, const AovInputs& inputs = {});

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  [[nodiscard]] std::unique_ptr<PathContext> make_path_context() const; // the same, for callers that set its recorder
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;
  uint32_t render_levels(const PixelRect& block, const SampleRange& levels, const SampleRates& rates,
                         ThreadContext& context, Film& film) const override;
  [[nodiscard]] uint32_t samples_per_pass() const override {
    return photon_maps_ ? photon_maps_->samples_per_pass() : Integrator::samples_per_pass();
  }
  [[nodiscard]] uint64_t paths_together() const override { return stages_.settings.batch_size; }
  void render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const override;

 private:
  // Returns the pixels whose paths are followed for a block: the whole block if they are shared.
  [[nodiscard]] PixelRect followed_block(const PixelRect& block, const PathContext& context) const {
    return context.reuses() ? whole_block(block, camera_.size_px()) : block;
  }
  // Takes the photon maps of these samples. False if the World was abandoned.
  [[nodiscard]] bool take_photons(const SampleRange& samples, PathContext& context) const;
  // Renders these samples of all blocks, which fit into a batch. False if the World was abandoned:
  // then none has been added to the film.
  bool render_batch(std::span<const PixelRect> blocks, const SampleRange& samples, PathContext& context,
                    Film& film) const;
  // The loops over a batch, in the order in which they run.
  void start_batch(std::span<const PixelRect> blocks, const SampleRange& samples, PathContext& context) const;
  void start_listed(const PixelRect& block, PathContext& context) const;
  void start_paths(size_t count, PathContext& context) const; // whose camera samples and rays are there
  void trace_camera_rays(std::span<const PixelRect> blocks, const SampleRange& samples, PathContext& context) const;
  void trace_together(PathContext& context) const; // the camera rays, whatever blocks they belong to
  void shade(PathContext& context) const;
  void shade_split(PathContext& context) const; // the same with SplittingSink (split_paths.cpp)
  // `first_surfaces`: of the paths, which have several light samples each if any have.
  void trace_shadows(PathContext& context, bool first_surfaces) const;
  void trace_bounces(PathContext& context) const;
  // Joins the paths of a batch of whole blocks, which have ended, to those of other pixels.
  void share_paths(std::span<const PixelRect> blocks, const SampleRange& samples, size_t path_count,
                   PathContext& context) const;
  // Adds the samples of these blocks to the film.
  void finish_batch(std::span<const PixelRect> blocks, size_t path_count, PathContext& context, Film& film) const;
  void follow(PathContext& context) const; // from the first hits to the end of all paths
  // Follows the samples that catchers have caught in the scene without what shades them.
  void follow_caught(std::span<const PixelRect> blocks, const SampleRange& samples, PathContext& context) const;

  // Steps of shade(), for the active paths [first, first + count) or [first, end).
  void prepare_group(size_t first, size_t count, PathContext& context) const;
  size_t draw_for_group(size_t first, size_t count, PathContext& context) const;
  void draw_reflections(size_t first, size_t reflecting, PathContext& context) const;
  void sample_lights(size_t first, size_t count, PathContext& context) const;
  template <typename Sink>
  void shade_group(size_t first, size_t end, PathContext& context, Sink& sink) const;
  void tint_shadows(PathContext& context) const; // of trace_shadows()
  void split_shadows(PathContext& context) const;
  static void note_first_hits(size_t first, size_t end, PathContext& context);

  PathStages stages_;
  const World& world_;
  const accel::Accelerator* accelerator_; // the World's, or that of catchers alone
  const Camera& camera_;
  Sampler sampler_;
  PixelFilter filter_;
  AovSet aovs_;
  std::unique_ptr<const PresampledEnvironment> presampled_; // of stages_; null: there is none
  LightGroups light_groups_;                                // none: not split by them
  LightGroupsView groups_;                                  // theirs
  FirstHits first_hits_;
  std::unique_ptr<const Manifolds> manifolds_; // null: no manifold sampling
  std::unique_ptr<LightPaths> light_paths_;    // null: none are traced
  std::unique_ptr<PhotonMaps> photon_maps_;    // null: no photons are gathered
  const ShadowCatchers* catchers_ = nullptr;   // only with Aov::shadow_catcher
  std::unique_ptr<PathIntegrator> unshaded_;   // of the scene without what shades them
};

} // namespace kindling
