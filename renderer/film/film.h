// The Film: sums of samples for each pixel, and the images computed from them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/film/aov.h"
#include "renderer/film/catcher_sum.h"
#include "renderer/film/film_sums.h"
#include "renderer/film/film_surface.h"
#include "renderer/film/film_view.h"
#include "renderer/film/matte_sums.h"
#include "renderer/film/nearest_sample.h"
#include "renderer/film/outliers.h"
#include "renderer/film/split_light.h"
#include "renderer/film/zeroed_array.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

inline constexpr int kMaxImageSide = 65536; // pixels, of an image that a user asks for

// A half-open rectangle of pixels.
struct PixelRect {
  V2i min{0, 0};
  V2i max{0, 0};
  [[nodiscard]] int width() const { return max.x - min.x; }
  [[nodiscard]] int height() const { return max.y - min.y; }
  [[nodiscard]] int64_t pixel_count() const { return static_cast<int64_t>(width()) * height(); }
  [[nodiscard]] bool empty() const { return width() <= 0 || height() <= 0; }
  [[nodiscard]] bool contains(const PixelRect& part) const {
    return part.min.x >= min.x && part.min.y >= min.y && part.max.x <= max.x && part.max.y <= max.y;
  }
  // Returns the smallest rectangle around both; neither is empty.
  [[nodiscard]] PixelRect united(const PixelRect& other) const {
    return {V2i(std::min(min.x, other.min.x), std::min(min.y, other.min.y)),
            V2i(std::max(max.x, other.max.x), std::max(max.y, other.max.y))};
  }
  bool operator==(const PixelRect&) const = default;
};

struct SplatLocks;

// Sums of samples for each pixel of a crop window. A mean is sum(weight * value) / sum(weight); if
// the sum of weights is not positive (few samples under negative lobes), the number of samples
// replaces it.
//
// All sums are exact (film_sums.h), so the state of a pixel is a function of the set of its
// samples. The order of samples, their distribution among threads and the merging of films by
// add(part) do not change a bit. A pixel must be written by one thread at a time.
class Film {
 public:
  Film(const V2i& size_px, const PixelRect& crop, AovSet aovs);

  // Adds a sample; `pixel` must be inside of crop().
  void add(const V2i& pixel, const FilmSample& sample) {
    const size_t index = index_of(pixel);
    sums_[index].add(sample.radiance, sample.alpha, sample.weight);
    if (!moments_.empty() || !blocks_.empty()) view().add_to_others(index, sample);
  }
  // Adds the AOV data of a sample, in addition to add(). Does nothing if no AOV needs it.
  void add_surface(const V2i& pixel, const FilmSurface& surface, float weight) {
    view().add_surface(index_of(pixel), surface, weight);
  }
  // Returns the sums as arrays, for what no function here adds: a pixel's are at index_of().
  [[nodiscard]] FilmView view() {
    return {sums_,       moments_, surfaces_, guides_, components_,
            blocks_,     groups_,  passes_,   colors_, light_groups_.size(),
            pass_places_};
  }
  [[nodiscard]] size_t index_of(const V2i& pixel) const {
    assert(pixel.x >= crop_.min.x && pixel.x < crop_.max.x && pixel.y >= crop_.min.y && pixel.y < crop_.max.y);
    return static_cast<size_t>(pixel.y - crop_.min.y) * static_cast<size_t>(crop_.width()) +
           static_cast<size_t>(pixel.x - crop_.min.x);
  }
  // Adds the ids of the first surface of a sample to the mattes. Does nothing without mattes.
  void add_matte(const V2i& pixel, const MatteIds& ids, float weight) {
    if (!mattes_.empty()) mattes_.add(index_of(pixel), ids, weight);
  }
  // True if a sample at this distance from its pixel's center would replace the pixel's nearest
  // one, by NearestSample::yields_to(). False unless AovSet::needs_nearest().
  [[nodiscard]] bool wants_nearest(const V2i& pixel, uint32_t number, float distance2) const {
    return !nearest_.empty() && nearest_[index_of(pixel)].yields_to(number, distance2);
  }
  void add_nearest(const V2i& pixel, const NearestSample& sample) {
    if (!nearest_.empty()) nearest_[index_of(pixel)].add(sample);
  }
  // Adds a sample whose first surface belongs to a shadow catcher, in addition to add() of a black
  // sample without alpha. Does nothing without Aov::shadow_catcher.
  void add_caught(const V2i& pixel, const CaughtLight& light, float weight) {
    if (!catchers_.empty()) catchers_[index_of(pixel)].add(light, weight);
  }
  // Enables add_splat() for the pixels of a rectangle that contains crop(): light paths of a part
  // of an image reach pixels of other parts. Must be called before the first add().
  void enable_splats(const PixelRect& area);
  void enable_splats() { enable_splats(crop_); }
  [[nodiscard]] bool has_splats() const { return !splats_.empty(); }
  // Returns the pixels that splats can be added to; empty without splats.
  [[nodiscard]] const PixelRect& splat_area() const { return splat_area_; }
  // Adds what a light path contributes to a pixel, which must be inside of splat_area(), and to the
  // light groups and passes there. Thread-safe among calls of this function.
  void add_splat(const V2i& pixel, const Rgb& radiance, const SplatParts& parts = {});
  // Counts light paths that belong to samples of `pixel`; they need not have added anything. The
  // beauty contains the sum of all splats at a pixel over the number of paths of the whole film.
  void add_light_paths(const V2i& pixel, uint64_t count) {
    if (!splats_.empty()) splats_[splat_index(pixel)].paths += count;
  }
  // Adds sums of samples of the pixels of `block`, which is inside of crop(): one record for each
  // pixel, rows from the top, in the arrays that this film has. Mattes, nearest samples and shadow
  // catchers remain.
  void add(const PixelRect& block, const FilmView& part);

