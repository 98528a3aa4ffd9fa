// The plugin: builds compressed wide BVHs over triangles and over instances, and answers queries.
// SPDX-License-Identifier: Apache-2.0
#include "accel/plugin/kindling_accelerator.h"
#include "bench/plugin/traversal.h"

#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <string_view>
#include <utility>

using namespace compressed_bvh;

namespace {

// Triangles of several meshes in one space.
struct TriangleTree {
  WideTree tree;
  std::vector<TriangleBlock> blocks; // by leaf

  // `instance` and meshes of each part.
  struct Part {
    uint32_t instance;
    uint32_t first_mesh;
    uint32_t mesh_count;
  };
  void build(const KindlingScene& scene, const std::vector<Part>& parts, size_t leaf_size, unsigned threads) {
    struct Source {
      uint32_t instance, mesh, triangle;
    };
    std::vector<Source> sources;
    std::vector<Box> boxes;
    for (const Part& part : parts)
      for (uint32_t m = part.first_mesh; m < part.first_mesh + part.mesh_count; ++m)
        for (uint64_t t = 0; t < scene.meshes[m].triangle_count; ++t) {
          const std::array<Vec, 3> p = corners(scene.meshes[m], t);
          if (!can_be_hit(p[0], p[1], p[2])) continue;
          Box box;
          for (const Vec& corner : p) box.add(corner);
          boxes.push_back(box);
          sources.push_back({part.instance, m, static_cast<uint32_t>(t)});
        }
    tree = widen(build_binary_tree(boxes, threads), leaf_size);
    blocks.resize(tree.leaves.size());
    for (size_t leaf = 0; leaf < blocks.size(); ++leaf) {
      TriangleBlock& block = blocks[leaf];
      const LeafRange range = tree.leaves[leaf];
      for (uint32_t lane = 0; lane < kLeafSize; ++lane) {
        constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
        std::array<Vec, 3> p{Vec{kNone, kNone, kNone}, Vec{kNone, kNone, kNone}, Vec{kNone, kNone, kNone}};
        if (lane < range.count) {
          const Source& source = sources[tree.order[range.first + lane]];
          p = corners(scene.meshes[source.mesh], source.triangle);
          block.instance[lane] = source.instance;
          block.mesh[lane] = source.mesh;
          block.triangle[lane] = source.triangle;
        }
        for (size_t c = 0; c < 3; ++c)
          for (size_t k = 0; k < 3; ++k) block.corner[c][k][lane] = p[c][k];
      }
    }
    tree.order = {}; // the blocks have it
    tree.leaves = {};
  }

  [[nodiscard]] size_t bytes() const {
    return tree.nodes.size() * sizeof(WideNode) + blocks.size() * sizeof(TriangleBlock);
  }

  // Lowers `t_max` and sets `hit` by the nearest hit, or any.
  template <bool kAny>
  bool trace(const PreparedRay& ray, float& t_max, Hit& hit) const {
    bool found = false;
    walk(tree, ray, t_max, [&](uint32_t leaf) {
      found |= intersect_block(blocks[leaf], leaf, ray, t_max, hit);
      return kAny && found;
    });
    return found;
  }

 private:
  static std::array<Vec, 3> corners(const KindlingMesh& mesh, uint64_t triangle) {
    std::array<Vec, 3> p;
    for (size_t c = 0; c < 3; ++c) {
      const float* position = mesh.positions + 3 * static_cast<size_t>(mesh.indices[3 * triangle + c]);
      p[c] = {position[0], position[1], position[2]};
    }
    return p;
  }
};

// An instance that is not part of the world's tree.
struct PlacedTree {
  std::array<std::array<double, 4>, 3> to_object{};
  uint32_t instance = 0;
  const TriangleTree* triangles = nullptr;

  // Returns false for a matrix that cannot be inverted.
  bool invert(const float m[3][4]) {
    double determinant = 0.0;
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k) {
        const size_t a = (k + 1) % 3, b = (k + 2) % 3, p = (i + 1) % 3, q = (i + 2) % 3;
        to_object[i][k] = static_cast<double>(m[a][p]) * m[b][q] - static_cast<double>(m[a][q]) * m[b][p];
      }
    for (size_t k = 0; k < 3; ++k) determinant += m[0][k] * to_object[k][0];
    if (!std::isfinite(determinant) || determinant == 0.0) return false;
    for (std::array<double, 4>& row : to_object) {
      for (size_t k = 0; k < 3; ++k) {
        row[k] /= determinant;
        if (!(std::fabs(row[k]) <= 1e12)) return false;
      }
      row[3] = -(row[0] * m[0][3] + row[1] * m[1][3] + row[2] * m[2][3]);
    }
    return true;
  }
  [[nodiscard]] Vec transform(const float* p, double w) const {
    Vec out;
    for (size_t i = 0; i < 3; ++i)
      out[i] = static_cast<float>(to_object[i][0] * p[0] + to_object[i][1] * p[1] + to_object[i][2] * p[2] +
                                  to_object[i][3] * w);
    return out;
  }
};

