// Compares the noise of blocks with photons and without, and derives it from single photons.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/photon_pilot.h"

#include "renderer/integrator/light_paths/light_paths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr uint32_t kSamplesOfMap = 2; // all of a run
constexpr int kGatheringSide = 4;     // of a block, in pixels
constexpr double kTrimmedPixels = 0.01;
constexpr double kPhotonFloor = 0.5;                               // caustics in shadows are no more than they look
constexpr std::array<float, 3> kChosenPhotons{0.05f, 0.1f, 0.25f}; // for each sample of a pixel
constexpr float kMeasuredPhotons = 0.1f;
constexpr double kRareShare = 0.0003; // of the pixels, whose sparkles do not count
// A sample that makes its pixel this many times as bright as its block is so rare that images are
// as if it were impossible.
constexpr double kImpossibleSample = 1e4;
// The pilot begins with a probe of this fraction of the paths. It ends the pilot if photons would
// make the product of noise and cost this much larger or more, and remove less than this share of
// the noise of its paths. On eleven scenes without caustics to speak of that share was .07 at most;
// a car in the sun, whose sparkles few paths meet, had .18 and more, though half of its probes
// predicted a loss, of up to 1.24. A probe that predicts more than the last limit ends the pilot
// whatever its paths have met.
constexpr uint64_t kPhotonProbe = 4;
constexpr double kHopelessPhotons = 1.05;
constexpr double kFewSparkles = 0.1;
constexpr double kMuchTooDear = 1.5;
// Costs in camera rays, fitted to times of path tracing.
constexpr double kGatherCost = 0.4; // for each path, of its weights and its search
constexpr double kPhotonRayCost = 4.0;

// In units of MeasuredNoise::error.
struct PhotonNoise {
  double camera = 0.0;  // of paths from the camera that find what photons find
  double photons = 0.0; // of photons
};

double squared(double x) { return x * x; }

// True if photons come from a lamp without a size. Its light through smooth glass is in images with
// photons alone, so whether there are any must not depend on noise: frames of an animation and
// previews would look different.
bool has_lamps_without_size(const EmissionView& emission) {
  const std::span<const LightSetView::Punctual> lamps = emission.lights->punctuals;
  for (size_t i = 0; i < lamps.size(); ++i)
    if (lamps[i].radius == 0.0f && emission.probability(emission.lights->triangles.size() + i) > 0.0f) return true;
  return false;
}

class PhotonPilot {
 public:
  PhotonPilot(const World& world, const Camera& camera, const SamplePilotSettings& settings, uint32_t samples_per_pixel,
              const std::function<bool()>& stopped)
      : world_(world), camera_(camera), settings_(settings), samples_per_pixel_(samples_per_pixel), stopped_(stopped),
        measured_fraction_(std::min(kMeasuredPhotons, max_chosen_photons(camera.size_px()))) {
    if (settings.integrator.path_reuse > 1) settings_count_ = 3;
  }

  // See why_no_photons_in().
  [[nodiscard]] std::string why_none() const {
    const auto paths = make_light_paths(gathering(settings_.integrator), world_, camera_, settings_.filter, 0);
    if (paths == nullptr) return "--photons auto: no light reaches glass, metal or a coat that could focus it";
    if (!has_lamps_without_size(paths->emission)) return {};
    return "--photons auto: lamps without a size light glass, metal or coats, and what they throw from there is in "
           "images with photons alone; a number of photons, such as 0.1, shows it";
  }

  [[nodiscard]] PhotonChoice choose() {
    PhotonChoice choice;
    const uint64_t probe = settings_.paths / kPhotonProbe;
    for (const uint64_t paths : {probe, settings_.paths - probe}) {
      choice.fraction = 0.0f;
      if (!measure(paths, choice)) continue; // stopped, or too few for a probe
      predict(choice);
      if (choice.predicted > (removed_by_paths_ < kFewSparkles ? kHopelessPhotons : kMuchTooDear)) break;
    }
    if (!(choice.predicted * kMinPhotonGain < 1.0)) choice.fraction = 0.0f;
    return choice;
  }

