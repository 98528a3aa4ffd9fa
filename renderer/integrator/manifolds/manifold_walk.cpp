// Steps of a walk, and how far a chain misses a lamp.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/manifolds/manifold_walk.h"

#include "renderer/integrator/stages/add_lights.h"

#include <array>
#include <cmath>

namespace kindling {

namespace {

constexpr uint32_t kMaxTraces = 24; // chains of a walk
constexpr float kMaxTurn = 0.5f;    // of a step, radians
constexpr float kMinStep = 0.125f;  // of what Newton's method asks for

struct Miss {
  float error;  // between the directions of the chain and to the lamp, both unit
  V2f turn;     // Newton's step, along the axes of DifferentialRay
  float spread; // ManifoldSolution::spread
};

std::optional<Miss> miss_of(const DifferentialRay& ray, const LightSetView::Punctual& lamp) {
  V3f to_lamp = -lamp.axis;
  float inverse_distance = 0.0f;
  if (lamp.kind != LightSetView::Punctual::Kind::directional) {
    to_lamp = lamp.position - ray.origin;
    const float distance = to_lamp.length();
    if (!(distance > 0.0f)) return std::nullopt;
    inverse_distance = 1.0f / distance;
    to_lamp *= inverse_distance;
  }
  const float along = to_lamp.dot(ray.direction);
  V3f across = to_lamp - ray.direction * along;
  if (along < 0.0f) across = across.normalized();
  const Frame frame = Frame::around(ray.direction);
  const V2f wanted(across.dot(frame.tangent), across.dot(frame.bitangent));
  std::array<V2f, 2> changes;
  for (size_t i = 0; i < 2; ++i) {
    const V3f change = ray.origin_change[i] * inverse_distance + ray.direction_change[i];
    changes[i] = V2f(change.dot(frame.tangent), change.dot(frame.bitangent));
  }
  const float determinant = changes[0].x * changes[1].y - changes[0].y * changes[1].x;
  if (!(std::abs(determinant) > 0.0f)) return std::nullopt;
  const V2f turn(wanted.x * changes[1].y - wanted.y * changes[1].x, wanted.y * changes[0].x - wanted.x * changes[0].y);
  return Miss{(to_lamp - ray.direction).length(), turn / determinant, std::abs(determinant)};
}

// The chain in a direction, and how far it misses.
struct Tried {
  V3f direction;
  ChainEnd end;
  Miss miss;
};

std::optional<Tried> try_direction(const PathStages& stages, const PathStages::Vertex& from, const PathInFlight& path,
                                   const LightSetView::Punctual& lamp, const V3f& direction, bool reflects,
                                   uint32_t& rays) {
  if (!PathStages::may_receive(from, direction)) return std::nullopt;
  const std::optional<ChainEnd> end = trace_chain(stages, from, path, direction, reflects, rays);
  const std::optional<Miss> miss = end ? miss_of(end->ray, lamp) : std::nullopt;
  return miss ? std::optional(Tried{direction, *end, *miss}) : std::nullopt;
}

V3f turned(const V3f& direction, const V2f& turn) {
  const Frame around = Frame::around(direction);
  return (direction + around.tangent * turn.x + around.bitangent * turn.y).normalized();
}

} // namespace

std::optional<ManifoldSolution> walk_to_lamp(const PathStages& stages, const PathStages::Vertex& from,
                                             const PathInFlight& path, const LightSetView::Punctual& lamp,
                                             const V3f& seed, bool reflects, uint32_t& rays) {
  const auto try_one = [&](const V3f& direction) {
    return try_direction(stages, from, path, lamp, direction, reflects, rays);
  };
  std::optional<Tried> best = try_one(seed);
  uint32_t traces = 1;
  while (best && best->miss.error > kManifoldError) {
    const float length = best->miss.turn.length();
    const V2f turn = length > kMaxTurn ? best->miss.turn * (kMaxTurn / length) : best->miss.turn;
    std::optional<Tried> closer;
    for (float step = 1.0f; !closer && step >= kMinStep && traces < kMaxTraces; step *= 0.5f, ++traces) {
      closer = try_one(turned(best->direction, turn * step));
      if (closer && !(closer->miss.error < best->miss.error)) closer.reset();
    }
    best = closer;
  }
  if (!best) return std::nullopt;
  // One step more takes the rest of the error away, so that all walks find the same direction.
  if (const std::optional<Tried> last = try_one(turned(best->direction, best->miss.turn));
      last && last->miss.error < best->miss.error)
    best = last;
  return ManifoldSolution{best->direction, best->end, best->miss.spread};
}

} // namespace kindling
