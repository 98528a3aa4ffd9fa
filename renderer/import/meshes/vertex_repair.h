// Brings vertex attributes into the form that the Scene promises: finite, unit length, in range.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <string>
#include <vector>

namespace kindling::gltf {

// Throws ImportFailure for a position that is not finite or above 1e18 in size (its square would not be finite).
void check_positions(const Primitive& primitive, const std::string& pointer);

// Normals to unit length; where one has none, the mean of the adjacent triangles' geometric normals takes its place.
void repair_normals(Primitive& primitive, const std::string& pointer, Warnings& warnings);

// Tangents to unit length with w = 1 or -1; if one cannot be, all are dropped and made anew later.
void repair_tangents(Primitive& primitive, const std::string& pointer, Warnings& warnings);

// Values that are not finite become 0.
void repair_texcoords(std::vector<V2f>& texcoords, const std::string& pointer, Warnings& warnings);

// To [0, 1], as glTF 2.0, section 3.7.2.1, asks for; values that are no number become 1.
void clamp_colors(std::vector<V4f>& colors, const std::string& pointer, Warnings& warnings);

// Weights become non-negative with a sum of 1 over all sets (a vertex without any follows its first joint), and the
// joints of zero weights 0.
void normalize_weights(Primitive& primitive);

} // namespace kindling::gltf
