// SPDX-License-Identifier: Apache-2.0
#include "accel/make_accelerator.h"

#include "accel/brute_force.h"
#include "accel/embree/embree_accelerator.h"
#include "accel/kdtree/kdtree_accelerator.h"

#include <array>
#include <utility>

namespace kindling::accel {
namespace {

struct KindName {
  Kind kind;
  std::string_view name;
};
constexpr std::array kKindNames = {KindName{Kind::brute_force, "brute-force"}, KindName{Kind::embree, "embree"},
                                   KindName{Kind::kdtree, "kdtree"}};

} // namespace

std::unique_ptr<Accelerator> make_accelerator(Kind kind, const BuildInput& input, const BuildOptions& options,
                                              std::unique_ptr<PersistentStructures> kept) {
  switch (kind) {
  case Kind::brute_force: return make_brute_force(input, options);
  case Kind::embree: return make_embree(input, options, std::move(kept));
  case Kind::kdtree: return make_kdtree(input, options, std::move(kept));
  }
  return nullptr;
}

std::string_view kind_name(Kind kind) {
  for (const KindName& entry : kKindNames)
    if (entry.kind == kind) return entry.name;
  return {};
}

std::optional<Kind> kind_from_name(std::string_view name) {
  for (const KindName& entry : kKindNames)
    if (entry.name == name) return entry.kind;
  return std::nullopt;
}

std::string_view kind_description(Kind kind) {
  switch (kind) {
  case Kind::brute_force: return "brute force";
  case Kind::embree: return embree_description();
  case Kind::kdtree: return "Kindling kd-tree";
  }
  return {};
}

std::string_view quality_name(Quality quality) {
  switch (quality) {
  case Quality::fast: return "fast";
  case Quality::balanced: return "balanced";
  case Quality::best: return "best";
  }
  return "balanced";
}

std::optional<Quality> quality_from_name(std::string_view name) {
  for (const Quality quality : {Quality::fast, Quality::balanced, Quality::best})
    if (name == quality_name(quality)) return quality;
  return std::nullopt;
}

} // namespace kindling::accel
