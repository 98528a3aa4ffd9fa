// Scenes that move: instances by keys, and meshes that deform.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/accel/accel_scenes.h"

#include <functional>
#include <string>
#include <vector>

namespace kindling::accel::testing {

// Gives the mesh so many keys; position(p, key / (keys - 1)) is where the vertex at p is at that time.
[[nodiscard]] Mesh deformed(Mesh mesh, uint32_t keys, const std::function<V3f(const V3f&, float)>& position);
// The same ways to move for all: straight on, twisted about z, swollen, every vertex its own way, folded through a plane.
enum class Deformation { shift, twist, swell, explode, fold };
inline constexpr Deformation kDeformations[] = {Deformation::shift, Deformation::twist, Deformation::swell,
                                                Deformation::explode, Deformation::fold};
[[nodiscard]] Mesh deformed(Mesh mesh, uint32_t keys, Deformation how, float amount, uint32_t seed = 1);

// Keys of a body that turns by `angle` about an axis, is scaled from 1 to `scale` and moves by `way`.
[[nodiscard]] std::vector<M44f> keys_of(uint32_t count, const M44f& start, const V3f& axis, float angle, float scale,
                                        const V3f& way);

// Moving instances of still groups, among still ones: translation far beyond their size, rotation by 2, 3, 17 and 129 keys, scaling
// through zero, mirrored on the way, keys that are not finite, hundreds.
[[nodiscard]] TestScene moving_instances();
// Deforming meshes of all sorts, in groups with still ones, in place, moved and moving; vertices that are not finite at some key.
[[nodiscard]] TestScene deforming_meshes();
// Small and random, from a seed; cut-outs by a filter in a third.
[[nodiscard]] TestScene random_motion(Rng& rng, int largest);

// 0, 1, keys of 3, 17 and 129, between keys, one ulp beside them.
[[nodiscard]] std::vector<float> some_times();

} // namespace kindling::accel::testing
