// The whole contract of an accelerator: what it is built from, what a ray asks, and what it answers.
//
// A library of its own: nothing under renderer/ is included here. Implementations: brute_force.h (the oracle),
// embree/embree_accelerator.h and kdtree/kdtree_accelerator.h; make_accelerator.h picks one by name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/simd_target.h"

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImathVec.h>

#include <atomic>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kindling::accel {

inline constexpr uint32_t kNoId = 0xffffffffU;

// 48 bytes: three SIMD-loadable quadwords. The direction need not be unit: t counts in lengths of it.
// Origin and direction must be finite (below 1.8e18) and the direction not zero, or the ray is a miss, as it is if t_min or t_max
// is NaN. t_min below 0 counts as 0. Ends are exact up to rounding in the distance of the triangle.
struct alignas(16) Ray {
  Imath::V3f origin;
  float t_min = 0.0f;
  Imath::V3f direction;
  float t_max = 0.0f; // hits are accepted in (t_min, t_max]
  uint32_t key = 0;   // opaque to the accelerator, for the hit filter: e.g. a hash of pixel and bounce
  float time = 0.0f;  // in [0, 1] over the shutter
  uint32_t index = 0; // opaque to the accelerator, for the hit filter: e.g. the number of the sample
  uint32_t flags = 0; // opaque to the accelerator, for the hit filter
};
static_assert(sizeof(Ray) == 48);

// Barycentric coordinates: p = (1 - u - v) p0 + u p1 + v p2.
struct Hit {
  float t = 0.0f; // valid only if is_hit()
  float u = 0.0f;
  float v = 0.0f;
  uint32_t instance = kNoId; // index into BuildInput::instances; kNoId: no hit
  uint32_t mesh = kNoId;     // index into BuildInput::meshes
  uint32_t triangle = kNoId; // index of the triangle in its mesh

  [[nodiscard]] bool is_hit() const { return instance != kNoId; }
};
static_assert(sizeof(Hit) == 24);

// Decides whether a candidate hit counts (cut-outs). Called only for meshes that are not opaque, during traversal, in any
// order and possibly more than once for one candidate: the answer must depend on its arguments alone, and not on ray.t_max, which may
// have been narrowed. Thread-safe.
struct HitFilter {
  bool (*accept)(const void* context, const Ray& ray, const Hit& candidate) = nullptr;
  const void* context = nullptr; // must outlive the accelerator
};

// Motion over the shutter is given by keys: state k of n is the one at time k / (n - 1), and between two keys coordinates, or the
// entries of a matrix, are interpolated linearly. Who wants a rotation to look round gives enough keys.
inline constexpr size_t kMaxMotionKeys = 129;

// One indexed triangle mesh in its own space. Arrays are borrowed and must outlive the accelerator; at least 16 bytes
// after the last position must be readable (Embree loads positions as quadwords).
// Triangles with a non-finite vertex (or a coordinate beyond 1.8e18) or no area are never hit. Where coordinates exceed about 5e12,
// products of three of them overflow, and hits may be told at an infinite distance.
struct TriangleMesh {
  std::span<const Imath::V3f> positions;
  std::span<const uint32_t> indices; // three per triangle, each < positions.size()
  bool opaque = true;                // false: the hit filter is asked
  // Deformation: `positions` are those of key 0, these are the ones of the later keys, each as many and padded likewise; empty: still.
  // A triangle with a vertex that is not finite (see above) at any key is never hit; where it has no area at a time, it is not hit then.
  std::span<const std::span<const Imath::V3f>> later_positions;
  // Not 0: a later build will have the mesh again, and this number says that it is the same one: the same arrays, untouched and in the
  // same place. Structures over such meshes alone are kept for it (PersistentStructures); under identity transforms they are traced apart from
  // other meshes, which costs rays that come near both. Without meaning where the mesh deforms.
  uint64_t lasting = 0;

  [[nodiscard]] size_t triangle_count() const { return indices.size() / 3; }
};

// Meshes that move together: [first_mesh, first_mesh + mesh_count) of BuildInput::meshes.
struct MeshGroup {
  uint32_t first_mesh = 0;
  uint32_t mesh_count = 0;
};

// A group placed in the world. Row-vector convention: p_world = p_object * object_to_world; affine. If it is not invertible,
// nothing of the instance is ever hit.
// An exact identity costs nothing: its triangles are traced in world space without a second level.
struct Instance {
  uint32_t group = 0;
  Imath::M44f object_to_world; // of a moving one: at key 0
  uint32_t motion = kNoId;     // index into BuildInput::motions; kNoId: still
};

