// The accelerator interface: rays and hits, build input and options, batch queries, statistics.
//
// This library includes nothing under renderer/. Implementations: brute_force.h (the oracle),
// embree/embree_accelerator.h and kdtree/kdtree_accelerator.h; make_accelerator.h picks one by
// name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "accel/simd_target.h"

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImathVec.h>

#include <atomic>
#include <cassert>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kindling::accel {

// Decides whether a candidate hit counts (cut-outs). Called only for meshes that are not opaque,
// during traversal, in any order and possibly more than once for one candidate. The answer must
// depend on the arguments alone, but not on ray.t_max, which traversal narrows. Thread-safe.
struct HitFilter {
  bool (*accept)(const void* context, const Ray& ray, const Hit& candidate) = nullptr;
  const void* context = nullptr; // must outlive the accelerator
  // Polled by queries, between instances and between the rays of a batch: once it is set, they
  // return soon, with answers that mean nothing. Null: queries cannot be ended. Must outlive the
  // accelerator.
  const std::atomic<bool>* abandon = nullptr;

  [[nodiscard]] bool abandoned() const { return abandon != nullptr && abandon->load(std::memory_order_relaxed); }
};

// Motion over the shutter is given by keys: key k of n holds the state at time k / (n - 1). Between
// two keys, coordinates or matrix entries are interpolated linearly. A rotation needs enough keys
// to look round.
inline constexpr size_t kMaxMotionKeys = 129;

// An indexed triangle mesh in its own space. Arrays are borrowed and must outlive the accelerator.
// At least 16 bytes after the last position must be readable, because Embree loads positions as
// quadwords. Triangles without area, or with a vertex that is not finite (or has a coordinate
// beyond 1.8e18), are never hit. Where coordinates exceed about 5e12, products of three of them
// overflow, and hits may be reported at an infinite distance.
struct TriangleMesh {
  std::span<const Imath::V3f> positions;
  std::span<const uint32_t> indices; // three per triangle, each less than positions.size()
  bool opaque = true;                // false: the hit filter decides
  // Deformation: `positions` holds key 0 and these spans the later keys, each of the same size and
  // padded likewise. Empty for a static mesh. A triangle with a vertex that is not finite at any
  // key is never hit; where it has no area at some time, it is not hit at that time.
  std::span<const std::span<const Imath::V3f>> later_positions;
  // Identifies a mesh across builds: a later build with the same nonzero number has the same
  // arrays, unchanged and at the same addresses. 0 for a mesh of this build alone. Structures over
  // such meshes alone are persistent (PersistentStructures); under identity transforms they are
  // traced apart from other meshes, which costs time for rays that come near both. Ignored for
  // meshes that deform.
  uint64_t persistent_id = 0;

  [[nodiscard]] size_t triangle_count() const { return indices.size() / 3; }
};

// Meshes that share a transform: [first_mesh, first_mesh + mesh_count) of BuildInput::meshes.
struct MeshGroup {
  uint32_t first_mesh = 0;
  uint32_t mesh_count = 0;
};

// A group placed in the world by an affine matrix. Row-vector convention: p_world = p_object *
// object_to_world. If the matrix is not invertible, nothing of the instance is ever hit. An exact
// identity is free: its triangles are traced in world space without a second level.
struct Instance {
  uint32_t group = 0;
  Imath::M44f object_to_world; // for a moving instance, the matrix at key 0
  uint32_t motion = kNoId;     // kNoId: static
};

// A borrowed array of instances, contiguous or embedded in larger records, so that a caller needs
// no second array.
class InstanceList {
 public:
  InstanceList() = default;
  InstanceList(std::span<const Instance> instances) : InstanceList(instances.data(), instances.size()) {}
  // T is Instance or a record that begins with it.
  template <std::derived_from<Instance> T>
  InstanceList(const std::vector<T>& records) : InstanceList(records.data(), records.size()) {}
  template <std::derived_from<Instance> T>
  InstanceList(const T* first, size_t size)
      : first_(reinterpret_cast<const std::byte*>(static_cast<const Instance*>(first))), size_(size),
        stride_(sizeof(T)) {}

  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] const Instance& operator[](size_t i) const {
    assert(i < size_);
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
  // Matrices of moving instances by key, 2 to kMaxMotionKeys of them. Nothing is hit at times when
  // the interpolated matrix is not invertible; if a key is not finite, nothing of the instance is
  // ever hit.
  std::span<const std::span<const Imath::M44f>> motions;
  HitFilter filter; // its function may be null if all meshes are opaque
};

enum class Kind { brute_force, embree, kdtree };
enum class Quality { fast, balanced, best };

