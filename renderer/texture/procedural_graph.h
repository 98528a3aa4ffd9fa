// A procedural texture as a file describes it: a graph of MaterialX nodes, as plain data.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Types of values that travel along a graph. Integers and booleans are numbers; strings only choose among variants of a node.
enum class ProceduralType : uint8_t {
  float_,
  color3,
  color4,
  vector2,
  vector3,
  vector4,
  integer,
  boolean,
  string,
  file
};

// Channels of a value; 1 for integers and booleans, 0 for strings and files.
[[nodiscard]] int channels_of(ProceduralType type);
[[nodiscard]] std::string_view name_of(ProceduralType type); // as MaterialX spells it

// Nodes of MaterialX 1.39 ("MaterialX Standard Nodes", March 2025), named as it names them.
enum class ProceduralKind : uint8_t {
  constant,
  texcoord,
  position,
  normal,
  geomcolor,
  image,
  checkerboard,
  noise2d,
  noise3d,
  fractal2d,
  fractal3d,
  cellnoise2d,
  cellnoise3d,
  worleynoise2d,
  worleynoise3d,
  ramplr,
  ramptb,
  splitlr,
  splittb,
  place2d,
  rotate2d,
  add,
  subtract,
  multiply,
  divide,
  modulo,
  absval,
  sign,
  floor,
  ceil,
  round,
  fract,
  power,
  sqrt,
  exp,
  ln,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan2,
  min,
  max,
  clamp,
  mix,
  smoothstep,
  remap,
  range,
  invert,
  contrast,
  dotproduct,
  crossproduct,
  magnitude,
  distance,
  normalize,
  luminance,
  combine2,
  combine3,
  combine4,
  extract,
  separate2,
  separate3,
  separate4,
  convert,
  dot,
  ifgreater,
  ifgreatereq,
  ifequal,
  switch_,
};

// What a node reads at one of its inputs.
struct ProceduralInput {
  enum class Source : uint8_t { value, node, uv0, position, normal };
  Source source =
      Source::value; // uv0, position, normal: MaterialX's default geometry, position and normal of the object
  ProceduralType type = ProceduralType::float_;
  int16_t node = -1;  // source node: an earlier one
  int8_t output = 0;  // source node: which of its outputs
  int8_t variant = 0; // type string: the number of the word among those that the node accepts
  int texture = -1;   // type file: index of the image's texture
  V4f value{0.0f};    // a number fills all channels
};

struct ProceduralNode {
  ProceduralKind kind = ProceduralKind::constant;
  ProceduralType type = ProceduralType::float_; // of its output; of a separate node, of its input
  std::vector<ProceduralInput> inputs;          // in the order of its definition, none missing
};

struct ProceduralOutput {
  int16_t node = -1; // -1: `value`
  int8_t output = 0;
  ProceduralType type = ProceduralType::color3;
  V4f value{0.0f};
};

// Without cycles: a node reads earlier ones. Types of inputs are those that definitions allow.
struct ProceduralGraph {
  std::string name;
  std::vector<ProceduralNode> nodes;
  std::vector<ProceduralOutput> outputs;
  uint32_t texcoord_sets = 0; // that it reads, as bits
};

inline constexpr size_t kMaxProceduralNodes = 256;
inline constexpr int kMaxProceduralOctaves = 16;
inline constexpr int kMaxProceduralTexcoordSets = 8;

// --- definitions ------------------------------------------------------------------------------------------------------

// Which types an input may have, told by the type of the node's output.
enum class ProceduralRule : uint8_t {
  same,          // that of the output
  same_or_float, // or one number for all channels
  number,        // float
  integer,
  boolean,
  vector2,
  vector3,
  color3,
  numeric,    // any with channels, but for integers
  like_first, // that of the first input
  scalar,     // float or integer
  string,
  file,
};

struct ProceduralInputRule {
  std::string_view name;
  ProceduralRule rule = ProceduralRule::same;
  float value = 0.0f;                                              // default, for all channels
  ProceduralInput::Source source = ProceduralInput::Source::value; // or this default
  std::span<const std::string_view> words = {};                    // rule string: what is accepted, the default first
  bool constant = false;                                           // must not vary over a surface
};

struct ProceduralDefinition {
  ProceduralKind kind;
  std::string_view name;
  uint32_t output_types; // bits by ProceduralType
  std::span<const ProceduralInputRule> inputs;
  std::span<const std::string_view> outputs = {}; // names, where there are several; their type is float
};

[[nodiscard]] const ProceduralDefinition* find_procedural_definition(std::string_view name);
[[nodiscard]] const ProceduralDefinition& definition_of(ProceduralKind kind);
[[nodiscard]] std::span<const ProceduralDefinition> procedural_definitions();

} // namespace kindling
