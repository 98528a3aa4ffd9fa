// Streams of attribute codec version 1, and their decoded bytes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace kindling::test {

struct MeshoptFixture {
  std::string_view name;
  const char* filter;
  size_t count;
  size_t stride;
  std::string_view encoded; // base64, as `decoded`
  std::string_view decoded;
};

[[nodiscard]] std::span<const MeshoptFixture> meshopt_fixtures();

} // namespace kindling::test