struct BuildOptions {
  Quality quality = Quality::balanced;
  // Instruction set of the kernels; if unset, the best one that the processor supports. The kd-tree
  // accepts simd_targets(), Embree embree_simd_targets(); brute force ignores it.
  std::optional<SimdTarget> simd;
  bool robust = true; // watertight at some cost in speed (Embree: RTC_SCENE_FLAG_ROBUST)
  // Prepares all_hits(). Only Embree needs it: it then calls back for every triangle that a ray
  // meets, and keeps the instances' matrices.
  bool all_hits = false;
  const std::atomic<bool>* cancel = nullptr; // polled often; a cancelled build returns null
  std::function<void(double)> on_progress;   // fraction done in [0, 1]; called from any one thread at a time
};

// The cost and result of a build, for reports.
struct Statistics {
  double build_s = 0.0;
  size_t memory_bytes = 0; // held by the accelerator, without borrowed arrays
  size_t triangle_count = 0;
  // Triangles in structures built this time, each counted once; persistent structures are left out.
  size_t built_triangle_count = 0;
  size_t instance_count = 0;
  size_t node_count = 0; // 0 if the library does not report it
  size_t leaf_count = 0;
  size_t reference_count = 0;             // triangle references in leaves
  std::vector<size_t> leaf_sizes;         // leaf_sizes[n]: number of leaves with n references; empty if not reported
  SimdTarget simd = SimdTarget::portable; // instruction set of the kernels in use
};

// A place where a ray passes through a surface.
struct Crossing {
  Hit hit;
  // The ray meets the side from which the corners run counter-clockwise, in the space of the mesh:
  // it enters a closed mesh with outward normals, mirrored instances included.
  bool front = false;

  bool operator==(const Crossing& other) const = default;
};
inline constexpr size_t kNoLimit = static_cast<size_t>(-1);

// The nodes, leaves and triangles that a ray visits.
struct TraversalCost {
  uint32_t nodes = 0;
  uint32_t leaves = 0;
  uint32_t triangles = 0; // tested
};

// Structures over persistent meshes that one accelerator leaves to the next build. Only builds of
// the same kind, quality and robustness can use them. Borrows the arrays of these meshes. Brute
// force has none.
class PersistentStructures {
 public:
  virtual ~PersistentStructures() = default;
};

// Immutable once built; every query is thread-safe. Batch queries answer each ray exactly as the
// single query does, whatever else is in the batch, so that images do not depend on how rays are
// grouped.
class Accelerator {
 public:
  virtual ~Accelerator() = default;

  // Returns the nearest hit in (t_min, t_max], or a Hit with instance kNoId.
  [[nodiscard]] virtual Hit intersect(const Ray& ray) const = 0;
  // Returns true if anything is hit in (t_min, t_max].
  [[nodiscard]] virtual bool occluded(const Ray& ray) const = 0;

  // Batch versions for mixed rays in any order and direction; the spans have equal sizes.
  virtual void intersect(std::span<const Ray> rays, std::span<Hit> hits) const = 0;
  // Sets occluded[i] to 1 if ray i is blocked, else to 0.
  virtual void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const = 0;

  // Batch version for rays that start close together and point almost the same way (camera rays of
  // a tile). Embree is the one exception to the rule above: its answer may differ from the single
  // query's by rounding, and in which of several triangles at the same distance is reported. It is
  // the same whenever the same rays come in the same order, so group rays by fixed blocks of the
  // image.
  virtual void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const { intersect(rays, hits); }
  // Returns whether that exception does not apply, so that groups may be of any kind.
  [[nodiscard]] virtual bool coherent_equals_single() const { return true; }
  // Any-hit version with the same exception: shadow rays from a tile's first surfaces to one light.
  virtual void occluded_coherent(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
    this->occluded(rays, occluded);
  }

  // Replaces `crossings` by the nearest `limit` crossings of surfaces in (t_min, t_max], by
  // distance, at equal distances by ids. A hit at an edge or a vertex may belong to several
  // triangles, but each surface is crossed once: those triangles count that a ray beside this one
  // would cross, displaced by an infinitesimal amount that is the same for all (crosses_sheared()
  // in triangle.h). So a line crosses a closed mesh an even number of times, as often at the front
  // as at the back. Returns false, and no crossing, if the accelerator cannot answer
  // (BuildOptions::all_hits). Allocates nothing but elements of `crossings`. all_hits.h has a
  // version for many rays.
  [[nodiscard]] virtual bool all_hits(const Ray& /*ray*/, size_t /*limit*/, std::vector<Crossing>& crossings) const {
    crossings.clear();
    return false;
  }

  // Returns the cost of the single query, or nullopt if the library does not report it. Slow; for
  // reports.
  [[nodiscard]] virtual std::optional<TraversalCost> traversal_cost(const Ray& /*ray*/, bool /*any_hit*/) const {
    return std::nullopt;
  }

  // World bounds of everything that can be hit; empty if nothing can.
  [[nodiscard]] virtual Imath::Box3f bounds() const = 0;
  [[nodiscard]] virtual Statistics statistics() const = 0;

  // Hands persistent structures over to a later build; null if there are none. The accelerator must
  // not be queried afterwards.
  [[nodiscard]] virtual std::unique_ptr<PersistentStructures> take_structures() { return nullptr; }
};

} // namespace kindling::accel
