// Hashes of results and inputs with special values, for the programs of compare_compilers.py.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "tests/sampling/random.h"

#include <bit>
#include <cinttypes>
#include <concepts>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <string>

namespace kindling::test {

class ResultHash {
 public:
  void add(std::integral auto x) {
    const auto bits = static_cast<uint64_t>(x);
    for (int i = 0; i < 8; ++i) value_ = (value_ ^ (bits >> (8 * i) & 0xff)) * 0x100000001b3U; // FNV-1a
  }
  // The sign and the bits of NaN are the processor's affair.
  void add(float x) { add(x == x ? std::bit_cast<uint32_t>(x) : 0x7fc00000U); }
  void add(const V2f& v) {
    add(v.x);
    add(v.y);
  }
  void add(const V3f& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  void add(const V4f& v) {
    add(V3f(v.x, v.y, v.z));
    add(v.w);
  }
  void print(const char* name) const { std::printf("%s %016" PRIx64 "\n", name, value_); }

 private:
  uint64_t value_ = 0xcbf29ce484222325U;
};

// Zeros, infinities, NaN, denormals, ends of the ranges of floats and of integers, neighbors of 1.
inline constexpr float kSpecialNumbers[] = {0.0f,
                                            -0.0f,
                                            std::numeric_limits<float>::quiet_NaN(),
                                            std::numeric_limits<float>::infinity(),
                                            -std::numeric_limits<float>::infinity(),
                                            0x1p-149f,
                                            -0x1p-149f,
                                            0x1.8p-130f,
                                            -0x1p-127f,
                                            0x1p-126f,
                                            std::numeric_limits<float>::max(),
                                            -std::numeric_limits<float>::max(),
                                            0x1p-24f,
                                            1.0f,
                                            -1.0f,
                                            0x1.fffffep-1f,
                                            0x1.000002p0f,
                                            0x1p31f,
                                            -0x1p31f,
                                            0x1p32f,
                                            0x1p63f,
                                            -0x1p64f,
                                            1e-20f,
                                            1e20f};

// Draws one number a statement: compilers choose the order of a call's arguments.
struct Inputs {
  Random random;
  bool special = false; // one number of any() in eight is one of kSpecialNumbers

  float number() { return random.next_1d(); }
  float between(float low, float high) { return low + (high - low) * random.next_1d(); }
  float any(float low, float high) {
    const float usual = between(low, high);
    const uint64_t choice = random.next_u64();
    return special && choice % 8 == 0 ? kSpecialNumbers[choice / 8 % std::size(kSpecialNumbers)] : usual;
  }
  V2f any_2d(float low, float high) {
    const float x = any(low, high);
    return {x, any(low, high)};
  }
  V3f any_3d(float low, float high) {
    const float x = any(low, high), y = any(low, high);
    return {x, y, any(low, high)};
  }
  // The ends of the range are as frequent as the interior.
  float pick() { return std::clamp(2.0f * number() - 0.5f, 0.0f, 1.0f); }
};

// The number of inputs of each function: the program's argument, or this.
inline int input_count(int argc, char** argv, int otherwise) { return argc > 1 ? std::atoi(argv[1]) : otherwise; }

// Prints the hashes of usual inputs under `name`, and of those with special numbers among them
// under `name`-special, by print(name, special, count).
template <class Print>
void print_usual_and_special(const std::string& name, int count, const Print& print) {
  print(name.c_str(), false, count);
  print((name + "-special").c_str(), true, count);
}

} // namespace kindling::test
