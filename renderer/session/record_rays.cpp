// Records rays while the integrators render.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/record_rays.h"

#include "renderer/base/hash.h"
#include "renderer/base/standard_arithmetic.h"
#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"
#include "renderer/session/tile_scheduler.h"

#include <algorithm>
#include <numeric>

namespace kindling {
namespace {

constexpr int kTileSide = 32;
// Maximum number of passes over the image for a kind that lacks rays.
constexpr uint32_t kMaxPasses = 64;

// Returns all tiles, each far from those before it: steps of the golden ratio through the scan
// order.
std::vector<PixelRect> spread_tiles(const PixelRect& area) {
  const std::vector<PixelRect> tiles = make_tiles(area, kTileSide);
  const size_t count = tiles.size();
  size_t step = std::max<size_t>(1, static_cast<size_t>(0.618034 * static_cast<double>(count)));
  while (std::gcd(step, count) != 1) ++step;
  std::vector<PixelRect> spread;
  for (size_t i = 0; i < count; ++i) spread.push_back(tiles[i * step % count]);
  return spread;
}

// A render whose image is discarded.
class RecordingRender {
 public:
  RecordingRender(IntegratorKind kind, const World& world, const Camera& camera, const RecordSettings& settings)
      : batch_size_(settings.batch_size), film_(camera.size_px(), whole_blocks(camera.size_px()), AovSet{}) {
    IntegratorSettings integrator_settings;
    integrator_settings.kind = kind;
    integrator_settings.batch_size = settings.batch_size;
    integrator_ = make_integrator(integrator_settings, world, camera, Sampler(settings.seed), PixelFilter(), AovSet{});
    context_ = integrator_->make_context();
  }

  // Renders until `enough`, a pass without new rays, or kMaxPasses.
  void run(const std::function<bool()>& enough, const std::function<size_t()>& recorded, const CancelToken* cancel) {
    const StandardArithmetic standard_arithmetic;
    const std::vector<PixelRect> tiles = spread_tiles(film_.crop());
    const uint32_t samples = batch_size_ / (kBlockSize * kBlockSize); // of each pixel in a batch
    for (uint32_t pass = 0; pass < kMaxPasses; ++pass) {
      const size_t before = recorded();
      for (const PixelRect& tile : tiles)
        for (const PixelRect& block : make_blocks(tile)) {
          if (enough() || (cancel && cancel->cancelled())) return;
          integrator_->render_block(block, {pass * samples, (pass + 1) * samples}, *context_, film_);
        }
      if (recorded() == before) return;
    }
  }

 private:
  // Blocks cut by the right and lower edges are skipped, so that all camera groups are whole.
  static PixelRect whole_blocks(const V2i& size) {
    const auto whole = [](int side) { return side < kBlockSize ? side : side / kBlockSize * kBlockSize; };
    return {V2i(0), V2i(whole(size.x), whole(size.y))};
  }

  uint32_t batch_size_;
  Film film_;
  std::unique_ptr<Integrator> integrator_;
  std::unique_ptr<ThreadContext> context_;
};

void append(RaySet& set, std::span<const accel::Ray> rays, size_t limit) {
  const size_t room = limit - std::min(limit, set.rays.size());
  set.rays.insert(set.rays.end(), rays.begin(), rays.begin() + static_cast<ptrdiff_t>(std::min(room, rays.size())));
}

// Fisher-Yates shuffle with hashes as random numbers.
void shuffle(std::vector<accel::Ray>& rays, uint32_t seed) {
  for (size_t i = rays.size(); i > 1; --i) {
    const uint32_t random = hash_combine(hash_combine(seed, 0x5f0e1e5U), static_cast<uint32_t>(i));
    std::swap(rays[i - 1], rays[uint64_t{random} * i >> 32]);
  }
}

} // namespace

accel::Hit RecordingAccelerator::intersect(const accel::Ray& ray) const {
  report(Call::nearest, {&ray, 1});
  return inner_->intersect(ray);
}

bool RecordingAccelerator::occluded(const accel::Ray& ray) const {
  report(Call::any_hit, {&ray, 1});
  return inner_->occluded(ray);
}

void RecordingAccelerator::intersect(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const {
  report(Call::nearest, rays);
  inner_->intersect(rays, hits);
}

void RecordingAccelerator::occluded(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const {
  report(Call::any_hit, rays);
  inner_->occluded(rays, occluded);
}

void RecordingAccelerator::intersect_coherent(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const {
  report(Call::coherent, rays);
  inner_->intersect_coherent(rays, hits);
}

void RecordingAccelerator::occluded_coherent(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const {
  report(Call::coherent_any_hit, rays);
  inner_->occluded_coherent(rays, occluded);
}

std::vector<RaySet> record_rays(const World& world, RecordingAccelerator& recorder, const Camera& camera,
                                const RecordSettings& settings, const CancelToken* cancel) {
  using Call = RecordingAccelerator::Call;
  const size_t limit = settings.rays_per_kind;
  RaySet camera_rays{"camera", RayQuery::nearest, kBlockSize * kBlockSize, {}};
  RaySet bounce1{"bounce1", RayQuery::nearest, 0, {}};
  RaySet bounce3{"bounce3", RayQuery::nearest, 0, {}};
  RaySet shadow1{"shadow1", RayQuery::any_hit, 0, {}};
  RaySet shadow3{"shadow3", RayQuery::any_hit, 0, {}};
  RaySet ambient{"ambient-occlusion", RayQuery::any_hit, 0, {}};
  const std::vector<const RaySet*> of_paths{&camera_rays, &bounce1, &bounce3, &shadow1, &shadow3};

  // A batch is one coherent call for each sample, then for each surface one call for shadow rays
  // and one for bounces.
  uint32_t surfaces = 0; // bounces of the batch so far
  recorder.listen([&](Call call, std::span<const accel::Ray> rays) {
    switch (call) {
    case Call::coherent:
      surfaces = 0;
      append(camera_rays, rays, limit);
      break;
    case Call::any_hit:
    case Call::coherent_any_hit:
      if (surfaces == 0) append(shadow1, rays, limit);
      if (surfaces == 2) append(shadow3, rays, limit);
      break;
    case Call::nearest:
      ++surfaces;
      if (surfaces == 1) append(bounce1, rays, limit);
      if (surfaces == 3) append(bounce3, rays, limit);
      break;
    }
  });
  const auto is_full = [limit](const RaySet* set) { return set->rays.size() >= limit; };
  RecordingRender(IntegratorKind::path, world, camera, settings)
      .run([&] { return std::all_of(of_paths.begin(), of_paths.end(), is_full); },
           [&] {
             size_t count = 0;
             for (const RaySet* set : of_paths) count += set->rays.size();
             return count;
           },
           cancel);

  recorder.listen([&](Call call, std::span<const accel::Ray> rays) {
    if (call == Call::any_hit || call == Call::coherent_any_hit) append(ambient, rays, limit);
  });
  RecordingRender(IntegratorKind::ambient_occlusion, world, camera, settings)
      .run([&] { return is_full(&ambient); }, [&] { return ambient.rays.size(); }, cancel);
  recorder.listen({});

  RaySet shuffled{"bounce1-shuffled", RayQuery::nearest, 0, bounce1.rays};
  shuffle(shuffled.rays, settings.seed);
  std::vector<RaySet> sets;
  for (RaySet* set : {&camera_rays, &bounce1, &bounce3, &shuffled, &shadow1, &shadow3, &ambient})
    sets.push_back(std::move(*set));
  return sets;
}

} // namespace kindling
