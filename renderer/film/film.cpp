// The Film: storage, merging and cutting of sums, and resolution of means.
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

// Returns the divisor of a sum of weighted values, which is positive.
double divisor(double weight, uint64_t count) { return weight > 0.0 ? weight : static_cast<double>(count); }

double mean_luminance(const PixelSum& sum, double by) {
  return (0.2126 * sum.rgb[0].value() + 0.7152 * sum.rgb[1].value() + 0.0722 * sum.rgb[2].value()) / by;
}

template <typename Sum>
void store_mean(const Sum (&sum)[3], double by, float* out) {
  for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c].value() / by);
}

// The mean of samples plus that of light paths.
template <typename Sum>
void store_mean(const Sum (&sum)[3], double by, const Sum (&splats)[3], double light_paths, float* out) {
  for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c].value() / by + splats[c].value() / light_paths);
}

// Returns the variance of the mean r = sum(w y) / sum(w). To first order it is
// sum(w^2 (y - r)^2) / sum(w)^2 (Cochran, "Sampling Techniques", 3rd ed., section 6.4), times
// n / (n - 1). With equal weights that is exactly the unbiased s^2 / n.
double variance_of_mean(const PixelSum& sum, const MomentSum& y, double mean) {
  if (sum.samples < 2) return 0.0;
  const auto n = static_cast<double>(sum.samples);
  const double by = divisor(sum.weight.value(), sum.samples);
  const double squares = y.w2_y2.value() - 2.0 * mean * y.w2_y.value() + mean * mean * y.w2.value();
  return std::max(squares, 0.0) / (by * by) * n / (n - 1.0);
}

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
  visit_if_present("light passes", film.passes_, film.pass_count_);
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
  for (size_t pass = 0; pass < kLightPassCount; ++pass)
    pass_slots_[pass] = aovs.contains(static_cast<LightPass>(pass)) ? static_cast<uint8_t>(pass_count_++) : kNotStored;
  passes_ = ZeroedArray<RadianceSum>(count * pass_count_);
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
  add_rows(passes_, part.passes_, pass_count_);
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

std::optional<Rgb> Film::trimmed(size_t index) const {
  std::array<BlockSum, kOutlierBlocks> blocks;
  const PixelSum& sum = sums_[index];
  ColorSum last{{sum.rgb[0], sum.rgb[1], sum.rgb[2]}, sum.weight};
  const auto values = [](const ColorSum& block) {
    return BlockSum{{block.rgb[0].value(), block.rgb[1].value(), block.rgb[2].value()}, block.weight.value()};
  };
  for (size_t i = 0; i + 1 < kOutlierBlocks; ++i) {
    const ColorSum& block = blocks_[index * (kOutlierBlocks - 1) + i];
    last.subtract(block);
    blocks[i] = values(block);
  }
  blocks[kOutlierBlocks - 1] = values(last);
  return outliers_trimmed(blocks);
}

// Returns false for AOVs of other planes.
bool Film::resolve_surface(Aov aov, size_t index, double by, float* out) const {
  const auto hits = [](const SurfaceSum& surface) { return divisor(surface.hit_weight.value(), surface.hits); };
  switch (aov) {
  case Aov::albedo:
    if (!surfaces_.empty()) store_mean(surfaces_[index].albedo, by, out);
    return true;
  case Aov::normal:
    if (!surfaces_.empty()) store_mean(surfaces_[index].normal, by, out);
    return true;
  case Aov::denoising_albedo:
    if (!guides_.empty()) store_mean(guides_[index].albedo, by, out);
    return true;
  case Aov::denoising_normal:
    if (!guides_.empty()) store_mean(guides_[index].normal, by, out);
    return true;
  case Aov::depth:
    if (!surfaces_.empty() && surfaces_[index].hits > 0)
      out[0] = static_cast<float>(surfaces_[index].depth.value() / hits(surfaces_[index]));
    return true;
  case Aov::position:
    if (!surfaces_.empty() && surfaces_[index].hits > 0)
      store_mean(surfaces_[index].position, hits(surfaces_[index]), out);
    return true;
  default: return false;
  }
}

void Film::resolve_pixel(Aov aov, size_t index, double light_paths, float* out) const {
  const PixelSum& sum = sums_[index];
  if (sum.samples == 0) return;
  const double by = divisor(sum.weight.value(), sum.samples);
  switch (aov) {
  case Aov::beauty:
    if (trims_outliers())
      if (const std::optional<Rgb> mean = trimmed(index)) {
        for (int c = 0; c < 3; ++c) out[c] = (*mean)[c];
        return;
      }
    if (light_paths > 0.0)
      store_mean(sum.rgb, by, splats_[splat_index_at(index)].rgb, light_paths, out);
    else
      store_mean(sum.rgb, by, out);
    return;
  // Negative lobes of the filter can move means at edges out of [0, 1].
  case Aov::alpha: out[0] = static_cast<float>(std::clamp(opacity(index) / by, 0.0, 1.0)); return;
  case Aov::samples: out[0] = static_cast<float>(sum.samples); return;
  case Aov::variance:
    if (!moments_.empty()) out[0] = static_cast<float>(variance_of_mean(sum, moments_[index], mean_luminance(sum, by)));
    return;
  default: break;
  }
  if (resolve_surface(aov, index, by, out)) return;
  switch (aov) {
  case Aov::emission:
    if (!components_.empty()) store_mean(components_[index].emission, by, out);
    return;
  case Aov::direct:
    if (!components_.empty()) store_mean(components_[index].direct, by, out);
    return;
  case Aov::indirect:
    for (int c = 0; c < 3 && !components_.empty(); ++c) {
      const double beauty = sum.rgb[c].value();
      const double emission = components_[index].emission[c].value(), direct = components_[index].direct[c].value();
      const double difference = beauty - emission - direct;
      // Radiance was summed in single precision; differences within its rounding count as 0.
      const double rounding = 1e-6 * (std::abs(beauty) + std::abs(emission) + std::abs(direct));
      const double of_samples = std::abs(difference) <= rounding ? 0.0 : difference / by;
      const double of_splats = light_paths > 0.0 ? splats_[splat_index_at(index)].rgb[c].value() / light_paths : 0.0;
      out[c] = static_cast<float>(of_samples + of_splats);
    }
    return;
  default: break;
  }
  if (is_light_pass(aov))
    resolve_light(aov, index, light_paths, out);
  else if (is_of_nearest(aov) && !nearest_.empty())
    nearest_[index].resolve(aov, out);
  else if (aov == Aov::shadow_catcher && !catchers_.empty())
    resolve_behind(index, by, out);
}

