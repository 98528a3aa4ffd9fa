// Reuse of paths: what one finds after its second surface lights the first surfaces of others, too.
//
// The paths of one sample of several pixels form a group (Bekaert, Sbert and Halton 2002,
// "Accelerating Path Tracing by Re-Using Paths"). The second surface of each is a point that any of
// them could have found; it is joined to the first surfaces of all that see it, and each such link
// is weighted by the balance heuristic (Veach 1997, section 9.2.2) over the densities with which
// the first surfaces find it. So each pixel gets the mean of several paths for one more ray each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "renderer/base/math.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/integrator/stages/path_stages.h"

#include <array>
#include <cstdint>

namespace kindling {

// Pixels on a side of a whole block: kBlockSize.
inline constexpr uint32_t kReuseSide = 8;

// Ways to divide the pixels of a block into groups: differences, by exclusive or, to the pixels
// with the places 1, 2 and 4; all others are sums of them. x in the lower three bits, y in the
// upper ones.
inline constexpr uint32_t kReusePatterns = 8;
inline constexpr uint8_t kReuseDifferences[kReusePatterns][3] = {{4, 32, 18}, {2, 16, 36}, {5, 40, 18}, {6, 24, 33},
                                                                 {3, 48, 20}, {7, 56, 18}, {1, 8, 36},  {12, 34, 17}};

// Returns the pattern of a sample in the block with this upper left pixel. It differs between
// neighboring blocks, so that no grid shows, and changes every 16 samples: of as many, each pixel
// of a group has a stratified set, and so has what it gives to the others.
[[nodiscard]] inline uint32_t reuse_pattern(const V2i& corner, uint32_t sample_index) {
  const uint32_t block = hash_combine(static_cast<uint32_t>(corner.x), static_cast<uint32_t>(corner.y));
  return (block + sample_index / 16) % kReusePatterns;
}

// Returns the pixel of a whole block of 8 x 8, numbered row by row, that has this place in the
// group of `pixel`: itself for 0. The same place leads back.
[[nodiscard]] inline uint32_t reuse_partner(uint32_t pixel, uint32_t pattern, uint32_t place) {
  for (uint32_t bit = 0; bit < 3; ++bit)
    if ((place >> bit & 1) != 0) pixel ^= kReuseDifferences[pattern][bit];
  return pixel;
}

// Alpha below which lobes are narrow. At second surfaces they are not shared: the direction of a
// tail that is drawn from one is not likely by the lobe that another first surface sees.
inline constexpr float kMinSharedAlpha = 0.1f;
// Returns whether a first surface is mostly a mirror, given SurfaceBsdf::smooth_share() of that
// alpha.
[[nodiscard]] inline bool is_mirror(float smooth_share) { return smooth_share >= 0.5f; }

// A surface of a path, as others may be joined to it: opaque, without layers.
struct ReusedSurface {
  V3f position{0.0f};
  V3f origin{0.0f}; // of rays
  V3f geometric_normal{0.0f}, shading_normal{0.0f};
  BsdfParameters bsdf;
};

// Data of a path for the others of its group.
struct ReusedPath {
  bool receives = false; // it has a first surface that light may be shared with
  bool gives = false;    // it has a second surface whose light is shared
  ReusedSurface first, second;
  // The first surface.
  V3f wo{0.0f};         // unit, to the camera
  Rgb throughput{1.0f}; // there
  Rgb value{0.0f};      // f |cos| of the direction to the second surface
  float pdf = 0.0f;     // and its density
  // The second surface.
  V3f light_wi{0.0f};    // unit, to its light sample
  Rgb light{0.0f};       // radiance over density; black: occluded, or none
  V3f tail_wi{0.0f};     // unit, of the next ray
  float tail_pdf = 0.0f; // 0: there is none
  Rgb tail{0.0f};        // radiance that this ray has brought
  // Factors of `light` and `tail` in light that this path alone receives: narrow lobes of the
  // second surface are not shared.
  Rgb own_of_light{0.0f}, own_of_tail{0.0f};

  // Forgets the path before; the rest is set with the surfaces.
  void start() { receives = gives = false; }
  [[nodiscard]] bool has_light() const { return gives && !(is_black(light) && is_black(tail)); }
  // Notes the first surface, or the second one; `wo_world` is the unit direction that the path
  // comes from.
  void note(const SurfacePoint& surface, const V3f& wo_world, const PathState& state);
};

// The way from the first surface of a path to the second one of another.
struct ReuseLink {
  Rgb value{0.0f};      // f |cos| of the first surface, times solid angle per area of the second
  float density = 0.0f; // with which the first surface finds the second, by area; 0: they are not joined
  // Factors of the other's `light` and `tail`, before the throughput to the first surface. Until
  // share_light() knows the former, it is the unit direction to the second surface.
  Rgb of_light{0.0f}, of_tail{0.0f};
};

// The straight way from a first surface to a second one, or several in lanes.
template <typename Real>
struct WayOf {
  Imath::Vec3<Real> direction; // unit
  Real solid_angle_per_area;   // 0: there is no way, and no direction
};
template <typename Real>
[[nodiscard]] WayOf<Real> way_between(const Imath::Vec3<Real>& first, const Imath::Vec3<Real>& second,
                                      const Imath::Vec3<Real>& normal_there) {
  const Imath::Vec3<Real> difference = second - first, none(Real(0.0f));
  const Real distance2 = difference.length2();
  const auto apart = distance2 > 0.0f;
  const Imath::Vec3<Real> direction = select(apart, difference / square_root(distance2), none);
  return {direction, select(apart, Real(-direction.dot(normal_there) / distance2), Real(0.0f))};
}

// Returns the unit direction from a first surface to a second one.
[[nodiscard]] V3f direction_between(const ReusedSurface& first, const ReusedSurface& second);

// The paths of a group by their places in it: the numbers of their slots; kNoPath: there is none.
using ReuseGroup = std::array<uint32_t, kMaxPathReuse>;
inline constexpr uint32_t kNoPath = ~0U;

// The records of many paths and of the links to their first surfaces, each group's in the order of
// the paths' places. Stages, once all paths have ended:
//
//   start_sharing()  by path: its tail
//   link_paths()     by path: the links to its first surface, whose rays are to be traced
//   share_light()    by path: what is received by the links from its second surface
//   receive()        by path: adds the light of the links to its first surface
struct ReuseView {
  ReusedPath* paths = nullptr; // by slot
  ReuseLink* links = nullptr;  // by slot and place
  uint32_t count = 1;          // of places in a group: 2, 4 or 8

  [[nodiscard]] ReuseLink& link(uint32_t slot, uint32_t place) const { return links[slot * count + place]; }

  // Takes the tail of a path out of its state.
  void start_sharing(uint32_t slot, PathState& state) const;
  // Sets the links to the first surface of a path. Returns the places of those whose link_ray()
  // must meet nothing, as bits; blocked links are cleared by the caller.
  [[nodiscard]] uint32_t link_paths(const PathStages& stages, uint32_t slot, const ReuseGroup& group) const;
  // Returns the ray of a link; `sample` is that of the path in `slot`.
  [[nodiscard]] accel::Ray link_ray(uint32_t slot, const ReuseGroup& group, uint32_t place,
                                    const CameraSample& sample) const;
  void share_light(uint32_t slot, const ReuseGroup& group) const;
  void receive(uint32_t slot, const ReuseGroup& group, PathState& state) const;
};

} // namespace kindling
