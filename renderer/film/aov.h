// Arbitrary output variables (AOVs) of a render: names, channels, storage and meaning.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class Aov : uint8_t {
  beauty,
  alpha,
  albedo,
  normal,
  depth,
  position,
  emission,
  direct,
  indirect,
  samples,
  variance,
  denoising_albedo,
  denoising_normal,
  // Light passes, in the order of LightPass.
  diffuse_direct,
  diffuse_indirect,
  glossy_direct,
  glossy_indirect,
  transmission_direct,
  transmission_indirect,
  volume_direct,
  volume_indirect,
  emit,
  environment,
  // Albedos of lobes.
  diffuse_color,
  glossy_color,
  transmission_color,
  object_id,
  material_id,
  uv,
  depth_nearest,
  position_nearest,
  vector,
  motion,
  shadow_catcher
};

// Parts of the radiance by the first event of a path: they sum to the beauty exactly.
enum class LightPass : uint8_t {
  diffuse_direct,
  diffuse_indirect,
  glossy_direct,
  glossy_indirect,
  transmission_direct,
  transmission_indirect,
  volume_direct,
  volume_indirect,
  emit,
  environment
};
inline constexpr size_t kLightPassCount = 10;

struct AovInfo {
  Aov aov;
  std::string_view name; // argument of --aov
  int channels;
  bool half;                // stored as half in EXR, else as float
  std::string_view meaning; // one sentence with unit and space
};

inline constexpr std::array<AovInfo, 34> kAovs{{
    {Aov::beauty, "beauty", 3, true, "radiance, linear Rec. 709, premultiplied by alpha"},
    {Aov::alpha, "alpha", 1, true, "coverage of the pixel"},
    {Aov::albedo, "albedo", 3, true,
     "directional albedo of the first surface; mean over all samples, misses count as 0"},
    {Aov::normal, "normal", 3, true,
     "shading normal of the first surface, world space; mean over all samples (not unit at edges), misses count as 0"},
    {Aov::depth, "depth", 1, false,
     "distance along the camera's axis to the first surface, meters; mean over the hits, 0 without hits"},
    {Aov::position, "position", 3, false,
     "position of the first surface, world space, meters; mean over the hits, 0 without hits"},
    {Aov::emission, "emission", 3, true, "emission seen directly by the camera, environment included"},
    {Aov::direct, "direct", 3, true, "light reflected once"},
    {Aov::indirect, "indirect", 3, true, "light reflected more than once"},
    {Aov::samples, "samples", 1, false, "number of samples"},
    {Aov::variance, "variance", 1, false,
     "unbiased estimate of the variance of the pixel's mean luminance; 0 below two samples"},
    {Aov::denoising_albedo, "denoising_albedo", 3, true,
     "albedo of the first surface that is neither a mirror nor clear glass, times their colors, in [0, 1]; what "
     "mirrors show of the environment, clamped to 1; mean over all samples, misses count as 0"},
    {Aov::denoising_normal, "denoising_normal", 3, true,
     "shading normal of the surface of denoising_albedo, world space; mean over all samples, misses count as 0"},
    {Aov::diffuse_direct, "diffuse_direct", 3, true,
     "light that the first surface reflects diffusely, from light sources; includes the surface's color"},
    {Aov::diffuse_indirect, "diffuse_indirect", 3, true, "the same, from other surfaces"},
    {Aov::glossy_direct, "glossy_direct", 3, true,
     "light that the first surface reflects specularly, from light sources; includes the surface's color"},
    {Aov::glossy_indirect, "glossy_indirect", 3, true, "the same, from other surfaces"},
    {Aov::transmission_direct, "transmission_direct", 3, true,
     "light that the first surface transmits, from light sources; includes the surface's color"},
    {Aov::transmission_indirect, "transmission_indirect", 3, true, "the same, from other surfaces"},
    {Aov::volume_direct, "volume_direct", 3, true,
     "light that is scattered in the medium behind the first surface, from emitters in it"},
    {Aov::volume_indirect, "volume_indirect", 3, true, "the same, from all others"},
    {Aov::emit, "emit", 3, true, "emission of surfaces seen directly by the camera"},
    {Aov::environment, "environment", 3, true, "environment or background seen directly by the camera"},
    {Aov::diffuse_color, "diffuse_color", 3, true,
     "directional albedo of the diffuse lobes of the first surface; mean over all samples, misses count as 0"},
    {Aov::glossy_color, "glossy_color", 3, true, "the same of its specular reflection"},
    {Aov::transmission_color, "transmission_color", 3, true, "the same of its transmission"},
    {Aov::object_id, "object_id", 1, false,
     "number of the first surface's node in the file, from 1; of the sample nearest to the pixel's center, 0 for a "
     "miss"},
    {Aov::material_id, "material_id", 1, false,
     "number of the first surface's material in the file, from 1; of the sample nearest to the pixel's center, 0 for a "
     "miss"},
    {Aov::uv, "uv", 3, false,
     "texture coordinates of set 0 at the first surface, and 1; of the sample nearest to the pixel's center, 0 for a "
     "miss"},
    {Aov::depth_nearest, "depth_nearest", 1, false,
     "depth of the sample nearest to the pixel's center, meters; 0 for a miss"},
    {Aov::position_nearest, "position_nearest", 3, false,
     "position of the sample nearest to the pixel's center, world space, meters; 0 for a miss"},
    {Aov::vector, "vector", 4, false,
     "motion of the first surface in pixels, y upwards: its position in the previous frame minus that in this one, and "
     "that in this frame minus that in the next; of the sample nearest to the pixel's center"},
    {Aov::motion, "motion", 4, false,
     "motion of the first surface in pixels, y upwards: to the next frame, and to the previous one; of the sample "
     "nearest to the pixel's center"},
    {Aov::shadow_catcher, "shadow_catcher", 3, true,
     "factor on another image behind this one: its visible share, times what shadow catchers leave of their "
     "light"},
}};

