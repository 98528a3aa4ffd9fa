// Parses and prints the names of accelerators with their settings.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/options/accelerator_variant.h"

#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

Error usage(std::string message) { return {ErrorKind::usage, std::move(message)}; }

// The instruction sets of the kernels that this processor runs.
std::vector<accel::SimdTarget> targets_of(accel::Kind kind) {
  switch (kind) {
  case accel::Kind::kdtree: return accel::simd_targets();
  case accel::Kind::embree: return accel::embree_simd_targets();
  case accel::Kind::brute_force: return {};
  }
  return {};
}

// "sse2, avx or avx2"
std::string names_of(const std::vector<accel::SimdTarget>& targets) {
  std::vector<std::string> names;
  for (const accel::SimdTarget target : targets) names.emplace_back(accel::simd_target_name(target));
  return join_choices(names);
}

Result<AcceleratorVariant> parse_variant(std::string_view text) {
  AcceleratorVariant variant;
  const std::string_view name = text.substr(0, text.find(':'));
  const std::optional<accel::Kind> kind = accel::kind_from_name(name);
  if (!kind) return usage(fmt::format("unknown accelerator '{}'; use kdtree, embree or brute-force", name));
  variant.kind = *kind;
  for (size_t at = name.size(); at < text.size();) {
    const size_t end = std::min(text.find(':', at + 1), text.size());
    const std::string_view word = text.substr(at + 1, end - at - 1);
    at = end;
    if (const std::optional<accel::Quality> quality = accel::quality_from_name(word)) {
      if (variant.kind == accel::Kind::brute_force) return usage("brute-force has no qualities");
      variant.quality = *quality;
    } else if (word == "robust" || word == "non-robust") {
      variant.robust = word == "robust";
      if (!variant.robust && variant.kind != accel::Kind::embree)
        return usage(fmt::format("{} is always robust; only embree can be non-robust", name));
    } else if (const std::optional<accel::SimdTarget> simd = accel::simd_target_from_name(word)) {
      const std::vector<accel::SimdTarget> targets = targets_of(variant.kind);
      if (targets.empty()) return usage("brute-force has no instruction sets to choose from");
      if (std::find(targets.begin(), targets.end(), *simd) == targets.end())
        return usage(
            fmt::format("{} has no kernels for {} that this processor runs; use {}", name, word, names_of(targets)));
      variant.simd = simd;
    } else {
      return usage(fmt::format("unknown setting '{}' of {}; use fast, balanced or best, robust or non-robust, or an "
                               "instruction set: portable, avx2 or avx512 for kdtree, sse2, sse4.2, avx, avx2 or "
                               "avx512 for embree",
                               word, name));
    }
  }
  return variant;
}

} // namespace

Result<accel::SimdTarget> parse_instruction_set(std::string_view text) {
  const std::vector<accel::SimdTarget> targets = accel::embree_simd_targets();
  const std::optional<accel::SimdTarget> found = accel::simd_target_from_name(text);
  if (!found || std::find(targets.begin(), targets.end(), *found) == targets.end())
    return usage(
        fmt::format("'{}' is not an instruction set that this processor runs; use {}", text, names_of(targets)));
  return *found;
}

void limit_instruction_set(std::vector<AcceleratorVariant>& variants, accel::SimdTarget limit) {
  for (AcceleratorVariant& variant : variants) {
    if (variant.simd) continue;
    for (const accel::SimdTarget target : targets_of(variant.kind))
      if (target <= limit) variant.simd = target;
  }
}

std::string AcceleratorVariant::name() const {
  std::string text(accel::kind_name(kind));
  if (quality != accel::Quality::balanced) text += fmt::format(":{}", quality_name(quality));
  if (!robust) text += ":non-robust";
  if (simd) text += fmt::format(":{}", accel::simd_target_name(*simd));
  return text;
}

std::string join_variants(const std::vector<AcceleratorVariant>& variants) {
  std::string text;
  for (const AcceleratorVariant& variant : variants) text += (text.empty() ? "" : ",") + variant.name();
  return text;
}

Result<std::vector<AcceleratorVariant>> parse_accelerator_variants(std::string_view text) {
  Result<std::vector<std::string>> words = parse_list(text);
  if (!words.ok()) return words.error();
  std::vector<AcceleratorVariant> variants;
  for (const std::string& word : words.value()) {
    Result<AcceleratorVariant> variant = parse_variant(word);
    if (!variant.ok()) return variant.error();
    if (std::find(variants.begin(), variants.end(), variant.value()) != variants.end())
      return usage(fmt::format("{} is given twice", variant.value().name()));
    variants.push_back(variant.value());
  }
  return variants;
}

} // namespace kindling::app
