// Every crossing of a ray: Embree finds candidates, the library's own triangle test decides.
//
// Embree's robust test rounds edge functions, so of the triangles at an edge it may report all or
// none. Each candidate is therefore tested again by triangle.h, which makes the answer that of the
// other accelerators, bit for bit, unless Embree has missed the triangle.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/affine.h"
#include "accel/crossing_collector.h"
#include "accel/triangle.h"

#include <vector>

namespace kindling::accel::embree {

// The triangles and instances of a scene, for the second test.
class CrossingScene {
 public:
  explicit CrossingScene(const BuildInput& input);

  // Transforms a world ray into the space of an instance; returns false if it misses by definition.
  [[nodiscard]] bool to_object(const Ray& world, uint32_t instance, Ray& inside) const;
  // Tests the triangle of `hit`, whose ids are set, against a ray in its space; sets the rest.
  [[nodiscard]] bool cross(const Ray& inside, const RayShear& shear, float t_far, Crossing& crossing) const;
  [[nodiscard]] bool accepts(const Ray& world, const Hit& hit) const;
  [[nodiscard]] size_t memory_bytes() const;

 private:
  struct Placed {
    bool identity = false;
    RayToObject to_object;
    std::vector<Imath::M44f> keys; // of a moving instance
  };

  std::vector<TriangleMesh> meshes_;
  std::vector<Placed> placed_; // by instance
  HitFilter filter_;
};

// The crossings of one world ray, which must satisfy can_hit() and outlive this.
class Crossings {
 public:
  Crossings(const CrossingScene& scene, const Ray& world, size_t limit, std::vector<Crossing>& crossings)
      : scene_(scene), world_(world), collector_(crossings, limit, world.t_max) {}

  // Takes the ids of a candidate; its distance and coordinates are not read.
  void test(const Hit& candidate);
  void finish() { collector_.finish(); }

 private:
  const CrossingScene& scene_;
  const Ray& world_;
  CrossingCollector collector_;
  uint32_t instance_ = kNoId; // to which the next three belong
  bool meets_instance_ = false;
  Ray inside_;
  RayShear shear_;
};

} // namespace kindling::accel::embree
