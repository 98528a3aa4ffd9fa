// Builds the table of path vertices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/replay.h"

#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

std::string triple(const V3f& v) { return fmt::format("{:.5g} {:.5g} {:.5g}", v.x, v.y, v.z); }

// Vertices without a surface have no normal, and vertices outside of the scene have no position.
std::string triple_or_dash(const V3f& v, bool known) { return known ? triple(v) : std::string("-"); }

std::string id(uint32_t value) { return value == accel::kNoId ? std::string("-") : fmt::format("{}", value); }

} // namespace

std::string format_replay(const ReplayedSample& sample, const V2i& pixel, uint32_t sample_index) {
  TextTable table({{"bounce", true},
                   {"event"},
                   {"position"},
                   {"normal"},
                   {"arrived along"},
                   {"distance", true},
                   {"instance", true},
                   {"mesh", true},
                   {"triangle", true},
                   {"material"},
                   {"throughput"},
                   {"radiance so far"}});
  for (const PathVertex& vertex : sample.trace) {
    const bool surface = vertex.normal.length2() > 0.0f;
    const bool placed = surface || vertex.position.length2() > 0.0f;
    table.add({fmt::format("{}", vertex.bounce), vertex.event, triple_or_dash(vertex.position, placed),
               triple_or_dash(vertex.normal, surface), triple(vertex.direction), fmt::format("{:.5g}", vertex.distance),
               id(vertex.instance), id(vertex.mesh), id(vertex.triangle), vertex.material, triple(vertex.throughput),
               triple(vertex.radiance)});
  }
  return fmt::format("pixel {},{} sample {}: radiance {} (luminance {:.6g})\n", pixel.x, pixel.y, sample_index,
                     triple(sample.radiance), luminance(sample.radiance)) +
         table.str();
}

} // namespace kindling::app
