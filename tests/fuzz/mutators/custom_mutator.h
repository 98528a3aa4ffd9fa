// LLVMFuzzerCustomMutator in terms of a function of strings; included by one source of a harness.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/mutators/random.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

namespace kindling::fuzz {

// `mutate` takes the input, its maximum size and a Random, and returns the mutant.
template <typename Mutate>
size_t mutate_in_place(uint8_t* data, size_t size, size_t max_size, unsigned seed, const Mutate& mutate) {
  Random random(seed);
  const std::string mutant = mutate(std::string_view(reinterpret_cast<const char*>(data), size), max_size, random);
  const size_t count = std::min(mutant.size(), max_size);
  std::memcpy(data, mutant.data(), count);
  return count;
}

} // namespace kindling::fuzz
