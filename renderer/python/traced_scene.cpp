// Blocks of rays: packed from strided arrays, traced, and handed out, one task each.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/python/traced_scene.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace kindling::python {
namespace {

constexpr size_t kBlock = 1024;  // rays per task
constexpr size_t kCoherent = 64; // rays that are traced together if they are coherent

// Runs f in an arena of so many threads; 0: all.
template <class F>
void with_threads(int threads, const F& f) {
  if (threads == 0)
    f();
  else
    tbb::task_arena(threads).execute(f);
}

std::string vertex_list(const Triples& faces, size_t face) {
  return "(" + std::to_string(faces.at(face, 0)) + ", " + std::to_string(faces.at(face, 1)) + ", " +
         std::to_string(faces.at(face, 2)) + ")";
}

// Returns the common number of rows.
size_t common_rows(std::initializer_list<std::pair<const char*, size_t>> arrays) {
  size_t count = 1;
  const char* counted = nullptr;
  for (const auto& [name, rows] : arrays) {
    if (rows == Floats::kAny) continue;
    if (counted != nullptr && rows != count)
      throw nb::value_error((std::string(name) + " has " + std::to_string(rows) + " rows, but " + counted + " has " +
                             std::to_string(count))
                                .c_str());
    count = rows;
    counted = name;
  }
  return count;
}

} // namespace

void RayArrays::pack(size_t first, std::span<accel::Ray> packed) const {
  const size_t size = packed.size();
  origins.for_rows3(first, size, [&](size_t i, float x, float y, float z) { packed[i].origin = {x, y, z}; });
  directions.for_rows3(first, size, [&](size_t i, float x, float y, float z) { packed[i].direction = {x, y, z}; });
  t_min.for_numbers(first, size, [&](size_t i, float t) { packed[i].t_min = t; });
  t_max.for_numbers(first, size, [&](size_t i, float t) { packed[i].t_max = t; });
}

RayArrays ray_arrays(const Array& origins, const Array& directions, const Array& t_min, const Array& t_max) {
  RayArrays rays{Floats(origins, "origins", 3), Floats(directions, "directions", 3), Floats(t_min, "t_min", 0),
                 Floats(t_max, "t_max", 0), 0};
  rays.count = common_rows({{"origins", rays.origins.rows()},
                            {"directions", rays.directions.rows()},
                            {"t_min", rays.t_min.rows()},
                            {"t_max", rays.t_max.rows()}});
  return rays;
}

void TracedScene::add_mesh(const Array& vertices, const Array& faces) {
  const std::string number = std::to_string(meshes_.size());
  const std::string vertices_name = "meshes[" + number + "]: vertices", faces_name = "meshes[" + number + "]: faces";
  if (vertices.ndim() != 2)
    throw nb::value_error((vertices_name + ": shape " + shape_text(vertices) + ", expected (n, 3)").c_str());
  const Floats positions(vertices, vertices_name.c_str(), 3);
  const Triples corners(faces, faces_name.c_str());
  if (corners.rows() >= 1U << 31U) throw nb::value_error((faces_name + ": more than 2^31 - 1 triangles").c_str());
  Mesh& mesh = meshes_.emplace_back();
  mesh.positions.reserve(positions.rows() + 2);
  for (size_t i = 0; i < positions.rows(); ++i) mesh.positions.push_back(positions.row3(i));
  mesh.indices.reserve(3 * corners.rows());
  for (size_t i = 0; i < corners.rows(); ++i)
    for (size_t k = 0; k < 3; ++k) {
      const int64_t index = corners.at(i, k);
      if (index < 0 || index >= static_cast<int64_t>(positions.rows()))
        throw nb::value_error((faces_name + "[" + std::to_string(i) + "] is " + vertex_list(corners, i) +
                               ", but there are " + std::to_string(positions.rows()) + " vertices")
                                  .c_str());
      mesh.indices.push_back(static_cast<uint32_t>(index));
    }
}

void TracedScene::add_instance(const Placement& placement) {
  if (placement.mesh >= meshes_.size())
    throw nb::value_error(("instances[" + std::to_string(instances_.size()) + "]: mesh " +
                           std::to_string(placement.mesh) + ", but there are " + std::to_string(meshes_.size()))
                              .c_str());
  instances_.push_back({placement.mesh, placement.object_to_world, accel::kNoId});
}

void TracedScene::build(accel::Kind kind, accel::Quality quality, bool robust, int threads) {
  kind_ = kind;
  for (const Mesh& mesh : meshes_) {
    groups_.push_back({static_cast<uint32_t>(views_.size()), 1});
    views_.push_back({mesh.positions, mesh.indices});
  }
  accel::BuildInput input;
  input.meshes = views_;
  input.groups = groups_;
  input.instances = instances_;
  accel::BuildOptions options;
  options.quality = quality;
  options.robust = robust;
  options.all_hits = true;
  with_threads(threads, [&] { accelerator_ = accel::make_accelerator(kind, input, options); });
}

void for_blocks(size_t total, int threads, const std::function<void(size_t, size_t)>& f) {
  with_threads(threads, [&] {
    tbb::parallel_for(size_t{0}, (total + kBlock - 1) / kBlock,
                      [&](size_t b) { f(b * kBlock, std::min(kBlock, total - b * kBlock)); });
  });
}

bool are_coherent(std::span<const accel::Ray> rays) {
  constexpr float kCosine = 0.97f;
  const accel::Ray& first = rays.front();
  const float length = first.direction.length();
  return std::all_of(rays.begin(), rays.end(), [&](const accel::Ray& ray) {
    return ray.origin == first.origin &&
           ray.direction.dot(first.direction) >= kCosine * length * ray.direction.length();
  });
}

void TracedScene::intersect(const RayArrays& rays, int threads,
                            const std::function<void(size_t, std::span<const accel::Hit>)>& done) const {
  for_blocks(rays.count, threads, [&](size_t first, size_t count) {
    std::array<accel::Ray, kBlock> packed;
    std::array<accel::Hit, kBlock> hits;
    rays.pack(first, std::span(packed).first(count));
    const std::span<const accel::Ray> block(packed.data(), count);
    // The kd-tree's two queries give the same bits; Embree's coherent query rounds differently.
    if (kind_ == accel::Kind::kdtree && are_coherent(block.first(std::min(count, kCoherent)))) {
      for (size_t i = 0; i < count; i += kCoherent) {
        const size_t some = std::min(kCoherent, count - i);
        accelerator_->intersect_coherent(block.subspan(i, some), std::span(hits).subspan(i, some));
      }
    } else {
      accelerator_->intersect(block, std::span(hits).first(count));
    }
    done(first, std::span(hits).first(count));
  });
}

void TracedScene::occluded(const RayArrays& rays, int threads, uint8_t* blocked) const {
  for_blocks(rays.count, threads, [&](size_t first, size_t count) {
    std::array<accel::Ray, kBlock> packed;
    rays.pack(first, std::span(packed).first(count));
    accelerator_->occluded(std::span<const accel::Ray>(packed).first(count), std::span(blocked + first, count));
  });
}

accel::CrossingLists TracedScene::all_hits(const RayArrays& rays, size_t limit, int threads) const {
  accel::CrossingLists lists;
  std::vector<accel::Ray> packed(rays.count);
  for_blocks(rays.count, threads,
             [&](size_t first, size_t count) { rays.pack(first, std::span(packed).subspan(first, count)); });
  with_threads(threads, [&] { (void)accel::all_hits(*accelerator_, packed, limit, lists); }); // built with all_hits
  return lists;
}

} // namespace kindling::python
