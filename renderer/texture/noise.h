// MaterialX's noise functions: Perlin, cell and Worley noise, equal on every machine.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>

namespace kindling::noise {

// All functions follow MaterialX 1.39 (libraries/stdlib/genglsl/lib/mx_noise.glsl), which follows
// Open Shading Language (oslnoise.h): Perlin 2002, "Improving Noise", with lattice points hashed by
// Jenkins' lookup3. Coordinates that are not finite or beyond 2^30 count as 0.

// Return the hash of integer lattice coordinates (Jenkins 2006, lookup3, hashword() with initial
// value 13).
[[nodiscard]] uint32_t hash(int x, int y);
[[nodiscard]] uint32_t hash(int x, int y, int z);
[[nodiscard]] uint32_t hash(int x, int y, int z, int w);

// Return gradient noise: in [-1, 1], with mean 0, and 0 at lattice points. The three channels of
// the _rgb forms use different bits of one hash; the first channel equals perlin().
[[nodiscard]] float perlin(const V2f& p);
[[nodiscard]] float perlin(const V3f& p);
[[nodiscard]] V3f perlin_rgb(const V2f& p);
[[nodiscard]] V3f perlin_rgb(const V3f& p);

// Return a constant in [0, 1] for each unit cell.
[[nodiscard]] float cell(const V2f& p);
[[nodiscard]] float cell(const V3f& p);
[[nodiscard]] V3f cell_rgb(const V2f& p);
[[nodiscard]] V3f cell_rgb(const V3f& p);

// Return the distances to the three nearest feature points (Worley 1996, "A Cellular Texture Basis
// Function"). Each unit cell has one, at its center for jitter 0 and anywhere in the cell for
// jitter 1. Only neighboring cells are searched, as in MaterialX. `nearest` receives the nearest
// point.
[[nodiscard]] V3f worley(const V2f& p, float jitter, V2f& nearest);
[[nodiscard]] V3f worley(const V3f& p, float jitter, V3f& nearest);

} // namespace kindling::noise
