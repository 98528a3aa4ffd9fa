// A folder for the accumulation files of each test, and states of random records.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/accumulation_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace kindling::test {

class AccumulationFolder : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  [[nodiscard]] size_t files_in_folder() const;

  std::filesystem::path folder_, path_; // file of the test
};

// Returns an identity whose members all differ from their defaults.
[[nodiscard]] AccumulationIdentity identity_of(const V2i& size_px, const PixelRect& crop);
// Returns a state of random records, even such that no render could produce. `everything`:
// all AOVs, trimmed outliers, adaptive sampling.
[[nodiscard]] RenderState random_state(const V2i& size_px, const PixelRect& area, bool everything, uint32_t seed);

void expect_same(const RenderState& a, const RenderState& b);
void expect_same(const AccumulationIdentity& a, const AccumulationIdentity& b);

[[nodiscard]] std::string contents(const std::filesystem::path& path);
void set_contents(const std::filesystem::path& path, std::string_view bytes);

// A file of everything in half a megabyte.
inline constexpr V2i kSmall(40, 24);
inline constexpr PixelRect kSmallArea{V2i(8, 0), V2i(40, 24)};
void write_small(const std::filesystem::path& path, uint32_t seed = 1, bool keep_previous = false);
void expect_small(const std::filesystem::path& path, uint32_t seed);

} // namespace kindling::test
