// Traces training paths block by block, gathers their records and learns a guide from them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/guide_training.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/guiding/learn_guide.h"
#include "renderer/integrator/light_paths/caustic_photons.h"
#include "renderer/integrator/light_paths/volume_photons.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/path_recorder.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <numeric>

namespace kindling {
namespace {

using Clock = std::chrono::steady_clock;

constexpr uint64_t kProbePart = 8; // the probe is one in this many of the training's paths

// Shares of GuideTrainingSettings::max_training_s: at most the first is spent on measuring the
// speed, and tracing is planned to end at the second, which leaves time to learn. A training that
// is predicted after its probe to exceed the third is given up.
constexpr double kMeasuringShare = 0.08, kTracingShare = 0.65, kGiveUpShare = 1.2;
constexpr uint64_t kShortTraining = 1U << 17; // paths; such a training costs little if it is in vain
constexpr uint64_t kMinTimedPaths = 2048;     // fewer teach a guide nothing
constexpr uint64_t kTimedPathStep = 1024;     // plans are multiples of this

// Second moments that the parts of a guide predict, relative to rendering without it.
struct Moments {
  double patches, openings, lights, environment;

  [[nodiscard]] bool any_below(const Moments& limits) const {
    return patches < limits.patches || openings < limits.openings || lights < limits.lights ||
           environment < limits.environment;
  }
};
// A guide is used for the parts that predict less than these limits. The probe knows little, so it
// only has to look promising. Patches make a sample up to 10 % more expensive and improve only the
// variance of reflected light. Patches in openings gain more than they predict: they find the light
// of the sky, too, most of whose light samples are blocked by walls. Probabilities of lights gain
// less: directions of paths that find the same light have other weights beside them.
constexpr Moments kPromising{0.91, 0.97, 0.85, 0.97};
constexpr Moments kPromisingAfterFew{0.98, 0.98, 0.85, 0.98}; // a short probe knows less
constexpr Moments kWorthwhile{0.88, 0.94, 0.75, 0.94};
constexpr Moments kWorthwhileAfterFew{0.94, 0.94, 0.75, 0.94}; // few paths predict less than their guide gains
constexpr Moments kAnyGain{1.0, 1.0, 0.85, 1.0};               // lights gain less than they predict
// A part is not learned again if a probe predicts no less for it. The environment is always learned
// again.
constexpr Moments kHopeless{0.97, 0.985, 0.95, 2.0};
// A probe whose directions followed the environment, and which predicts no less, is not repeated
// without them.
constexpr Moments kSlightGain{0.95, 0.985, 0.99, 1.0};

// Directions of caustics make paths on all surfaces with caustics 1.3 times as expensive. They pay
// where the BSDF alone would miss this share of the image's light in most pixels.
constexpr double kMinCausticShare = 0.02;
constexpr size_t kMinCausticRecords = 4 * CausticGuide::kLobes;
constexpr uint64_t kLightPathsPerPath = 2; // over casters, of a path from the camera

constexpr double kRarePixels = 0.001;  // light in so few pixels decides nothing
constexpr float kShareOfProbe = 0.25f; // of directions that follow the environment, where there is glass

struct Worker {
  std::unique_ptr<PathContext> context;
  std::unique_ptr<PathRecorder> recorder;
  double busy_s = 0.0;
};

struct BlockRecords {
  std::vector<GuideRecord> records;
  std::vector<LightRecord> light_records;
  double luminance_sum = 0.0;
  uint64_t paths = 0;
};

class Training {
 public:
  Training(const World& world, const Camera& camera, const GuideTrainingSettings& settings,
           const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done)
      : world_(world), camera_(camera), settings_(settings), stopped_(stopped), on_done_(on_done),
        sampler_(hash_u32(settings.seed ^ 0x6a09e667U)) {}

