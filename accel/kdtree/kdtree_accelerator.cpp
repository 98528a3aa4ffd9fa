// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kdtree_accelerator.h"

#include "accel/affine.h"
#include "accel/kdtree/build.h"
#include "accel/kdtree/instance_level.h"
#include "accel/kdtree/layout.h"
#include "accel/kdtree/stream.h"
#include "accel/kdtree/traversal.h"
#include "accel/triangle.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

namespace kindling::accel {
namespace {

using kd::Tree;

struct MovedInstance {
  RayToObject to_object;
  const Tree* tree = nullptr;
  uint32_t instance = 0;
};

class KdTreeAccelerator final : public Accelerator {
 public:
  KdTreeAccelerator(const BuildInput& input, const BuildOptions& options)
      : input_filter_(input.filter), config_(kd::config_for(options.quality)) {
    const auto start = std::chrono::steady_clock::now();
    cancelled_ = !build(input, options);
    if (cancelled_) return;
    count();
    statistics_.instance_count = input.instances.size();
    statistics_.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options.on_progress) options.on_progress(1.0);
  }

  [[nodiscard]] bool cancelled() const { return cancelled_; }

  [[nodiscard]] Hit intersect(const Ray& ray) const override {
    Hit hit;
    trace<false>(ray, hit);
    return hit;
  }
  [[nodiscard]] bool occluded(const Ray& ray) const override {
    Hit hit;
    return trace<true>(ray, hit);
  }
  // Streams through the world tree; moved instances follow ray by ray.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    if (rays.size() < kd::kSmallestStream) {
      for (size_t i = 0; i < rays.size(); ++i) hits[i] = intersect(rays[i]);
      return;
    }
    std::fill(hits.begin(), hits.end(), Hit());
    kd::Stream<false> stream(world_tree_, input_filter_);
    stream.trace(rays, [&](size_t i, const kd::TreeHit& hit) {
      hits[i] = kd::CandidateFilter{input_filter_, rays[i], world_tree_, kNoId}.resolve(hit);
    });
    if (instance_level_.empty()) return;
    for (size_t i = 0; i < rays.size(); ++i)
      if (can_hit(rays[i])) trace_instances<false>(rays[i], hits[i].is_hit() ? hits[i].t : rays[i].t_max, hits[i]);
  }
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    if (rays.size() < kd::kSmallestStream) {
      for (size_t i = 0; i < rays.size(); ++i) blocked[i] = occluded(rays[i]) ? 1 : 0;
      return;
    }
    std::fill(blocked.begin(), blocked.end(), uint8_t{0});
    kd::Stream<true> stream(world_tree_, input_filter_);
    stream.trace(rays, [&](size_t i, const kd::TreeHit&) { blocked[i] = 1; });
    if (instance_level_.empty()) return;
    for (size_t i = 0; i < rays.size(); ++i) {
      Hit hit;
      if (blocked[i] == 0 && can_hit(rays[i])) blocked[i] = trace_instances<true>(rays[i], rays[i].t_max, hit) ? 1 : 0;
    }
  }
  [[nodiscard]] Imath::Box3f bounds() const override { return bounds_; }
  [[nodiscard]] Statistics statistics() const override { return statistics_; }

 private:
  template <bool kAny>
  bool trace(const Ray& world, Hit& hit) const {
    if (!can_hit(world)) return false;
    const float t_min = std::max(world.t_min, 0.0f);
    float t_far = world.t_max;
    kd::TreeHit in_world;
    const kd::CandidateFilter filter{input_filter_, world, world_tree_, kNoId};
    if (kd::trace_tree<kAny>(world_tree_, world, t_min, filter, t_far, in_world)) {
      if (kAny) return true;
      hit = filter.resolve(in_world);
    }
    return trace_instances<kAny>(world, t_far, hit);
  }

  // Goes on behind the world tree, where `hit`, if any, lies at t_far.
  template <bool kAny>
  bool trace_instances(const Ray& world, float t_far, Hit& hit) const {
    const float t_min = std::max(world.t_min, 0.0f);
    return instance_level_.visit(world, t_min, t_far,
                                 [&](uint32_t i) { return trace_moved<kAny>(moved_[i], world, t_min, t_far, hit); });
  }

  template <bool kAny>
  bool trace_moved(const MovedInstance& moved, const Ray& world, float t_min, float& t_far, Hit& hit) const {
    const Ray ray = moved.to_object(world);
    if (!can_hit(ray)) return false;
    const kd::CandidateFilter filter{input_filter_, world, *moved.tree, moved.instance};
    kd::TreeHit in_tree;
    if (!kd::trace_tree<kAny>(*moved.tree, ray, t_min, filter, t_far, in_tree)) return false;
    if (kAny) return true;
    if (hit.is_hit() && in_tree.t == hit.t && hit.instance < moved.instance) return false;
    hit = filter.resolve(in_tree);
    return false;
  }

  // False if cancelled.
  bool build(const BuildInput& input, const BuildOptions& options) {
    std::vector<kd::Geometry> still;
    std::vector<uint8_t> group_moves(input.groups.size(), 0);
    std::vector<uint32_t> moved;
    for (size_t i = 0; i < input.instances.size(); ++i) {
      const Instance& instance = input.instances[i];
      RayToObject inverse;
      if (!inverse.set_inverse_of(instance.object_to_world)) continue;
      if (is_identity(instance.object_to_world)) {
        append_geometries(input, input.groups[instance.group], static_cast<uint32_t>(i), still);
      } else {
        group_moves[instance.group] = 1;
        moved.push_back(static_cast<uint32_t>(i));
      }
    }

    // One list of trees to build: the world's and those of the groups that move.
    struct Job {
      std::vector<kd::Geometry> geometries;
      Tree* tree;
    };
    group_trees_.resize(input.groups.size());
    std::vector<Job> jobs;
    jobs.push_back({std::move(still), &world_tree_});
    for (size_t g = 0; g < group_moves.size(); ++g) {
      if (group_moves[g] == 0) continue;
      jobs.push_back({{}, &group_trees_[g]});
      append_geometries(input, input.groups[g], kNoId, jobs.back().geometries);
    }
    size_t triangles = 0;
    for (const Job& job : jobs)
      for (const kd::Geometry& geometry : job.geometries) triangles += geometry.mesh.triangle_count();
    kd::BuildMonitor monitor(options, triangles);
    tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t j) {
      kd::BinaryTree binary = kd::build_binary_tree(config_, jobs[j].geometries, monitor);
      if (!monitor.cancelled()) *jobs[j].tree = kd::lay_out(std::move(binary), std::move(jobs[j].geometries));
    });
    if (monitor.cancelled()) return false;

    place_moved(input, moved);
    return true;
  }

  static void append_geometries(const BuildInput& input, const MeshGroup& group, uint32_t instance,
                                std::vector<kd::Geometry>& out) {
    uint64_t first = out.empty() ? 0 : out.back().first_primitive + out.back().mesh.triangle_count();
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
      const TriangleMesh& mesh = input.meshes[m];
      if (mesh.triangle_count() == 0) continue;
      if (first + mesh.triangle_count() >= kd::kPrimitiveMask) throw std::bad_alloc();
      out.push_back({mesh, static_cast<uint32_t>(first), instance, m});
      first += mesh.triangle_count();
    }
  }

  void place_moved(const BuildInput& input, const std::vector<uint32_t>& moved) {
    std::vector<Imath::Box3f> boxes;
    bounds_ = world_tree_.bounds;
    for (const uint32_t i : moved) {
      const Instance& instance = input.instances[i];
      const Tree& tree = group_trees_[instance.group];
      if (tree.root == kd::kEmptyChild) continue;
      MovedInstance placed;
      if (!placed.to_object.set_inverse_of(instance.object_to_world)) continue;
      placed.tree = &tree;
      placed.instance = i;
      moved_.push_back(placed);
      boxes.push_back(transform_bounds(instance.object_to_world, tree.bounds));
      bounds_.extendBy(boxes.back());
    }
    instance_level_ = kd::InstanceLevel(boxes);
  }

  void count() {
    Statistics& s = statistics_;
    s.node_count = instance_level_.node_count();
    s.memory_bytes = instance_level_.memory_bytes() + moved_.capacity() * sizeof(MovedInstance);
    const auto add = [&](const Tree& tree) {
      s.memory_bytes += tree.memory_bytes();
      s.node_count += tree.nodes.size() == 0 ? 0 : tree.nodes.size() - 1; // number 0 is not used
      s.leaf_count += tree.leaf_count;
      s.reference_count += tree.reference_count;
    };
    add(world_tree_);
    for (const Tree& tree : group_trees_) add(tree);
    s.triangle_count = world_tree_.triangle_count;
    for (const MovedInstance& moved : moved_) s.triangle_count += moved.tree->triangle_count;
  }

  HitFilter input_filter_;
  kd::Config config_;
  bool cancelled_ = false;
  Tree world_tree_;               // instances with identity transform, in world space
  std::vector<Tree> group_trees_; // by group; empty where no moved instance uses it
  std::vector<MovedInstance> moved_;
  kd::InstanceLevel instance_level_; // over moved_
  Imath::Box3f bounds_;
  Statistics statistics_;
};

} // namespace

std::unique_ptr<Accelerator> make_kdtree(const BuildInput& input, const BuildOptions& options) {
  auto accelerator = std::make_unique<KdTreeAccelerator>(input, options);
  if (accelerator->cancelled()) return nullptr;
  return accelerator;
}

} // namespace kindling::accel
