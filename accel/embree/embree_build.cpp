// Builds Embree's geometries, group scenes and top scene, with progress and cancellation.
// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_build.h"

#include "accel/affine.h"
#include "accel/embree/embree_limits.h"
#include "accel/merged_instances.h"
#include "accel/motion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>

namespace kindling::accel::embree {
namespace {

// Collects the progress of all scenes and reports it from one thread at a time.
class Monitor {
 public:
  Monitor(const BuildOptions& options, double total_weight) : options_(options), total_weight_(total_weight) {}

  [[nodiscard]] bool cancelled() const {
    return options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed);
  }
  void add(double weight) {
    if (!options_.on_progress) return;
    std::lock_guard lock(mutex_);
    done_ += weight;
    const double fraction = std::min(1.0, done_ / total_weight_);
    if (fraction < reported_ + 0.005) return;
    reported_ = fraction;
    options_.on_progress(fraction);
  }

 private:
  const BuildOptions& options_;
  double total_weight_;
  std::mutex mutex_;
  double done_ = 0.0, reported_ = 0.0;
};

// The share of one scene in the total progress.
struct SceneProgress {
  Monitor& monitor;
  double weight = 1.0;
  std::mutex mutex;
  double fraction = 0.0;

  static bool callback(void* user, double fraction) {
    auto& self = *static_cast<SceneProgress*>(user);
    double step = 0.0;
    {
      std::lock_guard lock(self.mutex);
      step = std::max(0.0, std::min(1.0, fraction) - self.fraction);
      self.fraction += step;
    }
    self.monitor.add(self.weight * step);
    return !self.monitor.cancelled();
  }
};

bool count_memory(void* user, ssize_t bytes, bool) {
  static_cast<std::atomic<int64_t>*>(user)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

class Builder {
 public:
  Builder(const BuildInput& input, const BuildOptions& options, const Filters& filters, BuiltScenes& out)
      : input_(input), options_(options), filters_(filters), out_(out) {}

  bool run(std::unique_ptr<PersistentScenes> previous) {
    if (previous) {
      out_.on = std::move(previous->on);
    } else {
      out_.on.memory_bytes = std::make_unique<std::atomic<int64_t>>(0);
      out_.on.simd = options_.simd;
      // Huge pages are Embree's default on Linux; the kd-tree asks for them too.
      std::string config = "hugepages=1";
      if (options_.simd) config.append(",isa=").append(simd_target_name(*options_.simd));
      out_.on.device = Device(rtcNewDevice(config.c_str()));
      if (!out_.on.device) throw std::bad_alloc();
      rtcSetDeviceMemoryMonitorFunction(out_.on.device.get(), count_memory, out_.on.memory_bytes.get());
    }

    count_group_triangles();
    std::vector<uint32_t> transformed = transformed_groups();
    if (previous) {
      take(*previous, transformed);
      previous.reset(); // frees memory before the build
    }
    if (!make_geometries(transformed)) return false;
    size_t triangles = top_triangles_ + (out_.persistent ? 0 : persistent_triangles_);
    for (const uint32_t g : transformed) triangles += group_triangles(g);
    out_.built_triangle_count = triangles;
    Monitor monitor(options_, 1.0 + static_cast<double>(triangles + input_.instances.size()));

    std::atomic<bool> ok{true};
    tbb::parallel_for(size_t{0}, transformed.size(), [&](size_t i) {
      if (!build_group(transformed[i], monitor)) ok.store(false, std::memory_order_relaxed);
    });
    if (!ok.load()) return failed(monitor);
    if (!build_persistent(monitor) || !build_top(monitor) || monitor.cancelled()) return failed(monitor);
    check_errors();
    if (options_.on_progress) options_.on_progress(1.0);
    return true;
  }

 private:
  [[nodiscard]] size_t group_triangles(uint32_t g) const { return group_triangles_[g]; }

  void count_group_triangles() {
    for (const MeshGroup& group : input_.groups) {
      size_t count = 0;
      for (uint32_t m = 0; m < group.mesh_count; ++m) count += input_.meshes[group.first_mesh + m].triangle_count();
      group_triangles_.push_back(count);
    }
  }

  // Sorts instances into those whose meshes go into the top scene and those with a transform. Skips
  // singular ones. Returns the groups used by transformed instances.
  std::vector<uint32_t> transformed_groups() {
    std::vector<uint8_t> used(input_.groups.size(), 0);
    MergedInstances merged(input_.groups.size());
    for (size_t i = 0; i < input_.instances.size(); ++i) {
      const Instance& instance = input_.instances[i];
      const size_t triangles = group_triangles(instance.group);
      const bool moves = instance.motion != kNoId;
      RayToObject inverse;
      if (triangles == 0) continue;
      if (moves ? !is_finite(input_.motions[instance.motion]) : !inverse.set_inverse_of(instance.object_to_world))
        continue;
      out_.triangle_count += triangles;
      if (!moves && is_identity(instance.object_to_world) && merged.take(instance.group, triangles)) {
        add_static(static_cast<uint32_t>(i));
      } else {
        used[instance.group] = 1;
        transformed_.push_back(static_cast<uint32_t>(i));
      }
    }
    std::vector<uint32_t> groups;
    for (size_t g = 0; g < used.size(); ++g)
      if (used[g] != 0) groups.push_back(static_cast<uint32_t>(g));
    out_.groups.resize(input_.groups.size());
    out_.group_meshes.resize(input_.groups.size());
    for (const uint32_t g : groups)
      for (uint32_t m = 0; m < input_.groups[g].mesh_count; ++m)
        out_.group_meshes[g].add(input_.meshes[input_.groups[g].first_mesh + m]);
    return groups;
  }

  // Adds the meshes of an instance with identity transform.
  void add_static(uint32_t instance) {
    const MeshGroup& group = input_.groups[input_.instances[instance].group];
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
      const TriangleMesh& mesh = input_.meshes[m];
      if (mesh.triangle_count() == 0) continue;
      if (mesh.persistent_id != 0 && !deforms(mesh)) {
        out_.names.persistent.push_back({instance, m});
        out_.persistent_meshes.add(mesh);
        persistent_triangles_ += mesh.triangle_count();
      } else {
        static_.push_back({instance, m});
        top_triangles_ += mesh.triangle_count();
      }
    }
  }

  // Reuses scenes of the previous build, and removes their groups from the list of those to build.
  void take(PersistentScenes& previous, std::vector<uint32_t>& transformed) {
    const auto take_scene = [&](const PersistentMeshes& meshes, Scene& scene) {
      std::optional<Scene> found = previous.scenes.take(meshes);
      if (found) scene = std::move(*found);
      return found.has_value();
    };
    if (!out_.persistent_meshes.empty()) (void)take_scene(out_.persistent_meshes, out_.persistent);
    std::erase_if(transformed, [&](uint32_t g) { return take_scene(out_.group_meshes[g], out_.groups[g]); });
  }

  [[nodiscard]] RTCBuildQuality build_quality() const {
    switch (options_.quality) {
    case Quality::fast: return RTC_BUILD_QUALITY_LOW;
    case Quality::balanced: return RTC_BUILD_QUALITY_MEDIUM;
    case Quality::best: return RTC_BUILD_QUALITY_HIGH;
    }
    return RTC_BUILD_QUALITY_MEDIUM;
  }

  // Creates the geometries of meshes that no reused scene contains. Returns false if cancelled.
  bool make_geometries(const std::vector<uint32_t>& groups) {
    geometries_.resize(input_.meshes.size());
    std::vector<uint8_t> wanted(input_.meshes.size(), 0);
    for (const NamedGeometry& named : static_) wanted[named.mesh] = 1;
    if (!out_.persistent)
      for (const NamedGeometry& named : out_.names.persistent) wanted[named.mesh] = 1;
    for (const uint32_t g : groups)
      std::fill_n(wanted.begin() + input_.groups[g].first_mesh, input_.groups[g].mesh_count, uint8_t{1});
    for (size_t m = 0; m < input_.meshes.size(); ++m) {
      const TriangleMesh& mesh = input_.meshes[m];
      if (mesh.triangle_count() == 0 || wanted[m] == 0) continue;
      if (options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed)) return false;
      Geometry geometry(rtcNewGeometry(out_.on.device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
      // Embree interpolates linearly between time steps at equal distances over [0, 1], its default
      // range.
      rtcSetGeometryTimeStepCount(geometry.get(), key_count(mesh));
      for (uint32_t key = 0; key < key_count(mesh); ++key)
        rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, key, RTC_FORMAT_FLOAT3,
                                   positions_at_key(mesh, key).data(), 0, sizeof(Imath::V3f), mesh.positions.size());
      rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                                 3 * sizeof(uint32_t), mesh.triangle_count());
      // A scene of low quality has one tree per mesh under a top tree; only this setting makes the
      // lower trees cheap too.
      if (options_.quality == Quality::fast) rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_LOW);
      if (RTCFilterFunctionN filter = mesh.opaque ? filters_.opaque : filters_.cutout; filter != nullptr) {
        rtcSetGeometryIntersectFilterFunction(geometry.get(), filter);
        rtcSetGeometryOccludedFilterFunction(geometry.get(), filter);
      }
      rtcCommitGeometry(geometry.get());
      geometries_[m] = std::move(geometry);
    }
    check_errors();
    return true;
  }

  Scene new_scene() {
    Scene scene(rtcNewScene(out_.on.device.get()));
    if (!scene) throw std::bad_alloc();
    rtcSetSceneFlags(scene.get(), options_.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene.get(), build_quality());
    return scene;
  }

  bool commit(const Scene& scene, double weight, Monitor& monitor) {
    if (monitor.cancelled()) return false;
    SceneProgress progress{monitor, weight, {}, 0.0};
    rtcSetSceneProgressMonitorFunction(scene.get(), SceneProgress::callback, &progress);
    rtcCommitScene(scene.get());
    rtcSetSceneProgressMonitorFunction(scene.get(), nullptr, nullptr);
    if (monitor.cancelled()) return false;
    monitor.add(weight * (1.0 - progress.fraction));
    return true;
  }

  bool build_group(uint32_t g, Monitor& monitor) {
    const MeshGroup& group = input_.groups[g];
    Scene scene = new_scene();
    for (uint32_t m = 0; m < group.mesh_count; ++m)
      if (geometries_[group.first_mesh + m])
        rtcAttachGeometryByID(scene.get(), geometries_[group.first_mesh + m].get(), m);
    if (!commit(scene, static_cast<double>(group_triangles(g)), monitor)) return false;
    out_.groups[g] = std::move(scene);
    return true;
  }

  bool build_persistent(Monitor& monitor) {
    if (out_.persistent || out_.names.persistent.empty()) return true;
    Scene scene = new_scene();
    for (size_t i = 0; i < out_.names.persistent.size(); ++i)
      rtcAttachGeometryByID(scene.get(), geometries_[out_.names.persistent[i].mesh].get(), static_cast<unsigned>(i));
    if (!commit(scene, static_cast<double>(persistent_triangles_), monitor)) return false;
    out_.persistent = std::move(scene);
    return true;
  }

  bool build_top(Monitor& monitor) {
    std::vector<NamedGeometry>& names = out_.names.top;
    if (out_.persistent && static_.empty() && transformed_.empty()) {
      names = out_.names.persistent;
      return true;
    }
    Scene scene = new_scene();
    names.reserve(static_.size() + transformed_.size() + 1);
    for (const NamedGeometry& named : static_) {
      rtcAttachGeometryByID(scene.get(), geometries_[named.mesh].get(), static_cast<unsigned>(names.size()));
      names.push_back(named);
    }
    if (out_.persistent) {
      const Geometry geometry(rtcNewGeometry(out_.on.device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
      rtcSetGeometryInstancedScene(geometry.get(), out_.persistent.get());
      rtcCommitGeometry(geometry.get());
      rtcAttachGeometryByID(scene.get(), geometry.get(), static_cast<unsigned>(names.size()));
      names.push_back({});
    }
    const double required_extent = transformed_.empty() ? 0.0 : required_ray_extent(largest_coordinate(input_));
    for (const uint32_t i : transformed_) {
      if (monitor.cancelled()) return false;
      const Geometry geometry = instance_geometry(input_.instances[i], required_extent);
      rtcAttachGeometryByID(scene.get(), geometry.get(), static_cast<unsigned>(names.size()));
      names.push_back({i, input_.groups[input_.instances[i].group].first_mesh});
    }
    if (!commit(scene, 1.0 + static_cast<double>(top_triangles_ + input_.instances.size()), monitor)) return false;
    out_.own_top = std::move(scene);
    return true;
  }

  [[nodiscard]] Geometry instance_geometry(const Instance& instance, double required_extent) {
    const bool moves = instance.motion != kNoId;
    const std::span<const Imath::M44f> keys =
        moves ? input_.motions[instance.motion] : std::span(&instance.object_to_world, 1);
    const RTCScene group = out_.groups[instance.group].get();
    const float extent = safe_ray_extent(keys);
    if (static_cast<double>(extent) < required_extent) {
      GuardedInstance& guarded = *out_.guarded.emplace_back(std::make_unique<GuardedInstance>());
      guarded.scene = group;
      RTCBounds box;
      rtcGetSceneBounds(group, &box);
      Imath::Box3f bounds;
      if (box.lower_x <= box.upper_x)
        bounds = {{box.lower_x, box.lower_y, box.lower_z}, {box.upper_x, box.upper_y, box.upper_z}};
      if (moves) {
        guarded.keys.assign(keys.begin(), keys.end());
        guarded.bounds = transform_bounds(keys, bounds);
      } else {
        (void)guarded.to_object.set_inverse_of(keys[0]); // invertible: see transformed_groups()
        guarded.bounds = transform_bounds(keys[0], bounds);
      }
      return guarded_geometry(out_.on.device.get(), guarded);
    }
    out_.ray_extent = std::min(out_.ray_extent, extent);
    Geometry geometry(rtcNewGeometry(out_.on.device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(geometry.get(), group);
    rtcSetGeometryTimeStepCount(geometry.get(), static_cast<unsigned>(keys.size()));
    // A matrix for row vectors stored by rows equals one for column vectors stored by columns; the
    // fourth row is not read. Embree interpolates entries.
    for (size_t key = 0; key < keys.size(); ++key)
      rtcSetGeometryTransform(geometry.get(), static_cast<unsigned>(key), RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                              &keys[key][0][0]);
    rtcCommitGeometry(geometry.get());
    return geometry;
  }

  bool failed(const Monitor& monitor) {
    if (!monitor.cancelled()) throw std::bad_alloc();
    return false;
  }

  // Embree reports exceptions of its tasks as device errors; with valid input only lack of memory
  // remains.
  void check_errors() {
    if (rtcGetDeviceError(out_.on.device.get()) != RTC_ERROR_NONE) throw std::bad_alloc();
  }

  const BuildInput& input_;
  const BuildOptions& options_;
  const Filters filters_;
  BuiltScenes& out_;
  std::vector<Geometry> geometries_;  // by mesh; empty if the mesh has no triangles
  std::vector<NamedGeometry> static_; // meshes under identity transforms that are not persistent
  std::vector<uint32_t> transformed_; // transformed instances
  std::vector<size_t> group_triangles_;
  size_t top_triangles_ = 0, persistent_triangles_ = 0;
};

} // namespace

bool build_scenes(const BuildInput& input, const BuildOptions& options, const Filters& filters,
                  std::unique_ptr<PersistentScenes> previous, BuiltScenes& out) {
  return Builder(input, options, filters, out).run(std::move(previous));
}

} // namespace kindling::accel::embree
