// Traces light paths as photon maps do, and takes of each photon what a caustic guide needs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/caustic_photons.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/path_integrator.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

namespace kindling {
namespace {

constexpr uint64_t kChunkPaths = 1024;         // traced together by one thread
constexpr uint32_t kCausticSeed = 0x63617573U; // makes these paths independent of others

void append_record(const Photon& photon, float paths_per_map, std::vector<CausticRecord>& records) {
  // No direction leads to a light without a size.
  if (photon.diffuse != 0 || photon.density == kInfinity) return;
  const float power = luminance(photon.power) * paths_per_map;
  if (power > 0.0f && power < kInfinity)
    records.push_back({photon.position, photon.position + photon.to_light * photon.distance_m, power});
}

} // namespace

std::vector<CausticRecord> trace_caustic_photons(const World& world, const Camera& camera,
                                                 const CausticPhotonSettings& settings,
                                                 const std::function<bool()>& stopped, RayCounters& counters) {
  IntegratorSettings integrator = settings.integrator;
  const V2i size = camera.size_px();
  integrator.light_paths = 0.0f;
  integrator.photons = static_cast<float>(static_cast<double>(settings.paths) / (static_cast<double>(size.x) * size.y));
  const Sampler sampler(hash_u32(settings.seed ^ kCausticSeed));
  const std::unique_ptr<LightPaths> light_paths =
      make_light_paths(integrator, world, camera, settings.filter, sampler.seed());
  std::vector<CausticRecord> all;
  if (!light_paths) return all;
  PathStages stages = make_path_stages(integrator, world, camera, sampler, nullptr);
  stages.light_paths = light_paths.get();
  const float paths_per_map = light_paths->photons_per_pass * static_cast<float>(light_paths->samples_per_map);
  struct Chunk {
    std::vector<CausticRecord> records;
    RayCounters rays;
  };
  std::vector<Chunk> chunks((settings.paths + kChunkPaths - 1) / kChunkPaths);
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    if (stopped && stopped()) return;
    const StandardArithmetic standard_arithmetic;
    LightPathContext context;
    std::vector<Photon> photons;
    const uint64_t begin = c * kChunkPaths;
    light_paths->trace_photons(stages, settings.first_path + begin, std::min(kChunkPaths, settings.paths - begin),
                               context, photons, chunks[c].rays);
    for (const Photon& photon : photons) append_record(photon, paths_per_map, chunks[c].records);
  });
  for (const Chunk& chunk : chunks) {
    all.insert(all.end(), chunk.records.begin(), chunk.records.end());
    counters.add(chunk.rays);
  }
  return all;
}

} // namespace kindling