// Borrowed instances, one after the other or as parts of larger records, so that a caller needs no second array of them.
class InstanceList {
 public:
  InstanceList() = default;
  InstanceList(std::span<const Instance> instances) : InstanceList(instances.data(), instances.size()) {}
  // T: Instance, or a record that begins with it.
  template <std::derived_from<Instance> T>
  InstanceList(const std::vector<T>& records) : InstanceList(records.data(), records.size()) {}
  template <std::derived_from<Instance> T>
  InstanceList(const T* first, size_t size)
      : first_(reinterpret_cast<const std::byte*>(static_cast<const Instance*>(first))), size_(size),
        stride_(sizeof(T)) {}

  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] const Instance& operator[](size_t i) const {
    return *reinterpret_cast<const Instance*>(first_ + i * stride_);
  }

 private:
  const std::byte* first_ = nullptr;
  size_t size_ = 0;
  size_t stride_ = sizeof(Instance);
};

struct BuildInput {
  std::span<const TriangleMesh> meshes;
  std::span<const MeshGroup> groups;
  InstanceList instances;
  // Matrices of moving instances by key, 2 to kMaxMotionKeys. Where the interpolated one is not invertible nothing is hit; if a key
  // is not finite, nothing of the instance is ever hit.
  std::span<const std::span<const Imath::M44f>> motions;
  HitFilter filter; // may be null if all meshes are opaque
};

enum class Kind { brute_force, embree, kdtree };
enum class Quality { fast, balanced, best };

struct BuildOptions {
  Quality quality = Quality::balanced;
  // Instruction set of the kernels; unset: the best that the processor runs. The kd-tree takes one of simd_targets(), Embree one of
  // embree_simd_targets(); brute force has no such choice.
  std::optional<SimdTarget> simd;
  bool robust = true;                        // watertight at the price of some speed (Embree: RTC_SCENE_FLAG_ROBUST)
  const std::atomic<bool>* cancel = nullptr; // polled; a cancelled build returns null
  std::function<void(double)> on_progress;   // fraction done in [0, 1]; called from any one thread at a time
};

// What a build cost and made; for reports.
struct Statistics {
  double build_s = 0.0;
  size_t memory_bytes = 0; // held by the accelerator, without the borrowed arrays
  size_t triangle_count = 0;
  size_t built_triangle_count =
      0; // of the structures that were built, each once; those of PersistentStructures were not
  size_t instance_count = 0;
  size_t node_count = 0; // 0 where the library does not tell
  size_t leaf_count = 0;
  size_t reference_count = 0;     // triangle references in leaves
  std::vector<size_t> leaf_sizes; // leaf_sizes[n]: leaves with n references; empty where the library does not tell
  SimdTarget simd = SimdTarget::portable; // of the kernels that answer
};

// What a ray visits.
struct TraversalCost {
  uint32_t nodes = 0;
  uint32_t leaves = 0;
  uint32_t triangles = 0; // tested
};

// What one accelerator leaves to the next: its structures over meshes that last. They are of use to builds of the same kind, quality and
// robustness alone. Borrows the arrays of these meshes. Brute force has none.
class PersistentStructures {
 public:
  virtual ~PersistentStructures() = default;
};

// Immutable once built; every query is thread-safe. Batch queries answer each ray exactly as the single query does,
// whatever else is in the batch, so that images do not depend on how rays were grouped.
class Accelerator {
 public:
  virtual ~Accelerator() = default;

  // Nearest hit in (t_min, t_max], or a Hit with instance kNoId.
  [[nodiscard]] virtual Hit intersect(const Ray& ray) const = 0;
  // Whether anything is hit in (t_min, t_max].
  [[nodiscard]] virtual bool occluded(const Ray& ray) const = 0;

  // The same for hits.size() == rays.size() rays in any order and direction (streams of mixed rays).
  virtual void intersect(std::span<const Ray> rays, std::span<Hit> hits) const = 0;
  // occluded[i] = 1 if ray i is blocked, else 0.
  virtual void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const = 0;

  // The same for rays that start close together and point almost the same way (camera rays of a tile). The one exception to the
  // rule above: the answer may differ from the single query's by rounding, and in which of several triangles at the same distance
  // is named; it is the same whenever the same rays come in the same order. Group rays by fixed blocks of the image.
  virtual void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const { intersect(rays, hits); }
  // The same for any hit, with the same exception: shadow rays from a tile's first surfaces to one light. Where a ray meets an edge
  // within rounding, whether it is blocked may differ from the single query's answer.
  virtual void occluded_coherent(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
    this->occluded(rays, occluded);
  }

  // What the single query visits; nullopt where the library does not tell. Slow: for reports.
  [[nodiscard]] virtual std::optional<TraversalCost> traversal_cost(const Ray& /*ray*/, bool /*any_hit*/) const {
    return std::nullopt;
  }

  // World bounds of all that can be hit; empty if nothing can.
  [[nodiscard]] virtual Imath::Box3f bounds() const = 0;
  [[nodiscard]] virtual Statistics statistics() const = 0;

  // For a later build; null if there are none. Nothing may be asked of the accelerator any more.
  [[nodiscard]] virtual std::unique_ptr<PersistentStructures> take_structures() { return nullptr; }
};

} // namespace kindling::accel
