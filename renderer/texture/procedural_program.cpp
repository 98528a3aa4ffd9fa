// Interpreter of procedural programs, with analytic filters of patterns.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/procedural_program.h"

#include "renderer/base/elementary.h"
#include "renderer/texture/noise.h"
#include "renderer/texture/texture.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling {
namespace {

using Op = ProceduralOp;

Float4 fill(float x) { return Float4{x, x, x, x}; }
V2f xy(const Float4& v) { return {v[0], v[1]}; }
V3f xyz(const Float4& v) { return {v[0], v[1], v[2]}; }
Float4 with_alpha(const V3f& v, float w) { return Float4{v.x, v.y, v.z, w}; }

template <typename F>
Float4 each(const ProceduralInstruction& instruction, const Float4& a, const F& f) {
  if (instruction.channels == 1) return fill(f(a[0]));
  return Float4{f(a[0]), f(a[1]), f(a[2]), f(a[3])};
}

template <typename F>
Float4 each(const ProceduralInstruction& instruction, const Float4& a, const Float4& b, const F& f) {
  if (instruction.channels == 1) return fill(f(a[0], b[0]));
  return Float4{f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])};
}

float modulo(float a, float b) { return a - b * std::floor(a / b); }

float smooth(float x, float low, float high) {
  if (x >= high) return 1.0f;
  if (x <= low) return 0.0f;
  const float t = (x - low) / (high - low);
  return t * t * (3.0f - 2.0f * t);
}

float dot_of(const Float4& a, const Float4& b, int channels) {
  float sum = 0.0f;
  for (int c = 0; c < channels; ++c) sum += a[c] * b[c];
  return sum;
}

// --- filters --------------------------------------------------------------------------------

// Changes of the coordinates of a pattern along the two axes of the footprint.
struct Extent {
  V3f along[2] = {V3f(0.0f), V3f(0.0f)};

  // Returns the side of a square with the area of the footprint, in cells of the pattern.
  [[nodiscard]] float width() const { return std::sqrt(std::sqrt(along[0].length2() * along[1].length2())); }
};

Extent extent_of(const ProceduralInstruction& instruction, const ProceduralProgramView& program,
                 const ProceduralPoint& point) {
  Extent extent;
  if (!instruction.filtered || !(point.scale > 0.0f)) return extent;
  const ProceduralFootprint& from = program.footprints[static_cast<size_t>(instruction.footprint)];
  const auto& across = point.across[static_cast<size_t>(from.stream)];
  for (int axis = 0; axis < 2; ++axis)
    for (int k = 0; k < 3; ++k)
      extent.along[axis][k] =
          (from.m[k][0] * across[static_cast<size_t>(axis)][0] + from.m[k][1] * across[static_cast<size_t>(axis)][1] +
           from.m[k][2] * across[static_cast<size_t>(axis)][2]) *
          point.scale;
  return extent;
}

// Returns the factor by which the deviation of a pattern from its mean shrinks when it is averaged
// over a square of side w. Rates are least-squares fits to measurements
// (renderer/texture/README.md).
float attenuation(float rate, float w) { return w > 0.0f ? elementary::exp(-rate * w * w) : 1.0f; }
constexpr float kPerlin2d = 0.69f, kPerlin3d = 0.5f, kAbsolute2d = 1.5f, kAbsolute3d = 1.1f, kWorleyRate2d = 0.92f,
                kWorleyRate3d = 0.68f;
constexpr float kCell = 0.6f;        // for exp(-kCell w), because cells have edges
constexpr float kNegligible = 1e-3f; // smaller factors count as 0

// Returns the mean of a function with antiderivative `integral` over an interval centered at x.
template <typename F>
float box_mean(float x, float width, const F& integral) {
  return (integral(x + 0.5f * width) - integral(x - 0.5f * width)) / width;
}

// Returns the mean over a width of the square wave that is +1 in even cells and -1 in odd cells.
float square_wave(float x, float width) {
  if (!(width > 1e-4f)) return modulo(std::floor(x), 2.0f) == 0.0f ? 1.0f : -1.0f;
  x = modulo(x, 2.0f); // preserves the precision of the integral
  return box_mean(x, width, [](float y) { return 1.0f - std::abs(modulo(y, 2.0f) - 1.0f); });
}

