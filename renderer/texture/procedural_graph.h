// Procedural textures as described by a file: graphs of MaterialX nodes, as plain data.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Types of the values of a graph. Integers and booleans are numbers; strings only select variants
// of a node.
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

// Returns the number of channels of a value; 1 for integers and booleans, 0 for strings and files.
[[nodiscard]] int channels_of(ProceduralType type);
// Returns MaterialX's name of a type.
[[nodiscard]] std::string_view name_of(ProceduralType type);

// Nodes of MaterialX 1.39 ("MaterialX Standard Nodes", March 2025), with its names.
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

// An input of a node.
struct ProceduralInput {
  // uv0, position and normal are MaterialX's default geometry properties, in object space.
  enum class Source : uint8_t { value, node, uv0, position, normal };
  Source source = Source::value;
  ProceduralType type = ProceduralType::float_;
  int16_t node = -1;  // source node: index of an earlier node
  int8_t output = 0;  // source node: index of its output
  int8_t variant = 0; // type string: index of the word among those that the node accepts
  int texture = -1;   // type file: index of the image's texture
  V4f value{0.0f};    // a number fills all channels
};

struct ProceduralNode {
  ProceduralKind kind = ProceduralKind::constant;
  ProceduralType type = ProceduralType::float_; // of the output; for separate nodes, of the input
  std::vector<ProceduralInput> inputs;          // complete, in the order of the definition
};

struct ProceduralOutput {
  int16_t node = -1; // -1 for the constant `value`
  int8_t output = 0;
  ProceduralType type = ProceduralType::color3;
  V4f value{0.0f};
};

// A graph without cycles: a node reads earlier nodes only. The types of inputs conform to the
// definitions.
struct ProceduralGraph {
  std::string name;
  std::vector<ProceduralNode> nodes;
  std::vector<ProceduralOutput> outputs;
  uint32_t texcoord_sets = 0; // bit mask of the sets that the graph reads
};

inline constexpr size_t kMaxProceduralNodes = 256;
inline constexpr int kMaxProceduralOctaves = 16;
inline constexpr int kMaxProceduralTexcoordSets = 8;

// --- definitions --------------------------------------------------------------------------------

// The types accepted by an input, depending on the type of the node's output.
enum class ProceduralRule : uint8_t {
  same,          // the type of the output
  same_or_float, // the type of the output, or one number for all channels
  number,        // float
  integer,
  boolean,
  vector2,
  vector3,
  color3,
  numeric,    // any type with channels except for integers
  like_first, // the type of the first input
  scalar,     // float or integer
  string,
  file,
};

struct ProceduralInputRule {
  std::string_view name;
  ProceduralRule rule = ProceduralRule::same;
  float value = 0.0f;                                              // default, for all channels
  ProceduralInput::Source source = ProceduralInput::Source::value; // default, unless it is a value
  std::span<const std::string_view> words = {};                    // rule string: accepted words, the default first
  bool constant = false;                                           // true if it must not vary over a surface
};

struct ProceduralDefinition {
  ProceduralKind kind;
  std::string_view name;
  uint32_t output_types; // bit mask by ProceduralType
  std::span<const ProceduralInputRule> inputs;
  std::span<const std::string_view> outputs = {}; // names of several outputs, all of type float
};

// Returns the definition of a node by its MaterialX name; null for an unknown name.
[[nodiscard]] const ProceduralDefinition* find_procedural_definition(std::string_view name);
[[nodiscard]] const ProceduralDefinition& definition_of(ProceduralKind kind);
[[nodiscard]] std::span<const ProceduralDefinition> procedural_definitions();

} // namespace kindling
