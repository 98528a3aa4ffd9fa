// Records the rays of a render by kind, with an accelerator that reports its calls.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/progress.h"
#include "renderer/camera/camera.h"
#include "renderer/session/ray_set.h"
#include "renderer/world/world.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace kindling {

// Forwards each query to the accelerator inside and reports it to a listener. Without a listener it
// is as thread-safe as the accelerator inside; with one, only one thread at a time may call it.
class RecordingAccelerator final : public accel::Accelerator {
 public:
  enum class Call { nearest, any_hit, coherent, coherent_any_hit };
  using Listener = std::function<void(Call, std::span<const accel::Ray>)>;

  explicit RecordingAccelerator(std::unique_ptr<accel::Accelerator> inner) : inner_(std::move(inner)) {}

  void listen(Listener listener) { listener_ = std::move(listener); }

  [[nodiscard]] accel::Hit intersect(const accel::Ray& ray) const override;
  [[nodiscard]] bool occluded(const accel::Ray& ray) const override;
  void intersect(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const override;
  void occluded(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const override;
  [[nodiscard]] bool coherent_equals_single() const override { return inner_->coherent_equals_single(); }
  void intersect_coherent(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const override;
  void occluded_coherent(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const override;
  [[nodiscard]] std::optional<accel::TraversalCost> traversal_cost(const accel::Ray& ray, bool any_hit) const override {
    return inner_->traversal_cost(ray, any_hit);
  }
  [[nodiscard]] bool all_hits(const accel::Ray& ray, size_t limit,
                              std::vector<accel::Crossing>& crossings) const override {
    return inner_->all_hits(ray, limit, crossings); // not reported: renders do not ask for it
  }
  [[nodiscard]] Imath::Box3f bounds() const override { return inner_->bounds(); }
  [[nodiscard]] accel::Statistics statistics() const override { return inner_->statistics(); }
  [[nodiscard]] std::unique_ptr<accel::PersistentStructures> take_structures() override {
    return inner_->take_structures();
  }

 private:
  void report(Call call, std::span<const accel::Ray> rays) const {
    if (listener_) listener_(call, rays);
  }

  std::unique_ptr<accel::Accelerator> inner_;
  Listener listener_;
};

struct RecordSettings {
  size_t rays_per_kind = 1 << 18; // maximum; scenes whose rays escape early may give fewer
  uint32_t batch_size = 256;      // of the path tracer, a multiple of 64
  uint32_t seed = 0;
};

// Renders on this thread, with tiles spread evenly over the image, until every kind has its rays or
// no more come. `recorder` must be the accelerator of `world`. Returns these sets, some of which
// may be empty:
//   camera             coherent groups of an 8 x 8 block
//   bounce1, bounce3   rays that leave the first and the third surface of their path, as the path
//                      tracer batches them. A partly transparent surface that a path passes counts
//                      as one
//   bounce1-shuffled   the rays of bounce1 in a random order
//   shadow1, shadow3   any hit: from the first and the third surface to a sampled light
//   ambient-occlusion  any hit: cosine-distributed from the first surface, a tenth of the scene's
//                      diagonal long
// Deterministic. If cancelled, returns the rays recorded so far. `cancel` may be null.
[[nodiscard]] std::vector<RaySet> record_rays(const World& world, RecordingAccelerator& recorder, const Camera& camera,
                                              const RecordSettings& settings, const CancelToken* cancel);

} // namespace kindling