float checker(const Float4& at, const Extent& extent) {
  float w[2];
  for (int k = 0; k < 2; ++k) w[k] = std::sqrt(square(extent.along[0][k]) + square(extent.along[1][k]));
  // The footprint is replaced by a rectangle of equal area along the axes of the pattern.
  const float area = std::abs(extent.along[0].x * extent.along[1].y - extent.along[0].y * extent.along[1].x);
  if (w[0] * w[1] > area) {
    const float shrink = std::sqrt(area / (w[0] * w[1]));
    w[0] *= shrink;
    w[1] *= shrink;
  }
  return 0.5f - 0.5f * square_wave(at[0], w[0]) * square_wave(at[1], w[1]);
}

float duty(float x, float period, float below, const Extent& extent) {
  const float fraction = std::clamp(below / period, 0.0f, 1.0f);
  const float phase = x / period;
  const float width = std::sqrt(square(extent.along[0].x) + square(extent.along[1].x)) / std::abs(period);
  if (!(width > 1e-4f)) return phase - std::floor(phase) < fraction ? 1.0f : 0.0f;
  return box_mean(phase - std::floor(phase), width,
                  [&](float y) { return std::floor(y) * fraction + std::min(y - std::floor(y), fraction); });
}

// Returns the exact attenuation of a sine averaged over the footprint.
float sine_attenuation(const Extent& extent) {
  const auto sinc = [](float x) { return std::abs(x) < 1e-3f ? 1.0f : elementary::sin(x) / x; };
  return sinc(0.5f * extent.along[0].x) * sinc(0.5f * extent.along[1].x);
}

// --- patterns --------------------------------------------------------------------------------

// The fourth channel of noise, and the second channel of two-channel fractals, is single-channel
// noise at an offset point, as in MaterialX's mx_noise2d_vector4 and mx_fractal3d_vector4.
V2f offset_point(const V2f& p, bool fractal) { return p + (fractal ? V2f(19.0f, 193.0f) : V2f(19.0f, 73.0f)); }
V3f offset_point(const V3f& p, bool fractal) {
  return p + (fractal ? V3f(19.0f, 193.0f, 17.0f) : V3f(19.0f, 73.0f, 29.0f));
}

template <typename P>
Float4 perlin(const P& p, int channels) {
  if (channels == 1) return fill(noise::perlin(p));
  const V3f rgb = noise::perlin_rgb(p);
  return with_alpha(rgb, channels == 4 ? noise::perlin(offset_point(p, false)) : 1.0f);
}

template <typename P, typename Noise>
auto sum_of_octaves(P p, const ProceduralInstruction& instruction, float rate, float width, const Noise& noise) {
  auto sum = noise(P(0.0f)) * 0.0f;
  float amplitude = 1.0f;
  for (int octave = 0; octave < instruction.i[1]; ++octave) {
    const float factor = attenuation(rate, width);
    if (factor > kNegligible) sum += noise(p) * (amplitude * factor);
    amplitude *= instruction.f[1];
    width *= std::abs(instruction.f[0]);
    p *= instruction.f[0];
  }
  return sum;
}

template <typename P>
Float4 fractal(const P& p, const ProceduralInstruction& instruction, float rate, float width) {
  const auto single = [&](const P& at) {
    return sum_of_octaves(at, instruction, rate, width, [](const P& q) { return noise::perlin(q); });
  };
  if (instruction.i[0] == 1) return fill(single(p));
  if (instruction.i[0] == 2) return Float4{single(p), single(offset_point(p, true)), 0.0f, 1.0f};
  const V3f rgb = sum_of_octaves(p, instruction, rate, width, [](const P& q) { return noise::perlin_rgb(q); });
  return with_alpha(rgb, instruction.i[0] == 4 ? single(offset_point(p, true)) : 1.0f);
}

template <typename P>
Float4 cell(const P& p, int channels) {
  return channels == 1 ? fill(noise::cell(p)) : with_alpha(noise::cell_rgb(p), 1.0f);
}

