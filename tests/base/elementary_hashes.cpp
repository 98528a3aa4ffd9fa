// Prints a hash of the results of each elementary function, for compare_compilers.py.
//
// It needs no library, so that any compiler for any processor can build it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/elementary.h"
#include "renderer/base/elementary_double.h"

#include <bit>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace {

namespace elementary = kindling::elementary;

// Most functions can be computed while compiling.
static_assert(elementary::exp(0.0f) == 1.0f && elementary::pow(2.0f, 10.0f) == 1024.0f);
static_assert(elementary::sin(0.5) == 0x1.eaee8744b05f0p-2 && elementary::log2(8.0) == 3.0);

class Hash {
 public:
  void add(uint64_t bits) { // FNV-1a
    for (int i = 0; i < 8; ++i) value_ = (value_ ^ (bits >> (8 * i) & 0xff)) * 0x100000001b3U;
  }
  // The sign and the bits of NaN are the processor's affair.
  void add(float x) { add(uint64_t{x == x ? std::bit_cast<uint32_t>(x) : 0x7fc00000U}); }
  void add(double x) { add(x == x ? std::bit_cast<uint64_t>(x) : uint64_t{0x7ff8000000000000}); }
  void print(const char* kind, const char* name) const { std::printf("%s %s %016" PRIx64 "\n", kind, name, value_); }

 private:
  uint64_t value_ = 0xcbf29ce484222325U;
};

uint64_t count = 1 << 18; // of inputs; the program's argument

uint64_t mixed(uint64_t x) { // SplitMix64
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
  x = (x ^ x >> 27) * 0x94d049bb133111ebU;
  return x ^ x >> 31;
}

float any_float(uint64_t i) { return std::bit_cast<float>(static_cast<uint32_t>(mixed(i))); }
double any_double(uint64_t i) { return std::bit_cast<double>(mixed(i)); }
// From -1 to 1, at the place of the sample times `range`.
double uniform(uint64_t i, double range) {
  return static_cast<double>(static_cast<int64_t>(mixed(i + count))) * 0x1p-63 * range;
}

template <typename F>
void print_float(const char* name, double range, const F& f) {
  Hash hash;
  for (uint64_t i = 0; i < count; ++i) {
    hash.add(f(any_float(i)));
    hash.add(f(static_cast<float>(uniform(i, range))));
  }
  hash.print("float", name);
}

template <typename F>
void print_double(const char* name, double range, const F& f) {
  Hash hash;
  for (uint64_t i = 0; i < count / 4; ++i) {
    hash.add(f(any_double(i)));
    hash.add(f(uniform(i, range)));
  }
  hash.print("double", name);
}

template <typename F>
void print_floats(const char* name, const F& f) {
  Hash hash;
  for (uint64_t i = 0; i < count; ++i) {
    hash.add(f(any_float(2 * i), any_float(2 * i + 1)));
    hash.add(f(static_cast<float>(uniform(2 * i, 4.0)), static_cast<float>(uniform(2 * i + 1, 30.0))));
    hash.add(f(static_cast<float>(uniform(2 * i, 1.0) + 1.0), static_cast<float>(uniform(2 * i + 1, 30.0))));
  }
  hash.print("float", name);
}

template <typename F>
void print_doubles(const char* name, const F& f) {
  Hash hash;
  for (uint64_t i = 0; i < count / 4; ++i) {
    hash.add(f(any_double(2 * i), any_double(2 * i + 1)));
    hash.add(f(uniform(2 * i, 4.0), uniform(2 * i + 1, 100.0)));
    hash.add(f(uniform(2 * i, 1.0) + 1.0, uniform(2 * i + 1, 100.0)));
  }
  hash.print("double", name);
}

} // namespace

int main(int argc, char** argv) {
  if (argc > 1) count = std::strtoull(argv[1], nullptr, 10);
#define KINDLING_HASH(NAME, RANGE)                                                                                     \
  print_float(#NAME, RANGE, [](float x) { return elementary::NAME(x); });                                              \
  print_double(#NAME, RANGE, [](double x) { return elementary::NAME(x); })
#define KINDLING_HASH_OF_TWO(NAME)                                                                                     \
  print_floats(#NAME, [](float x, float y) { return elementary::NAME(x, y); });                                        \
  print_doubles(#NAME, [](double x, double y) { return elementary::NAME(x, y); })
  KINDLING_HASH(exp, 100.0);
  KINDLING_HASH(exp2, 150.0);
  KINDLING_HASH(log, 2.0);
  KINDLING_HASH(log2, 2.0);
  KINDLING_HASH(sin, 10.0);
  KINDLING_HASH(cos, 10.0);
  KINDLING_HASH(tan, 10.0);
  KINDLING_HASH(asin, 1.0);
  KINDLING_HASH(acos, 1.0);
  KINDLING_HASH(atan, 4.0);
  KINDLING_HASH_OF_TWO(pow);
  KINDLING_HASH_OF_TWO(atan2);
  return 0;
}
