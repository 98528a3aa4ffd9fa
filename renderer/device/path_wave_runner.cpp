// Leads the paths of a wave through the kernels, bounce by bounce.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/path_wave_runner.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/integrator/stages/splat_pixels.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

namespace kindling {
namespace {

// True if light paths are followed, of samples or for photons.
bool follows_light_paths(const WaveSetup& setup) { return setup.light_paths > 0.0f || !setup.photons.empty(); }

// Returns the light paths of photon maps that are traced together.
uint32_t photon_paths_together(const WaveSetup& setup) {
  return setup.photons.empty() ? 0 : std::min(setup.paths, PathWave::kPhotonPaths);
}

// Fewer paths are not sorted: a multiprocessor has a warp or two of them.
constexpr uint32_t kFewestSorted = 8192;

Kernel shading_kernel(const WaveSetup& setup) {
  if (setup.splits()) return Kernel::shade_split;
  if (!setup.photons.empty()) return Kernel::shade_beside_photons;
  if (setup.manifolds) return Kernel::shade_with_manifolds;
  if (setup.path_reuse > 1) return Kernel::shade_reused;
  return setup.light_paths > 0.0f ? Kernel::shade_beside_light_paths : Kernel::shade;
}

} // namespace

uint64_t path_wave_bytes(const WaveSetup& setup) {
  constexpr uint64_t kOfPath = sizeof(PathState) + sizeof(MediumStack) + sizeof(accel::Ray) + sizeof(accel::Hit) +
                               3 * sizeof(uint32_t) + sizeof(uint8_t);
  constexpr uint64_t kOfShadowRay = sizeof(accel::Ray) + sizeof(WaveShadow);
  const uint64_t of_light_path =
      (follows_light_paths(setup) ? sizeof(WaveLightPath) : 0) + (setup.light_paths > 0.0f ? sizeof(WaveSplat) : 0);
  const uint64_t of_reuse =
      setup.path_reuse > 1 ? sizeof(ReusedPath) + setup.path_reuse * (sizeof(ReuseLink) + sizeof(uint32_t)) : 0;
  const uint64_t of_split =
      !setup.splits() ? 0
                      : setup.light_groups * sizeof(SplitView::Classes) + sizeof(SplitView::Passes) +
                            sizeof(FirstEvent) + sizeof(LobeColors) + setup.max_shadow_rays * sizeof(SplitShadow) +
                            (setup.path_reuse > 1 ? std::max(setup.light_groups, 1U) * sizeof(Rgb) + 1 : 0) +
                            (setup.light_paths > 0.0f ? sizeof(SplatParts) : 0);
  return common_wave_bytes(setup) +
         setup.paths * (kOfPath + setup.max_shadow_rays * kOfShadowRay + of_light_path + of_reuse + of_split) +
         photon_paths_together(setup) * sizeof(WavePhoton) + 2 * sizeof(uint64_t) + 2 * kHitKinds * sizeof(uint32_t);
}

std::vector<Kernel> path_wave_kernels(bool filters_hits, const WaveSetup& setup) {
  std::vector<Kernel> kernels{Kernel::begin_path, filters_hits ? Kernel::intersect : Kernel::intersect_opaque,
                              shading_kernel(setup), filters_hits ? Kernel::trace_shadow : Kernel::trace_shadow_opaque,
                              setup.splits() ? Kernel::finish_split_pixel : Kernel::finish_pixel};
  const auto add = [&](std::initializer_list<Kernel> more) {
    for (const Kernel kernel : more) kernels.push_back(kernel);
  };
  add({Kernel::place_kinds, Kernel::sort_paths});
  if (setup.max_shadow_rays > 1 && !filters_hits) kernels.push_back(Kernel::add_shadows);
  if (setup.splits()) add({Kernel::begin_split, Kernel::split_shadow});
  if (setup.splits() && setup.path_reuse > 1) add({Kernel::split_tail, Kernel::split_shared});
  if (setup.light_paths > 0.0f)
    add({Kernel::begin_light_path, setup.splits() ? Kernel::scatter_split_light_path : Kernel::scatter_light_path,
         filters_hits ? Kernel::trace_sight : Kernel::trace_sight_opaque});
  if (!setup.photons.empty()) add({Kernel::begin_photon_path, Kernel::leave_photon});
  if (setup.path_reuse > 1)
    add({Kernel::start_sharing, Kernel::link_paths, filters_hits ? Kernel::trace_link : Kernel::trace_link_opaque,
         Kernel::share_light, Kernel::receive_light});
  return kernels;
}

PathWaveRunner::PathWaveRunner(Device& on, const World& world, const DeviceScene* scene, const WaveSetup& setup)
    : DeviceWave(on, world, setup, setup.aovs.needs_film_surface()), filters_hits_(world.filters_hits),
      has_light_paths_(setup.light_paths > 0.0f), splits_(setup.splits()), sorts_(world.materials.size() > 1),
      adds_together_(setup.max_shadow_rays > 1), shade_(shading_kernel(setup)), map_sizes_(setup.photons),
      filter_(setup.filter), states_(on, capacity()), media_(on, capacity()), rays_(on, capacity()),
      shadow_rays_(on, capacity() * setup.max_shadow_rays), hits_(on, capacity()), active_(on, capacity()),
      next_(on, capacity()), sorted_(on, capacity()), kinds_(on, capacity()), kind_counts_(on, 1), queue_counts_(on, 1),
      shadow_records_(on, capacity() * setup.max_shadow_rays),
      light_paths_(on, follows_light_paths(setup) ? capacity() : 0), splats_(on, has_light_paths_ ? capacity() : 0),
      reused_(on, setup.path_reuse > 1 ? capacity() : 0), links_(on, reused_.size() * setup.path_reuse),
      traced_links_(on, links_.size()), left_photons_(on, photon_paths_together(setup)),
      photon_maps_(on, setup.photons, setup.photon_maps) {
  QueueCounts* const counts = queue_counts_.data();
  wave_.scene = scene;
  wave_.states = states_.data();
  wave_.media = media_.data();
  wave_.path_rays = rays_.data();
  wave_.hits = hits_.data();
  wave_.active.paths = active_.data();
  wave_.next = {&counts->next, next_.data()};
  wave_.kind_counts = kind_counts_.data()->paths.data();
  wave_.kind_places = kind_counts_.data()->places.data();
  wave_.sorted_paths = sorted_.data();
  wave_.shadows.count = &counts->shadows;
  wave_.shadow_rays = shadow_rays_.data();
  wave_.shadow_records = shadow_records_.data();
  if (reused_.size() > 0) {
    wave_.reuse = {reused_.data(), links_.data(), setup.path_reuse};
    wave_.reuse_links = {&counts->links, traced_links_.data()};
  }
  wave_.light_paths = light_paths_.data();
  wave_.splats = splats_.data();
  if (splits_) place_split(setup.light_groups);
  wave_.photons_left.count = &counts->photons;
  wave_.left_photons = left_photons_.data();
}

void PathWaveRunner::place_split(uint32_t light_groups) {
  split_groups_.grow(device(), size_t{capacity()} * light_groups);
  split_passes_.grow(device(), capacity());
  split_firsts_.grow(device(), capacity());
  split_colors_.grow(device(), capacity());
  split_shadows_.grow(device(), shadow_rays_.size());
  split_tails_.grow(device(), reused_.size() * std::max(light_groups, 1U));
  second_groups_.grow(device(), reused_.size());
  splat_parts_.grow(device(), splats_.size());
  wave_.split = {.group_count = light_groups,
                 .by_group = split_groups_.data(),
                 .by_pass = split_passes_.data(),
                 .firsts = split_firsts_.data(),
                 .colors = split_colors_.data(),
                 .shadows = split_shadows_.data(),
                 .tails = split_tails_.data(),
                 .second_groups = second_groups_.data()};
  wave_.splat_parts = splat_parts_.data();
}

bool PathWaveRunner::take_photons() {
  if (map_sizes_.empty()) return true;
  const PhotonMapsOnDevice::Maps maps = photon_maps_.absent(samples());
  if (!maps.empty()) {
    photon_maps_.begin(maps);
    const uint64_t begin = maps.first * map_sizes_.paths, count = maps.count() * map_sizes_.paths;
    const auto together = static_cast<uint32_t>(left_photons_.size());
    for (uint64_t first = 0; first < count; first += together)
      if (!follow_photon_paths(begin, first, static_cast<uint32_t>(std::min<uint64_t>(together, count - first))))
        return false;
    photon_maps_.build();
  }
  wave_.photons = photon_maps_.of_samples(samples());
  return true;
}

bool PathWaveRunner::follow_photon_paths(uint64_t maps_begin, uint64_t first, uint32_t count) {
  wave_.first_light_path = maps_begin + first;
  queue_counts_.clear(1);
  launch(Kernel::begin_photon_path, wave_, count);
  uint32_t surfaces = 0; // that the paths have met
  for (uint32_t active = take_next().next; active > 0; ++surfaces) {
    if (abandoned()) return false;
    find_hits(active, true);
    counters.photon += active;
    queue_counts_.clear(1);
    launch_shading(Kernel::leave_photon, wave_, active);
    const QueueCounts counts = take_next();
    downloaded_photons_.resize(counts.photons);
    left_photons_.download(downloaded_photons_);
    photon_maps_.add(first, surfaces, downloaded_photons_);
    active = counts.next;
  }
  return true;
}

bool PathWaveRunner::run(const Film& film) {
  start(film, wave_);
  found_.clear();
  found_parts_.clear();
  if (!take_photons() || !follow_camera_paths()) return false;
  if (wave_.reuse.paths != nullptr) share_paths();
  launch(splits_ ? Kernel::finish_split_pixel : Kernel::finish_pixel, wave_, pixel_count());
  const uint64_t light_paths = film.has_splats() ? light_path_count() : 0; // none for a pilot
  for (uint64_t first = 0; first < light_paths; first += capacity())
    if (!follow_light_paths(first, static_cast<uint32_t>(std::min<uint64_t>(capacity(), light_paths - first))))
      return false;
  download_sums();
  return !abandoned();
}

bool PathWaveRunner::follow_camera_paths() {
  launch(Kernel::begin_path, wave_, sample_count());
  if (splits_) launch(Kernel::begin_split, wave_, sample_count());
  bool coherent = true; // rays of the camera are in the order of the pixels
  for (uint32_t active = sample_count(); active > 0; coherent = false) {
    if (abandoned()) return false;
    find_hits(active, !coherent);
    queue_counts_.clear(1);
    launch_shading(shade_, wave_, active);
    const QueueCounts counts = take_next();
    launch(filters_hits_ ? Kernel::trace_shadow : Kernel::trace_shadow_opaque, wave_, counts.shadows);
    if (adds_together_ && !filters_hits_) launch(Kernel::add_shadows, wave_, counts.shadows);
    if (splits_) launch(Kernel::split_shadow, wave_, counts.shadows);
    active = counts.next;
  }
  return true;
}

void PathWaveRunner::find_hits(uint32_t active, bool sort) {
  sort = sort && sorts_ && active >= kFewestSorted;
  wave_.kinds = sort ? kinds_.data() : nullptr;
  if (sort) kind_counts_.clear(1);
  launch(filters_hits_ ? Kernel::intersect : Kernel::intersect_opaque, wave_, active);
  if (!sort) return;
  launch(Kernel::place_kinds, wave_, kHitKinds);
  launch(Kernel::sort_paths, wave_, active);
  std::swap(wave_.active.paths, wave_.sorted_paths);
}

void PathWaveRunner::share_paths() {
  if (splits_) launch(Kernel::split_tail, wave_, sample_count());
  launch(Kernel::start_sharing, wave_, sample_count());
  queue_counts_.clear(1);
  launch(Kernel::link_paths, wave_, sample_count());
  std::array<QueueCounts, 1> counts;
  queue_counts_.download(counts);
  launch(filters_hits_ ? Kernel::trace_link : Kernel::trace_link_opaque, wave_, counts[0].links);
  launch(Kernel::share_light, wave_, sample_count());
  launch(Kernel::receive_light, wave_, sample_count());
  if (splits_) launch(Kernel::split_shared, wave_, sample_count());
}

bool PathWaveRunner::follow_light_paths(uint64_t first, uint32_t count) {
  wave_.first_light_path = first;
  queue_counts_.clear(1);
  launch(Kernel::begin_light_path, wave_, count);
  for (uint32_t active = take_next().next; active > 0;) {
    if (abandoned()) return false;
    find_hits(active, true);
    queue_counts_.clear(1);
    launch_shading(splits_ ? Kernel::scatter_split_light_path : Kernel::scatter_light_path, wave_, active);
    const QueueCounts counts = take_next();
    launch(filters_hits_ ? Kernel::trace_sight : Kernel::trace_sight_opaque, wave_, counts.shadows);
    take_splats(counts.shadows);
    active = counts.next;
  }
  return true;
}

PathWaveRunner::QueueCounts PathWaveRunner::take_next() {
  std::array<QueueCounts, 1> counts;
  queue_counts_.download(counts);
  std::swap(wave_.active.paths, wave_.next.paths);
  return counts[0];
}

void PathWaveRunner::take_splats(uint32_t count) {
  downloaded_.resize(count);
  splats_.download(downloaded_);
  if (splits_) {
    downloaded_parts_.resize(count);
    splat_parts_.download(downloaded_parts_);
  }
  for (uint32_t i = 0; i < count; ++i) {
    if (is_black(downloaded_[i].radiance)) continue;
    found_.push_back(downloaded_[i]);
    if (splits_) found_parts_.push_back(downloaded_parts_[i]);
  }
}

void PathWaveRunner::take_results(std::span<BlockWork> work, Film& film) {
  const PixelRect& area = film.splat_area();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, found_.size(), 1024), [&](const auto& range) {
    const StandardArithmetic standard_arithmetic;
    for (size_t i = range.begin(); i < range.end(); ++i) {
      const SplatParts parts = splits_ ? found_parts_[i] : SplatParts{};
      visit_splat_pixels(filter_, found_[i].film_px, area.min, area.max, [&](const V2i& pixel, float weight) {
        film.add_splat(pixel, found_[i].radiance * weight, parts);
      });
    }
  });
  DeviceWave::take_results(work, film);
}

} // namespace kindling
