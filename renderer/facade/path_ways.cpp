// Projects the vertices of a path and tells its bounces apart.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/path_ways.h"

#include <algorithm>

namespace kindling {
namespace {

constexpr float kShareOfDepth = 1e-3f; // in front of the camera's plane, where ways are cut

std::optional<std::array<V2f, 2>> seen_way(const Camera& camera, V3f from, V3f to) {
  const float start = camera.depth(from, 0.0f), end = camera.depth(to, 0.0f);
  const float near_m = kShareOfDepth * std::max(start, end);
  if (!(near_m > 0.0f)) return std::nullopt;
  if (start < near_m) from = lerp(to, from, (end - near_m) / (end - start));
  if (end < near_m) to = lerp(from, to, (start - near_m) / (start - end));
  const std::optional<V2f> first = camera.project(from), last = camera.project(to);
  if (!first || !last) return std::nullopt;
  const V2f size(camera.size_px());
  return std::array<V2f, 2>{*first / size, *last / size};
}

PathStep step_between(const PathVertex& before, const PathVertex& after) {
  if (before.event == "camera") return PathStep::camera;
  if (after.bounces[0] > before.bounces[0]) return PathStep::diffuse;
  if (after.bounces[1] > before.bounces[1]) return PathStep::glossy;
  if (after.bounces[2] > before.bounces[2]) return PathStep::transmission;
  return before.normal.length2() > 0.0f ? PathStep::straight : PathStep::medium;
}

} // namespace

std::string_view path_step_name(PathStep step) {
  constexpr std::array<std::string_view, 6> kNames{"camera", "diffuse", "glossy", "transmission", "straight", "medium"};
  return kNames[static_cast<size_t>(step)];
}

std::vector<PathWay> find_path_ways(const Camera& camera, const PathTrace& trace, const Box3f& bounds) {
  const float far_m = bounds.isEmpty() ? 1.0f : 2.0f * bounds.size().length();
  std::vector<PathWay> ways(trace.size());
  V3f last(0.0f);
  for (size_t i = 0; i < trace.size(); ++i) {
    const PathVertex& vertex = trace[i];
    if (vertex.event == kJoinedEvent) continue;
    const V3f position = vertex.event == "escaped" ? last + vertex.direction * far_m : vertex.position;
    PathWay& way = ways[i];
    if (i > 0) way = {step_between(trace[i - 1], vertex), seen_way(camera, last, position)};
    last = position;
  }
  return ways;
}

} // namespace kindling
