// Traces light paths into scattering media in waves, by the stages of the camera's paths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/volume_photons.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/integrator/light_paths/casters.h"
#include "renderer/integrator/stages/emitted_path.h"
#include "renderer/integrator/stages/shade_path.h"
#include "renderer/light/emission_sampling.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

namespace kindling {
namespace {

constexpr uint64_t kWavePaths = 256;                // traced together by one thread
constexpr size_t kMaxWaveRecords = 32 * kWavePaths; // further events of a wave are dropped
constexpr size_t kRoundWaves = 16;                  // between two counts of the records
constexpr uint32_t kSeed = 0x70686f74U;             // makes these paths independent of others

// A path on its way from a light.
struct Photon {
  CameraSample sample; // its random numbers
  PathState state;
  MediumStack media;
  EmittedRay emitted;
  bool arrived = false; // at the boundary of a medium: its throughput has the light's radiance
};

// Keeps the rays of paths that continue, and the events in media.
struct PhotonSink {
  static constexpr bool kSplits = false;
  static constexpr bool kReuses = false;
  static constexpr bool kBesideLightPaths = false;
  static constexpr bool kManifolds = false;

  std::vector<uint32_t>& active;
  std::vector<accel::Ray>& rays;
  std::vector<VolumeRecord>& events;

  void extend(const PathInFlight& path, const accel::Ray& ray) {
    active.push_back(path.slot);
    rays.push_back(ray);
  }
  void scatter_event(const accel::Ray& ray, float, const V3f& position, const PathState& state) {
    const float weight = state.throughput.x + state.throughput.y + state.throughput.z;
    if (weight > 0.0f && weight < kInfinity && events.size() < kMaxWaveRecords)
      events.push_back({position, -ray.direction, weight});
  }
  void add_shadow(const accel::Ray&, const ShadowRecord&) {} // no light is sampled
  void gather_photons(const PathStages::Vertex&, const PathInFlight&, float) {}
  [[nodiscard]] static bool records() { return false; }
  void arrive(const PathInFlight&, const SurfacePoint*) {}
  void escape(const PathInFlight&, const accel::Ray&) {}
  void reflect(const PathStages::Vertex&, const GuidedBsdf::Sample&, const PathInFlight&) {}
  void offer_light(const PathStages::Vertex&, const LightSample&, const Rgb&) {}
  void surface_event(const accel::Ray&, const accel::Hit&, const SurfacePoint&, const PathState&) {}
  void escaped_event(const accel::Ray&, const PathState&) {}
};

class PhotonTracer {
 public:
  PhotonTracer(const World& world, const IntegratorSettings& settings, uint32_t seed, const EmissionView& emission)
      : world_(world), emission_(emission),
        key_(hash_u32(seed ^ kSeed)), stages_{.settings = settings, .world = &world} {}

  // Traces the paths of these numbers.
  void trace(uint64_t first, uint64_t end, std::vector<VolumeRecord>& events, RayCounters& counters) const {
    const StandardArithmetic standard_arithmetic;
    std::vector<Photon> photons;
    std::vector<uint32_t> active, next_active; // photons, parallel to the rays
    std::vector<accel::Ray> rays, next_rays;
    std::vector<accel::Hit> hits;
    for (uint64_t number = first; number < end; ++number) {
      const uint32_t key = hash_combine(key_, static_cast<uint32_t>(number >> 32));
      const auto index = static_cast<uint32_t>(number);
      const std::optional<EmittedPath> started = start_emitted_path(emission_, key, index, world_.has_motion);
      // No direction leads to a light without a size.
      if (!started || started->emitted.density == kInfinity) continue;
      Photon photon;
      photon.sample.address = {.key = key, .index = index};
      photon.state.cone.spread = 0.0f;
      photon.emitted = started->emitted;
      active.push_back(static_cast<uint32_t>(photons.size()));
      photons.push_back(photon);
      rays.push_back(started->ray);
    }
    while (!active.empty() && !world_.abandoned()) {
      hits.resize(rays.size());
      world_.accelerator().intersect(rays, hits);
      counters.bounce += rays.size();
      next_active.clear();
      next_rays.clear();
      PhotonSink sink{next_active, next_rays, events};
      for (size_t i = 0; i < active.size(); ++i)
        if (hits[i].is_hit()) follow(rays[i], hits[i], active[i], photons[active[i]], sink);
      active.swap(next_active);
      rays.swap(next_rays);
    }
  }

 private:
  // Moves a path on from its hit. Surfaces other than boundaries of media and thin walls end it.
  void follow(const accel::Ray& ray, const accel::Hit& hit, uint32_t slot, Photon& photon, PhotonSink& sink) const {
    const PathInFlight path{slot, photon.sample, photon.state, photon.media, nullptr};
    if (const std::optional<float> distance = stages_.scatter_distance(hit.t, path)) {
      stages_.scatter_in_medium(ray, *distance, path, sink);
      return;
    }
    SurfacePoint surface;
    world_.surface_at(ray, hit, surface);
    const bool boundary = surface.layered && surface.layers.boundary;
    if (!boundary && !surface.has_thin_wall() && !photon.state.in_medium) return;
    if (boundary && !photon.arrived) {
      photon.arrived = true;
      photon.state.throughput *= emission_.radiance(photon.emitted, surface.position) / photon.emitted.finite_density;
    }
    SurfaceDraws sampled;
    if (PathStages::reflects(surface, photon.state)) {
      const BounceAddress address = PathStages::draws_address(path);
      sampled.draws = draw_bounce(address.address, address.dimension);
    }
    stages_.shade_hit(ray, hit, surface, sampled, std::span<const std::optional<LightSample>>(), path, sink);
  }

  const World& world_;
  const EmissionView& emission_;
  uint32_t key_;
  PathStages stages_;
};

} // namespace

std::vector<VolumeRecord> trace_volume_photons(const World& world, const VolumePhotonSettings& settings,
                                               const std::function<bool()>& stopped, RayCounters& counters) {
  std::vector<VolumeRecord> all;
  std::vector<uint8_t> scatters; // by material
  for (uint32_t material = 0; material < world.materials.size(); ++material)
    scatters.push_back(world.materials[material].layers != kNone && !is_black(world.medium(material).scattering) ? 1
                                                                                                                 : 0);
  if (std::find(scatters.begin(), scatters.end(), 1) == scatters.end()) return all;
  const EmissionSampling emission(world.lights, find_targets(world, scatters), world.bounds);
  if (emission.empty()) return all;
  const PhotonTracer tracer(world, settings.integrator, settings.seed, emission);
  all.reserve(std::min<size_t>(settings.enough_records, kMaxWaveRecords * settings.max_paths / kWavePaths) +
              kRoundWaves * kMaxWaveRecords);
  uint64_t next = 0;
  while (next < settings.max_paths && all.size() < settings.enough_records && !(stopped && stopped())) {
    std::array<std::vector<VolumeRecord>, kRoundWaves> events;
    std::array<RayCounters, kRoundWaves> rays;
    tbb::parallel_for(size_t{0}, kRoundWaves, [&](size_t wave) {
      const uint64_t first = next + wave * kWavePaths;
      tracer.trace(first, std::min(first + kWavePaths, settings.max_paths), events[wave], rays[wave]);
    });
    next += kRoundWaves * kWavePaths;
    for (size_t wave = 0; wave < kRoundWaves; ++wave) {
      all.insert(all.end(), events[wave].begin(), events[wave].end());
      counters.add(rays[wave]);
    }
  }
  return all;
}

} // namespace kindling
