// Sixteen rays at a time into the space of a moving instance, each at its own time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/level_rays.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Matrices of sixteen rays: rows 0 to 2 and the translation, by column.
struct alignas(64) MatrixLanes {
  float entry[4][3][kRayLanes];
};

// Inverts as RayToObject::set_inverse_of() does, with the same bits. Returns a mask of the matrices
// that have an inverse.
inline uint32_t invert(const MatrixLanes& matrices, MatrixLanes& inverses) {
  alignas(64) float flaws[kRayLanes];
  for (uint32_t i = 0; i < kRayLanes; ++i) { // vectorized by the compiler
    const auto m = [&](int row, int column) -> double { return matrices.entry[row][column][i]; };
    const double c00 = m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1), c01 = m(0, 2) * m(2, 1) - m(0, 1) * m(2, 2),
                 c02 = m(0, 1) * m(1, 2) - m(0, 2) * m(1, 1), c10 = m(1, 2) * m(2, 0) - m(1, 0) * m(2, 2),
                 c11 = m(0, 0) * m(2, 2) - m(0, 2) * m(2, 0), c12 = m(0, 2) * m(1, 0) - m(0, 0) * m(1, 2),
                 c20 = m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0), c21 = m(0, 1) * m(2, 0) - m(0, 0) * m(2, 1),
                 c22 = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
    const double determinant = m(0, 0) * c00 + m(0, 1) * c10 + m(0, 2) * c20;
    const double cofactors[3][3] = {{c00, c01, c02}, {c10, c11, c12}, {c20, c21, c22}};
    // Zero times what is not finite is NaN, which no comparison admits.
    float flaw = static_cast<float>(determinant * 0.0) + (determinant == 0.0 ? 1.0f : 0.0f);
    for (int column = 0; column < 3; ++column) {
      double origin = 0.0;
      for (int row = 0; row < 3; ++row) {
        const double value = cofactors[row][column] / determinant;
        inverses.entry[row][column][i] = static_cast<float>(value);
        origin -= m(3, row) * value;
        flaw += std::fabs(value) <= 1e12 ? 0.0f : 1.0f;
      }
      inverses.entry[3][column][i] = static_cast<float>(origin);
      flaw += inverses.entry[3][column][i] * 0.0f;
    }
    flaws[i] = flaw;
  }
  return at_most(Lanes16::load(flaws), Lanes16(0.0f));
}

// The rays of a mask that are in one interval between keys.
struct OneInterval {
  uint32_t first, rays;
  alignas(64) float fractions[kRayLanes];

  // Takes them from the mask; `segments`: the number of intervals.
  OneInterval(const LevelRays& level, uint32_t segments, uint32_t& mask) : rays(0) {
    first = interval(level, static_cast<uint32_t>(std::countr_zero(mask)), segments).first;
    for (uint32_t i = 0; i < kRayLanes; ++i) fractions[i] = 0.0f;
    for (uint32_t rest = mask; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(rest));
      const KeyInterval at = interval(level, i, segments);
      if (at.first != first) continue;
      fractions[i] = at.fraction;
      rays |= 1U << i;
    }
    mask &= ~rays;
  }
  [[nodiscard]] Lanes16 between(float a, float b) const {
    return Lanes16(a) + Lanes16(b - a) * Lanes16::load(fractions);
  }

 private:
  static KeyInterval interval(const LevelRays& level, uint32_t i, uint32_t segments) {
    return key_interval(clamped_time(level.ray[i]->time), segments);
  }
};

// Takes rays of a mask into the space of an instance whose matrix moves, and writes them to
// `inside`. Returns a mask of those that may hit something there.
inline uint32_t enter_moving(const MovingInstance& moving, const LevelRays& level, uint32_t active, Ray* inside) {
  uint32_t entered = 0;
  while (active != 0) {
    const OneInterval at(level, static_cast<uint32_t>(moving.keys.size() - 1), active);
    const Imath::Box3f &from = moving.boxes[at.first], &to = moving.boxes[at.first + 1];
    const auto face = [&](bool high, uint32_t k) {
      const auto axis = static_cast<int>(k);
      return high ? at.between(from.max[axis], to.max[axis]) : at.between(from.min[axis], to.min[axis]);
    };
    uint32_t reach = at.rays & level.entering([&](uint32_t k) { return face(level.points_down(k), k); },
                                              [&](uint32_t k) { return face(!level.points_down(k), k); });
    if (reach == 0) continue;
    MatrixLanes matrices, inverses;
    const Imath::M44f &first = moving.keys[at.first], &second = moving.keys[at.first + 1];
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 3; ++column)
        at.between(first[row][column], second[row][column]).store(matrices.entry[row][column]);
    reach &= invert(matrices, inverses);
    RayLanes out;
    for (uint32_t to_axis = 0; to_axis < 3; ++to_axis) {
      const auto part = [&](const float(&lanes)[3][kRayLanes], uint32_t k) {
        return Lanes16::load(lanes[k]) * Lanes16::load(inverses.entry[k][to_axis]);
      };
      const auto whole = [&](const float(&lanes)[3][kRayLanes]) {
        return (part(lanes, 0) + part(lanes, 1)) + part(lanes, 2);
      };
      (whole(level.lanes.origin) + Lanes16::load(inverses.entry[3][to_axis])).store(out.origin[to_axis]);
      whole(level.lanes.direction).store(out.direction[to_axis]);
    }
    Lanes16::load(level.lanes.t_min).store(out.t_min);
    Lanes16::load(level.lanes.t_max).store(out.t_max);
    reach &= out.can_hit();
    out.store(reach, inside);
    entered |= reach;
  }
  return entered;
}

} // namespace kindling::accel::kd::KINDLING_SIMD
