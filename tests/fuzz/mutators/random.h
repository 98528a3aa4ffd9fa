// Random choices of the mutators, from the seed that libFuzzer gives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace kindling::fuzz {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  // Returns a number below `count`, which is at least 1.
  size_t below(size_t count) { return static_cast<size_t>(engine_() % count); }
  // True once in `count` times.
  bool one_in(size_t count) { return below(count) == 0; }
  unsigned seed() { return static_cast<unsigned>(engine_()); }

 private:
  std::mt19937_64 engine_;
};

} // namespace kindling::fuzz