  TrainedGuide run() {
    const uint64_t paths = statistics_.max_paths = settings_.max_paths > 0 ? affordable_paths() : 0;
    std::unique_ptr<const Guide> guide;
    if (paths > 0) {
      const bool selective = settings_.only_if_worthwhile, few = paths < kShortTraining;
      const Moments& promising = !selective ? kAnyGain : few ? kPromisingAfterFew : kPromising;
      const Moments& worthwhile = !selective ? kAnyGain : few ? kWorthwhileAfterFew : kWorthwhile;
      const uint64_t probe = paths / kProbePart;
      guide = find_promising(probe, promising);
      uint64_t traced = probe;
      if (selective && guide && !predicted_.any_below(worthwhile)) { // unclear: again, with twice the paths
        trace(probe, guide.get());
        traced += probe;
        guide = learn(promising);
      }
      if (selective && !few) leave_out_hopeless();
      const double rest_s = traced_s_ * static_cast<double>(kProbePart - traced / std::max<uint64_t>(probe, 1));
      if (settings_.max_training_s && elapsed_s() + rest_s > kGiveUpShare * *settings_.max_training_s) {
        guide.reset(); // a plan of fewer paths would need a probe of its own
        statistics_.max_paths = 0;
      } else if (!selective || guide) {
        trace(paths - traced, guide.get());
        guide = learn(worthwhile);
      }
    }
    if (paths > 0) guide = with_volumes(std::move(guide), paths);
    if (paths > 0) guide = with_caustics(std::move(guide), paths);
    if (stopped()) guide.reset();
    if (guide) {
      statistics_.patches = static_cast<int>(guide->patches.patches().size());
      statistics_.environment_regions = static_cast<int>(guide->environment.region_count());
      statistics_.light_regions = static_cast<int>(guide->light_probabilities.region_count());
      statistics_.volume_regions = static_cast<int>(guide->volumes.bright_region_count());
      statistics_.caustic_regions = static_cast<int>(guide->caustics.regions.size());
    }
    statistics_.training_s = elapsed_s();
    return {std::move(guide), statistics_, busy_s_};
  }

 private:
  [[nodiscard]] bool stopped() const { return stopped_ && stopped_(); }
  [[nodiscard]] double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  // Returns the number of paths that the time allows, at most max_paths; 0 if too few.
  uint64_t affordable_paths() {
    if (!settings_.max_training_s) return settings_.max_paths;
    trace(settings_.max_paths / kProbePart, nullptr, kMeasuringShare * *settings_.max_training_s);
    const double per_path_s = elapsed_s() / static_cast<double>(std::max<uint64_t>(statistics_.paths, 1));
    const double left_s = std::max(kTracingShare * *settings_.max_training_s - elapsed_s(), 0.0);
    forget_paths();
    const auto affordable = static_cast<uint64_t>(left_s / per_path_s) / kTimedPathStep * kTimedPathStep;
    return affordable < kMinTimedPaths ? 0 : std::min(affordable, settings_.max_paths);
  }

  // The probe: traces paths and returns what they learn, or null if no part of it is below
  // `limits`. Few paths meet the light of an environment behind glass. If the scene has both, the
  // paths are guided to bright places of the environment everywhere. If no share of such directions
  // is worthwhile, but other parts of a guide may be, the paths are forgotten, and others are
  // traced without them.
  std::unique_ptr<const Guide> find_promising(uint64_t paths, const Moments& limits) {
    if (has_glass() && !world_.lights.environment.is_black()) {
      Guide everywhere = even_lights();
      everywhere.environment = EnvironmentGuide(kShareOfProbe);
      probes_environment_ = true;
      trace(paths, &everywhere);
      std::unique_ptr<const Guide> guide = learn(limits);
      if (guide && !guide->environment.empty()) return guide;
      probes_environment_ = false;
      if (settings_.only_if_worthwhile && !predicted_.any_below(kSlightGain)) return nullptr;
      forget_paths();
    }
    const Guide even = even_lights();
    trace(paths, even.light_probabilities.empty() ? nullptr : &even);
    return learn(limits);
  }
  // Returns a guide that selects all kinds of light equally often, or an empty one if there is but
  // one kind. Without it light of a kind that is seldom selected would be so rare in a probe, and
  // so bright, that its share of the noise would not be known.
  [[nodiscard]] Guide even_lights() const {
    Guide guide;
    LightProbabilities equal;
    equal.fill(1.0f / kLightKinds);
    if (!world_.lights.single_kind) guide.light_probabilities = LightSelectionTree(equal);
    return guide;
  }
  [[nodiscard]] bool has_glass() const {
    return std::any_of(world_.layer_materials.begin(), world_.layer_materials.end(),
                       [](const LayerMaterial& layers) { return layers.volume && layers.transmission_factor > 0.0f; });
  }

