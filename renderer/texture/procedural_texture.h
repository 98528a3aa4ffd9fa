// Procedural texture: a compiled graph, evaluated at a point and filtered over its footprint.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/texture/procedural_graph.h"
#include "renderer/texture/procedural_program.h"

#include <array>
#include <functional>
#include <span>

namespace kindling {

// Surface attributes that a graph can read.
enum class ProceduralStream : uint8_t {
  texcoord, // texture coordinates of set 0; texcoord + k for set k
  position_object = kMaxProceduralTexcoordSets,
  position_world,
  normal_object,
  normal_world,
  color,
  count
};
inline constexpr size_t kProceduralStreams = static_cast<size_t>(ProceduralStream::count);

// The value of a stream at a point, and its changes from one side of the footprint to the other
// along the two axes of the footprint (0 for no filtering).
struct ProceduralSample {
  V4f value{0.0f};
  V4f across[2] = {V4f(0.0f), V4f(0.0f)};
};

// A procedural texture as look-ups read it. Immutable, thread-safe.
struct ProceduralTextureView {
  // Returns the mean over the footprint. Channels are in [0, 65504]; NaN becomes 0. A single
  // channel fills red, green and blue; alpha is 1 if the output has none. `samples` are those of
  // `streams`, in this order. `shift` in [0, 1)^2 moves the points at which the footprint is
  // sampled, so that the mean over many shifts is that of the footprint. At most `max_points`
  // points are evaluated (1, 4 or 16). Does not allocate.
  [[nodiscard]] V4f evaluate(std::span<const ProceduralSample> samples, std::span<const TextureView> textures,
                             const V2f& shift, int max_points = 16) const;

  [[nodiscard]] bool has_alpha() const { return channels == 4; }
  [[nodiscard]] size_t instruction_count() const { return program.instructions.size(); }
  [[nodiscard]] size_t register_count() const { return static_cast<size_t>(program.register_count); }
  // Returns true if a single evaluation is the filtered value for any footprint.
  [[nodiscard]] bool filters_itself() const { return program.filters_itself; }
  // Returns the number of points at which evaluate() samples such a footprint: 1, 4 or 16.
  [[nodiscard]] int point_count(std::span<const ProceduralSample> samples) const;

  ProceduralProgramView program;
  std::span<const ProceduralStream> streams; // that evaluate() reads
  int channels = 3;                          // of the output
};

class ProceduralTexture : public ProceduralTextureView {
 public:
  // Returns the index of an image among the textures that are passed to evaluate(), or -1 if it is
  // missing. `color` requests sRGB decoding.
  using TextureNumber = std::function<int(int texture, bool color)>;

  // Compiles output number `output` of a valid graph.
  ProceduralTexture(const ProceduralGraph& graph, size_t output, const TextureNumber& number_of);

 private:
  OwnedArrays arrays_;
};

} // namespace kindling