template <typename P>
Float4 worley(const P& p, const ProceduralInstruction& instruction) {
  P nearest;
  const V3f distances = noise::worley(p, instruction.f[0], nearest);
  if (instruction.i[1] == 1) return cell(nearest, instruction.i[0]);
  return instruction.i[0] == 1 ? fill(distances.x) : with_alpha(distances, 1.0f);
}

// Scales the deviation of a pattern from its mean.
template <typename F>
Float4 faded(const ProceduralInstruction& instruction, float factor, const F& pattern) {
  const Float4 mean = {instruction.mean[0], instruction.mean[1], instruction.mean[2], instruction.mean[3]};
  return factor > kNegligible ? mean + (pattern() - mean) * factor : mean;
}

// Returns a pattern at its coordinates, averaged over its extent if it is filtered.
Float4 pattern(const ProceduralInstruction& instruction, const Float4& at, const Extent& extent) {
  const float w = extent.width();
  const int channels = instruction.i[0];
  switch (instruction.op) {
  case Op::noise2d: return faded(instruction, attenuation(kPerlin2d, w), [&] { return perlin(xy(at), channels); });
  case Op::noise3d: return faded(instruction, attenuation(kPerlin3d, w), [&] { return perlin(xyz(at), channels); });
  case Op::fractal2d: return fractal(xy(at), instruction, kPerlin2d, w);
  case Op::fractal3d: return fractal(xyz(at), instruction, kPerlin3d, w);
  case Op::abs_noise2d:
    return faded(instruction, attenuation(kAbsolute2d, w), [&] { return fill(std::abs(noise::perlin(xy(at)))); });
  case Op::abs_noise3d:
    return faded(instruction, attenuation(kAbsolute3d, w), [&] { return fill(std::abs(noise::perlin(xyz(at)))); });
  case Op::cell2d: return faded(instruction, elementary::exp(-kCell * w), [&] { return cell(xy(at), channels); });
  case Op::cell3d: return faded(instruction, elementary::exp(-kCell * w), [&] { return cell(xyz(at), channels); });
  case Op::worley2d:
    return faded(instruction, attenuation(kWorleyRate2d, w), [&] { return worley(xy(at), instruction); });
  case Op::worley3d:
    return faded(instruction, attenuation(kWorleyRate3d, w), [&] { return worley(xyz(at), instruction); });
  case Op::checker: return fill(checker(at, extent));
  case Op::sin: return fill(elementary::sin(at[0]) * sine_attenuation(extent));
  case Op::cos: return fill(elementary::cos(at[0]) * sine_attenuation(extent));
  default: return fill(duty(at[0], instruction.f[0], instruction.f[1], extent));
  }
}

Float4 image(const ProceduralInstruction& instruction, const Float4& at, const ProceduralProgramView& program,
             const ProceduralPoint& point, std::span<const TextureView> textures) {
  assert(static_cast<size_t>(instruction.i[0]) < textures.size());
  const TextureView& texture = textures[static_cast<size_t>(instruction.i[0])];
  int level = 0;
  if (instruction.footprint >= 0 && point.scale > 0.0f) {
    ProceduralInstruction filtered = instruction;
    filtered.filtered = true;
    const Extent extent = extent_of(filtered, program, point);
    level = texture.choose_level(
        std::abs(extent.along[0].x * extent.along[1].y - extent.along[0].y * extent.along[1].x), 0.5f);
  }
  const V4f texel = texture.sample(xy(at), level);
  return instruction.i[1] != 0 ? fill(texel.x) : Float4{texel.x, texel.y, texel.z, texel.w};
}

} // namespace