// World bounds of a box, widened for the rounding of rays' transforms.
Box bounds_in_world(const Box& box, const float m[3][4]) {
  Box out;
  float largest = 0.0f;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec p;
    for (size_t i = 0; i < 3; ++i) {
      double sum = m[i][3];
      for (size_t k = 0; k < 3; ++k)
        sum += static_cast<double>(m[i][k]) * ((corner >> k & 1) != 0 ? box.high[k] : box.low[k]);
      p[i] = static_cast<float>(sum);
      largest = std::max({largest, std::fabs(p[i]), std::fabs(m[i][3])});
    }
    out.add(p);
  }
  for (size_t k = 0; k < 3; ++k) {
    out.low[k] -= 0x1p-19f * largest;
    out.high[k] += 0x1p-19f * largest;
  }
  return out;
}

bool can_hit(const KindlingRay& ray) {
  const Vec o{ray.origin[0], ray.origin[1], ray.origin[2]}, d{ray.direction[0], ray.direction[1], ray.direction[2]};
  return is_finite(o) && is_finite(d) && (d[0] != 0.0f || d[1] != 0.0f || d[2] != 0.0f) && ray.t_min < ray.t_max &&
         ray.t_max > 0.0f;
}

} // namespace

struct KindlingAccelerator {
  TriangleTree world;                                                             // of instances under the identity
  std::map<std::pair<uint32_t, uint32_t>, std::unique_ptr<TriangleTree>> objects; // by meshes
  WideTree instances;                                                             // a leaf is a range of `placed`
  std::vector<PlacedTree> placed;
  std::vector<LeafRange> leaves;
  KindlingStatistics statistics{};

  void build(const KindlingScene& scene, size_t leaf_size, unsigned threads) {
    std::vector<TriangleTree::Part> at_rest;
    std::vector<PlacedTree> unsorted;
    std::vector<Box> boxes;
    for (uint64_t i = 0; i < scene.instance_count; ++i) {
      const KindlingInstance& instance = scene.instances[i];
      if (instance.is_identity != 0) {
        at_rest.push_back({static_cast<uint32_t>(i), instance.first_mesh, instance.mesh_count});
        continue;
      }
      PlacedTree tree;
      if (!tree.invert(instance.object_to_world)) continue;
      std::unique_ptr<TriangleTree>& object = objects[{instance.first_mesh, instance.mesh_count}];
      if (!object) {
        object = std::make_unique<TriangleTree>();
        object->build(scene, {{0, instance.first_mesh, instance.mesh_count}}, leaf_size, threads);
      }
      if (object->tree.nodes.empty()) continue;
      const Box box = bounds_in_world(object->tree.box, instance.object_to_world);
      if (!is_finite(box.low) || !is_finite(box.high)) continue;
      tree.instance = static_cast<uint32_t>(i);
      tree.triangles = object.get();
      unsorted.push_back(tree);
      boxes.push_back(box);
    }
    world.build(scene, at_rest, leaf_size, threads);
    instances = widen(build_binary_tree(boxes, threads), 1);
    for (const uint32_t i : instances.order) placed.push_back(unsorted[i]);
    count();
  }

