// Lattice hashes, Perlin noise, cell noise and Worley noise of MaterialX.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/noise.h"

#include <bit>
#include <cmath>
#include <limits>

namespace kindling::noise {
namespace {

// The next lower lattice point, and the distance of x from it.
struct Lattice {
  int cell;
  float t;
};

inline Lattice locate(float x) {
  if (!(std::abs(x) < 0x1p30f)) x = 0.0f;
  const float low = std::floor(x);
  return {static_cast<int>(low), x - low};
}

inline float fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }
inline float to_unit(uint32_t bits) { return static_cast<float>(bits) / static_cast<float>(0xffffffffU); }

// State of Jenkins' lookup3 for a number of words.
struct Words {
  uint32_t a, b, c;
  explicit Words(uint32_t count) : a(0xdeadbeefU + (count << 2U) + 13U), b(a), c(a) {}

  void mix() {
    const auto step = [](uint32_t& x, uint32_t& y, uint32_t& z, int bits) {
      x -= z;
      x ^= std::rotl(z, bits);
      z += y;
    };
    step(a, b, c, 4);
    step(b, c, a, 6);
    step(c, a, b, 8);
    step(a, b, c, 16);
    step(b, c, a, 19);
    step(c, a, b, 4);
  }

  [[nodiscard]] uint32_t finish() {
    const auto step = [](uint32_t& x, uint32_t y, int bits) {
      x ^= y;
      x -= std::rotl(y, bits);
    };
    step(c, b, 14);
    step(a, c, 11);
    step(b, a, 25);
    step(c, b, 16);
    step(a, c, 4);
    step(b, a, 14);
    step(c, b, 24);
    return c;
  }
};

inline float signed_by(float x, uint32_t bit) { return bit != 0 ? -x : x; }

// Scalar product with one of the gradients (+-1, +-2) and (+-2, +-1).
inline float gradient(uint32_t h, float x, float y) {
  const bool low = (h & 7U) < 4U;
  return signed_by(low ? x : y, h & 1U) + signed_by(2.0f * (low ? y : x), h & 2U);
}

// Scalar product with one of the gradients from the center of a cube to the middle of its edges.
inline float gradient(uint32_t h, float x, float y, float z) {
  h &= 15U;
  const float u = h < 8U ? x : y;
  const float v = h < 4U ? y : h == 12U || h == 14U ? x : z;
  return signed_by(u, h & 1U) + signed_by(v, h & 2U);
}

constexpr float kScale2d = 0.6616f; // MaterialX's normalization to about [-1, 1]
constexpr float kScale3d = 0.9820f;

inline float blend2(const float* v, float s, float t) {
  const float s1 = 1.0f - s;
  return (1.0f - t) * (v[0] * s1 + v[1] * s) + t * (v[2] * s1 + v[3] * s);
}

inline float blend3(const float* v, float s, float t, float r) {
  return (1.0f - r) * blend2(v, s, t) + r * blend2(v + 4, s, t);
}

// The corners of a cell with their hashes; value() is gradient noise by the bits of the hashes
// above `shift`.
struct Corners2 {
  Lattice x, y;
  uint32_t hashes[4];
  float s, t;

  explicit Corners2(const V2f& p) : x(locate(p.x)), y(locate(p.y)), s(fade(x.t)), t(fade(y.t)) {
    for (int i = 0; i < 4; ++i) hashes[i] = hash(x.cell + (i & 1), y.cell + (i >> 1));
  }
  [[nodiscard]] float value(int shift) const {
    float corners[4];
    for (int i = 0; i < 4; ++i)
      corners[i] = gradient(hashes[i] >> shift, x.t - static_cast<float>(i & 1), y.t - static_cast<float>(i >> 1));
    return kScale2d * blend2(corners, s, t);
  }
};

struct Corners3 {
  Lattice x, y, z;
  uint32_t hashes[8];
  float s, t, r;

  explicit Corners3(const V3f& p)
      : x(locate(p.x)), y(locate(p.y)), z(locate(p.z)), s(fade(x.t)), t(fade(y.t)), r(fade(z.t)) {
    for (int i = 0; i < 8; ++i) hashes[i] = hash(x.cell + (i & 1), y.cell + ((i >> 1) & 1), z.cell + (i >> 2));
  }
  [[nodiscard]] float value(int shift) const {
    float corners[8];
    for (int i = 0; i < 8; ++i)
      corners[i] = gradient(hashes[i] >> shift, x.t - static_cast<float>(i & 1), y.t - static_cast<float>((i >> 1) & 1),
                            z.t - static_cast<float>(i >> 2));
    return kScale3d * blend3(corners, s, t, r);
  }
};

// The three smallest squared distances so far, in ascending order.
struct Nearest {
  float squared[3] = {1e6f, 1e6f, 1e6f};