  void forget_paths() {
    statistics_.paths = 0;
    next_sample_ = 0;
    records_.clear();
    light_records_.clear();
  }

  // Traces about `paths` more paths, spread over the image as evenly as whole blocks allow. Begins
  // no block later than `end_s` after the start of the training.
  void trace(uint64_t paths, const Guide* guide, double end_s = kInfinity) {
    const double before_s = elapsed_s();
    const PathIntegrator integrator(settings_.integrator, world_, camera_, sampler_, settings_.filter, AovSet{}, guide);
    tbb::enumerable_thread_specific<Worker> workers([&] {
      Worker worker{integrator.make_path_context(), std::make_unique<PathRecorder>(settings_.integrator.batch_size),
                    0.0};
      worker.context->recorder = worker.recorder.get();
      return worker;
    });
    const std::vector<PixelRect>& blocks = settings_.blocks;
    const size_t count = blocks.size();
    const uint64_t visits = std::max<uint64_t>(1, paths / (kBlockSize * kBlockSize));
    // Blocks are visited in steps of the golden ratio, which spreads those with one more sample
    // over the image.
    size_t step = count * 618 / 1000 + 1;
    while (std::gcd(step, count) != 1) ++step;
    std::vector<BlockRecords> found(count);
    std::atomic<uint64_t> traced{statistics_.paths};
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
      const uint64_t place = i * step % count;
      const auto samples = static_cast<uint32_t>((place + 1) * visits / count - place * visits / count);
      if (samples == 0 || stopped() || (end_s < kInfinity && elapsed_s() > end_s)) return;
      const StandardArithmetic standard_arithmetic;
      const Clock::time_point start = Clock::now();
      Worker& worker = workers.local();
      PathRecorder& recorder = *worker.recorder;
      recorder.records.clear();
      recorder.light_records.clear();
      recorder.luminance_sum = 0.0;
      Film film(camera_.size_px(), blocks[i], AovSet{});
      if (integrator.render_block(blocks[i], {next_sample_, next_sample_ + samples}, *worker.context, film) < samples)
        return; // abandoned
      found[i] = {recorder.records, recorder.light_records, recorder.luminance_sum,
                  static_cast<uint64_t>(blocks[i].pixel_count()) * samples};
      traced += found[i].paths;
      worker.busy_s += std::chrono::duration<double>(Clock::now() - start).count();
      if (on_done_ && !is_extra_) on_done_(traced);
    });
    next_sample_ += static_cast<uint32_t>((visits + count - 1) / count);
    for (Worker& worker : workers) {
      statistics_.rays.add(worker.context->counters);
      busy_s_ += worker.busy_s;
    }
    gather(found);
    traced_s_ = elapsed_s() - before_s;
  }

