// Morph targets and linear blend skinning, vertex by vertex (glTF 2.0, sections 3.7.2.2 and 3.7.3).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/deform.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cassert>

namespace kindling {
namespace {

constexpr size_t kVerticesPerTask = 4096;

V3f normalized_or(const V3f& v, const V3f& otherwise) {
  const float length = v.length();
  return length > 0.0f && std::isfinite(length) ? v / length : otherwise;
}

// The linear part of a transform, applied to positions, normals (inverse transpose) and handedness.
class Linear {
 public:
  explicit Linear(const M44f& m) : m_(m) {
    // Cofactors are products of two entries; scaled by the largest entry they cannot underflow.
    float largest = 0.0f;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) largest = std::max(largest, std::abs(m[row][column]));
    }
    const float scale = largest > 0.0f && std::isfinite(largest) ? 1.0f / largest : 0.0f;
    const V3f x = V3f(m[0][0], m[0][1], m[0][2]) * scale;
    const V3f y = V3f(m[1][0], m[1][1], m[1][2]) * scale;
    const V3f z = V3f(m[2][0], m[2][1], m[2][2]) * scale;
    yz_ = y.cross(z);
    zx_ = z.cross(x);
    xy_ = x.cross(y);
    sign_ = x.dot(yz_) < 0.0f ? -1.0f : 1.0f;
  }

  // Correct up to a positive factor; zero only for transforms of rank one or less.
  [[nodiscard]] V3f normal(const V3f& n) const { return (yz_ * n.x + zx_ * n.y + xy_ * n.z) * sign_; }
  [[nodiscard]] V3f vector(const V3f& v) const { return transform_vector(m_, v); }
  [[nodiscard]] float handedness() const { return sign_; }

 private:
  const M44f& m_;
  V3f yz_, zx_, xy_;
  float sign_ = 1.0f;
};

M44f blend_joints(const Primitive& primitive, size_t vertex, std::span<const M44f> joint_matrices) {
  const size_t vertex_count = primitive.positions.size();
  M44f blended(0.0f);
  for (size_t i = vertex; i < primitive.joints.size(); i += vertex_count) {
    for (int k = 0; k < 4; ++k) {
      const float weight = primitive.weights[i][k];
      if (weight == 0.0f) continue;
      assert(primitive.joints[i][static_cast<size_t>(k)] < joint_matrices.size());
      blended += joint_matrices[primitive.joints[i][static_cast<size_t>(k)]] * weight;
    }
  }
  // The weights sum to 1 up to rounding; setting the corner exactly keeps the matrix affine.
  blended[3][3] = 1.0f;
  return blended;
}

// A morph target with a nonzero weight.
struct ActiveTarget {
  const MorphTarget* target;
  float weight;
};

std::vector<ActiveTarget> active_targets(const Primitive& primitive, std::span<const float> weights) {
  std::vector<ActiveTarget> active;
  for (size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
    const MorphTarget& target = primitive.targets[i];
    const bool moves = !target.positions.empty() || !target.normals.empty() || !target.tangents.empty();
    if (weights[i] != 0.0f && moves) active.push_back({&target, weights[i]});
  }
  return active;
}

void morph_vertex(const std::vector<ActiveTarget>& targets, size_t v, PosedMesh::Deformed& out) {
  const bool has_normals = !out.normals.empty();
  const bool has_tangents = !out.tangents.empty();
  V3f normal = has_normals ? out.normals[v] : V3f(0.0f);
  V3f tangent = has_tangents ? V3f(out.tangents[v].x, out.tangents[v].y, out.tangents[v].z) : V3f(0.0f);
  for (const ActiveTarget& active : targets) {
    const MorphTarget& target = *active.target;
    if (!target.positions.empty()) out.positions[v] += target.positions[v] * active.weight;
    if (has_normals && !target.normals.empty()) normal += target.normals[v] * active.weight;
    if (has_tangents && !target.tangents.empty()) tangent += target.tangents[v] * active.weight;
  }
  if (has_normals) {
    normal = normalized_or(normal, out.normals[v]);
    out.normals[v] = normal;
  }
  if (has_tangents) {
    // Files often move normals but not tangents: keeps the pair orthogonal.
    if (has_normals) tangent -= normal * normal.dot(tangent);
    const V4f rest = out.tangents[v];
    tangent = normalized_or(tangent, V3f(rest.x, rest.y, rest.z));
    out.tangents[v] = {tangent.x, tangent.y, tangent.z, rest.w};
  }
}

void transform_vertex(const M44f& matrix, size_t v, PosedMesh::Deformed& out) {
  out.positions[v] = transform_point(matrix, out.positions[v]);
  if (out.normals.empty() && out.tangents.empty()) return;
  const Linear linear(matrix);
  if (!out.normals.empty()) out.normals[v] = normalized_or(linear.normal(out.normals[v]), out.normals[v]);
  if (!out.tangents.empty()) {
    // A mirrored frame keeps its texture direction only if the sign of the bitangent flips.
    const V4f& rest = out.tangents[v];
    const V3f old(rest.x, rest.y, rest.z);
    const V3f tangent = normalized_or(linear.vector(old), old);
    out.tangents[v] = {tangent.x, tangent.y, tangent.z, rest.w * linear.handedness()};
  }
}

} // namespace

PosedMesh::Deformed deform_primitive(const Primitive& primitive, std::span<const float> morph_weights,
                                     std::span<const M44f> joint_matrices, const M44f& unskinned) {
  PosedMesh::Deformed out{primitive.positions, primitive.normals, primitive.tangents};
  const std::vector<ActiveTarget> targets = active_targets(primitive, morph_weights);
  const bool skinned = !joint_matrices.empty();
  const bool has_joints = !primitive.joints.empty() && primitive.weights.size() == primitive.joints.size();

  tbb::parallel_for(tbb::blocked_range<size_t>(0, out.positions.size(), kVerticesPerTask),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t v = range.begin(); v != range.end(); ++v) {
                        if (!targets.empty()) morph_vertex(targets, v, out);
                        if (skinned && has_joints) {
                          transform_vertex(blend_joints(primitive, v, joint_matrices), v, out);
                        } else if (skinned) {
                          transform_vertex(unskinned, v, out);
                        }
                      }
                    });
  return out;
}

void move_to_world(const M44f& mesh_to_world, PosedMesh::Deformed& deformed) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, deformed.positions.size(), kVerticesPerTask),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t v = range.begin(); v != range.end(); ++v)
                        transform_vertex(mesh_to_world, v, deformed);
                    });
}

} // namespace kindling
