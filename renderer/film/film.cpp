// The Film: storage, merging and cutting of sums.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

namespace kindling {

namespace {

// Records are written to files without conversion.
static_assert(std::endian::native == std::endian::little);

} // namespace

template <typename ThisFilm, typename Visit>
void Film::for_each_plane(ThisFilm& film, const Visit& visit) {
  const auto visit_if_present = [&](std::string_view name, auto& records, size_t per_pixel, bool of_splats = false) {
    static_assert(std::is_trivially_copyable_v<typename std::remove_reference_t<decltype(records)>::value_type>);
    if (!records.empty()) visit(name, records, per_pixel, of_splats);
  };
  visit_if_present("beauty", film.sums_, 1);
  visit_if_present("variance", film.moments_, 1);
  visit_if_present("surface", film.surfaces_, 1);
  visit_if_present("guides", film.guides_, 1);
  visit_if_present("components", film.components_, 1);
  visit_if_present("blocks", film.blocks_, kOutlierBlocks - 1);
  visit_if_present("light groups", film.groups_, film.light_groups_.size());
  visit_if_present("light passes", film.passes_, film.pass_places_.count);
  visit_if_present("lobe colors", film.colors_, 1);
  visit_if_present("nearest", film.nearest_, 1);
  visit_if_present("shadow catcher", film.catchers_, 1);
  visit_if_present("splats", film.splats_, 1, true);
  visit_if_present("splat groups", film.splat_groups_, film.light_groups_.size(), true);
  visit_if_present("splat passes", film.splat_passes_, film.splat_pass_count_, true);
}

Film::Film(const V2i& size_px, const PixelRect& crop, AovSet aovs) : size_px_(size_px), crop_(crop), aovs_(aovs) {
  const size_t count = crop.empty() ? 0 : static_cast<size_t>(crop.pixel_count());
  sums_ = ZeroedArray<PixelSum>(count);
  if (aovs.contains(Aov::variance)) moments_ = ZeroedArray<MomentSum>(count);
  if (aovs.needs_surface()) surfaces_ = ZeroedArray<SurfaceSum>(count);
  if (aovs.needs_guides()) guides_ = ZeroedArray<GuideSum>(count);
  if (aovs.needs_components()) components_ = ZeroedArray<ComponentSum>(count);
  pass_places_ = LightPassPlaces(aovs);
  passes_ = ZeroedArray<RadianceSum>(count * pass_places_.count);
  if (aovs.needs_lobe_colors()) colors_ = ZeroedArray<LobeColorSum>(count);
  if (aovs.needs_nearest()) nearest_ = ZeroedArray<NearestSample>(count);
  if (aovs.contains(Aov::shadow_catcher)) catchers_ = ZeroedArray<CatcherSum>(count);
  if (aovs.has_mattes()) mattes_ = MatteSums(count);
}

void Film::trim_outliers() { blocks_ = ZeroedArray<ColorSum>(sums_.size() * (kOutlierBlocks - 1)); }

void Film::split_by_light_groups(std::vector<std::string> names) {
  light_groups_ = std::move(names);
  groups_ = ZeroedArray<RadianceSum>(sums_.size() * light_groups_.size());
  allocate_splat_groups();
}

Film Film::cut(const PixelRect& crop) const {
  assert(crop.empty() || crop_.contains(crop));
  Film part(size_px_, crop, aovs_);
  if (trims_outliers()) part.trim_outliers();
  part.split_by_light_groups(light_groups_);
  const std::vector<ConstPlane> from = planes(); // splats are the last
  const std::vector<Plane> to = part.planes();
  tbb::parallel_for(crop.min.y, crop.max.y, [&](int y) {
    for (size_t p = 0; p < to.size(); ++p) {
      const size_t size = to[p].bytes_per_pixel;
      std::memcpy(to[p].bytes.data() + part.index_of({crop.min.x, y}) * size,
                  from[p].bytes.data() + index_of({crop.min.x, y}) * size, static_cast<size_t>(crop.width()) * size);
    }
    for (int x = crop.min.x; x < crop.max.x && !mattes_.empty(); ++x)
      part.mattes_.add(part.index_of({x, y}), mattes_, index_of({x, y}));
  });
  cut_splats(part);
  return part;
}

void Film::add(const Film& part) {
  assert(part.size_px_ == size_px_ && part.aovs_.bits() == aovs_.bits());
  if (part.crop_.empty()) return;
  assert(part.trims_outliers() == trims_outliers() && part.light_groups_ == light_groups_);
  assert(crop_.contains(part.crop_));
  const auto width = static_cast<size_t>(part.crop_.width());
  const auto add_rows = [&](auto& sums, const auto& of_part, size_t per_pixel = 1) {
    if (sums.empty()) return;
    tbb::parallel_for(part.crop_.min.y, part.crop_.max.y, [&](int y) {
      const V2i first(part.crop_.min.x, y);
      for (size_t i = 0; i < width * per_pixel; ++i)
        sums[index_of(first) * per_pixel + i].add(of_part[part.index_of(first) * per_pixel + i]);
    });
  };
  add_rows(sums_, part.sums_);
  add_rows(moments_, part.moments_);
  add_rows(surfaces_, part.surfaces_);
  add_rows(guides_, part.guides_);
  add_rows(components_, part.components_);
  add_rows(blocks_, part.blocks_, kOutlierBlocks - 1);
  add_rows(groups_, part.groups_, light_groups_.size());
  add_rows(passes_, part.passes_, pass_places_.count);
  add_rows(colors_, part.colors_);
  add_rows(nearest_, part.nearest_);
  add_rows(catchers_, part.catchers_);
  assert(part.splats_.empty() || splat_area_.contains(part.splat_area_));
  if (!splats_.empty() && !part.splats_.empty())
    tbb::parallel_for(part.splat_area_.min.y, part.splat_area_.max.y, [&](int y) {
      const V2i first(part.splat_area_.min.x, y);
      const auto add_row = [&](auto& sums, const auto& of_part, size_t per_pixel) {
        const size_t count = sums.empty() ? 0 : static_cast<size_t>(part.splat_area_.width()) * per_pixel;
        for (size_t i = 0; i < count; ++i)
          sums[splat_index(first) * per_pixel + i].add(of_part[part.splat_index(first) * per_pixel + i]);
      };
      add_row(splats_, part.splats_, 1);
      add_row(splat_groups_, part.splat_groups_, light_groups_.size());
      add_row(splat_passes_, part.splat_passes_, splat_pass_count_);
    });
  if (mattes_.empty()) return;
  tbb::parallel_for(part.crop_.min.y, part.crop_.max.y, [&](int y) {
    for (int x = part.crop_.min.x; x < part.crop_.max.x; ++x)
      mattes_.add(index_of({x, y}), part.mattes_, part.index_of({x, y}));
  });
}

void Film::add(const PixelRect& block, const FilmView& part) {
  assert(crop_.contains(block) && part.sums.size() == static_cast<size_t>(block.pixel_count()));
  const auto width = static_cast<size_t>(block.width());
  const auto add_rows = [&](auto& sums, const auto& of_part, size_t per_pixel = 1) {
    assert(of_part.size() == (sums.empty() ? 0 : part.sums.size() * per_pixel));
    if (sums.empty()) return;
    size_t next = 0;
    for (int y = block.min.y; y < block.max.y; ++y) {
      const size_t first = index_of({block.min.x, y}) * per_pixel;
      for (size_t i = 0; i < width * per_pixel; ++i) sums[first + i].add(of_part[next++]);
    }
  };
  add_rows(sums_, part.sums);
  add_rows(moments_, part.moments);
  add_rows(surfaces_, part.surfaces);
  add_rows(guides_, part.guides);
  add_rows(components_, part.components);
  add_rows(blocks_, part.blocks, kOutlierBlocks - 1);
  add_rows(groups_, part.groups, light_groups_.size());
  add_rows(passes_, part.passes, pass_places_.count);
  add_rows(colors_, part.colors);
}

std::vector<Film::ConstPlane> Film::planes() const {
  std::vector<ConstPlane> planes;
  for_each_plane(*this, [&](std::string_view name, const auto& records, size_t per_pixel, bool of_splats) {
    planes.push_back({name, sizeof records[0] * per_pixel, std::as_bytes(std::span(records)), of_splats});
  });
  return planes;
}

std::vector<Film::Plane> Film::planes() {
  std::vector<Plane> planes;
  for_each_plane(*this, [&](std::string_view name, auto& records, size_t per_pixel, bool of_splats) {
    planes.push_back({name, sizeof records[0] * per_pixel, std::as_writable_bytes(std::span(records)), of_splats});
  });
  return planes;
}

uint64_t Film::total_samples() const {
  uint64_t total = 0;
  for (const PixelSum& sum : sums_) total += sum.samples;
  return total;
}

size_t Film::memory_bytes() const {
  size_t bytes = 0;
  for (const ConstPlane& plane : planes()) bytes += plane.bytes.size();
  return bytes + mattes_.memory_bytes();
}

} // namespace kindling
