// Decides which meshes are baked and which are instanced, and prepares their vertices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/prepare_geometry.h"

#include "renderer/world/world_parts.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

namespace kindling {
namespace {

constexpr size_t kBoundsGrain = 1U << 14;
// Maximum memory per thread of vertices that are stored twice, as read and as prepared; one
// primitive is always allowed.
constexpr uint64_t kBytesInHand = 2U << 20;

// True if a matrix mirrors: front faces become clockwise.
bool is_mirrored(const M44f& m) { return m.determinant() < 0.0f; }

bool is_invertible(const M44f& m) {
  const float determinant = m.determinant();
  return std::isfinite(determinant) && determinant != 0.0f;
}

bool moves(const PosedMesh& posed) { return !posed.later_transforms.empty() || !posed.later_deformed.empty(); }

Box3f transformed(const Box3f& box, const M44f& matrix) {
  Box3f result;
  if (box.isEmpty()) return result;
  for (int corner = 0; corner < 8; ++corner)
    result.extendBy(
        transform_point(matrix, V3f((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                                    (corner & 4) ? box.max.z : box.min.z)));
  return result;
}

// Returns the union of the boxes that extend(box, i) adds for i from 0 to `count`. Halves are
// joined in order, so that even the signs of zeros equal those of a serial loop.
template <typename Extend>
Box3f box_of_all(size_t count, size_t grain, const Extend& extend) {
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, count, grain), Box3f(),
      [&](const tbb::blocked_range<size_t>& range, Box3f box) {
        for (size_t i = range.begin(); i != range.end(); ++i) extend(box, i);
        return box;
      },
      [](Box3f a, const Box3f& b) {
        a.extendBy(b);
        return a;
      });
}

// Returns the box over all keys.
Box3f box_of(const Geometry& geometry) {
  const auto box_of_span = [](std::span<const V3f> positions) {
    return box_of_all(positions.size(), kBoundsGrain, [&](Box3f& box, size_t i) {
      if (is_finite(positions[i])) box.extendBy(positions[i]);
    });
  };
  Box3f box = box_of_span(geometry.positions);
  for (const std::span<const V3f> key : geometry.later_positions) box.extendBy(box_of_span(key));
  return box;
}

uint64_t vertex_bytes(const Primitive& primitive) {
  uint64_t vertex = sizeof(V3f) + sizeof(V3f) + sizeof(V4f) + (primitive.colors.empty() ? 0 : sizeof(V4f));
  for (const std::vector<V2f>& set : primitive.texcoords) vertex += set.empty() ? 0 : sizeof(V2f);
  return primitive.positions.size() * vertex + primitive.indices.size() * sizeof(uint32_t);
}

class GeometryPreparation {
 public:
  GeometryPreparation(Scene& scene, PosedScene& posed, WorldParts& parts)
      : scene_(scene), posed_(posed), parts_(parts) {}

  PreparedGeometry run() {
    std::vector<uint32_t> uses(scene_.meshes.size(), 0);
    for (const PosedMesh& posed : posed_.meshes) ++uses[static_cast<size_t>(posed.mesh)];
    const BakeChoice choice = choose_baked(scene_.meshes, posed_);
    out_.instances.reserve(
        1 + static_cast<size_t>(std::count_if(posed_.meshes.begin(), posed_.meshes.end(),
                                              [&](const PosedMesh& posed) { return !choice.is_baked(posed); })));
    for (PosedMesh& posed : posed_.meshes) {
      const auto mesh = static_cast<size_t>(posed.mesh);
      if (!choice.is_baked(posed)) continue;
      append_mesh(posed, posed.mesh_to_world, --uses[mesh] == 0);
      out_.nodes.resize(out_.geometries.size(), posed.node);
    }
    const auto baked_count = static_cast<uint32_t>(out_.geometries.size());
    if (baked_count > 0) {
      out_.groups.push_back({0, baked_count});
      add_instance(0, PosedMesh{});
    }
    for (PosedMesh& posed : posed_.meshes) {
      if (posed.deformed.empty() || !moves(posed)) continue;
      add_instance(append_group(posed, --uses[static_cast<size_t>(posed.mesh)] == 0), posed);
    }
    std::vector<uint32_t> group_of_mesh(scene_.meshes.size(), accel::kNoId);
    for (PosedMesh& posed : posed_.meshes) {
      const auto mesh = static_cast<size_t>(posed.mesh);
      if (choice.is_baked(posed) || !posed.deformed.empty()) continue;
      if (group_of_mesh[mesh] == accel::kNoId) group_of_mesh[mesh] = append_group(posed, true);
      add_instance(group_of_mesh[mesh], posed);
    }
    make_geometries();
    // "= {}" would keep their memory.
    posed_.meshes = std::vector<PosedMesh>();
    if (!parts_.keep_scene) {
      scene_.meshes = std::vector<Mesh>();
      scene_.nodes = std::vector<Node>();
    }
    parts_.geometries.clear(); // unused ones
    find_bounds();
    return std::move(out_);
  }

