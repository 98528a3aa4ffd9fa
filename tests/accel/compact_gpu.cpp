// Entry points of the compact queries for a GPU, which check_ptx.py compiles and looks through.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/compact/queries.h"
#include "accel/kdtree/view.h"

#include <cstdint>

namespace {

using namespace kindling::accel;

// A filter that keeps all ids alive.
struct ByParity {
  bool operator()(const Ray& ray, const Hit& candidate) const {
    return ((ray.key ^ candidate.instance ^ candidate.mesh ^ candidate.triangle) & 1U) != 0;
  }
};

uint32_t thread_index() {
  return __nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x() + __nvvm_read_ptx_sreg_tid_x();
}

} // namespace

extern "C" {

[[clang::nvptx_kernel]] void nearest_hit(const kd::StructureView* view, const Ray* rays, Hit* hits, uint32_t count) {
  const uint32_t i = thread_index();
  if (i < count) hits[i] = kd::compact::intersect(*view, rays[i], ByParity());
}

[[clang::nvptx_kernel]] void any_hit(const kd::StructureView* view, const Ray* rays, uint8_t* blocked, uint32_t count) {
  const uint32_t i = thread_index();
  if (i < count) blocked[i] = kd::compact::occluded(*view, rays[i], ByParity()) ? 1 : 0;
}

} // extern "C"
