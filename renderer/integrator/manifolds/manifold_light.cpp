// Batches of walks, and the light of the chains that they find.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/manifolds/manifold_light.h"

#include "renderer/integrator/manifolds/manifold_walk.h"
#include "renderer/integrator/stages/trace_shadow.h"
#include "renderer/sampling/warp.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kindling {

namespace {

constexpr uint32_t kManifoldKey = 0x3a91f0c7U; // of the random numbers of walks
// A chain that fewer than one in so many batches finds loses a part of its light.
constexpr uint32_t kMaxBatches = 256;
constexpr float kReflectedShare = 0.15f;  // of the walks that begin outside of all media
constexpr float kTowardsLampShare = 0.6f; // of the others, those that begin close to the direction to the lamp
constexpr float kTowardsLamp = 0.08f;     // how close: one minus the cosine
constexpr float kSameDirection = 1e-3f;   // between the directions of one chain, without their errors
// Chains that bring less than this part of what the lamp would bring without them are followed with
// a smaller probability, down to the second number.
constexpr float kFullSurvival = 0.1f, kMinSurvival = 0.2f;

// The walks of one vertex.
class Walks {
 public:
  Walks(const PathStages& stages, const PathStages::Vertex& vertex, const PathInFlight& path)
      : stages_(stages), vertex_(vertex), path_(path),
        key_(hash_combine(path.sample.address.key, kManifoldKey + path.state.dimension(0))) {}

  struct Found {
    ManifoldSolution solution;
    LightSetView::Punctual lamp; // at the time of the path
    uint32_t lamp_number;
    bool reflects;
  };
  // Walks by one number are independent of all others.
  [[nodiscard]] std::optional<Found> walk(uint32_t number);
  // Returns the light of a chain; black: something is in its way, or it is not followed.
  [[nodiscard]] Rgb light_of(const Found& found);
  [[nodiscard]] uint32_t rays() const { return rays_; }

 private:
  [[nodiscard]] V3f seed(const LightSetView::Punctual& lamp, bool reflects, uint32_t key) const;
  [[nodiscard]] float survival(const Found& found, const LightSample& light) const;

