// Table of the names of the samplers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/sampler.h"

namespace kindling {
namespace {

struct NamedKind {
  SamplerKind kind;
  std::string_view name;
};
constexpr std::array<NamedKind, 4> kNames{{
    {SamplerKind::blue_noise, "blue-noise"},
    {SamplerKind::sobol, "sobol"},
    {SamplerKind::independent, "independent"},
    {SamplerKind::jittered, "jittered"},
}};

} // namespace

std::string_view sampler_name(SamplerKind kind) {
  for (const NamedKind& named : kNames)
    if (named.kind == kind) return named.name;
  return "unknown";
}

std::optional<SamplerKind> sampler_from_name(std::string_view name) {
  for (const NamedKind& named : kNames)
    if (named.name == name) return named.kind;
  return std::nullopt;
}

} // namespace kindling
