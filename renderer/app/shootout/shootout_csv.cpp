// Writes a shootout as comma-separated values (RFC 4180, lines end with a line feed).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

namespace kindling::app {

std::string format_shootout_csv(const ShootoutReport& report) {
  std::string text = "scene,triangles,instances,accelerator,rays,query,call,count,median_s,min_s,max_s,mega_rays_per_s,"
                     "ratio_to_first,hit_or_miss_disagreements,distance_disagreements,build_1_thread_s,build_threads,"
                     "build_threads_s,memory_bytes,build_peak_bytes,nodes,leaves,references\n";
  for (const SceneResult& scene : report.scenes)
    for (const AcceleratorResult& a : scene.accelerators) {
      const accel::Statistics& s = a.build.statistics;
      const std::string build = fmt::format(
          "{},{},{},{},{},{},{},{}", median(a.build.one_thread_s), report.build_threads, median(a.build.many_threads_s),
          s.memory_bytes, a.build.peak_growth_bytes ? fmt::format("{}", *a.build.peak_growth_bytes) : std::string(),
          s.node_count, s.leaf_count, s.reference_count);
      for (const TraversalResult& result : a.traversal) {
        if (result.times_s.empty()) continue; // it has no such call
        const RaySetInfo& set = scene.sets[result.set];
        const Summary time = summarize(result.times_s);
        text +=
            fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_field(scene.file),
                        scene.triangle_count, scene.instance_count, a.name(), set.name,
                        set.query == RayQuery::nearest ? "nearest" : "any-hit", call_form_name(result.form),
                        set.ray_count, time.median, time.min, time.max, mega_rays_per_s(set, time.median),
                        result.ratio_to_first, result.disagreements.hit_or_miss, result.disagreements.distance, build);
      }
    }
  return text;
}

} // namespace kindling::app