Float4 run(const ProceduralInstruction& instruction, const std::array<Float4, 4>& operands,
           const ProceduralProgramView& program, const ProceduralPoint& point, std::span<const TextureView> textures) {
  const Float4 &a = operands[0], &b = operands[1], &c = operands[2], &d = operands[3];
  switch (instruction.op) {
  case Op::stream: return point.values[static_cast<size_t>(instruction.i[0])];
  case Op::image: return image(instruction, a, program, point, textures);
  case Op::add: return a + b;
  case Op::subtract: return a - b;
  case Op::multiply: return a * b;
  case Op::divide: return a / b;
  case Op::modulo: return each(instruction, a, b, modulo);
  case Op::absolute: return each(instruction, a, [](float x) { return std::abs(x); });
  case Op::sign:
    return each(instruction, a, [](float x) { return static_cast<float>(x > 0.0f) - static_cast<float>(x < 0.0f); });
  case Op::floor: return each(instruction, a, [](float x) { return std::floor(x); });
  case Op::ceil: return each(instruction, a, [](float x) { return std::ceil(x); });
  case Op::round: return each(instruction, a, [](float x) { return std::floor(x + 0.5f); });
  case Op::fract: return each(instruction, a, [](float x) { return x - std::floor(x); });
  case Op::power: return each(instruction, a, b, [](float x, float y) { return elementary::pow(x, y); });
  case Op::sqrt: return each(instruction, a, [](float x) { return std::sqrt(x); });
  case Op::exp: return each(instruction, a, [](float x) { return elementary::exp(x); });
  case Op::ln: return each(instruction, a, [](float x) { return elementary::log(x); });
  case Op::sin:
    if (instruction.channels == 1) return pattern(instruction, a, extent_of(instruction, program, point));
    return each(instruction, a, [](float x) { return elementary::sin(x); });
  case Op::cos:
    if (instruction.channels == 1) return pattern(instruction, a, extent_of(instruction, program, point));
    return each(instruction, a, [](float x) { return elementary::cos(x); });
  case Op::tan: return each(instruction, a, [](float x) { return elementary::tan(x); });
  case Op::asin: return each(instruction, a, [](float x) { return elementary::asin(x); });
  case Op::acos: return each(instruction, a, [](float x) { return elementary::acos(x); });
  case Op::atan2: return each(instruction, a, b, [](float y, float x) { return elementary::atan2(y, x); });
  case Op::min: return each(instruction, a, b, [](float x, float y) { return std::min(x, y); });
  case Op::max: return each(instruction, a, b, [](float x, float y) { return std::max(x, y); });
  case Op::mix: return b + (a - b) * c;
  case Op::smoothstep:
    if (instruction.channels == 1) return fill(smooth(a[0], b[0], c[0]));
    return Float4{smooth(a[0], b[0], c[0]), smooth(a[1], b[1], c[1]), smooth(a[2], b[2], c[2]),
                  smooth(a[3], b[3], c[3])};
  case Op::dot: return fill(dot_of(a, b, instruction.i[0]));
  case Op::cross: return with_alpha(xyz(a).cross(xyz(b)), 1.0f);
  case Op::normalize: {
    const float length = std::sqrt(dot_of(a, a, instruction.i[0]));
    return length > 0.0f ? a / fill(length) : fill(0.0f);
  }
  case Op::greater: return a[0] > b[0] ? c : d;
  case Op::greater_equal: return a[0] >= b[0] ? c : d;
  case Op::equal: return a[0] == b[0] ? c : d;
  case Op::swizzle: {
    Float4 result;
    for (int k = 0; k < 4; ++k) {
      const auto from = static_cast<size_t>(instruction.i[static_cast<size_t>(k)]);
      result[k] = operands[from >> 2U][from & 3U];
    }
    return result;
  }
  default: return pattern(instruction, a, extent_of(instruction, program, point));
  }
}

Float4 run(const ProceduralProgramView& program, const ProceduralPoint& point, std::span<const TextureView> textures) {
  assert(program.register_count <= static_cast<int16_t>(kMaxProceduralRegisters));
  std::array<Float4, kMaxProceduralRegisters> values; // uninitialized, so the unused rest costs nothing
  const auto value_of = [&](int16_t operand) {
    return operand >= 0 ? values[static_cast<size_t>(operand)] : program.constants[static_cast<size_t>(~operand)];
  };
  for (const ProceduralInstruction& instruction : program.instructions) {
    const std::array<Float4, 4> operands = {value_of(instruction.operands[0]), value_of(instruction.operands[1]),
                                            value_of(instruction.operands[2]), value_of(instruction.operands[3])};
    values[static_cast<size_t>(instruction.target)] = run(instruction, operands, program, point, textures);
  }
  return value_of(program.result);
}

} // namespace kindling