  // Enables trimming of outliers (outliers_trimmed()) for the beauty AOV only. Must be called
  // before the first add().
  void trim_outliers();

  // Enables sums for each of these light groups (kindling::LightGroups). Must be called before the
  // first add().
  void split_by_light_groups(std::vector<std::string> names);
  [[nodiscard]] const std::vector<std::string>& light_groups() const { return light_groups_; }

  // Sums over the samples of a pixel: of weight times radiance, and of weights.
  struct Totals {
    std::array<double, 3> rgb{};
    double weight = 0.0;
    [[nodiscard]] double luminance() const { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }
  };
  [[nodiscard]] Totals totals(const V2i& pixel) const {
    const PixelSum& sum = sums_[index_of(pixel)];
    return {{sum.rgb[0].value(), sum.rgb[1].value(), sum.rgb[2].value()}, sum.weight.value()};
  }
  // Returns the part of this film inside of `crop`, a rectangle within crop(), with the splats
  // there.
  [[nodiscard]] Film cut(const PixelRect& crop) const;

  // Adds the sums of another film of the same image, AOVs, light groups and treatment of outliers,
  // whose crop must be within crop(), and its splats within splat_area().
  void add(const Film& part);

  // A plane gives access to stored sums, for files: an array of fixed-size records of little-endian
  // words, one for each pixel of the crop window, or of splat_area(), rows from the top. The set of
  // planes depends on the AOVs, on trim_outliers(), enable_splats() and light groups only;
  // README.md describes their layout. Mattes are no plane: pixels have different numbers of terms.
  struct ConstPlane {
    std::string_view name; // unique, at most 31 characters
    size_t bytes_per_pixel = 0;
    std::span<const std::byte> bytes;
    bool of_splats = false; // records are those of splat_area()
  };
  struct Plane {
    std::string_view name;
    size_t bytes_per_pixel = 0;
    std::span<std::byte> bytes;
    bool of_splats = false;
  };
  [[nodiscard]] std::vector<ConstPlane> planes() const;
  [[nodiscard]] std::vector<Plane> planes();
  [[nodiscard]] bool trims_outliers() const { return !blocks_.empty(); }

  [[nodiscard]] const MatteSums& mattes() const { return mattes_; } // empty without mattes
  [[nodiscard]] MatteSums& mattes() { return mattes_; }

  // Returns width * height * channels values of the crop window, rows from the top. All are 0 for
  // an AOV that is not in the set, except beauty, alpha and samples, which every film has.
  [[nodiscard]] std::vector<float> resolve(Aov aov) const;
  // Returns 3 values for each pixel: the part of the beauty that the light group of this index in
  // light_groups() contributes.
  [[nodiscard]] std::vector<float> resolve_light_group(size_t group) const;
  // Returns interleaved premultiplied RGBA of the crop window.
  [[nodiscard]] std::vector<float> resolve_rgba() const;
  // The same of a rectangle inside of it.
  [[nodiscard]] std::vector<float> resolve_rgba(const PixelRect& rect) const;

