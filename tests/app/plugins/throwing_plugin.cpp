// A plugin in C++ that lets exceptions out, in a build or in a query as its options say.
// SPDX-License-Identifier: Apache-2.0
#include "accel/plugin/kindling_accelerator.h"

#include <stdexcept>
#include <string>

struct KindlingAccelerator {
  bool throws_in_query = false;
};

namespace {

KindlingAccelerator* build(const KindlingScene* /*scene*/, const KindlingBuildSettings* settings, char* /*error*/,
                           size_t /*error_bytes*/) {
  const std::string options = settings->options;
  if (options == "build") throw std::runtime_error("thrown in a build");
  return new KindlingAccelerator{options == "query"};
}

void destroy(KindlingAccelerator* accelerator) { delete accelerator; }

int intersect(const KindlingAccelerator* accelerator, const KindlingRay* /*rays*/, KindlingHit* hits, size_t count) {
  if (accelerator->throws_in_query) throw 42;
  for (size_t i = 0; i < count; ++i) hits[i].instance = KINDLING_NO_HIT;
  return 0;
}

int occluded(const KindlingAccelerator* /*accelerator*/, const KindlingRay* /*rays*/, uint8_t* blocked, size_t count) {
  for (size_t i = 0; i < count; ++i) blocked[i] = 0;
  return 0;
}

const KindlingAcceleratorTable kTable{KINDLING_ACCELERATOR_VERSION,
                                      sizeof(KindlingAcceleratorTable),
                                      "throws",
                                      build,
                                      destroy,
                                      intersect,
                                      occluded,
                                      nullptr,
                                      nullptr,
                                      nullptr,
                                      nullptr};

} // namespace

const KindlingAcceleratorTable* kindling_accelerator_plugin(uint32_t /*newest*/) { return &kTable; }
