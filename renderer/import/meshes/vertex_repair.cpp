// Parallel repair of vertex attributes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/meshes/vertex_repair.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace kindling::gltf {
namespace {

constexpr float kFarthest = 1e18f;
constexpr size_t kVertexGrain = 1U << 14;

// Returns the number of i in [0, count) for which f(i) is false.
template <typename F>
size_t count_bad(size_t count, F&& f) {
  std::atomic<size_t> bad{0};
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kVertexGrain), [&](const tbb::blocked_range<size_t>& range) {
    size_t here = 0;
    for (size_t i = range.begin(); i < range.end(); ++i) here += f(i) ? 0U : 1U;
    if (here != 0) bad.fetch_add(here, std::memory_order_relaxed);
  });
  return bad.load();
}

// Returns false, with v unchanged, if it has no direction.
bool normalize(V3f& v) {
  const V3d wide(v.x, v.y, v.z);
  const double length = std::sqrt(wide.dot(wide));
  if (!(length > 1e-30) || !std::isfinite(length)) return false;
  v = V3f(static_cast<float>(wide.x / length), static_cast<float>(wide.y / length),
          static_cast<float>(wide.z / length));
  return true;
}

} // namespace

void repair_positions(Primitive& primitive, const std::string& pointer, Warnings& warnings) {
  const auto fine = [&](size_t i) {
    const V3f& p = primitive.positions[i];
    return std::abs(p.x) <= kFarthest && std::abs(p.y) <= kFarthest && std::abs(p.z) <= kFarthest;
  };
  if (count_bad(primitive.positions.size(), fine) == 0) return;
  size_t first = 0;
  while (fine(first)) ++first;
  const V3f& p = primitive.positions[first];
  warnings.repair("position", pointer,
                  fmt::format("vertex ({}, {}, {}), expected finite numbers up to 1e18", p.x, p.y, p.z),
                  "ACCESSOR_INVALID_FLOAT", "its triangles are not rendered");
  erase_triangles(primitive.indices, [&](uint32_t index) { return !fine(index); });
  if (primitive.indices.empty()) return;
  const V3f other = primitive.positions[primitive.indices.front()];
  for (size_t i = 0; i < primitive.positions.size(); ++i)
    if (!fine(i)) primitive.positions[i] = other;
}

void repair_normals(Primitive& primitive, const std::string& pointer, Warnings& warnings) {
  const size_t bad = count_bad(primitive.normals.size(), [&](size_t i) { return normalize(primitive.normals[i]); });
  if (bad == 0) return;
  warnings.add("normals", pointer, fmt::format("{} normals without a direction are replaced", bad),
               "ACCESSOR_VECTOR3_NON_UNIT");
  const auto has_direction = [](const V3f& n) { return is_finite(n) && std::abs(n.dot(n) - 1.0f) < 1e-3f; };
  std::vector<V3d> sums(primitive.normals.size(), V3d(0.0));
  for (size_t t = 0; t < primitive.indices.size(); t += 3) {
    const uint32_t* corner = &primitive.indices[t];
    const V3d a(primitive.positions[corner[0]]);
    const V3d normal = (V3d(primitive.positions[corner[1]]) - a).cross(V3d(primitive.positions[corner[2]]) - a);
    for (int c = 0; c < 3; ++c) sums[corner[c]] += normal;
  }
  for (size_t i = 0; i < sums.size(); ++i) {
    if (has_direction(primitive.normals[i])) continue;
    const double length = std::sqrt(sums[i].dot(sums[i]));
    primitive.normals[i] = length > 0.0 && std::isfinite(length) ? V3f(sums[i] / length) : V3f(0.0f, 0.0f, 1.0f);
  }
}

void repair_tangents(Primitive& primitive, const std::string& pointer, Warnings& warnings) {
  const size_t bad = count_bad(primitive.tangents.size(), [&](size_t i) {
    V4f& tangent = primitive.tangents[i];
    V3f direction(tangent.x, tangent.y, tangent.z);
    if (!normalize(direction) || std::isnan(tangent.w)) return false;
    tangent = V4f(direction.x, direction.y, direction.z, tangent.w < 0.0f ? -1.0f : 1.0f);
    return true;
  });
  if (bad == 0) return;
  warnings.add("tangents", pointer, fmt::format("{} tangents without a direction: all are recomputed", bad),
               "ACCESSOR_VECTOR3_NON_UNIT");
  primitive.tangents.clear();
}

void repair_texcoords(std::vector<V2f>& texcoords, const std::string& pointer, Warnings& warnings) {
  const size_t bad = count_bad(texcoords.size(), [&](size_t i) {
    V2f& uv = texcoords[i];
    if (std::isfinite(uv.x) && std::isfinite(uv.y)) return true;
    uv = V2f(0.0f, 0.0f);
    return false;
  });
  if (bad > 0)
    warnings.add("texcoords", pointer, fmt::format("{} texture coordinates that are not finite are set to 0", bad),
                 "ACCESSOR_INVALID_FLOAT");
}

void clamp_colors(std::vector<V4f>& colors, const std::string& pointer, Warnings& warnings) {
  const size_t bad = count_bad(colors.size(), [&](size_t i) {
    bool fine = true;
    for (int c = 0; c < 4; ++c) {
      float& value = colors[i][c];
      fine &= !std::isnan(value);
      value = std::isnan(value) ? 1.0f : std::clamp(value, 0.0f, 1.0f);
    }
    return fine;
  });
  if (bad > 0)
    warnings.add("colors", pointer, fmt::format("{} vertex colors that are NaN are set to 1", bad),
                 "ACCESSOR_INVALID_FLOAT");
}

void normalize_weights(Primitive& primitive) {
  const size_t vertices = primitive.positions.size();
  if (vertices == 0 || primitive.weights.empty()) return;
  const size_t sets = primitive.weights.size() / vertices;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, vertices, kVertexGrain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t v = range.begin(); v < range.end(); ++v) {
                        double sum = 0.0;
                        for (size_t s = 0; s < sets; ++s) {
                          V4f& weights = primitive.weights[s * vertices + v];
                          for (int c = 0; c < 4; ++c) {
                            weights[c] = std::max(weights[c], 0.0f);
                            sum += static_cast<double>(weights[c]);
                          }
                        }
                        if (!(sum > 1e-30)) {
                          for (size_t s = 0; s < sets; ++s)
                            primitive.weights[s * vertices + v] = V4f(s == 0 ? 1.0f : 0.0f, 0.0f, 0.0f, 0.0f);
                          sum = 1.0;
                        }
                        for (size_t s = 0; s < sets; ++s) {
                          for (int c = 0; c < 4; ++c) {
                            float& weight = primitive.weights[s * vertices + v][c];
                            weight = static_cast<float>(static_cast<double>(weight) / sum);
                            if (weight == 0.0f) primitive.joints[s * vertices + v][static_cast<size_t>(c)] = 0;
                          }
                        }
                      }
                    });
}

void ignore_joints_from(Primitive& primitive, size_t joint_count) {
  for (size_t i = 0; i < primitive.joints.size(); ++i) {
    for (size_t c = 0; c < 4; ++c) {
      if (primitive.joints[i][c] < joint_count) continue;
      primitive.joints[i][c] = 0;
      primitive.weights[i][static_cast<int>(c)] = 0.0f;
    }
  }
  normalize_weights(primitive);
}

} // namespace kindling::gltf
