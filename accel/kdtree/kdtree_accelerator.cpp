// Builds the kd-tree accelerator from a BuildInput, and forwards its queries to the kernels.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kdtree_accelerator.h"

#include "accel/affine.h"
#include "accel/kdtree/all_hits_queries.h"
#include "accel/kdtree/build/build.h"
#include "accel/kdtree/instance_bounds.h"
#include "accel/kdtree/layout.h"
#include "accel/kdtree/leaf_sizes.h"
#include "accel/kdtree/persistent_trees.h"
#include "accel/kdtree/queries.h"
#include "accel/kdtree/structure.h"
#include "accel/kdtree/traversal_cost.h"
#include "accel/merged_instances.h"
#include "accel/motion.h"
#include "accel/triangle.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <iterator>
#include <new>
#include <utility>

namespace kindling::accel {
namespace {

using kd::Tree;

constexpr size_t kGrain = 4096; // instances per task

class KdTreeAccelerator final : public Accelerator {
 public:
  KdTreeAccelerator(const BuildInput& input, const BuildOptions& options, std::unique_ptr<kd::PersistentTrees> previous)
      : quality_(options.quality), config_(kd::config_for(options.quality)) {
    structure_.filter = input.filter;
    const auto start = std::chrono::steady_clock::now();
    cancelled_ = !build(input, options, std::move(previous));
    if (cancelled_) return;
    statistics_.simd = options.simd.value_or(best_simd_target());
    queries_ = &kd::queries_for(statistics_.simd, {!structure_.moving.empty(), structure_.is_split()});
    all_hits_ = &kd::all_hits_queries_for(statistics_.simd);
    count();
    statistics_.instance_count = input.instances.size();
    statistics_.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options.on_progress) options.on_progress(1.0);
  }

  [[nodiscard]] bool cancelled() const { return cancelled_; }
  [[nodiscard]] const kd::Structure& structure() const { return structure_; }

