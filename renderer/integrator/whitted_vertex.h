// Shading state of a Whitted node at its surface: local frame, media on both sides, BSDF.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/integrator/whitted_terms.h"
#include "renderer/integrator/whitted_tree.h"
#include "renderer/world/world_view.h"

#include <optional>

namespace kindling {

// Returns the transmittance of the innermost medium over a distance; 1 for an infinite one (a ray
// left an open mesh).
[[nodiscard]] Rgb medium_transmittance(const WorldView& world, const MediumStack& media, float distance);

class WhittedVertex {
 public:
  // Completes the surface's layers with what depends on the node. All arguments must outlive the
  // vertex.
  WhittedVertex(const WorldView& world, const WhittedNode& node, SurfacePoint& surface, const WhittedTerms& terms,
                float highlight_roughness);

  const WhittedNode& node;
  const SurfacePoint& surface;
  const WhittedTerms& terms;
  Frame frame; // around the shading normal
  V3f wo;      // local

  // The exact BSDF: for rays, and for lights that rays can hit.
  [[nodiscard]] const SurfaceBsdf& bsdf() const {
    if (!exact_) exact_.emplace(surface.bsdf, layers_, wo);
    return *exact_;
  }
  // The BSDF for lights that no ray can hit, with a roughness of at least `highlight_roughness`.
  [[nodiscard]] const SurfaceBsdf& highlight_bsdf() const {
    if (!blurred_) return bsdf();
    if (!highlight_) make_highlight();
    return *highlight_;
  }
  // True if highlight_bsdf() differs from bsdf(). Then light from beyond the surface is left to
  // refracted rays.
  [[nodiscard]] bool highlight_is_blurred() const { return blurred_; }
  // Returns the fraction of f in direction wi (local, of density `pdf`) that no ray follows.
  [[nodiscard]] float share_of_lights(const V3f& wi, float pdf) const;

  // Updates media and wavelength of a node below that continues on the other side of the surface.
  void cross(WhittedNode& below) const;
  // Returns the transmittance for light from that distance, on the side of wo (side > 0) or beyond
  // the surface.
  [[nodiscard]] Rgb transmittance_to_light(float side, float distance) const;

 private:
  void resolve_media(SurfacePoint& mutable_surface);
  void make_highlight() const;

  const WorldView& world_;
  const LayerParameters* layers_ = nullptr; // null: the plain model
  float highlight_roughness_;
  bool blurred_;
  float wavelength_nm_ = 0.0f; // of refracted light; 0: all wavelengths
  Rgb wavelength_weight_{1.0f};
  mutable std::optional<SurfaceBsdf> exact_, highlight_;
};

} // namespace kindling