// Sum of weights times what hides a background; a shadow does in part.
double Film::opacity(size_t index) const {
  const double objects = sums_[index].alpha.value();
  return catchers_.empty() ? objects : objects + catchers_[index].weight.value() * catchers_[index].shadow();
}

void Film::resolve_behind(size_t index, double by, float* out) const {
  const CatcherSum& caught = catchers_[index];
  const double background = by - sums_[index].alpha.value() - caught.weight.value();
  for (int c = 0; c < 3; ++c)
    out[c] = static_cast<float>(std::max(background + caught.weight.value() * caught.lit(c), 0.0) / by);
}

void Film::resolve_light(Aov aov, size_t index, double light_paths, float* out) const {
  const double by = divisor(sums_[index].weight.value(), sums_[index].samples);
  switch (aov) {
  case Aov::diffuse_color:
    if (!colors_.empty()) store_mean(colors_[index].diffuse, by, out);
    return;
  case Aov::glossy_color:
    if (!colors_.empty()) store_mean(colors_[index].glossy, by, out);
    return;
  case Aov::transmission_color:
    if (!colors_.empty()) store_mean(colors_[index].transmission, by, out);
    return;
  default: break;
  }
  const size_t pass = static_cast<size_t>(aov) - static_cast<size_t>(Aov::diffuse_direct);
  assert(aov >= Aov::diffuse_direct && pass < kLightPassCount);
  if (pass_slots_[pass] == kNotStored) return;
  const RadianceSum& sum = passes_[index * pass_count_ + pass_slots_[pass]];
  const auto* const of_splats = std::find(kSplatPasses.begin(), kSplatPasses.end(), static_cast<LightPass>(pass));
  if (of_splats == kSplatPasses.end() || !(light_paths > 0.0)) {
    store_mean(sum.rgb, by, out);
    return;
  }
  const size_t slot = splat_slots_[static_cast<size_t>(of_splats - kSplatPasses.begin())];
  store_mean(sum.rgb, by, splat_passes_[splat_index_at(index) * splat_pass_count_ + slot].rgb, light_paths, out);
}

std::vector<float> Film::resolve(Aov aov) const {
  const auto channels = static_cast<size_t>(aov_info(aov).channels);
  std::vector<float> values(sums_.size() * channels, 0.0f);
  const double paths = light_paths();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) resolve_pixel(aov, i, paths, values.data() + i * channels);
  });
  return values;
}

std::vector<float> Film::resolve_light_group(size_t group) const {
  assert(group < light_groups_.size());
  std::vector<float> values(sums_.size() * 3, 0.0f);
  const double paths = light_paths();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const PixelSum& sum = sums_[i];
      if (sum.samples == 0) continue;
      const double by = divisor(sum.weight.value(), sum.samples);
      const RadianceSum& of_samples = groups_[i * light_groups_.size() + group];
      if (paths > 0.0)
        store_mean(of_samples.rgb, by, splat_groups_[splat_index_at(i) * light_groups_.size() + group].rgb, paths,
                   values.data() + i * 3);
      else
        store_mean(of_samples.rgb, by, values.data() + i * 3);
    }
  });
  return values;
}

std::vector<float> Film::resolve_rgba() const {
  std::vector<float> values(sums_.size() * 4, 0.0f);
  const double paths = light_paths();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      resolve_pixel(Aov::beauty, i, paths, values.data() + i * 4);
      resolve_pixel(Aov::alpha, i, paths, values.data() + i * 4 + 3);
    }
  });
  return values;
}

std::vector<float> Film::resolve_rgba(const PixelRect& rect) const {
  assert(crop_.contains(rect));
  std::vector<float> values(static_cast<size_t>(rect.pixel_count()) * 4, 0.0f);
  const double paths = light_paths();
  float* out = values.data();
  for (int y = rect.min.y; y < rect.max.y; ++y)
    for (int x = rect.min.x; x < rect.max.x; ++x, out += 4) {
      resolve_pixel(Aov::beauty, index_of({x, y}), paths, out);
      resolve_pixel(Aov::alpha, index_of({x, y}), paths, out + 3);
    }
  return values;
}

std::vector<float> Film::resolve_matte(Matte matte, int levels) const {
  const size_t channels = 2 * static_cast<size_t>(levels);
  std::vector<float> values(sums_.size() * channels, 0.0f);
  if (!aovs_.contains(matte)) return values;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    std::vector<MatteTerm> terms;
    for (size_t i = range.begin(); i != range.end(); ++i) {
      if (sums_[i].samples == 0) continue;
      mattes_.list(i, terms);
      rank_mattes(terms, matte, divisor(sums_[i].weight.value(), sums_[i].samples),
                  std::span(values).subspan(i * channels, channels));
    }
  });
  return values;
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
