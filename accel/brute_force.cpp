// The brute-force accelerator: linear search with the scalar watertight triangle test.
// SPDX-License-Identifier: Apache-2.0
#include "accel/brute_force.h"

#include "accel/affine.h"
#include "accel/crossing_collector.h"
#include "accel/motion.h"
#include "accel/triangle.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace kindling::accel {
namespace {

struct CheckedMesh {
  std::vector<uint32_t> triangles; // those that can be hit
  Imath::Box3f bounds;             // of these triangles, at all times
};

struct PlacedGroup {
  uint32_t instance = 0;
  MeshGroup group;
  bool identity = true;
  RayToObject to_object;
  std::vector<Imath::M44f> keys; // matrices of a moving instance; else empty
};

// Conservative box test: the margin exceeds the rounding errors of the triangle test, which sees
// vertices relative to the ray origin.
bool may_hit(const Imath::Box3f& box, const Ray& ray, float t_max) {
  float extent = 0.0f;
  for (int k = 0; k < 3; ++k)
    extent = std::max({extent, std::fabs(box.min[k] - ray.origin[k]), std::fabs(box.max[k] - ray.origin[k])});
  const double margin = 1e-5 * extent;
  double enter = 0.0, leave = static_cast<double>(t_max) * (1.0 + 1e-5);
  for (int k = 0; k < 3; ++k) {
    const double low = static_cast<double>(box.min[k]) - ray.origin[k] - margin;
    const double high = static_cast<double>(box.max[k]) - ray.origin[k] + margin;
    const double d = ray.direction[k];
    if (d == 0.0) {
      if (low > 0.0 || high < 0.0) return false;
      continue;
    }
    enter = std::max(enter, std::min(low / d, high / d));
    leave = std::min(leave, std::max(low / d, high / d));
  }
  return enter <= leave;
}

class BruteForce final : public Accelerator {
 public:
  BruteForce(const BuildInput& input, const BuildOptions& options)
      : meshes_(input.meshes.begin(), input.meshes.end()), filter_(input.filter) {
    const auto start = std::chrono::steady_clock::now();
    checked_.resize(meshes_.size());
    for (size_t m = 0; m < meshes_.size(); ++m) {
      check(m);
      if (options.on_progress) options.on_progress(static_cast<double>(m + 1) / static_cast<double>(meshes_.size()));
    }
    for (size_t i = 0; i < input.instances.size(); ++i) {
      const Instance& instance = input.instances[i];
      const bool moves = instance.motion != kNoId;
      PlacedGroup placed{static_cast<uint32_t>(i),
                         input.groups[instance.group],
                         !moves && is_identity(instance.object_to_world),
                         {},
                         {}};
      if (moves) {
        const std::span<const Imath::M44f> keys = input.motions[instance.motion];
        if (!is_finite(keys)) continue;
        placed.keys.assign(keys.begin(), keys.end());
      } else if (!placed.to_object.set_inverse_of(instance.object_to_world)) {
        continue;
      }
      for (uint32_t m = 0; m < placed.group.mesh_count; ++m) {
        const CheckedMesh& mesh = checked_[placed.group.first_mesh + m];
        statistics_.triangle_count += mesh.triangles.size();
        bounds_.extendBy(moves             ? transform_bounds(placed.keys, mesh.bounds)
                         : placed.identity ? mesh.bounds
                                           : transform_bounds(instance.object_to_world, mesh.bounds));
      }
      placed_.push_back(std::move(placed));
    }
    statistics_.instance_count = input.instances.size();
    statistics_.memory_bytes = placed_.capacity() * sizeof(PlacedGroup) + checked_.capacity() * sizeof(CheckedMesh);
    for (const PlacedGroup& placed : placed_) statistics_.memory_bytes += placed.keys.capacity() * sizeof(Imath::M44f);
    for (const CheckedMesh& mesh : checked_) {
      statistics_.memory_bytes += mesh.triangles.capacity() * sizeof(uint32_t);
      statistics_.built_triangle_count += mesh.triangles.size();
    }
    statistics_.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  [[nodiscard]] Hit intersect(const Ray& ray) const override { return trace<false>(ray); }
  [[nodiscard]] bool occluded(const Ray& ray) const override { return trace<true>(ray).is_hit(); }
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    assert(hits.size() == rays.size());
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = trace<false>(rays[i]);
  }
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    assert(blocked.size() == rays.size());
    for (size_t i = 0; i < rays.size(); ++i) blocked[i] = trace<true>(rays[i]).is_hit() ? 1 : 0;
  }
  [[nodiscard]] bool all_hits(const Ray& ray, size_t limit, std::vector<Crossing>& crossings) const override {
    CrossingCollector collector(crossings, limit, std::min(ray.t_max, std::numeric_limits<float>::max()));
    visit_triangles(
        ray, collector.t_far(), [&](const RayShear& shear, const ShearedTriangle& seen, float t_min, Hit hit) {
          bool front = false;
          if (intersect_sheared(seen.a, seen.b, seen.c, shear.sz, t_min, collector.t_far(), hit.t, hit.u, hit.v) &&
              crosses_sheared(seen.a, seen.b, seen.c, shear.sz, front) && accepts(ray, hit))
            collector.add({hit, front});
          return false;
        });
    collector.finish();
    return true;
  }
  [[nodiscard]] Imath::Box3f bounds() const override { return bounds_; }
  [[nodiscard]] Statistics statistics() const override { return statistics_; }

