// The context of a query, and the filter functions that Embree calls with candidates.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/embree/embree_all_hits.h"
#include "accel/embree/embree_api.h"
#include "accel/embree/embree_build.h"
#include "accel/embree/embree_limits.h"
#include "accel/embree/embree_rays.h"

namespace kindling::accel::embree {

// Embree's context must come first.
struct Context {
  QueryContext embree;
  const Ray* rays = nullptr; // indexed by RTCRay::id
  const GeometryNames* names = nullptr;
  HitFilter filter;
  const StartedRay* started = nullptr; // the shortened ray traced in place of rays[0], if any
  Crossings* crossings = nullptr;      // takes all candidates and refuses them, if set
};

// The filter of meshes that are not opaque, or of others if all_hits() is prepared.
template <bool kCutout>
void filter_candidates(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const Context*>(args->context);
  if (!kCutout && context->crossings == nullptr) return;
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const Ray& ray = context->rays[RTCRayN_id(args->ray, args->N, i)];
    float t = RTCRayN_tfar(args->ray, args->N, i);
    if (context->started != nullptr) t = context->started->world_t(ray, t);
    const Hit candidate = to_hit(*context->names, t, RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i),
                                 RTCHitN_primID(args->hit, args->N, i), RTCHitN_geomID(args->hit, args->N, i),
                                 RTCHitN_instID(args->hit, args->N, i, 0));
    if (context->crossings != nullptr) {
      context->crossings->test(candidate);
      args->valid[i] = 0;
    } else if (!context->filter.accept(context->filter.context, ray, candidate)) {
      args->valid[i] = 0;
    }
  }
}

// Returns the functions that a build attaches to its meshes.
inline Filters filters_for(const HitFilter& filter, bool all_hits) {
  Filters filters;
  if (all_hits) filters.opaque = filter_candidates<false>;
  if (filter.accept != nullptr) filters.cutout = filter_candidates<true>;
  if (filter.accept == nullptr) filters.cutout = filters.opaque; // without a filter, all hits of cut-outs count
  return filters;
}

} // namespace kindling::accel::embree