  // Appends the records of all blocks and makes their moments relative to the image: the measure is
  // squared error over squared radiance, with a block's mean in place of its pixels' radiance.
  void gather(std::span<BlockRecords> found) {
    double sum = 0.0;
    uint64_t paths = 0;
    for (const BlockRecords& block : found) {
      sum += block.luminance_sum;
      paths += block.paths;
    }
    if (paths == 0) return;
    statistics_.paths += paths;
    const double mean = sum / static_cast<double>(paths);
    mean_luminance_ = mean;
    tbb::parallel_for(size_t{0}, found.size(), [&](size_t b) {
      BlockRecords& block = found[b];
      const double block_mean = block.paths == 0 ? 0.0 : block.luminance_sum / static_cast<double>(block.paths);
      const double scale = 1.0 / (block_mean * block_mean + 0.01 * mean * mean);
      make_relative(block.records, &GuideRecord::contribution2, scale);
      make_relative(block.light_records, &LightRecord::moment, scale);
    });
    append(found, &BlockRecords::records, records_);
    append(found, &BlockRecords::light_records, light_records_);
  }

  // Scales the moments and drops records that are not finite afterwards.
  template <typename Record>
  static void make_relative(std::vector<Record>& records, float Record::*moment, double scale) {
    for (Record& record : records) record.*moment *= static_cast<float>(scale);
    std::erase_if(records, [&](const Record& record) { return !std::isfinite(record.*moment); });
  }

  // Appends one kind of record to `all`, in the order of the blocks.
  template <typename Record>
  static void append(std::span<BlockRecords> found, std::vector<Record> BlockRecords::*of, std::vector<Record>& all) {
    std::vector<size_t> begin;
    size_t count = all.size();
    for (const BlockRecords& block : found) {
      begin.push_back(count);
      count += (block.*of).size();
    }
    all.resize(count);
    tbb::parallel_for(size_t{0}, found.size(), [&](size_t b) {
      std::copy((found[b].*of).begin(), (found[b].*of).end(), all.begin() + static_cast<std::ptrdiff_t>(begin[b]));
    });
  }

  // Returns the parts of the learned guide that predict second moments below `limits`, or null if
  // neither does.
  std::unique_ptr<const Guide> learn(const Moments& limits) {
    LearnedGuide learned = learn_guide(records_, light_records_, parts_);
    if (!parts_.patches) learned.second_moment = predicted_.patches;
    if (!parts_.lights) learned.light_second_moment = predicted_.lights;
    predicted_ = {learned.second_moment, learned.second_moment_of_openings, learned.light_second_moment, 1.0};
    statistics_.predicted = learned.second_moment;
    statistics_.predicted_lights = learned.light_second_moment;
    if (learned.second_moment_of_openings < limits.openings) {
      learned.guide.patches = learned.patches_of_openings;
      statistics_.predicted = learned.second_moment_of_openings;
    } else if (!(learned.second_moment < limits.patches)) {
      learned.guide.patches = {};
    }
    if (!(learned.light_second_moment < limits.lights)) learned.guide.light_probabilities = {};
    if (probes_environment_) {
      const double rare = kRarePixels / settings_.samples * static_cast<double>(statistics_.paths);
      LearnedEnvironment environment = learn_environment(records_, rare);
      statistics_.predicted_environment = predicted_.environment = environment.second_moment;
      if (environment.second_moment < limits.environment) learned.guide.environment = std::move(environment.guide);
    }
    if (learned.guide.patches.empty() && learned.guide.environment.empty() && learned.guide.light_probabilities.empty())
      return nullptr;
    return std::make_unique<Guide>(std::move(learned.guide));
  }

  // By the last learn(), the parts to learn from then on.
  void leave_out_hopeless() {
    parts_.patches = predicted_.patches < kHopeless.patches;
    parts_.openings = predicted_.openings < kHopeless.openings;
    parts_.lights = predicted_.lights < kHopeless.lights;
  }

