// Compiler of procedural graphs: translates each MaterialX 1.39 node into instructions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/compile_procedural.h"

#include "renderer/texture/procedural_emitter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>
#include <vector>

namespace kindling {
namespace {

using K = ProceduralKind;
using Op = ProceduralOp;
using S = ProceduralInput::Source;
using T = ProceduralType;

// Channels of operand 0 in swizzles; those of operand k are 4 k larger.
constexpr int kRed = 0, kGreen = 1, kBlue = 2, kAlpha = 3;

class Compiler {
 public:
  Compiler(const ProceduralGraph& graph, const ProceduralTexture::TextureNumber& number_of)
      : graph_(graph), number_of_(number_of) {}

  CompiledProcedural compile(size_t output) {
    for (const ProceduralNode& node : graph_.nodes) {
      node_ = &node;
      Results results;
      const bool several = !definition_of(node.kind).outputs.empty();
      if (several) {
        for (size_t k = 0; k < definition_of(node.kind).outputs.size(); ++k)
          results[k] = extract(in(0), static_cast<int>(k));
      } else {
        results[0] = lower();
      }
      results_.push_back(results);
    }
    const ProceduralOutput& source = graph_.outputs[output];
    CompiledProcedural compiled;
    compiled.program = e_.finish(results_[static_cast<size_t>(source.node)][static_cast<size_t>(source.output)]);
    compiled.streams = e_.streams();
    return compiled;
  }

 private:
  using Results = std::array<int16_t, 4>;

  // Returns the operand of input `k` of the current node.
  int16_t in(size_t k) {
    const ProceduralInput& input = node_->inputs[k];
    switch (input.source) {
    case S::value: return e_.constant(Float4{input.value.x, input.value.y, input.value.z, input.value.w});
    case S::node: return results_[static_cast<size_t>(input.node)][static_cast<size_t>(input.output)];
    case S::uv0: return e_.stream(ProceduralStream::texcoord);
    case S::position: return e_.stream(ProceduralStream::position_object);
    case S::normal: return e_.stream(ProceduralStream::normal_object);
    }
    return 0;
  }
  // Returns the operands of the first inputs. They are emitted in this order; that of a call's
  // arguments would be the compiler's choice.
  template <size_t... kInputs>
  std::array<int16_t, sizeof...(kInputs)> in_order(std::index_sequence<kInputs...> /*list*/) {
    return {in(kInputs)...};
  }
  template <size_t kCount>
  std::array<int16_t, kCount> inputs() {
    return in_order(std::make_index_sequence<kCount>());
  }
  [[nodiscard]] float number(size_t k) const { return node_->inputs[k].value.x; }
  [[nodiscard]] int integer(size_t k) const {
    return static_cast<int>(std::min(std::max(-0x1p24f, node_->inputs[k].value.x), 0x1p24f));
  }
  // Returns the number of channels that operators of the current node compute.
  [[nodiscard]] int width() const { return channels_of(node_->type) == 1 ? 1 : 4; }

  int16_t binary(Op op, int16_t a, int16_t b) { return e_.emit(op, {a, b}, {.channels = width()}); }
  int16_t binary(Op op) {
    const auto [a, b] = inputs<2>();
    return binary(op, a, b);
  }
  int16_t unary(Op op) { return e_.emit(op, {in(0)}, {.channels = width()}); }
  int16_t mix(int16_t fg, int16_t bg, int16_t weight) {
    return e_.emit(Op::mix, {fg, bg, weight}, {.channels = width()});
  }
  int16_t extract(int16_t from, int channel) {
    return e_.emit(Op::swizzle, {from, from, from, from}, {.i = {channel, channel, channel, channel}});
  }
  int16_t clamp(int16_t x, int16_t low, int16_t high) { return binary(Op::min, binary(Op::max, x, low), high); }

  int16_t pattern(Op op, int16_t at) { return e_.emit(op, {at}, pattern_details()); }
  [[nodiscard]] ProceduralEmitter::Details pattern_details() const {
    const int channels = channels_of(node_->type);
    return {.channels = channels == 1 ? 1 : 4, .i = {channels}};
  }