  const PathStages& stages_;
  const PathStages::Vertex& vertex_;
  const PathInFlight& path_;
  uint32_t key_;
  uint32_t rays_ = 0;
};

std::optional<Walks::Found> Walks::walk(uint32_t number) {
  const LightSetView& lights = stages_.world->lights;
  const std::span<const uint32_t> lamps = stages_.manifolds->lamps;
  const uint32_t key = hash_combine(key_, number);
  const V2f u = Sampler::sample_2d(key, path_.sample.address.index, 0);
  const uint32_t lamp_number =
      lamps[std::min(static_cast<size_t>(u.x * static_cast<float>(lamps.size())), lamps.size() - 1)];
  const bool reflects = !path_.state.in_medium && u.y < kReflectedShare;
  const LightSetView::Punctual& listed = lights.punctuals[lamp_number];
  const LightSetView::Punctual lamp = listed.key_count == 0 ? listed : lights.posed(listed, vertex_.time);
  const std::optional<ManifoldSolution> solution =
      walk_to_lamp(stages_, vertex_, path_, lamp, seed(lamp, reflects, key), reflects, rays_);
  return solution ? std::optional(Found{*solution, lamp, lamp_number, reflects}) : std::nullopt;
}

// Most light is bent little, so that many chains begin near the direction to the lamp.
V3f Walks::seed(const LightSetView::Punctual& lamp, bool reflects, uint32_t key) const {
  const uint32_t index = path_.sample.address.index;
  const V2f choice = Sampler::sample_2d(key, index, 2);
  const V2f u = Sampler::sample_2d(key, index, 4);
  const V3f& position = vertex_.surface.position;
  if (!reflects && choice.y < kTowardsLampShare) {
    const V3f to_lamp = lamp.kind == LightSetView::Punctual::Kind::directional ? -lamp.axis : lamp.position - position;
    return Frame::around(to_lamp.normalized()).to_world(sample_even_cone(u, kTowardsLamp));
  }
  const std::span<const EmissionTarget> targets = stages_.manifolds->targets;
  const EmissionTarget& target =
      targets[std::min(static_cast<size_t>(choice.x * static_cast<float>(targets.size())), targets.size() - 1)];
  const V3f to_center = target.center - position;
  const float sin2 = square(target.radius) / to_center.length2();
  if (sin2 < 1.0f)
    return Frame::around(to_center.normalized()).to_world(sample_even_cone(u, sin2 / (1.0f + std::sqrt(1.0f - sin2))));
  const V3f normal = vertex_.surface.light_normal();
  return is_black(normal) ? sample_uniform_sphere(u) : Frame::around(normal).to_world(sample_cosine_hemisphere(u));
}

// Returns the probability of following a chain.
float Walks::survival(const Found& found, const LightSample& light) const {
  const std::optional<LightSample> direct =
      stages_.world->lights.sample_posed(found.lamp, vertex_.surface.position, V2f(0.5f));
  if (!direct) return 1.0f;
  const float part = luminance(found.solution.end.transmittance * light.radiance) /
                     (found.solution.spread * luminance(direct->radiance));
  return std::clamp(part / kFullSurvival, kMinSurvival, 1.0f);
}

Rgb Walks::light_of(const Found& found) {
  const PathState& state = path_.state;
  const ChainEnd& end = found.solution.end;
  const int refractions_between = std::max(static_cast<int>(end.refractions) - 1, 0);
  if (!stages_.within_limits(state.diffuse_bounces() + 1, state.glossy_bounces,
                             state.transmission_bounces + refractions_between))
    return Rgb(0.0f);
  const std::optional<LightSample> light =
      stages_.world->lights.sample_posed(found.lamp, end.surface.position, V2f(0.5f));
  if (!light) return Rgb(0.0f);
  const uint32_t index = path_.sample.address.index;
  const float follows = survival(found, *light);
  if (follows < 1.0f && Sampler::sample_1d(key_, index, 0) >= follows) return Rgb(0.0f);
  Rgb contribution = state.throughput * vertex_.bsdf.eval(found.solution.direction).value * end.transmittance *
                     light->radiance * (vertex_.surface.alpha / (found.solution.spread * follows));
  if (is_black(contribution) || !is_finite(contribution)) return Rgb(0.0f);
  accel::Ray ray = make_shadow_ray(end.surface, *light, key_, index, vertex_.time);
  ray.flags = kPassThinWalls;
  return reaches_light(stages_, ray, contribution, rays_) ? contribution : Rgb(0.0f);
}

// The distinct chains of a batch.
class FoundChains {
 public:
  // Returns the place of a chain; size(): it is not among them.
  [[nodiscard]] uint32_t find(const Walks::Found& found) const {
    const auto same = [&](const Chain& chain) {
      return chain.lamp == found.lamp_number && chain.reflects == found.reflects &&
             (chain.direction - found.solution.direction).length() < chain.tolerance;
    };
    return static_cast<uint32_t>(std::find_if(chains_.begin(), chains_.begin() + count_, same) - chains_.begin());
  }
  void add(const Walks::Found& found, const Rgb& light) {
    chains_[count_++] = {found.solution.direction, found.lamp_number, found.reflects, light,
                         kSameDirection + kManifoldError / found.solution.spread};
  }
  [[nodiscard]] uint32_t size() const { return count_; }
  [[nodiscard]] const Rgb& light(uint32_t place) const { return chains_[place].light; }

 private:
  struct Chain {
    V3f direction;
    uint32_t lamp;
    bool reflects;
    Rgb light;
    float tolerance; // between the directions of walks that find it
  };

  std::array<Chain, kMaxManifoldSamples> chains_;
  uint32_t count_ = 0;
};

} // namespace

ManifoldLight manifold_light(const PathStages& stages, const PathStages::Vertex& vertex, const PathInFlight& path) {
  const auto per_batch = static_cast<uint32_t>(stages.settings.manifold_samples);
  Walks walks(stages, vertex, path);
  FoundChains chains;
  for (uint32_t number = 0; number < per_batch; ++number)
    if (const std::optional<Walks::Found> found = walks.walk(number); found && chains.find(*found) == chains.size())
      chains.add(*found, walks.light_of(*found));
  ManifoldLight result;
  uint32_t missing = 0; // a bit for each chain that brings light and was not found again so far
  for (uint32_t i = 0; i < chains.size(); ++i) missing |= is_black(chains.light(i)) ? 0U : 1U << i;
  for (uint32_t batch = 1; missing != 0 && batch <= kMaxBatches; ++batch) {
    for (uint32_t i = 0; i < chains.size(); ++i)
      if ((missing >> i & 1U) != 0) result.light += chains.light(i);
    uint32_t found_again = 0;
    for (uint32_t i = 0; i < per_batch && found_again != missing; ++i)
      if (const std::optional<Walks::Found> found = walks.walk(batch * per_batch + i))
        found_again |= missing & 1U << chains.find(*found);
    missing &= ~found_again;
  }
  result.rays = walks.rays();
  return result;
}

} // namespace kindling
