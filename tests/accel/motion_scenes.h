// Scenes with motion: instances with keys, and deforming meshes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/accel/accel_scenes.h"

#include <functional>
#include <string>
#include <vector>

namespace kindling::accel::testing {

// Gives the mesh `keys` keys; position(p, time) returns the position of vertex p at time key /
// (keys - 1).
[[nodiscard]] Mesh deformed(Mesh mesh, uint32_t keys, const std::function<V3f(const V3f&, float)>& position);
// Deformations: translation, twist about z, swelling, scattering of vertices, folding through a
// plane.
enum class Deformation { shift, twist, swell, explode, fold };
inline constexpr Deformation kDeformations[] = {Deformation::shift, Deformation::twist, Deformation::swell,
                                                Deformation::explode, Deformation::fold};
[[nodiscard]] Mesh deformed(Mesh mesh, uint32_t keys, Deformation how, float amount, uint32_t seed = 1);

// Returns the keys of a body that rotates by `angle` about an axis, scales from 1 to `scale` and
// moves by `displacement`.
[[nodiscard]] std::vector<M44f> keys_of(uint32_t count, const M44f& start, const V3f& axis, float angle, float scale,
                                        const V3f& displacement);

// Returns moving instances of static groups among static ones: translation far beyond their size,
// rotation with 2, 3, 17 and 129 keys, scaling through zero, mirroring, keys that are not finite,
// and many small ones.
[[nodiscard]] TestScene moving_instances();
// Returns deforming meshes of all kinds, in groups with static ones, under identity, static and
// moving transforms, with vertices that are not finite at some key.
[[nodiscard]] TestScene deforming_meshes();
// Returns a small random scene; a third have cut-outs with a filter.
[[nodiscard]] TestScene random_motion(Rng& rng, int largest);

// Returns times at 0, 1 and keys of 3, 17 and 129, between keys, and one ulp beside them.
[[nodiscard]] std::vector<float> some_times();

} // namespace kindling::accel::testing