  int16_t lower_pattern() {
    ProceduralEmitter::Details details = pattern_details();
    switch (node_->kind) {
    case K::noise2d:
    case K::noise3d: {
      const auto [amplitude, pivot, at] = inputs<3>();
      const int16_t noise = pattern(node_->kind == K::noise2d ? Op::noise2d : Op::noise3d, at);
      return binary(Op::add, binary(Op::multiply, noise, amplitude), pivot);
    }
    case K::fractal2d:
    case K::fractal3d: {
      details.i[1] = integer(1);
      details.f = {number(2), number(3)};
      const int16_t sum = e_.emit(node_->kind == K::fractal2d ? Op::fractal2d : Op::fractal3d, {in(4)}, details);
      return binary(Op::multiply, sum, in(0));
    }
    case K::cellnoise2d: return pattern(Op::cell2d, in(0));
    case K::cellnoise3d: return pattern(Op::cell3d, in(0));
    default:
      details.i[1] = integer(2);
      details.f = {number(1)};
      return e_.emit(node_->kind == K::worleynoise2d ? Op::worley2d : Op::worley3d, {in(0)}, details);
    }
  }

  int16_t rotate(int16_t at, int16_t degrees) {
    const int16_t angle = e_.emit(Op::multiply, {degrees, e_.number(kPi / 180.0f)}, {.channels = 1});
    const int16_t s = e_.emit(Op::sin, {angle}, {.channels = 1}), c = e_.emit(Op::cos, {angle}, {.channels = 1});
    const int16_t x = extract(at, kRed), y = extract(at, kGreen);
    const int16_t cx = binary(Op::multiply, c, x), sy = binary(Op::multiply, s, y);
    const int16_t cy = binary(Op::multiply, c, y), sx = binary(Op::multiply, s, x);
    const int16_t turned_x = binary(Op::add, cx, sy), turned_y = binary(Op::subtract, cy, sx);
    const int16_t zero = e_.number(0.0f), one = e_.number(1.0f);
    return combine(turned_x, turned_y, zero, one);
  }

  int16_t combine(int16_t r, int16_t g, int16_t b, int16_t a) {
    return e_.emit(Op::swizzle, {r, g, b, a}, {.i = {0, 4, 8, 12}});
  }

  int16_t place2d() {
    const int16_t pivot = in(1), scale = in(2), degrees = in(3), offset = in(4);
    int16_t at = binary(Op::subtract, in(0), pivot);
    if (integer(5) == 0) {
      at = binary(Op::subtract, rotate(binary(Op::divide, at, scale), degrees), offset);
    } else {
      at = binary(Op::divide, rotate(binary(Op::subtract, at, offset), degrees), scale);
    }
    return binary(Op::add, at, pivot);
  }

  int16_t remap(int16_t x, int16_t in_low, int16_t in_high, int16_t out_low, int16_t out_high) {
    const int16_t above = binary(Op::subtract, x, in_low), extent = binary(Op::subtract, in_high, in_low);
    const int16_t unit = binary(Op::divide, above, extent);
    return binary(Op::add, binary(Op::multiply, unit, binary(Op::subtract, out_high, out_low)), out_low);
  }

  int16_t range() {
    const int16_t one = e_.number(1.0f), zero = e_.number(0.0f);
    const auto [value, in_low, in_high, gamma, out_low, out_high] = inputs<6>();
    int16_t x = remap(value, in_low, in_high, zero, one);
    if (!is_one(gamma)) {
      const int16_t size = e_.emit(Op::absolute, {x}, {.channels = width()});
      const int16_t power = binary(Op::power, size, binary(Op::divide, one, gamma));
      x = binary(Op::multiply, power, e_.emit(Op::sign, {x}, {.channels = width()}));
    }
    x = remap(x, zero, one, out_low, out_high);
    return number(6) != 0.0f ? clamp(x, out_low, out_high) : x;
  }

  [[nodiscard]] bool is_one(int16_t operand) const {
    if (!ProceduralEmitter::is_constant(operand)) return false;
    const Float4& v = e_.value_of(operand);
    return v[0] == 1.0f && v[1] == 1.0f && v[2] == 1.0f;
  }

  // Converts between types. Channels that the input lacks are 0, alpha or w is 1.
  int16_t convert(int16_t x, T from, T to) {
    const int channels_in = channels_of(from), channels_out = channels_of(to);
    if (channels_in == channels_out) return x;
    if (channels_in == 1) return x; // a number fills all channels
    if (channels_out == 1) return extract(x, kRed);
    const int16_t rest = e_.constant(Float4{0.0f, 0.0f, 0.0f, 1.0f});
    const auto channel = [&](int k) { return k < channels_in && k < channels_out ? k : 4 + k; };
    return e_.emit(Op::swizzle, {x, rest, rest, rest}, {.i = {channel(0), channel(1), channel(2), channel(3)}});
  }