 private:
  [[nodiscard]] uint32_t material_index(const Primitive& primitive) const {
    return primitive.material == kNone ? static_cast<uint32_t>(scene_.materials.size() - 1)
                                       : static_cast<uint32_t>(primitive.material);
  }

  // A geometry to be made.
  struct Job {
    size_t mesh = 0, primitive = 0;
    PosedMesh* posed = nullptr;
    M44f bake;
    uint32_t material = 0;
    size_t geometry = 0;   // index of the result
    uint64_t name = 0;     // Geometry::number
    bool consumes = false; // last use of the primitive: it is moved out of the scene
  };

  // Adds the jobs for the primitives of one posed mesh, and their positions in the result.
  void append_mesh(PosedMesh& posed, const M44f& bake, bool last_use) {
    const auto number = static_cast<size_t>(posed.mesh);
    const Mesh& mesh = scene_.meshes[number];
    const bool consumed = last_use && (!parts_.keep_scene || parts_.static_meshes[number] != 0);
    for (size_t p = 0; p < mesh.primitives.size(); ++p) {
      const GeometryKey same_as = key_of(posed, static_cast<uint32_t>(p), bake);
      if (std::optional<Geometry> same = parts_.geometries.take(same_as)) {
        parts_.keys.push_back(same_as);
        out_.geometries.push_back(*std::move(same));
        continue;
      }
      if (mesh.primitives[p].indices.empty()) continue;
      parts_.keys.push_back(same_as);
      jobs_.push_back({number, p, &posed, bake, same_as.material, out_.geometries.size(),
                       posed.deformed.empty() ? ++parts_.geometry_count : 0, consumed});
      out_.geometries.emplace_back();
    }
  }

  // Copies first, then consumed primitives; in parallel within the limit of kBytesInHand.
  void make_geometries() {
    std::stable_partition(jobs_.begin(), jobs_.end(), [](const Job& job) { return !job.consumes; });
    const uint64_t max_bytes = static_cast<uint64_t>(tbb::this_task_arena::max_concurrency()) * kBytesInHand;
    for (size_t begin = 0, end = 0; begin < jobs_.size(); begin = end) {
      for (uint64_t in_hand = 0; end < jobs_.size() && jobs_[end].consumes == jobs_[begin].consumes; ++end) {
        in_hand += vertex_bytes(scene_.meshes[jobs_[end].mesh].primitives[jobs_[end].primitive]);
        if (end > begin && in_hand > max_bytes) break;
      }
      tbb::parallel_for(begin, end, [&](size_t i) { make(jobs_[i]); });
    }
    jobs_.clear();
  }

  void make(const Job& job) {
    PosedMesh& posed = *job.posed;
    Primitive& source = scene_.meshes[job.mesh].primitives[job.primitive];
    Primitive primitive = job.consumes ? std::move(source) : copy_for(posed, source);
    if (!posed.deformed.empty()) {
      PosedMesh::Deformed& deformed = posed.deformed[job.primitive];
      primitive.positions = std::move(deformed.positions);
      primitive.normals = std::move(deformed.normals);
      primitive.tangents = std::move(deformed.tangents);
    }
    GeometrySource all{std::move(primitive), job.bake, job.material, posed.clockwise, {}};
    for (std::vector<PosedMesh::Deformed>& moment : posed.later_deformed)
      all.later_keys.push_back(std::move(moment[job.primitive]));
    Geometry& geometry = out_.geometries[job.geometry];
    geometry = make_geometry(std::move(all), scene_.materials[job.material]);
    geometry.number = job.name;
  }

  [[nodiscard]] GeometryKey key_of(const PosedMesh& posed, uint32_t primitive, const M44f& bake) const {
    const uint32_t material = material_index(scene_.meshes[static_cast<size_t>(posed.mesh)].primitives[primitive]);
    return {posed.deformed.empty() ? posed.mesh : kNone, primitive, material,
            geometry_layout(scene_.materials[material]), bake};
  }

  // Returns a copy of the attributes that make_geometry() reads.
  static Primitive copy_for(const PosedMesh& posed, const Primitive& primitive) {
    Primitive copy;
    copy.indices = primitive.indices;
    copy.stroke = primitive.stroke;
    copy.texcoords = primitive.texcoords;
    copy.colors = primitive.colors;
    if (!posed.deformed.empty()) return copy;
    copy.positions = primitive.positions;
    copy.normals = primitive.normals;
    copy.tangents = primitive.tangents;
    return copy;
  }

