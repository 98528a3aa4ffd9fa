// A procedural texture ready to be read: a graph compiled to a list of instructions, evaluated at a point with its footprint.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/texture/procedural_graph.h"
#include "renderer/texture/procedural_program.h"

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace kindling {

// What a graph reads of the surface: texture coordinates by set, positions and normals, the vertex color.
enum class ProceduralStream : uint8_t {
  texcoord, // and texcoord + 1, ... for set 1, ...
  position_object = kMaxProceduralTexcoordSets,
  position_world,
  normal_object,
  normal_world,
  color,
  count
};
inline constexpr size_t kProceduralStreams = static_cast<size_t>(ProceduralStream::count);

// A stream at a point, and how it changes from one side of the footprint to the other along the footprint's two axes (0: unfiltered).
struct ProceduralSample {
  V4f value{0.0f};
  V4f across[2] = {V4f(0.0f), V4f(0.0f)};
};

// Immutable, thread-safe.
class ProceduralTexture {
 public:
  // The number of an image among the textures that evaluate() is given; -1: not there. `color`: sRGB.
  using TextureNumber = std::function<int(int texture, bool color)>;

  // Output number `output` of the graph, which must be sound.
  ProceduralTexture(const ProceduralGraph& graph, size_t output, const TextureNumber& number_of);

  // The streams that evaluate() reads, in its order.
  [[nodiscard]] std::span<const ProceduralStream> streams() const { return streams_; }
  // The mean over the footprint, each channel from 0 to 65504; what is not finite is 0. A single channel fills red, green and blue; alpha is 1
  // where the output has none. `shift` in [0, 1)^2 moves the points at which a footprint is sampled, so that over many shifts the mean
  // is that of the footprint; at most `max_points` points, 1, 4 or 16. Does not allocate.
  [[nodiscard]] V4f evaluate(std::span<const ProceduralSample> streams, std::span<const Texture> textures,
                             const V2f& shift, int max_points = 16) const;

  [[nodiscard]] bool has_alpha() const { return type_ == ProceduralType::color4 || type_ == ProceduralType::vector4; }
  [[nodiscard]] size_t instruction_count() const { return program_.instructions.size(); }
  // True: one evaluation is the filtered value, whatever the footprint.
  [[nodiscard]] bool filters_itself() const { return program_.filters_itself; }
  // At how many points evaluate() samples such a footprint: 1, 4 or 16.
  [[nodiscard]] int point_count(std::span<const ProceduralSample> streams) const;

 private:
  ProceduralProgram program_;
  ProceduralType type_;
  std::vector<ProceduralStream> streams_;
};

} // namespace kindling