  int16_t combine2() {
    const int first = channels_of(node_->inputs[0].type);
    const int16_t a = in(0), b = in(1), rest = e_.constant(Float4{0.0f, 0.0f, 0.0f, 1.0f});
    const int total = channels_of(node_->type);
    const auto channel = [&](int k) { return k < first ? k : k < total ? 4 + (k - first) : 8 + k; };
    return e_.emit(Op::swizzle, {a, b, rest, rest}, {.i = {channel(0), channel(1), channel(2), channel(3)}});
  }

  int16_t compare(Op op, int16_t value1, int16_t value2, int16_t yes, int16_t no) {
    if (yes == no) return yes;
    return e_.emit(op, {value1, value2, yes, no}, {.channels = width()});
  }

  int16_t luminance() {
    // Without coefficients in the file, those of the working space, linear Rec. 709, are used.
    const bool given = node_->inputs[1].value.x + node_->inputs[1].value.y + node_->inputs[1].value.z != 0.0f;
    const int16_t weights = given ? in(1) : e_.constant(Float4{0.2126f, 0.7152f, 0.0722f, 0.0f});
    const int16_t value = e_.emit(Op::dot, {in(0), weights}, {.channels = 1, .i = {3}});
    if (node_->type != T::color4) return value;
    return e_.emit(Op::swizzle, {value, in(0), value, value}, {.i = {kRed, kGreen, kBlue, 4 + kAlpha}});
  }

  int16_t image() {
    const bool color = node_->type == T::color3 || node_->type == T::color4;
    const int number = number_of_(node_->inputs[0].texture, color);
    if (number < 0) return in(1);
    return e_.emit(Op::image, {in(2)}, {.i = {number, channels_of(node_->type) == 1 ? 1 : 0}});
  }

  // Left to right, or from the top, which is at v = 1, to the bottom.
  int16_t ramp(int channel) {
    const auto [first, second, at] = inputs<3>();
    const int16_t zero = e_.number(0.0f), one = e_.number(1.0f);
    const int16_t weight = clamp(extract(at, channel), zero, one);
    return channel == kRed ? mix(second, first, weight) : mix(first, second, weight);
  }

  int16_t contrast() {
    const auto [value, amount, pivot] = inputs<3>();
    return binary(Op::add, binary(Op::multiply, binary(Op::subtract, value, pivot), amount), pivot);
  }

  int16_t compare(Op op) {
    const auto [value1, value2, yes, no] = inputs<4>();
    return compare(op, value1, value2, yes, no);
  }

