// Texture look-ups at one hit, each at the level of detail that the hit asks for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/texture.h"
#include "renderer/world/hit_records.h"

#include <cstddef>
#include <span>

namespace kindling {

// One for each hit; all textures of its material are read through it. Every binding must be present().
class TextureLookup {
 public:
  TextureLookup(std::span<const Texture> textures, const HitRecords& records)
      : textures_(textures), records_(records) {}

  [[nodiscard]] V4f sample(const TextureBinding& binding) const {
    return texture(binding).sample(records_.texcoord(binding));
  }
  [[nodiscard]] Rgb sample_rgb(const TextureBinding& binding) const {
    return texture(binding).sample_rgb(records_.texcoord(binding));
  }
  // One channel of 0..3.
  [[nodiscard]] float sample_channel(const TextureBinding& binding, int channel) const {
    return texture(binding).sample_channel(records_.texcoord(binding), channel);
  }

 private:
  [[nodiscard]] const Texture& texture(const TextureBinding& binding) const {
    return textures_[static_cast<size_t>(binding.texture)];
  }

  std::span<const Texture> textures_;
  const HitRecords& records_;
};

} // namespace kindling