  [[nodiscard]] Hit intersect(const Ray& ray) const override { return queries_->intersect(structure_, ray); }
  [[nodiscard]] bool occluded(const Ray& ray) const override { return queries_->occluded(structure_, ray); }
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    assert(hits.size() == rays.size());
    queries_->intersect_stream(structure_, rays, hits);
  }
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    assert(blocked.size() == rays.size());
    queries_->occluded_stream(structure_, rays, blocked);
  }
  void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const override {
    assert(hits.size() == rays.size());
    queries_->intersect_coherent(structure_, rays, hits);
  }
  void occluded_coherent(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    assert(blocked.size() == rays.size());
    queries_->occluded_coherent(structure_, rays, blocked);
  }
  [[nodiscard]] bool all_hits(const Ray& ray, size_t limit, std::vector<Crossing>& crossings) const override {
    kd::all_hits(*all_hits_, structure_, ray, limit, crossings);
    return true;
  }
  // See kdtree_all_hits().
  void all_hits(std::span<const Ray> rays, size_t limit, std::vector<Crossing>& crossings,
                std::span<uint32_t> counts) const {
    kd::all_hits(*all_hits_, structure_, rays, limit, crossings, counts);
  }
  [[nodiscard]] std::optional<TraversalCost> traversal_cost(const Ray& ray, bool any_hit) const override {
    return kd::traversal_cost(structure_, ray, any_hit);
  }
  [[nodiscard]] Imath::Box3f bounds() const override { return bounds_; }
  [[nodiscard]] Statistics statistics() const override { return statistics_; }

  [[nodiscard]] std::unique_ptr<PersistentStructures> take_structures() override {
    auto out = std::make_unique<kd::PersistentTrees>(quality_);
    out->put(std::move(structure_.world_tree));
    for (Tree& tree : structure_.group_trees) out->put(std::move(tree));
    if (out->empty()) return nullptr;
    return out;
  }

 private:
  // Returns false if cancelled.
  bool build(const BuildInput& input, const BuildOptions& options, std::unique_ptr<kd::PersistentTrees> previous) {
    std::vector<kd::Geometry> static_geometries;
    std::vector<uint8_t> group_has_transform(input.groups.size(), 0), group_deforms(input.groups.size(), 0);
    std::vector<uint32_t> transformed, moving;
    const std::vector<uint8_t> traceable = find_traceable(input);
    std::vector<uint8_t> with_deforming(input.groups.size());
    std::vector<uint64_t> triangles(input.groups.size());
    for (size_t g = 0; g < input.groups.size(); ++g) {
      with_deforming[g] = has_deforming(input, input.groups[g]) ? 1 : 0;
      triangles[g] = group_triangles(input, input.groups[g]);
    }
    MergedInstances merged(input.groups.size());
    for (size_t i = 0; i < input.instances.size(); ++i) {
      const Instance& instance = input.instances[i];
      const auto number = static_cast<uint32_t>(i);
      const bool moves = instance.motion != kNoId;
      if (traceable[i] == 0) continue;
      // The static meshes of a partly deforming group are traced in a tree of their own.
      const bool deforms = with_deforming[instance.group] != 0;
      if (deforms) group_deforms[instance.group] = 1;
      if (moves || deforms) moving.push_back(number);
      if (!moves && is_identity(instance.object_to_world) && merged.take(instance.group, triangles[instance.group])) {
        append_geometries(input, input.groups[instance.group], number, false, static_geometries);
      } else {
        group_has_transform[instance.group] = 1;
        if (!moves) transformed.push_back(number);
      }
    }

    // Trees to build: the world's and those of the groups.
    struct Job {
      std::vector<kd::Geometry> geometries;
      Tree* tree; // set, unless `deforming` is
      kd::DeformingTrees* deforming = nullptr;
    };
    structure_.group_trees.resize(input.groups.size());
    structure_.deforming.resize(moving.empty() ? 0 : input.groups.size());
    std::vector<Job> jobs;
    std::vector<kd::Geometry> transient = split_off_transient(static_geometries);
    jobs.push_back({std::move(static_geometries), &structure_.world_tree});
    if (!transient.empty()) jobs.push_back({std::move(transient), &structure_.transient_tree});
    for (size_t g = 0; g < group_has_transform.size(); ++g) {
      if (group_has_transform[g] != 0) {
        jobs.push_back({{}, &structure_.group_trees[g]});
        append_geometries(input, input.groups[g], kNoId, false, jobs.back().geometries);
      }
      if (group_deforms[g] != 0) {
        jobs.push_back({{}, nullptr, &structure_.deforming[g]});
        append_geometries(input, input.groups[g], kNoId, true, jobs.back().geometries);
      }
    }
    if (previous) {
      std::erase_if(jobs, [&](Job& job) { return job.tree != nullptr && previous->take(job.geometries, *job.tree); });
      previous.reset(); // frees memory before the build
    }
    for (const Job& job : jobs)
      for (const kd::Geometry& geometry : job.geometries)
        statistics_.built_triangle_count += geometry.mesh.triangle_count();
    kd::BuildMonitor monitor(options, statistics_.built_triangle_count);
    tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t j) {
      if (jobs[j].deforming != nullptr) {
        *jobs[j].deforming = kd::build_deforming(config_, jobs[j].geometries, monitor);
        return;
      }
      kd::BinaryTree binary = kd::build_binary_tree(config_, jobs[j].geometries, monitor);
      if (!monitor.cancelled())
        *jobs[j].tree = kd::lay_out(std::move(binary), std::move(jobs[j].geometries), nullptr, &monitor);
    });
    if (monitor.cancelled()) return false;

    place_transformed(input, std::move(transformed), options.cancel);
    place_moving(input, moving, options.cancel);
    return !monitor.cancelled();
  }

  // Returns, per instance, whether its transform can be inverted or its motion keys are finite.
  static std::vector<uint8_t> find_traceable(const BuildInput& input) {
    std::vector<uint8_t> traceable(input.instances.size());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, traceable.size(), kGrain),
                      [&](const tbb::blocked_range<size_t>& range) {
                        for (size_t i = range.begin(); i < range.end(); ++i) {
                          const Instance& instance = input.instances[i];
                          RayToObject inverse;
                          traceable[i] = instance.motion != kNoId ? is_finite(input.motions[instance.motion])
                                                                  : inverse.set_inverse_of(instance.object_to_world);
                        }
                      });
    return traceable;
  }

  static bool has_deforming(const BuildInput& input, const MeshGroup& group) {
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m)
      if (deforms(input.meshes[m])) return true;
    return false;
  }

  static uint64_t group_triangles(const BuildInput& input, const MeshGroup& group) {
    uint64_t count = 0;
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m)
      count += input.meshes[m].triangle_count();
    return count;
  }

  // Appends the meshes of a group that deform, or those that do not.
  static void append_geometries(const BuildInput& input, const MeshGroup& group, uint32_t instance, bool deforming,
                                std::vector<kd::Geometry>& out) {
    uint64_t first = out.empty() ? 0 : out.back().first_primitive + out.back().mesh.triangle_count();
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
      const TriangleMesh& mesh = input.meshes[m];
      if (mesh.triangle_count() == 0 || deforms(mesh) != deforming) continue;
      if (first + mesh.triangle_count() >= kNoId) throw std::bad_alloc();
      out.push_back({mesh, static_cast<uint32_t>(first), instance, m});
      first += mesh.triangle_count();
    }
  }

  // If only some geometries are persistent, keeps those and returns the others.
  static std::vector<kd::Geometry> split_off_transient(std::vector<kd::Geometry>& static_geometries) {
    const auto is_persistent = [](const kd::Geometry& geometry) { return geometry.mesh.persistent_id != 0; };
    if (std::none_of(static_geometries.begin(), static_geometries.end(), is_persistent)) return {};
    std::vector<kd::Geometry> transient;
    std::remove_copy_if(static_geometries.begin(), static_geometries.end(), std::back_inserter(transient),
                        is_persistent);
    std::erase_if(static_geometries, [&](const kd::Geometry& geometry) { return !is_persistent(geometry); });
    for (std::vector<kd::Geometry>* part : {&static_geometries, &transient}) {
      uint32_t first = 0;
      for (kd::Geometry& geometry : *part) {
        geometry.first_primitive = first;
        first += static_cast<uint32_t>(geometry.mesh.triangle_count());
      }
    }
    return transient;
  }

  void place_transformed(const BuildInput& input, std::vector<uint32_t> transformed, const std::atomic<bool>* cancel) {
    bounds_ = structure_.world_tree.bounds;
    bounds_.extendBy(structure_.transient_tree.bounds);
    std::erase_if(transformed,
                  [&](uint32_t i) { return structure_.group_trees[input.instances[i].group].root == kd::kEmptyChild; });
    structure_.transformed.resize(transformed.size());
    std::vector<Imath::Box3f> boxes(transformed.size());
    std::vector<float> growths(transformed.size());
    const std::vector<std::vector<Imath::Box3f>> parts = parts_of_groups(transformed.size());
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, transformed.size(), kGrain), [&](const tbb::blocked_range<size_t>& range) {
          for (size_t i = range.begin(); i < range.end(); ++i) {
            const Instance& instance = input.instances[transformed[i]];
            kd::TransformedInstance& placed = structure_.transformed[i];
            placed.tree = &structure_.group_trees[instance.group];
            placed.instance = transformed[i];
            (void)placed.to_object.set_inverse_of(instance.object_to_world); // invertible: see find_traceable()
            boxes[i] = kd::transform_bounds({&instance.object_to_world, 1}, parts[instance.group]);
            growths[i] = rounding_growth(instance.object_to_world, placed.to_object);
          }
        });
    float largest = 1.0f;
    for (size_t i = 0; i < boxes.size(); ++i) {
      const Instance& instance = input.instances[transformed[i]];
      bounds_.extendBy(transform_bounds(instance.object_to_world, structure_.transformed[i].tree->bounds));
      boxes[i] = widened(boxes[i], growths[i], translation_of(instance.object_to_world));
      largest = std::max(largest, growths[i]);
    }
    transformed = decltype(transformed)();
    growths = decltype(growths)();
    structure_.instance_level = kd::InstanceLevel(std::move(boxes), cancel, largest);
  }

  // Returns the boxes that bound instances of each group; none if there are no instances.
  [[nodiscard]] std::vector<std::vector<Imath::Box3f>> parts_of_groups(size_t instances) const {
    std::vector<std::vector<Imath::Box3f>> parts;
    if (instances != 0)
      for (const Tree& tree : structure_.group_trees) parts.push_back(kd::parts_of(tree, kd::parts_for(instances)));
    return parts;
  }

  static Imath::V3f translation_of(const Imath::M44f& m) { return {m[3][0], m[3][1], m[3][2]}; }

  void place_moving(const BuildInput& input, const std::vector<uint32_t>& moving, const std::atomic<bool>* cancel) {
    std::vector<Imath::Box3f> boxes;
    float largest = 1.0f;
    const std::vector<std::vector<Imath::Box3f>> parts = parts_of_groups(moving.size());
    const Imath::M44f identity;
    if (!moving.empty())
      for (const std::span<const Imath::M44f> keys : input.motions)
        structure_.motions.emplace_back(keys.begin(), keys.end());
    for (const uint32_t i : moving) {
      const Instance& instance = input.instances[i];
      kd::MovingInstance placed;
      placed.instance = i;
      const bool moves = instance.motion != kNoId;
      if (moves)
        placed.keys = structure_.motions[instance.motion];
      else if (is_identity(instance.object_to_world))
        placed.in_place = true;
      else if (!placed.to_object.set_inverse_of(instance.object_to_world))
        continue;
      const float growth = moves             ? kd::growth_of(placed.keys)
                           : placed.in_place ? 1.0f
                                             : rounding_growth(instance.object_to_world, placed.to_object);
      largest = std::max(largest, growth);
      Imath::V3f translation = translation_of(instance.object_to_world);
      for (const Imath::M44f& key : placed.keys)
        for (int k = 0; k < 3; ++k) translation[k] = std::max(std::fabs(translation[k]), std::fabs(key[3][k]));
      const std::span<const Imath::M44f> keys =
          moves ? placed.keys : std::span(placed.in_place ? &identity : &instance.object_to_world, 1);
      const auto add = [&](const Imath::Box3f& bounds, const std::vector<Imath::Box3f>& in_tree) {
        structure_.moving.push_back(placed);
        for (const Imath::M44f& key : placed.keys)
          structure_.key_boxes.push_back(widened(kd::transform_bounds({&key, 1}, in_tree), growth, translation));
        bounds_.extendBy(placed.in_place ? bounds : transform_bounds(keys, bounds));
        boxes.push_back(widened(kd::transform_bounds(keys, in_tree), growth, translation));
      };
      // The static meshes of an instance without motion are in the other trees.
      const Tree& tree = structure_.group_trees[instance.group];
      if (moves && tree.root != kd::kEmptyChild) {
        placed.tree = &tree;
        add(tree.bounds, parts[instance.group]);
      }
      const kd::DeformingTrees& deforming = structure_.deforming[instance.group];
      if (deforming.slices.empty()) continue;
      placed.tree = nullptr;
      placed.deforming = &deforming;
      add(deforming.bounds, {deforming.bounds});
    }
    size_t box = 0;
    for (kd::MovingInstance& placed : structure_.moving) {
      placed.boxes = std::span(structure_.key_boxes).subspan(box, placed.keys.size());
      box += placed.keys.size();
    }
    structure_.moving_level = kd::InstanceLevel(std::move(boxes), cancel, largest);
  }

  void count() {
    Statistics& s = statistics_;
    s.node_count = structure_.instance_level.node_count();
    s.memory_bytes =
        structure_.instance_level.memory_bytes() + structure_.transformed.capacity() * sizeof(kd::TransformedInstance);
    s.node_count += structure_.moving_level.node_count();
    s.memory_bytes += structure_.moving_level.memory_bytes() +
                      structure_.moving.capacity() * sizeof(kd::MovingInstance) +
                      structure_.key_boxes.capacity() * sizeof(Imath::Box3f);
    for (const auto& keys : structure_.motions)
      s.memory_bytes += sizeof(std::vector<Imath::M44f>) + keys.capacity() * sizeof(Imath::M44f);
    const auto add = [&](const Tree& tree) {
      s.memory_bytes += tree.memory_bytes();
      s.node_count += tree.node_count();
      s.leaf_count += tree.leaf_count;
      s.reference_count += tree.reference_count;
      kd::count_leaf_sizes(tree, s.leaf_sizes);
    };
    add(structure_.world_tree);
    if (structure_.is_split()) add(structure_.transient_tree);
    for (const Tree& tree : structure_.group_trees) add(tree);
    for (const kd::DeformingTrees& deforming : structure_.deforming)
      for (const kd::DeformingSlice& slice : deforming.slices) add(slice.tree);
    s.triangle_count = structure_.world_tree.triangle_count + structure_.transient_tree.triangle_count;
    for (const kd::TransformedInstance& transformed : structure_.transformed)
      s.triangle_count += transformed.tree->triangle_count;
    for (const kd::MovingInstance& moving : structure_.moving)
      s.triangle_count += moving.tree != nullptr ? moving.tree->triangle_count : moving.deforming->triangle_count;
  }

  Quality quality_;
  kd::Config config_;
  const kd::Queries* queries_ = nullptr;
  const kd::AllHitsQueries* all_hits_ = nullptr;
  bool cancelled_ = false;
  kd::Structure structure_;
  Imath::Box3f bounds_;
  Statistics statistics_;
};

} // namespace

std::unique_ptr<Accelerator> make_kdtree(const BuildInput& input, const BuildOptions& options,
                                         std::unique_ptr<PersistentStructures> previous) {
  auto accelerator = std::make_unique<KdTreeAccelerator>(
      input, options, kd::PersistentTrees::from(std::move(previous), options.quality));
  if (accelerator->cancelled()) return nullptr;
  return accelerator;
}

std::unique_ptr<const kd::StructureTables> view_of(const Accelerator& accelerator) {
  const auto* kdtree = dynamic_cast<const KdTreeAccelerator*>(&accelerator);
  return kdtree == nullptr ? nullptr : std::make_unique<const kd::StructureTables>(kdtree->structure());
}

bool kdtree_all_hits(const Accelerator& accelerator, std::span<const Ray> rays, size_t limit,
                     std::vector<Crossing>& crossings, std::span<uint32_t> counts) {
  assert(counts.size() == rays.size());
  const auto* kdtree = dynamic_cast<const KdTreeAccelerator*>(&accelerator);
  if (kdtree != nullptr) kdtree->all_hits(rays, limit, crossings, counts);
  return kdtree != nullptr;
}

} // namespace kindling::accel