  // Returns the index of the group.
  uint32_t append_group(PosedMesh& posed, bool last_use) {
    const auto first = static_cast<uint32_t>(out_.geometries.size());
    append_mesh(posed, M44f(), last_use);
    out_.groups.push_back({first, static_cast<uint32_t>(out_.geometries.size()) - first});
    return static_cast<uint32_t>(out_.groups.size() - 1);
  }

  void add_instance(uint32_t group, const PosedMesh& posed) {
    WorldInstance& instance = out_.instances.emplace_back();
    out_.instance_nodes.push_back(posed.node);
    instance.group = group;
    instance.object_to_world = posed.mesh_to_world;
    instance.first_mesh = out_.groups[group].first_mesh;
    instance.moving = moves(posed);
    instance.identity = posed.mesh_to_world == M44f() && !instance.moving;
    instance.mirrored = is_mirrored(posed.mesh_to_world);
    if (!posed.later_transforms.empty()) {
      instance.motion = static_cast<uint32_t>(out_.motions.size());
      out_.motions.push_back({posed.mesh_to_world});
      out_.motions.back().insert(out_.motions.back().end(), posed.later_transforms.begin(),
                                 posed.later_transforms.end());
    }
  }

  // Interpolated geometry stays within both boxes and the space between them.
  void find_bounds() {
    std::vector<Box3f> geometry_boxes(out_.geometries.size());
    tbb::parallel_for(size_t{0}, geometry_boxes.size(),
                      [&](size_t i) { geometry_boxes[i] = box_of(out_.geometries[i]); });
    std::vector<Box3f> group_boxes;
    for (const accel::MeshGroup& group : out_.groups) {
      Box3f& box = group_boxes.emplace_back();
      for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) box.extendBy(geometry_boxes[m]);
    }
    out_.bounds = box_of_all(out_.instances.size(), 1024, [&](Box3f& bounds, size_t i) {
      const WorldInstance& instance = out_.instances[i];
      bounds.extendBy(transformed(group_boxes[instance.group], instance.object_to_world));
      if (instance.motion == accel::kNoId) return;
      for (const M44f& key : out_.motions[instance.motion])
        bounds.extendBy(transformed(group_boxes[instance.group], key));
    });
  }

  Scene& scene_;
  PosedScene& posed_;
  WorldParts& parts_;
  PreparedGeometry out_;
  std::vector<Job> jobs_;
};

} // namespace

// Meshes flattened by a transform are still visible, but cannot be instances: the matrix has no
// inverse.
bool BakeChoice::is_baked(const PosedMesh& posed) const {
  return !moves(posed) && (!posed.deformed.empty() || meshes[static_cast<size_t>(posed.mesh)] != 0 ||
                           !is_invertible(posed.mesh_to_world));
}

// Meshes that are placed once are baked. The others are baked in ascending order of the cost of
// copies, as long as all copies together stay within kMaxCopiedTriangles: a second level costs
// every ray nearby.
BakeChoice choose_baked(const std::vector<Mesh>& meshes, const PosedScene& posed) {
  constexpr uint64_t kMaxCopiedTriangles = 1U << 18;
  std::vector<uint32_t> uses(meshes.size(), 0); // of instances that can be baked
  for (const PosedMesh& mesh : posed.meshes)
    if (mesh.deformed.empty() && !moves(mesh)) ++uses[static_cast<size_t>(mesh.mesh)];
  BakeChoice choice{std::vector<uint8_t>(meshes.size(), 0)};
  std::vector<std::pair<uint64_t, size_t>> copies; // triangles, mesh
  for (size_t mesh = 0; mesh < meshes.size(); ++mesh) {
    uint64_t triangles = 0;
    for (const Primitive& primitive : meshes[mesh].primitives) triangles += primitive.indices.size() / 3;
    if (uses[mesh] != 0) copies.emplace_back(triangles * (uses[mesh] - 1), mesh);
  }
  std::sort(copies.begin(), copies.end());
  uint64_t total = 0;
  for (const auto& [triangles, mesh] : copies) {
    total += triangles;
    if (total > kMaxCopiedTriangles) break;
    choice.meshes[mesh] = 1;
  }
  return choice;
}

PreparedGeometry prepare_geometry(Scene& scene, PosedScene& posed, WorldParts* parts) {
  WorldParts none;
  WorldParts& used = parts ? *parts : none;
  used.keys.clear();
  return GeometryPreparation(scene, posed, used).run();
}

} // namespace kindling