  int16_t lower() {
    const auto split = [&](int channel) {
      const auto [first, second, center, at] = inputs<4>();
      const int16_t beyond = channel == kRed ? second : first, before = channel == kRed ? first : second;
      return compare(Op::greater_equal, extract(at, channel), center, beyond, before);
    };
    switch (node_->kind) {
    case K::constant:
    case K::dot: return in(0);
    case K::texcoord:
      return e_.stream(static_cast<ProceduralStream>(static_cast<int>(ProceduralStream::texcoord) + integer(0)));
    case K::position:
      return e_.stream(is_world() ? ProceduralStream::position_world : ProceduralStream::position_object);
    case K::normal: return e_.stream(is_world() ? ProceduralStream::normal_world : ProceduralStream::normal_object);
    case K::geomcolor: return convert(e_.stream(ProceduralStream::color), T::color4, node_->type);
    case K::image: return image();
    case K::checkerboard: {
      const auto [color1, color2, tiling, offset, uv] = inputs<5>();
      const int16_t at = binary(Op::subtract, binary(Op::multiply, uv, tiling), offset);
      return mix(color1, color2, e_.emit(Op::checker, {at}, {.channels = 1}));
    }
    case K::ramplr: return ramp(kRed);
    case K::ramptb: return ramp(kGreen);
    case K::splitlr: return split(kRed);
    case K::splittb: return split(kGreen);
    case K::place2d: return place2d();
    case K::rotate2d: {
      const auto [at, degrees] = inputs<2>();
      return rotate(at, degrees);
    }
    case K::add: return binary(Op::add);
    case K::subtract: return binary(Op::subtract);
    case K::multiply: return binary(Op::multiply);
    case K::divide: return binary(Op::divide);
    case K::modulo: return binary(Op::modulo);
    case K::power: return binary(Op::power);
    case K::atan2: return binary(Op::atan2);
    case K::min: return binary(Op::min);
    case K::max: return binary(Op::max);
    case K::absval: return unary(Op::absolute);
    case K::sign: return unary(Op::sign);
    case K::floor: return unary(Op::floor);
    case K::ceil: return unary(Op::ceil);
    case K::round: return unary(Op::round);
    case K::fract: return unary(Op::fract);
    case K::sqrt: return unary(Op::sqrt);
    case K::exp: return unary(Op::exp);
    case K::ln: return unary(Op::ln);
    case K::sin: return unary(Op::sin);
    case K::cos: return unary(Op::cos);
    case K::tan: return unary(Op::tan);
    case K::asin: return unary(Op::asin);
    case K::acos: return unary(Op::acos);
    case K::clamp: {
      const auto [x, low, high] = inputs<3>();
      return clamp(x, low, high);
    }
    case K::mix: {
      const auto [fg, bg, weight] = inputs<3>();
      return mix(fg, bg, weight);
    }
    case K::smoothstep: return e_.emit(Op::smoothstep, {in(0), in(1), in(2)}, {.channels = width()});
    case K::remap: {
      const auto [x, in_low, in_high, out_low, out_high] = inputs<5>();
      return remap(x, in_low, in_high, out_low, out_high);
    }
    case K::range: return range();
    case K::invert: {
      const auto [value, amount] = inputs<2>();
      return binary(Op::subtract, amount, value);
    }
    case K::contrast: return contrast();
    case K::dotproduct: return e_.emit(Op::dot, {in(0), in(1)}, {.channels = 1, .i = {input_channels()}});
    case K::crossproduct: return e_.emit(Op::cross, {in(0), in(1)}, {});
    case K::magnitude: return length(in(0));
    case K::distance: return length(e_.emit(Op::subtract, {in(0), in(1)}, {}));
    case K::normalize: return e_.emit(Op::normalize, {in(0)}, {.i = {input_channels()}});
    case K::luminance: return luminance();
    case K::combine2: return combine2();
    case K::combine3: {
      const auto [r, g, b] = inputs<3>();
      return combine(r, g, b, e_.number(1.0f));
    }
    case K::combine4: {
      const auto [r, g, b, a] = inputs<4>();
      return combine(r, g, b, a);
    }
    case K::extract: return extract(in(0), integer(1));
    case K::convert: return convert(in(0), node_->inputs[0].type, node_->type);
    case K::ifgreater: return compare(Op::greater);
    case K::ifgreatereq: return compare(Op::greater_equal);
    case K::ifequal: return compare(Op::equal);
    case K::switch_: {
      int16_t result = e_.number(0.0f);
      const int16_t which = in(10);
      for (size_t k = 10; k-- > 0;) {
        const int16_t limit = e_.number(static_cast<float>(k + 1)), value = in(k);
        result = compare(Op::greater, limit, which, value, result);
      }
      return result;
    }
    default: return lower_pattern();
    }
  }

  [[nodiscard]] bool is_world() const { return node_->inputs[0].variant == 2; } // of "object", "model", "world"
  [[nodiscard]] int input_channels() const { return channels_of(node_->inputs[0].type); }
  int16_t length(int16_t v) {
    const int16_t squared = e_.emit(Op::dot, {v, v}, {.channels = 1, .i = {input_channels()}});
    return e_.emit(Op::sqrt, {squared}, {.channels = 1});
  }

  const ProceduralGraph& graph_;
  const ProceduralTexture::TextureNumber& number_of_;
  ProceduralEmitter e_;
  const ProceduralNode* node_ = nullptr; // the current node
  std::vector<Results> results_;         // of the nodes compiled so far
};

} // namespace

CompiledProcedural compile_procedural(const ProceduralGraph& graph, size_t output,
                                      const ProceduralTexture::TextureNumber& number_of) {
  assert(output < graph.outputs.size());
  return Compiler(graph, number_of).compile(output);
}

ProceduralTexture::ProceduralTexture(const ProceduralGraph& graph, size_t output, const TextureNumber& number_of) {
  CompiledProcedural compiled = compile_procedural(graph, output, number_of);
  program = {.instructions = arrays_.keep(std::move(compiled.program.instructions)),
             .constants = arrays_.keep(std::move(compiled.program.constants)),
             .footprints = arrays_.keep(std::move(compiled.program.footprints)),
             .frequencies = arrays_.keep(std::move(compiled.program.frequencies)),
             .result = compiled.program.result,
             .register_count = compiled.program.register_count,
             .filters_itself = compiled.program.filters_itself};
  streams = arrays_.keep(std::move(compiled.streams));
  channels = channels_of(graph.outputs[output].type);
}

} // namespace kindling