  // Returns `levels` pairs of id and coverage for each pixel of the crop window (rank_mattes()).
  // All are 0 for a matte that is not in the set.
  [[nodiscard]] std::vector<float> resolve_matte(Matte matte, int levels) const;

  [[nodiscard]] const V2i& size_px() const { return size_px_; }
  [[nodiscard]] const PixelRect& crop() const { return crop_; }
  [[nodiscard]] AovSet aovs() const { return aovs_; }
  [[nodiscard]] uint64_t total_samples() const;
  [[nodiscard]] size_t memory_bytes() const;

 private:
  [[nodiscard]] size_t splat_index(const V2i& pixel) const {
    assert(pixel.x >= splat_area_.min.x && pixel.x < splat_area_.max.x);
    assert(pixel.y >= splat_area_.min.y && pixel.y < splat_area_.max.y);
    return static_cast<size_t>(pixel.y - splat_area_.min.y) * static_cast<size_t>(splat_area_.width()) +
           static_cast<size_t>(pixel.x - splat_area_.min.x);
  }
  [[nodiscard]] size_t splat_index_at(size_t index) const; // of the pixel with this index_of()
  void cut_splats(Film& part) const;                       // of cut()
  void allocate_splat_groups();

  void resolve_pixel(Aov aov, size_t index, double light_paths, float* out) const;
  [[nodiscard]] double light_paths() const; // of all pixels
  [[nodiscard]] bool resolve_surface(Aov aov, size_t index, double by, float* out) const;
  // Resolves light passes and colors of lobes.
  void resolve_light(Aov aov, size_t index, double light_paths, float* out) const;
  [[nodiscard]] double opacity(size_t index) const;
  void resolve_behind(size_t index, double by, float* out) const; // Aov::shadow_catcher
  [[nodiscard]] std::optional<Rgb> trimmed(size_t index) const;
  // Calls visit(name, array, records per pixel) for each non-empty array of sums.
  template <typename ThisFilm, typename Visit>
  static void for_each_plane(ThisFilm& film, const Visit& visit);

  V2i size_px_;
  PixelRect crop_;
  AovSet aovs_;
  ZeroedArray<PixelSum> sums_;
  ZeroedArray<MomentSum> moments_;       // only with Aov::variance
  ZeroedArray<SurfaceSum> surfaces_;     // only if AovSet::needs_surface()
  ZeroedArray<GuideSum> guides_;         // only if AovSet::needs_guides()
  ZeroedArray<ComponentSum> components_; // only if AovSet::needs_components()
  ZeroedArray<ColorSum> blocks_;         // all but the last of kOutlierBlocks blocks; only with trim_outliers()
  ZeroedArray<RadianceSum> groups_;      // one for each of light_groups_
  ZeroedArray<RadianceSum> passes_;      // pass_places_.count for each pixel
  ZeroedArray<LobeColorSum> colors_;     // only if AovSet::needs_lobe_colors()
  std::vector<std::string> light_groups_;
  static constexpr uint8_t kNotStored = LightPassPlaces::kNotStored;
  LightPassPlaces pass_places_;
  ZeroedArray<NearestSample> nearest_;                     // only if AovSet::needs_nearest()
  ZeroedArray<CatcherSum> catchers_;                       // only with Aov::shadow_catcher
  ZeroedArray<SplatSum> splats_;                           // of splat_area_; only with enable_splats()
  ZeroedArray<RadianceSum> splat_groups_;                  // one for each of light_groups_
  ZeroedArray<RadianceSum> splat_passes_;                  // splat_pass_count_ for each pixel
  std::array<uint8_t, kSplatPasses.size()> splat_slots_{}; // by kSplatPasses: its place among these
  size_t splat_pass_count_ = 0;
  PixelRect splat_area_;
  std::shared_ptr<SplatLocks> splat_locks_; // copies of a film may share them
  MatteSums mattes_;                        // only with AovSet::has_mattes()
};

} // namespace kindling