  // Adds a squared distance; returns true if it is the smallest so far.
  bool add(float d) {
    if (d < squared[0]) {
      squared[2] = squared[1];
      squared[1] = squared[0];
      squared[0] = d;
      return true;
    }
    if (d < squared[1]) {
      squared[2] = squared[1];
      squared[1] = d;
    } else if (d < squared[2]) {
      squared[2] = d;
    }
    return false;
  }
  [[nodiscard]] V3f distances() const { return {std::sqrt(squared[0]), std::sqrt(squared[1]), std::sqrt(squared[2])}; }
};

inline V3f jittered(const V3f& unit, float jitter) { return (unit - V3f(0.5f)) * jitter + V3f(0.5f); }

inline V3f cell_rgb_at(int x, int y) {
  return {to_unit(hash(x, y, 0)), to_unit(hash(x, y, 1)), to_unit(hash(x, y, 2))};
}
inline V3f cell_rgb_at(int x, int y, int z) {
  return {to_unit(hash(x, y, z, 0)), to_unit(hash(x, y, z, 1)), to_unit(hash(x, y, z, 2))};
}

} // namespace

uint32_t hash(int x, int y) {
  Words words(2);
  words.a += static_cast<uint32_t>(x);
  words.b += static_cast<uint32_t>(y);
  return words.finish();
}

uint32_t hash(int x, int y, int z) {
  Words words(3);
  words.a += static_cast<uint32_t>(x);
  words.b += static_cast<uint32_t>(y);
  words.c += static_cast<uint32_t>(z);
  return words.finish();
}

uint32_t hash(int x, int y, int z, int w) {
  Words words(4);
  words.a += static_cast<uint32_t>(x);
  words.b += static_cast<uint32_t>(y);
  words.c += static_cast<uint32_t>(z);
  words.mix();
  words.a += static_cast<uint32_t>(w);
  return words.finish();
}

float perlin(const V2f& p) { return Corners2(p).value(0); }
float perlin(const V3f& p) { return Corners3(p).value(0); }

V3f perlin_rgb(const V2f& p) {
  const Corners2 corners(p);
  return {corners.value(0), corners.value(8), corners.value(16)};
}

V3f perlin_rgb(const V3f& p) {
  const Corners3 corners(p);
  return {corners.value(0), corners.value(8), corners.value(16)};
}

float cell(const V2f& p) { return to_unit(hash(locate(p.x).cell, locate(p.y).cell)); }
float cell(const V3f& p) { return to_unit(hash(locate(p.x).cell, locate(p.y).cell, locate(p.z).cell)); }
V3f cell_rgb(const V2f& p) { return cell_rgb_at(locate(p.x).cell, locate(p.y).cell); }
V3f cell_rgb(const V3f& p) { return cell_rgb_at(locate(p.x).cell, locate(p.y).cell, locate(p.z).cell); }

V3f worley(const V2f& p, float jitter, V2f& nearest) {
  const Lattice x = locate(p.x), y = locate(p.y);
  Nearest found;
  V2f offset(0.0f);
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const V3f in_cell = jittered(cell_rgb_at(x.cell + i, y.cell + j), jitter);
      const V2f to(static_cast<float>(i) + in_cell.x - x.t, static_cast<float>(j) + in_cell.y - y.t);
      if (found.add(to.dot(to))) offset = to;
    }
  }
  nearest = p + offset;
  return found.distances();
}

V3f worley(const V3f& p, float jitter, V3f& nearest) {
  const Lattice x = locate(p.x), y = locate(p.y), z = locate(p.z);
  Nearest found;
  V3f offset(0.0f);
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      for (int k = -1; k <= 1; ++k) {
        const V3f in_cell = jittered(cell_rgb_at(x.cell + i, y.cell + j, z.cell + k), jitter);
        const V3f to(static_cast<float>(i) + in_cell.x - x.t, static_cast<float>(j) + in_cell.y - y.t,
                     static_cast<float>(k) + in_cell.z - z.t);
        if (found.add(to.dot(to))) offset = to;
      }
    }
  }
  nearest = p + offset;
  return found.distances();
}

} // namespace kindling::noise
