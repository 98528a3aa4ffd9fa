// A scene for Python: owns what an accelerator borrows, and traces arrays of rays with all threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/all_hits.h"
#include "accel/make_accelerator.h"
#include "renderer/python/strided_array.h"

#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kindling::python {

// Arrays of rays, borrowed. `count` rays; arrays with one row stand for all.
struct RayArrays {
  Floats origins, directions, t_min, t_max;
  size_t count = 0;

  // Sets `packed` to the rays from `first` on.
  void pack(size_t first, std::span<accel::Ray> packed) const;
};

// Returns the rays. Raises ValueError if the numbers of rows differ.
[[nodiscard]] RayArrays ray_arrays(const Array& origins, const Array& directions, const Array& t_min,
                                   const Array& t_max);

class TracedScene {
 public:
  struct Placement {
    uint32_t mesh = 0;
    Imath::M44f object_to_world;
  };

  // Adds a mesh; copies the arrays. Raises ValueError for indices out of range.
  void add_mesh(const Array& vertices, const Array& faces);
  void add_instance(const Placement& placement);
  // Builds the accelerator over everything added; `threads` 0: all. Call once, without the GIL.
  void build(accel::Kind kind, accel::Quality quality, bool robust, int threads);

  [[nodiscard]] size_t mesh_count() const { return meshes_.size(); }
  [[nodiscard]] const accel::Accelerator& accelerator() const { return *accelerator_; }

  // Calls done(first ray, hits) for blocks of rays, from any thread.
  void intersect(const RayArrays& rays, int threads,
                 const std::function<void(size_t, std::span<const accel::Hit>)>& done) const;
  // Sets blocked[i] to 1 if ray i hits anything, else to 0.
  void occluded(const RayArrays& rays, int threads, uint8_t* blocked) const;
  [[nodiscard]] accel::CrossingLists all_hits(const RayArrays& rays, size_t limit, int threads) const;

 private:
  struct Mesh {
    std::vector<Imath::V3f> positions; // with 16 bytes of padding in its capacity
    std::vector<uint32_t> indices;
  };

  accel::Kind kind_ = accel::Kind::kdtree;
  std::deque<Mesh> meshes_;
  std::vector<accel::TriangleMesh> views_;
  std::vector<accel::MeshGroup> groups_;
  std::vector<accel::Instance> instances_;
  std::unique_ptr<accel::Accelerator> accelerator_;
};

// Calls f(first, count) for blocks of `total` rays, by so many threads; 0: all.
void for_blocks(size_t total, int threads, const std::function<void(size_t, size_t)>& f);

// Returns true if the rays begin near each other and point almost the same way, so that they are
// traced together faster.
[[nodiscard]] bool are_coherent(std::span<const accel::Ray> rays);

} // namespace kindling::python
