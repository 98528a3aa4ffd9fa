// Repairs vertex attributes: finite values, unit vectors, weights with sum 1.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <string>
#include <vector>

namespace kindling::gltf {

// Removes the triangles of positions that are not finite or above 1e18 in size (the square would
// not be finite), and gives these vertices the position of another one. Throws ImportFailure if
// `warnings` is strict.
void repair_positions(Primitive& primitive, const std::string& pointer, Warnings& warnings);

// Removes the triangles of which is_bad(index) is true for a corner.
template <typename IsBad>
void erase_triangles(std::vector<uint32_t>& indices, const IsBad& is_bad) {
  size_t count = 0;
  for (size_t t = 0; t + 2 < indices.size(); t += 3) {
    if (is_bad(indices[t]) || is_bad(indices[t + 1]) || is_bad(indices[t + 2])) continue;
    for (size_t c = 0; c < 3; ++c) indices[count + c] = indices[t + c];
    count += 3;
  }
  indices.resize(count);
}

// Normalizes normals. One without a direction becomes the mean of the adjacent triangles' geometric
// normals.
void repair_normals(Primitive& primitive, const std::string& pointer, Warnings& warnings);

// Normalizes tangents, with w = 1 or -1. If one has no direction, removes all; they are recomputed
// later.
void repair_tangents(Primitive& primitive, const std::string& pointer, Warnings& warnings);

// Replaces texture coordinates that are not finite by 0.
void repair_texcoords(std::vector<V2f>& texcoords, const std::string& pointer, Warnings& warnings);

// Clamps colors to [0, 1], as glTF 2.0, section 3.7.2.1, requires; NaN becomes 1.
void clamp_colors(std::vector<V4f>& colors, const std::string& pointer, Warnings& warnings);

// Makes weights non-negative with a sum of 1 over all sets, and joints of zero weights 0. A vertex
// without weights follows its first joint.
void normalize_weights(Primitive& primitive);

// Sets the weights of joints from `joint_count` on to 0, and normalizes the others.
void ignore_joints_from(Primitive& primitive, size_t joint_count);

} // namespace kindling::gltf
