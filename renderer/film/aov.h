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
  transmission_color
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

inline constexpr std::array<AovInfo, 26> kAovs{{
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
     "mirrors "
     "show of the environment, clamped to 1; mean over all samples, misses count as 0"},
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

class AovSet {
 public:
  constexpr void insert(Aov aov) { bits_ |= uint64_t{1} << static_cast<unsigned>(aov); }
  [[nodiscard]] constexpr bool contains(Aov aov) const { return ((bits_ >> static_cast<unsigned>(aov)) & 1U) != 0; }
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
    return needs_surface() || needs_guides() || needs_components();
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
  uint64_t bits_ = 0;
};

} // namespace kindling