 private:
  // Sets the best fraction, if there is noise, and what it predicts, by what was measured.
  void predict(PhotonChoice& choice) {
    find_rarest();
    // The ratio of densities says too much, since sparkles that most images lack have most of that
    // noise, and the paths of the pilot say too little, since they have met few of them. The
    // geometric mean of both is near to what images show.
    const double alone = measured_.error.all[settings_count_ - 2], beside = measured_.error.all[settings_count_ - 1];
    const PhotonNoise here = noise_at(1.0);
    const double rest = std::max(beside - here.camera - here.photons, 0.1 * beside);
    const double by_ratio = noise_at(0.0).camera;
    const double by_paths = std::max(alone - (beside - here.photons), 0.0);
    const double removed = std::max(std::sqrt(by_ratio * by_paths), by_paths);
    removed_by_paths_ = alone > 0.0 ? by_paths / alone : 0.0;
    // Light that paths from the camera lack is an error that more samples do not make smaller.
    const double missing = missing_light() * samples_per_pixel_ / kSamplesOfMap;
    const double without = (measured_.error.all[0] - alone + rest + removed + missing) * cost(0, 0.0);
    if (!(without > 0.0)) return;
    for (const float chosen : kChosenPhotons) {
      const float fraction = std::min(chosen, max_chosen_photons(camera_.size_px()));
      const double of_measured = static_cast<double>(fraction / measured_fraction_);
      const PhotonNoise noise = noise_at(of_measured);
      const double with = (rest + noise.camera + noise.photons) * cost(settings_count_ - 1, of_measured);
      if (choice.fraction > 0.0f && !(with / without < choice.predicted)) continue;
      choice.predicted = with / without;
      choice.fraction = fraction;
    }
  }

  [[nodiscard]] IntegratorSettings gathering(IntegratorSettings integrator) const {
    integrator.path_reuse = 1;
    integrator.photons = measured_fraction_;
    integrator.samples_per_photon_map = kSamplesOfMap;
    return integrator;
  }

  [[nodiscard]] int block_side() const { return settings_.integrator.path_reuse > 1 ? kBlockSize : kGatheringSide; }

  // Measures the settings as they are, without path reuse if they have it, and with photons, by
  // about so many more paths. False if it is not complete.
  bool measure(uint64_t paths, SampleChoice& choice) {
    const NoiseBlocks blocks{.side = block_side(),
                             .samples = kSamplesOfMap,
                             .settings = settings_count_,
                             .trimmed = kTrimmedPixels,
                             .floor = kPhotonFloor,
                             .notes_photons = true};
    const auto change = [&](IntegratorSettings& integrator, size_t setting) {
      if (setting > 0) integrator.path_reuse = 1;
      if (setting + 1 == settings_count_) integrator = gathering(integrator);
    };
    if (!survey_) survey_.emplace(world_, camera_, settings_, blocks, change, stopped_);
    MeasuredNoise found = survey_->measure(paths, choice);
    if (!found.complete) return false;
    if (measured_.complete)
      measured_.add(found);
    else
      measured_ = std::move(found);
    pixels_ = measured_.camera_rays / (2.0 * kSamplesOfMap);
    return true;
  }

  // Returns the luminance of a sample of a path from the camera that finds what a photon brought.
  [[nodiscard]] static double camera_sample(const GatheredPhoton& photon) {
    return static_cast<double>(photon.luminance) * static_cast<double>(photon.traced_ratio);
  }

  // Finds how bright the samples are that only kRareShare of the pixels of the image meet.
  void find_rarest() {
    std::vector<std::pair<double, double>> samples; // luminance, share of the pixels that meet it
    for (const GatheredPhoton& photon : measured_.photons)
      if (const double sample = camera_sample(photon); std::isfinite(sample) && sample > 0.0)
        samples.emplace_back(sample, static_cast<double>(photon.luminance) / sample);
    std::sort(samples.begin(), samples.end(), std::greater<>());
    double share = 0.0;
    for (const auto& [sample, met] : samples) {
      rarest_ = sample;
      share += met * samples_per_pixel_ / (2.0 * kSamplesOfMap * pixels_);
      if (share > kRareShare) return;
    }
  }