  template <bool kAny>
  [[nodiscard]] bool trace(const KindlingRay& ray, KindlingHit& out) const {
    if (!can_hit(ray)) return false;
    const Vec o{ray.origin[0], ray.origin[1], ray.origin[2]}, d{ray.direction[0], ray.direction[1], ray.direction[2]};
    const float t_min = std::max(ray.t_min, 0.0f);
    float t_max = std::min(ray.t_max, std::numeric_limits<float>::max());
    Hit hit;
    const TriangleTree* hit_tree = nullptr;
    uint32_t hit_instance = KINDLING_NO_HIT;
    if (world.trace<kAny>(PreparedRay(o, d, t_min, 0.0f), t_max, hit)) {
      if (kAny) return true;
      hit_tree = &world;
    }
    if (!placed.empty()) {
      const float slack = 0x1p-19f * std::max({std::fabs(o[0]), std::fabs(o[1]), std::fabs(o[2])});
      bool done = false;
      walk(instances, PreparedRay(o, d, t_min, slack), t_max, [&](uint32_t leaf) {
        const PlacedTree& tree = placed[leaf];
        const Vec object_o = tree.transform(ray.origin, 1.0), object_d = tree.transform(ray.direction, 0.0);
        if (!is_finite(object_o) || !is_finite(object_d) ||
            (object_d[0] == 0.0f && object_d[1] == 0.0f && object_d[2] == 0.0f))
          return false;
        if (!tree.triangles->trace<kAny>(PreparedRay(object_o, object_d, t_min, 0.0f), t_max, hit)) return false;
        hit_tree = tree.triangles;
        hit_instance = tree.instance;
        return done = kAny;
      });
      if (done) return true;
    }
    if (hit_tree == nullptr) return false;
    const TriangleBlock& block = hit_tree->blocks[hit.block];
    out = {hit.t,
           hit.u,
           hit.v,
           hit_instance == KINDLING_NO_HIT ? block.instance[hit.lane] : hit_instance,
           block.mesh[hit.lane],
           block.triangle[hit.lane]};
    return true;
  }

 private:
  void count() {
    const auto add = [this](const TriangleTree& tree) {
      statistics.memory_bytes += tree.bytes();
      statistics.node_count += tree.tree.nodes.size();
      statistics.leaf_count += tree.blocks.size();
      for (const TriangleBlock& block : tree.blocks)
        for (size_t lane = 0; lane < kLeafSize; ++lane)
          statistics.reference_count += std::isnan(block.corner[0][0][lane]) ? 0 : 1;
    };
    add(world);
    for (const auto& [meshes, tree] : objects) add(*tree);
    statistics.memory_bytes += instances.nodes.size() * sizeof(WideNode) + placed.size() * sizeof(PlacedTree);
    statistics.node_count += instances.nodes.size();
    instances.order = {};
    instances.leaves = {};
  }
};

namespace {

KindlingAccelerator* build(const KindlingScene* scene, const KindlingBuildSettings* settings, char* error,
                           size_t error_bytes) {
  size_t leaf_size = kLeafSize;
  const std::string_view options = settings->options;
  if (options.size() == 6 && options.starts_with("leaf=") && options[5] >= '1' && options[5] <= '4') {
    leaf_size = static_cast<size_t>(options[5] - '0');
  } else if (!options.empty()) {
    std::snprintf(error, error_bytes, "unknown options '%s'; use leaf=1 to leaf=4", settings->options);
    return nullptr;
  }
  try {
    auto accelerator = std::make_unique<KindlingAccelerator>();
    accelerator->build(*scene, leaf_size, settings->thread_count);
    return accelerator.release();
  } catch (const std::exception& exception) {
    std::snprintf(error, error_bytes, "%s", exception.what());
    return nullptr;
  }
}

void destroy(KindlingAccelerator* accelerator) { delete accelerator; }

int intersect(const KindlingAccelerator* accelerator, const KindlingRay* rays, KindlingHit* hits, size_t count) {
  for (size_t i = 0; i < count; ++i)
    if (!accelerator->trace<false>(rays[i], hits[i])) hits[i].instance = KINDLING_NO_HIT;
  return 0;
}

int occluded(const KindlingAccelerator* accelerator, const KindlingRay* rays, uint8_t* blocked, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    KindlingHit unused;
    blocked[i] = accelerator->trace<true>(rays[i], unused) ? 1 : 0;
  }
  return 0;
}

void statistics(const KindlingAccelerator* accelerator, KindlingStatistics* out) { *out = accelerator->statistics; }

constexpr KindlingAcceleratorTable kTable{KINDLING_ACCELERATOR_VERSION,
                                          sizeof(KindlingAcceleratorTable),
#ifdef __AVX2__
                                          "8-wide BVH with compressed nodes, AVX2",
#else
                                          "8-wide BVH with compressed nodes, portable",
#endif
                                          build,
                                          destroy,
                                          intersect,
                                          occluded,
                                          nullptr, // no calls for coherent rays
                                          nullptr,
                                          statistics,
                                          nullptr};

} // namespace

const KindlingAcceleratorTable* kindling_accelerator_plugin(uint32_t newest) {
  return newest >= KINDLING_ACCELERATOR_VERSION ? &kTable : nullptr;
}
