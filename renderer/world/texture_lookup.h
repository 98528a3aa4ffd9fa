// Texture lookups at one hit, each at its level of detail.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "renderer/texture/texture.h"
#include "renderer/world/hit_records.h"
#include "renderer/world/procedural_lookup.h"
#include "renderer/world/surface_point.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <span>

namespace kindling {

// A footprint on the plane of the hit triangle, which determines the levels of detail.
struct SurfaceFootprint {
  const accel::Ray& ray;
  const RayFootprint& footprint;
  V3f normal{0.0f}; // cross product of two triangle edges, in the ray's space; its length is twice the area

  // Returns the footprint's area relative to twice the triangle's. The footprint is an ellipse,
  // width_m by width_m / cos; only its area counts (renderer/texture/README.md explains why).
  [[nodiscard]] float relative_area() const {
    if (footprint.relative_area >= 0.0f) return footprint.relative_area;
    const float seen = std::abs(normal.dot(ray.direction)); // twice the triangle's area, projected along the ray
    return footprint.width_m * footprint.width_m / std::max(seen, 1e-30f);
  }
  // Returns the number in [0, 1) that selects between two levels for all textures of a hit. Over
  // the samples of a key it steps by the golden ratio, so that every run of them selects both
  // levels in proportion.
  [[nodiscard]] float choice() const {
    if (footprint.relative_area >= 0.0f) return footprint.choice;
    return to_unit_float(ray.key + ray.index * 0x9e3779b9U);
  }
};

// Constructed once per hit; all textures of its material are read through it. Every binding must be
// present(). Construction is free until a texture is read. Borrows all arguments.
class TextureLookup {
 public:
  TextureLookup(std::span<const TextureView> textures, const ProceduralScene& procedurals, const HitRecords& records,
                const SurfaceFootprint& footprint)
      : textures_(textures.data()), procedurals_(procedurals), records_(records), footprint_(footprint) {}

  [[nodiscard]] V4f sample(const TextureBinding& binding) const {
    if (binding.is_procedural()) [[unlikely]]
      return procedural(binding, true);
    const Place at = place(binding);
    return texture(binding).sample(at.uv, at.level);
  }
  [[nodiscard]] Rgb sample_rgb(const TextureBinding& binding) const { return sample_rgb(binding, place(binding)); }
  // Returns one channel, 0 to 3.
  [[nodiscard]] float sample_channel(const TextureBinding& binding, int channel) const {
    if (binding.is_procedural()) [[unlikely]]
      return procedural(binding, true)[channel];
    const Place at = place(binding);
    return texture(binding).sample_channel(at.uv, channel, at.level);
  }

  // Reads level 0 regardless of the footprint, for values that must agree with code that has no
  // footprint.
  [[nodiscard]] Rgb sample_rgb_finest(const TextureBinding& binding) const {
    if (binding.is_procedural()) [[unlikely]]
      return rgb_of(procedural(binding, false));
    return texture(binding).sample_rgb(records_.texcoord(binding));
  }
  [[nodiscard]] float sample_channel_finest(const TextureBinding& binding, int channel) const {
    if (binding.is_procedural()) [[unlikely]]
      return procedural(binding, false)[channel];
    return texture(binding).sample_channel(records_.texcoord(binding), channel);
  }

  struct Place {
    V2f uv;
    int level = 0;
  };
  [[nodiscard]] Rgb sample_rgb(const TextureBinding& binding, const Place& at) const {
    if (binding.is_procedural()) [[unlikely]]
      return rgb_of(procedural(binding, true));
    return texture(binding).sample_rgb(at.uv, at.level);
  }
  // Returns the place where the binding is read; unused for procedural bindings.
  [[nodiscard, gnu::always_inline]] Place place(const TextureBinding& binding) const {
    if (binding.is_procedural()) [[unlikely]]
      return {};
    if (binding.texcoord != set_) find_set(binding.texcoord);
    return {binding.apply(uv_), texture(binding).choose_level(uv_area_ * binding.area_scale, choice_)};
  }
  // True if sample() may differ from the value at the finest level.
  [[nodiscard]] bool is_filtered(const TextureBinding& binding) const {
    return binding.is_procedural() || place(binding).level > 0;
  }

 private:
  [[nodiscard]] static Rgb rgb_of(const V4f& value) { return {value.x, value.y, value.z}; }
  [[gnu::noinline]] V4f procedural(const TextureBinding& binding, bool filtered) const {
    return procedurals_.sample(binding.procedural(), records_, footprint_, filtered);
  }
  [[nodiscard]] const TextureView& texture(const TextureBinding& binding) const {
    assert(binding.texture >= 0);
    return textures_[static_cast<size_t>(binding.texture)];
  }
  // Updates the cached set; most materials read all textures with one set.
  [[gnu::noinline]] void find_set(uint8_t set) const {
    set_ = set;
    uv_ = records_.texcoord(set);
    uv_area_ = choice_ = 0.0f;
    if (!(footprint_.footprint.width_m > 0.0f)) return;
    uv_area_ = footprint_.relative_area() * records_.texcoord_area(set);
    choice_ = footprint_.choice();
  }

  const TextureView* textures_;
  const ProceduralScene& procedurals_;
  const HitRecords& records_;
  const SurfaceFootprint& footprint_;
  mutable uint8_t set_ = 0xff; // of the next three members
  mutable V2f uv_;
  mutable float uv_area_; // of the footprint, before the binding's transform
  mutable float choice_;
};

} // namespace kindling
