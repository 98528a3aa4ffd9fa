// Names of accelerators with their settings.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/accelerator_variant.h"

#include "renderer/app/parse_values.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

Error usage(std::string message) { return {ErrorKind::usage, std::move(message)}; }

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
    if (const std::optional<accel::Quality> quality = quality_from_name(word)) {
      if (variant.kind == accel::Kind::brute_force) return usage("brute-force has no qualities");
      variant.quality = *quality;
    } else if (word == "robust" || word == "non-robust") {
      variant.robust = word == "robust";
      if (!variant.robust && variant.kind != accel::Kind::embree)
        return usage(fmt::format("{} is always robust; only embree can be non-robust", name));
    } else if (const std::optional<accel::SimdTarget> simd = accel::simd_target_from_name(word)) {
      if (variant.kind != accel::Kind::kdtree)
        return usage(fmt::format("{} does not let its instruction set be chosen; only kdtree does", name));
      const std::vector<accel::SimdTarget> targets = accel::simd_targets();
      if (std::find(targets.begin(), targets.end(), *simd) == targets.end())
        return usage(fmt::format("this processor does not run {}; its best is {}", word,
                                 accel::simd_target_name(accel::best_simd_target())));
      variant.simd = simd;
    } else {
      return usage(
          fmt::format("unknown setting '{}' of {}; use fast, balanced or best, robust or non-robust, and with kdtree "
                      "portable, avx2 or avx512",
                      word, name));
    }
  }
  return variant;
}

} // namespace

std::string_view quality_name(accel::Quality quality) {
  switch (quality) {
  case accel::Quality::fast: return "fast";
  case accel::Quality::balanced: return "balanced";
  case accel::Quality::best: return "best";
  }
  return "balanced";
}

std::optional<accel::Quality> quality_from_name(std::string_view name) {
  for (const accel::Quality quality : {accel::Quality::fast, accel::Quality::balanced, accel::Quality::best})
    if (name == quality_name(quality)) return quality;
  return std::nullopt;
}

std::string AcceleratorVariant::name() const {
  std::string text(accel::kind_name(kind));
  if (quality != accel::Quality::balanced) text += fmt::format(":{}", quality_name(quality));
  if (!robust) text += ":non-robust";
  if (simd) text += fmt::format(":{}", accel::simd_target_name(*simd));
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
