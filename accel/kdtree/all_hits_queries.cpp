// Chooses between the stream and the query of single rays.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/all_hits_queries.h"

#include "accel/triangle.h"

#include <algorithm>
#include <limits>

namespace kindling::accel::kd {

void all_hits(const AllHitsQueries& queries, const Structure& structure, const Ray& ray, size_t limit,
              std::vector<Crossing>& crossings) {
  CrossingCollector collector(crossings, limit, std::min(ray.t_max, std::numeric_limits<float>::max()));
  if (structure.filter.abandoned() || !can_hit(ray)) return;
  queries.single(structure, ray, collector);
  collector.finish();
}

void all_hits(const AllHitsQueries& queries, const Structure& structure, std::span<const Ray> rays, size_t limit,
              std::vector<Crossing>& crossings, std::span<uint32_t> counts) {
  constexpr size_t kMinLimit = 8; // a smaller one ends the single query early
  CrossingBatch batch(rays.size());
  if (limit >= kMinLimit && !structure.is_split() && !structure.has_instances())
    queries.stream(structure, rays, batch);
  else
    for (uint32_t i = 0; i < rays.size(); ++i) batch.leave_aside(i);
  const auto single = [&](uint32_t i, std::vector<Crossing>& of_ray) {
    all_hits(queries, structure, rays[i], limit, of_ray);
  };
  batch.finish(limit, single, crossings, counts);
}

} // namespace kindling::accel::kd
