// Tables of MaterialX node definitions: inputs, their types and defaults.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/procedural_graph.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling {
namespace {

using K = ProceduralKind;
using R = ProceduralRule;
using T = ProceduralType;
using I = ProceduralInputRule;
using S = ProceduralInput::Source;

constexpr uint32_t bit(T type) { return 1U << static_cast<unsigned>(type); }
constexpr uint32_t kFloat = bit(T::float_);
constexpr uint32_t kColors = bit(T::color3) | bit(T::color4);
constexpr uint32_t kVectors = bit(T::vector2) | bit(T::vector3) | bit(T::vector4);
constexpr uint32_t kAny = kFloat | kColors | kVectors;

// Source: "MaterialX Standard Nodes" 1.39, March 2025.
constexpr std::string_view kSpaces[] = {"object", "model", "world"};
constexpr std::string_view kAddressModes[] = {"periodic", "clamp", "mirror", "constant"};
constexpr std::string_view kFilterTypes[] = {"linear", "closest", "cubic"};
constexpr std::string_view kText[] = {""}; // accepts any other text as well

constexpr I kValue[] = {{.name = "value"}};
constexpr I kIndexed[] = {{.name = "index", .rule = R::integer, .constant = true}};
constexpr I kSpaced[] = {{.name = "space", .rule = R::string, .words = kSpaces, .constant = true}};
constexpr I kImage[] = {{.name = "file", .rule = R::file, .constant = true},
                        {.name = "default", .constant = true},
                        {.name = "texcoord", .rule = R::vector2, .source = S::uv0},
                        {.name = "layer", .rule = R::string, .words = kText, .constant = true},
                        {.name = "uaddressmode", .rule = R::string, .words = kAddressModes, .constant = true},
                        {.name = "vaddressmode", .rule = R::string, .words = kAddressModes, .constant = true},
                        {.name = "filtertype", .rule = R::string, .words = kFilterTypes, .constant = true},
                        {.name = "framerange", .rule = R::string, .words = kText, .constant = true},
                        {.name = "frameoffset", .rule = R::integer, .constant = true},
                        {.name = "frameendaction", .rule = R::string, .words = kText, .constant = true}};
constexpr I kCheckerboard[] = {{.name = "color1", .value = 1.0f},
                               {.name = "color2"},
                               {.name = "uvtiling", .rule = R::vector2, .value = 8.0f},
                               {.name = "uvoffset", .rule = R::vector2},
                               {.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kNoise2d[] = {{.name = "amplitude", .rule = R::same_or_float, .value = 1.0f},
                          {.name = "pivot", .rule = R::number},
                          {.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kNoise3d[] = {{.name = "amplitude", .rule = R::same_or_float, .value = 1.0f},
                          {.name = "pivot", .rule = R::number},
                          {.name = "position", .rule = R::vector3, .source = S::position}};
constexpr I kFractal2d[] = {{.name = "amplitude", .rule = R::same_or_float, .value = 1.0f},
                            {.name = "octaves", .rule = R::integer, .value = 3.0f, .constant = true},
                            {.name = "lacunarity", .rule = R::number, .value = 2.0f, .constant = true},
                            {.name = "diminish", .rule = R::number, .value = 0.5f, .constant = true},
                            {.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kFractal3d[] = {{.name = "amplitude", .rule = R::same_or_float, .value = 1.0f},
                            {.name = "octaves", .rule = R::integer, .value = 3.0f, .constant = true},
                            {.name = "lacunarity", .rule = R::number, .value = 2.0f, .constant = true},
                            {.name = "diminish", .rule = R::number, .value = 0.5f, .constant = true},
                            {.name = "position", .rule = R::vector3, .source = S::position}};
constexpr I kCell2d[] = {{.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kCell3d[] = {{.name = "position", .rule = R::vector3, .source = S::position}};
constexpr I kWorley2d[] = {{.name = "texcoord", .rule = R::vector2, .source = S::uv0},
                           {.name = "jitter", .rule = R::number, .value = 1.0f, .constant = true},
                           {.name = "style", .rule = R::integer, .constant = true}};
constexpr I kWorley3d[] = {{.name = "position", .rule = R::vector3, .source = S::position},
                           {.name = "jitter", .rule = R::number, .value = 1.0f, .constant = true},
                           {.name = "style", .rule = R::integer, .constant = true}};
constexpr I kRampLr[] = {
    {.name = "valuel"}, {.name = "valuer"}, {.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kRampTb[] = {
    {.name = "valuet"}, {.name = "valueb"}, {.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kSplitLr[] = {{.name = "valuel"},
                          {.name = "valuer"},
                          {.name = "center", .rule = R::number, .value = 0.5f},
                          {.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kSplitTb[] = {{.name = "valuet"},
                          {.name = "valueb"},
                          {.name = "center", .rule = R::number, .value = 0.5f},
                          {.name = "texcoord", .rule = R::vector2, .source = S::uv0}};
constexpr I kPlace2d[] = {{.name = "texcoord", .rule = R::vector2, .source = S::uv0},
                          {.name = "pivot", .rule = R::vector2},
                          {.name = "scale", .rule = R::vector2, .value = 1.0f},
                          {.name = "rotate", .rule = R::number},
                          {.name = "offset", .rule = R::vector2},
                          {.name = "operationorder", .rule = R::integer, .constant = true}};
constexpr I kRotate2d[] = {{.name = "in", .rule = R::vector2}, {.name = "amount", .rule = R::number}};
constexpr I kUnary[] = {{.name = "in"}};
constexpr I kSum[] = {{.name = "in1"}, {.name = "in2", .rule = R::same_or_float}};
constexpr I kProduct[] = {{.name = "in1"}, {.name = "in2", .rule = R::same_or_float, .value = 1.0f}};
constexpr I kAtan2[] = {{.name = "iny"}, {.name = "inx", .value = 1.0f}};
constexpr I kClamp[] = {{.name = "in"},
                        {.name = "low", .rule = R::same_or_float},
                        {.name = "high", .rule = R::same_or_float, .value = 1.0f}};
constexpr I kMix[] = {{.name = "fg"}, {.name = "bg"}, {.name = "mix", .rule = R::same_or_float}};
constexpr I kRemap[] = {{.name = "in"},
                        {.name = "inlow", .rule = R::same_or_float},
                        {.name = "inhigh", .rule = R::same_or_float, .value = 1.0f},
                        {.name = "outlow", .rule = R::same_or_float},
                        {.name = "outhigh", .rule = R::same_or_float, .value = 1.0f}};
constexpr I kRange[] = {{.name = "in"},
                        {.name = "inlow", .rule = R::same_or_float},
                        {.name = "inhigh", .rule = R::same_or_float, .value = 1.0f},
                        {.name = "gamma", .rule = R::same_or_float, .value = 1.0f},
                        {.name = "outlow", .rule = R::same_or_float},
                        {.name = "outhigh", .rule = R::same_or_float, .value = 1.0f},
                        {.name = "doclamp", .rule = R::boolean, .constant = true}};
constexpr I kInvert[] = {{.name = "in"}, {.name = "amount", .rule = R::same_or_float, .value = 1.0f}};
constexpr I kContrast[] = {{.name = "in"},
                           {.name = "amount", .rule = R::same_or_float, .value = 1.0f},
                           {.name = "pivot", .rule = R::same_or_float, .value = 0.5f}};
constexpr I kLuminance[] = {{.name = "in"}, {.name = "lumacoeffs", .rule = R::color3, .constant = true}};
constexpr I kNumericUnary[] = {{.name = "in", .rule = R::numeric}};
constexpr I kNumericPair[] = {{.name = "in1", .rule = R::numeric}, {.name = "in2", .rule = R::like_first}};
constexpr I kCombine2[] = {{.name = "in1", .rule = R::numeric}, {.name = "in2", .rule = R::numeric}};
constexpr I kCombine3[] = {
    {.name = "in1", .rule = R::number}, {.name = "in2", .rule = R::number}, {.name = "in3", .rule = R::number}};
constexpr I kCombine4[] = {{.name = "in1", .rule = R::number},
                           {.name = "in2", .rule = R::number},
                           {.name = "in3", .rule = R::number},
                           {.name = "in4", .rule = R::number}};
constexpr I kExtract[] = {{.name = "in", .rule = R::numeric}, {.name = "index", .rule = R::integer, .constant = true}};
constexpr I kDot[] = {{.name = "in"}, {.name = "note", .rule = R::string, .words = kText, .constant = true}};
constexpr I kCondition[] = {{.name = "value1", .rule = R::scalar, .value = 1.0f},
                            {.name = "value2", .rule = R::scalar},
                            {.name = "in1"},
                            {.name = "in2"}};
constexpr I kEqual[] = {
    {.name = "value1", .rule = R::scalar}, {.name = "value2", .rule = R::scalar}, {.name = "in1"}, {.name = "in2"}};
constexpr I kSwitch[] = {{.name = "in1"},
                         {.name = "in2"},
                         {.name = "in3"},
                         {.name = "in4"},
                         {.name = "in5"},
                         {.name = "in6"},
                         {.name = "in7"},
                         {.name = "in8"},
                         {.name = "in9"},
                         {.name = "in10"},
                         {.name = "which", .rule = R::scalar}};
constexpr std::string_view kOut2[] = {"outx", "outy"};
constexpr std::string_view kOut3[] = {"outx", "outy", "outz"}; // or outr, outg, outb
constexpr std::string_view kOut4[] = {"outx", "outy", "outz", "outw"};

constexpr ProceduralDefinition kTable[] = {
    {K::constant, "constant", kAny, kValue},
    {K::texcoord, "texcoord", bit(T::vector2), kIndexed},
    {K::position, "position", bit(T::vector3), kSpaced},
    {K::normal, "normal", bit(T::vector3), kSpaced},
    {K::geomcolor, "geomcolor", kFloat | kColors, kIndexed},
    {K::image, "image", kAny, kImage},
    {K::checkerboard, "checkerboard", bit(T::color3), kCheckerboard},
    {K::noise2d, "noise2d", kAny, kNoise2d},
    {K::noise3d, "noise3d", kAny, kNoise3d},
    {K::fractal2d, "fractal2d", kAny, kFractal2d},
    {K::fractal3d, "fractal3d", kAny, kFractal3d},
    {K::cellnoise2d, "cellnoise2d", kFloat | bit(T::vector3), kCell2d},
    {K::cellnoise3d, "cellnoise3d", kFloat | bit(T::vector3), kCell3d},
    {K::worleynoise2d, "worleynoise2d", kFloat | bit(T::vector2) | bit(T::vector3), kWorley2d},
    {K::worleynoise3d, "worleynoise3d", kFloat | bit(T::vector2) | bit(T::vector3), kWorley3d},
    {K::ramplr, "ramplr", kAny, kRampLr},
    {K::ramptb, "ramptb", kAny, kRampTb},
    {K::splitlr, "splitlr", kAny, kSplitLr},
    {K::splittb, "splittb", kAny, kSplitTb},
    {K::place2d, "place2d", bit(T::vector2), kPlace2d},
    {K::rotate2d, "rotate2d", bit(T::vector2), kRotate2d},
    {K::add, "add", kAny, kSum},
    {K::subtract, "subtract", kAny, kSum},
    {K::multiply, "multiply", kAny, kProduct},
    {K::divide, "divide", kAny, kProduct},
    {K::modulo, "modulo", kAny, kProduct},
    {K::absval, "absval", kAny, kUnary},
    {K::sign, "sign", kAny, kUnary},
    {K::floor, "floor", kAny, kUnary},
    {K::ceil, "ceil", kAny, kUnary},
    {K::round, "round", kAny, kUnary},
    {K::fract, "fract", kAny, kUnary},
    {K::power, "power", kAny, kProduct},
    {K::sqrt, "sqrt", kAny, kUnary},
    {K::exp, "exp", kAny, kUnary},
    {K::ln, "ln", kAny, kUnary},
    {K::sin, "sin", kAny, kUnary},
    {K::cos, "cos", kAny, kUnary},
    {K::tan, "tan", kAny, kUnary},
    {K::asin, "asin", kAny, kUnary},
    {K::acos, "acos", kAny, kUnary},
    {K::atan2, "atan2", kAny, kAtan2},
    {K::min, "min", kAny, kSum},
    {K::max, "max", kAny, kSum},
    {K::clamp, "clamp", kAny, kClamp},
    {K::mix, "mix", kAny, kMix},
    {K::smoothstep, "smoothstep", kAny, kClamp},
    {K::remap, "remap", kAny, kRemap},
    {K::range, "range", kAny, kRange},
    {K::invert, "invert", kAny, kInvert},
    {K::contrast, "contrast", kAny, kContrast},
    {K::dotproduct, "dotproduct", kFloat, kNumericPair},
    {K::crossproduct, "crossproduct", bit(T::vector3), kSum},
    {K::magnitude, "magnitude", kFloat, kNumericUnary},
    {K::distance, "distance", kFloat, kNumericPair},
    {K::normalize, "normalize", kVectors, kUnary},
    {K::luminance, "luminance", kColors, kLuminance},
    {K::combine2, "combine2", kColors | kVectors, kCombine2},
    {K::combine3, "combine3", bit(T::color3) | bit(T::vector3), kCombine3},
    {K::combine4, "combine4", bit(T::color4) | bit(T::vector4), kCombine4},
    {K::extract, "extract", kFloat, kExtract},
    {K::separate2, "separate2", 0, kNumericUnary, kOut2},
    {K::separate3, "separate3", 0, kNumericUnary, kOut3},
    {K::separate4, "separate4", 0, kNumericUnary, kOut4},
    {K::convert, "convert", kAny, kNumericUnary},
    {K::dot, "dot", kAny, kDot},
    {K::ifgreater, "ifgreater", kAny, kCondition},
    {K::ifgreatereq, "ifgreatereq", kAny, kCondition},
    {K::ifequal, "ifequal", kAny, kEqual},
    {K::switch_, "switch", kAny, kSwitch},
};

constexpr bool in_order_of_kinds() {
  for (size_t i = 0; i < std::size(kTable); ++i)
    if (static_cast<size_t>(kTable[i].kind) != i) return false;
  return std::size(kTable) == static_cast<size_t>(K::switch_) + 1;
}
static_assert(in_order_of_kinds());

} // namespace

int channels_of(ProceduralType type) {
  switch (type) {
  case T::vector2: return 2;
  case T::color3:
  case T::vector3: return 3;
  case T::color4:
  case T::vector4: return 4;
  case T::string:
  case T::file: return 0;
  default: return 1;
  }
}

std::string_view name_of(ProceduralType type) {
  constexpr std::string_view kNames[] = {"float",   "color3",  "color4",  "vector2", "vector3",
                                         "vector4", "integer", "boolean", "string",  "filename"};
  return kNames[static_cast<size_t>(type)];
}

const ProceduralDefinition* find_procedural_definition(std::string_view name) {
  const auto* found =
      std::find_if(std::begin(kTable), std::end(kTable), [&](const auto& entry) { return entry.name == name; });
  return found == std::end(kTable) ? nullptr : found;
}

const ProceduralDefinition& definition_of(ProceduralKind kind) { return kTable[static_cast<size_t>(kind)]; }

std::span<const ProceduralDefinition> procedural_definitions() { return kTable; }

} // namespace kindling