 private:
  void check(size_t m) {
    const TriangleMesh& mesh = meshes_[m];
    CheckedMesh& checked = checked_[m];
    for (size_t i = 0; i < mesh.triangle_count(); ++i) {
      const uint32_t* corner = &mesh.indices[3 * i];
      Imath::Box3f bounds;
      bool finite = true;
      for (uint32_t key = 0; key < key_count(mesh); ++key)
        for (int k = 0; k < 3; ++k) {
          const Imath::V3f& p = positions_at_key(mesh, key)[corner[k]];
          finite = finite && is_finite(p);
          bounds.extendBy(p);
        }
      if (!finite) continue;
      if (!deforms(mesh) &&
          !can_be_hit(mesh.positions[corner[0]], mesh.positions[corner[1]], mesh.positions[corner[2]]))
        continue;
      checked.triangles.push_back(static_cast<uint32_t>(i));
      checked.bounds.extendBy(bounds);
    }
  }

  template <bool kAny>
  Hit trace(const Ray& world) const {
    Hit best;
    float t_max = std::min(world.t_max, std::numeric_limits<float>::max());
    visit_triangles(world, t_max, [&](const RayShear& shear, const ShearedTriangle& seen, float t_min, Hit hit) {
      if (!intersect_sheared(seen.a, seen.b, seen.c, shear.sz, t_min, t_max, hit.t, hit.u, hit.v)) return false;
      if (best.is_hit() && hit.t == best.t) return false; // a tie: the earlier triangle has the smaller ids
      if (!accepts(world, hit)) return false;
      best = hit;
      t_max = hit.t;
      return kAny;
    });
    return best;
  }

  struct ShearedTriangle {
    ShearedCorner a, b, c;
  };

  [[nodiscard]] bool accepts(const Ray& world, const Hit& hit) const {
    return meshes_[hit.mesh].opaque || filter_.accept == nullptr || filter_.accept(filter_.context, world, hit);
  }

  // Calls visit(shear, triangle, t_min, ids) for the triangles that the ray may hit up to t_max,
  // which visit may narrow, by rising ids; ends when visit returns true.
  template <class Visit>
  void visit_triangles(const Ray& world, const float& t_max, const Visit& visit) const {
    if (!can_hit(world) || filter_.abandoned()) return;
    const float t_min = std::max(world.t_min, 0.0f);
    for (const PlacedGroup& placed : placed_) {
      RayToObject to_object = placed.to_object;
      if (!placed.keys.empty() && !to_object.set_inverse_of(matrix_at(placed.keys, world.time))) continue;
      const Ray ray = placed.identity ? world : to_object(world);
      if (!can_hit(ray)) continue;
      const RayShear shear(ray.origin, ray.direction);
      const auto sheared = [&](const Imath::V3f& p) {
        return ShearedCorner(shear, p[shear.kx], p[shear.ky], p[shear.kz]);
      };
      for (uint32_t m = placed.group.first_mesh; m < placed.group.first_mesh + placed.group.mesh_count; ++m) {
        if (checked_[m].triangles.empty() || !may_hit(checked_[m].bounds, ray, t_max)) continue;
        const TriangleMesh& mesh = meshes_[m];
        const PositionsAt positions(mesh, world.time);
        for (const uint32_t triangle : checked_[m].triangles) {
          const uint32_t* corner = &mesh.indices[3 * static_cast<size_t>(triangle)];
          const ShearedTriangle seen{sheared(positions[corner[0]]), sheared(positions[corner[1]]),
                                     sheared(positions[corner[2]])};
          if (visit(shear, seen, t_min, Hit{0.0f, 0.0f, 0.0f, placed.instance, m, triangle})) return;
        }
      }
    }
  }

  std::vector<TriangleMesh> meshes_;
  HitFilter filter_;
  std::vector<CheckedMesh> checked_;
  std::vector<PlacedGroup> placed_;
  Imath::Box3f bounds_;
  Statistics statistics_;
};

} // namespace

std::unique_ptr<Accelerator> make_brute_force(const BuildInput& input, const BuildOptions& options) {
  if (options.cancel != nullptr && options.cancel->load(std::memory_order_relaxed)) return nullptr;
  return std::make_unique<BruteForce>(input, options);
}

} // namespace kindling::accel
