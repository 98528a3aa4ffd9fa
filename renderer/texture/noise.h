// The noises of MaterialX: values at a point, the same on every machine.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>

namespace kindling::noise {

// All follow MaterialX 1.39 (libraries/stdlib/genglsl/lib/mx_noise.glsl), which follows Open Shading Language (oslnoise.h): Perlin 2002,
// "Improving Noise", with lattice points hashed by Jenkins' lookup3. Coordinates that are not finite or beyond 2^30 read as 0.

// Of integers as coordinates of a lattice (Jenkins 2006, lookup3, hashword() with 13 as start value).
[[nodiscard]] uint32_t hash(int x, int y);
[[nodiscard]] uint32_t hash(int x, int y, int z);
[[nodiscard]] uint32_t hash(int x, int y, int z, int w);

// Gradient noise: 0 at lattice points, in [-1, 1], mean 0. The three channels of the second form share a hash, of which the first
// has the bits of the first form.
[[nodiscard]] float perlin(const V2f& p);
[[nodiscard]] float perlin(const V3f& p);
[[nodiscard]] V3f perlin_rgb(const V2f& p);
[[nodiscard]] V3f perlin_rgb(const V3f& p);

// One number in [0, 1] for each unit cell.
[[nodiscard]] float cell(const V2f& p);
[[nodiscard]] float cell(const V3f& p);
[[nodiscard]] V3f cell_rgb(const V2f& p);
[[nodiscard]] V3f cell_rgb(const V3f& p);

// Distances to the nearest, second and third of points that stand one in each unit cell, in its middle for jitter 0, anywhere in it for 1
// (Worley 1996, "A Cellular Texture Basis Function"). Only neighboring cells are searched, as MaterialX has it. `nearest` gets the nearest
// point.
[[nodiscard]] V3f worley(const V2f& p, float jitter, V2f& nearest);
[[nodiscard]] V3f worley(const V3f& p, float jitter, V3f& nearest);

} // namespace kindling::noise