[[nodiscard]] constexpr const AovInfo& aov_info(Aov aov) { return kAovs[static_cast<size_t>(aov)]; }
[[nodiscard]] constexpr std::optional<Aov> aov_from_name(std::string_view name) {
  for (const AovInfo& info : kAovs)
    if (info.name == name) return info.aov;
  return std::nullopt;
}

// True for light passes and the albedos of lobes, which only paths on the CPU record.
[[nodiscard]] constexpr bool is_light_pass(Aov aov) {
  return aov >= Aov::diffuse_direct && aov <= Aov::transmission_color;
}

// True for AOVs that show one sample of a pixel, the one nearest to its center, instead of a mean.
[[nodiscard]] constexpr bool is_of_nearest(Aov aov) {
  return aov == Aov::object_id || aov == Aov::material_id || aov == Aov::uv || aov == Aov::depth_nearest ||
         aov == Aov::position_nearest || aov == Aov::vector || aov == Aov::motion;
}

// True for AOVs that compare the image with its neighbors in time.
[[nodiscard]] constexpr bool is_motion(Aov aov) { return aov == Aov::vector || aov == Aov::motion; }

// The names by which Cryptomatte divides an image: of objects, of materials, or of the root nodes
// above objects.
enum class Matte : uint8_t { object, material, asset };

struct MatteInfo {
  Matte matte;
  std::string_view name;  // argument of --cryptomatte
  std::string_view layer; // in EXR files
};
inline constexpr std::array<MatteInfo, 3> kMattes{{{Matte::object, "object", "CryptoObject"},
                                                   {Matte::material, "material", "CryptoMaterial"},
                                                   {Matte::asset, "asset", "CryptoAsset"}}};
[[nodiscard]] constexpr std::optional<Matte> matte_from_name(std::string_view name) {
  for (const MatteInfo& info : kMattes)
    if (info.name == name) return info.matte;
  return std::nullopt;
}

// AOVs, and the mattes that a film has beside them.
class AovSet {
 public:
  constexpr void insert(Aov aov) { bits_ |= uint64_t{1} << static_cast<unsigned>(aov); }
  constexpr void insert(Matte matte) { bits_ |= kFirstMatte << static_cast<unsigned>(matte); }
  [[nodiscard]] constexpr bool contains(Aov aov) const { return ((bits_ >> static_cast<unsigned>(aov)) & 1U) != 0; }
  [[nodiscard]] constexpr bool contains(Matte matte) const {
    return (bits_ & kFirstMatte << static_cast<unsigned>(matte)) != 0;
  }
  [[nodiscard]] constexpr bool has_mattes() const { return (bits_ & 7 * kFirstMatte) != 0; }
  // Returns true if films must keep the sample nearest to the center of each pixel.
  [[nodiscard]] constexpr bool needs_nearest() const {
    for (const AovInfo& info : kAovs)
      if (is_of_nearest(info.aov) && contains(info.aov)) return true;
    return false;
  }
  // Returns true if the hit at the first surface of a path is needed.
  [[nodiscard]] constexpr bool needs_first_hit() const {
    return needs_nearest() || has_mattes() || contains(Aov::shadow_catcher);
  }
  // Returns true if the frames before and after the image are needed.
  [[nodiscard]] constexpr bool needs_motion() const { return contains(Aov::vector) || contains(Aov::motion); }
  // Returns true if paths must record their first surface.
  [[nodiscard]] constexpr bool needs_surface() const {
    return contains(Aov::albedo) || contains(Aov::normal) || contains(Aov::depth) || contains(Aov::position);
  }
  // Returns true if paths must record the first surface that scatters widely, for denoisers.
  [[nodiscard]] constexpr bool needs_guides() const {
    return contains(Aov::denoising_albedo) || contains(Aov::denoising_normal);
  }
  // Returns true if paths must separate emission and direct light from their radiance.
  [[nodiscard]] constexpr bool needs_components() const {
    return contains(Aov::emission) || contains(Aov::direct) || contains(Aov::indirect);
  }
  // Returns true if paths must fill a FilmSurface.
  [[nodiscard]] constexpr bool needs_film_surface() const {
    return needs_surface() || needs_guides() || needs_components() || needs_first_hit();
  }
  [[nodiscard]] constexpr bool contains(LightPass pass) const {
    return contains(static_cast<Aov>(static_cast<size_t>(Aov::diffuse_direct) + static_cast<size_t>(pass)));
  }
  // Returns true if paths must split their radiance by their first event.
  [[nodiscard]] constexpr bool needs_light_passes() const {
    for (size_t i = 0; i < kLightPassCount; ++i)
      if (contains(static_cast<LightPass>(i))) return true;
    return false;
  }
  // Returns true if paths must record the albedos of the lobes of their first surface.
  [[nodiscard]] constexpr bool needs_lobe_colors() const {
    return contains(Aov::diffuse_color) || contains(Aov::glossy_color) || contains(Aov::transmission_color);
  }
  [[nodiscard]] constexpr uint64_t bits() const { return bits_; }

 private:
  static constexpr uint64_t kFirstMatte = uint64_t{1} << 60;

  uint64_t bits_ = 0; // AOVs from the lowest bit, mattes from kFirstMatte
};
static_assert(kAovs.size() <= 60);

} // namespace kindling
