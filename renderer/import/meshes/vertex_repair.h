// Repairs vertex attributes: finite values, unit vectors, weights with sum 1.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <string>
#include <vector>

namespace kindling::gltf {

// Throws ImportFailure for a position that is not finite or above 1e18 in size (its square would
// not be finite).
void check_positions(const Primitive& primitive, const std::string& pointer);

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

} // namespace kindling::gltf