  // Returns the squared light of photons that no path from the camera finds, by the product of both
  // runs, which has no part of the noise.
  [[nodiscard]] double missing_light() const {
    const int side = block_side();
    std::map<std::pair<int, int>, std::array<double, 2>> sums; // by block: of its samples in each run
    for (const GatheredPhoton& photon : measured_.photons) {
      const double sample = camera_sample(photon);
      if (!std::isfinite(sample) || sample > kImpossibleSample * samples_per_pixel_)
        sums[{photon.pixel.x / side, photon.pixel.y / side}][photon.run] += static_cast<double>(photon.luminance);
    }
    double missing = 0.0;
    const double samples = kSamplesOfMap * squared(side);
    for (const auto& [block, of_run] : sums) missing += 2.0 * squared(side) * of_run[0] * of_run[1] / squared(samples);
    return missing;
  }

  // Returns the noise with so many times the photons that were measured.
  [[nodiscard]] PhotonNoise noise_at(double of_measured) const {
    PhotonNoise sum;
    for (const GatheredPhoton& photon : measured_.photons) {
      const double ratio = of_measured * static_cast<double>(photon.ratio);
      const double camera_weight = 1.0 / (1.0 + squared(ratio));
      const auto light = static_cast<double>(photon.luminance);
      if (const double sample = camera_sample(photon); sample < rarest_)
        sum.camera += light * sample * squared(camera_weight);
      if (of_measured > 0.0) sum.photons += squared(light * (1.0 - camera_weight)) / of_measured;
    }
    constexpr double kPerSample = 1.0 / (2.0 * kSamplesOfMap); // of a pixel, both runs
    return {sum.camera * kPerSample, sum.photons * kPerSample * kSamplesOfMap};
  }

  // Returns the cost of a setting, if it has so many times the photons that were measured.
  [[nodiscard]] double cost(size_t setting, double of_measured) const {
    const double rays = measured_.cost(kSampleRayCosts, setting);
    if (setting + 1 < settings_count_) return rays;
    // Maps are those of the whole image, of which the blocks are a part.
    const double image = static_cast<double>(camera_.size_px().x) * static_cast<double>(camera_.size_px().y);
    return rays + kGatherCost * measured_.camera_rays +
           kPhotonRayCost * pixels_ / image * of_measured * measured_.photon_rays[setting];
  }

  const World& world_;
  const Camera& camera_;
  const SamplePilotSettings& settings_;
  uint32_t samples_per_pixel_;
  const std::function<bool()>& stopped_;
  float measured_fraction_;
  size_t settings_count_ = 2;         // without photons, if need be without path reuse, with photons
  std::optional<NoiseSurvey> survey_; // once it has begun
  MeasuredNoise measured_;
  double removed_by_paths_ = 0.0; // share of the noise that photons remove by what paths show
  double pixels_ = 0.0;           // of all blocks
  double rarest_ = std::numeric_limits<double>::infinity();
};

} // namespace

float max_chosen_photons(const V2i& size_px) {
  constexpr double kMaxPaths = 1U << 18; // of a sample of all pixels
  const double pixels = static_cast<double>(size_px.x) * static_cast<double>(size_px.y);
  return static_cast<float>(std::min(static_cast<double>(kChosenPhotons.back()), kMaxPaths / pixels));
}

std::string why_no_photons_in(const World& world, const Camera& camera, const SamplePilotSettings& settings) {
  return PhotonPilot(world, camera, settings, 1, {}).why_none();
}

PhotonChoice choose_photon_fraction(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                                    uint32_t samples_per_pixel, const std::function<bool()>& stopped) {
  return PhotonPilot(world, camera, settings, samples_per_pixel, stopped).choose();
}

} // namespace kindling