  // Adds what light paths of the same number learn of scattering media.
  std::unique_ptr<const Guide> with_volumes(std::unique_ptr<const Guide> guide, uint64_t paths) {
    records_ = {}; // no longer needed
    light_records_ = {};
    const size_t enough = paths + paths / 2; // a light path has several
    std::vector<VolumeRecord> records =
        trace_volume_photons(world_, {settings_.integrator, settings_.seed, paths, enough}, stopped_, statistics_.rays);
    VolumeGuide volumes(records);
    if (volumes.empty()) return guide;
    Guide all = guide ? *guide : Guide{};
    all.volumes = std::move(volumes);
    return std::make_unique<const Guide>(std::move(all));
  }

  // Adds directions of caustics, learned from light paths, if they pay: an eighth as many light
  // paths as the training has paths, and as many paths that they guide, determine that.
  std::unique_ptr<const Guide> with_caustics(std::unique_ptr<const Guide> guide, uint64_t paths) {
    const IntegratorSettings& integrator = settings_.integrator;
    if (integrator.caustics != Caustics::full || integrator.light_paths > 0.0f || integrator.photons > 0.0f)
      return guide; // other ways to caustics, with weights of their own
    const uint64_t probe = paths / kProbePart;
    std::vector<CausticRecord> records = caustic_photons(0, probe);
    if (records.size() < kMinCausticRecords || stopped()) return guide;
    const std::unique_ptr<const Guide> tried = with_caustics(guide.get(), records, probe);
    records_.clear();
    const uint64_t traced_before = statistics_.paths;
    is_extra_ = true;
    trace(probe, tried.get());
    const CausticGain gain = caustic_gain(records_, statistics_.paths - traced_before);
    records_ = {};
    light_records_ = {};
    if (!(gain.share > (settings_.only_if_worthwhile ? kMinCausticShare : 0.0)) || !(gain.second_moment < 1.0))
      return guide;
    statistics_.caustic_share = gain.share;
    const uint64_t light_paths = kLightPathsPerPath * paths;
    const std::vector<CausticRecord> more = caustic_photons(probe, light_paths - probe);
    records.insert(records.end(), more.begin(), more.end());
    return with_caustics(guide.get(), records, light_paths);
  }
  std::vector<CausticRecord> caustic_photons(uint64_t first, uint64_t count) {
    return trace_caustic_photons(world_, camera_,
                                 {settings_.integrator, settings_.filter, settings_.seed, first, count}, stopped_,
                                 statistics_.rays);
  }
  // The records are sorted. `guide` may be null.
  [[nodiscard]] std::unique_ptr<const Guide> with_caustics(const Guide* guide, std::vector<CausticRecord>& records,
                                                           uint64_t paths) const {
    // Caustics as strong as this part of the image's mean are sampled as often as all other light.
    constexpr double kEqual = 0.1;
    Guide all = guide ? *guide : Guide{};
    all.caustics = CausticGuide(records, paths, static_cast<float>(kEqual * kPi * mean_luminance_));
    return std::make_unique<const Guide>(std::move(all));
  }

  const World& world_;
  const Camera& camera_;
  const GuideTrainingSettings& settings_;
  const std::function<bool()>& stopped_;
  const std::function<void(uint64_t)>& on_done_;
  Sampler sampler_;
  Clock::time_point start_ = Clock::now();
  uint32_t next_sample_ = 0;
  std::vector<GuideRecord> records_;
  std::vector<LightRecord> light_records_;
  GuidingStatistics statistics_;
  Moments predicted_{1.0, 1.0, 1.0, 1.0}; // by the last learn()
  GuideParts parts_;
  double busy_s_ = 0.0;
  bool probes_environment_ = false; // its directions are learned, too
  double traced_s_ = 0.0;           // of the last trace()
  double mean_luminance_ = 0.0;     // of the paths traced last
  bool is_extra_ = false;           // further paths are beyond max_paths
};

} // namespace

TrainedGuide train_guide(const World& world, const Camera& camera, const GuideTrainingSettings& settings,
                         const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done) {
  return Training(world, camera, settings, stopped, on_done).run();
}

} // namespace kindling
