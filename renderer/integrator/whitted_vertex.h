// A surface as a node of a Whitted tree meets it: frame, media on both sides, BSDF.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/integrator/whitted_terms.h"
#include "renderer/integrator/whitted_tree.h"
#include "renderer/world/world.h"

#include <optional>

namespace kindling {

// By how much light is dimmed over a distance; 1 out of an open mesh.
[[nodiscard]] Rgb medium_transmittance(const World& world, const MediumStack& media, float distance);

class WhittedVertex {
 public:
  // Sets what the layers of the surface take from the node. All must outlive the vertex.
  WhittedVertex(const World& world, const WhittedNode& node, SurfacePoint& surface, const WhittedTerms& terms,
                float highlight_roughness);

  const WhittedNode& node;
  const SurfacePoint& surface;
  const WhittedTerms& terms;
  Frame frame; // around the shading normal
  V3f wo;      // local

  // As it is: for rays, and for lights that rays meet as well.
  [[nodiscard]] const SurfaceBsdf& bsdf() const {
    if (!exact_) exact_.emplace(surface.bsdf, layers_, wo);
    return *exact_;
  }
  // For lights that no ray can meet: no smoother than `highlight_roughness`.
  [[nodiscard]] const SurfaceBsdf& highlight_bsdf() const {
    if (!blurred_) return bsdf();
    if (!highlight_) make_highlight();
    return *highlight_;
  }
  // Light from beyond a smooth surface is left to refracted rays.
  [[nodiscard]] bool highlight_is_blurred() const { return blurred_; }
  // How much of f in direction wi (local), whose density is `pdf`, no ray follows.
  [[nodiscard]] float share_of_lights(const V3f& wi, float pdf) const;

  // The light that goes on from the other side: with media and wavelength as they are there.
  void cross(WhittedNode& below) const;
  // Of light that comes from that far on the side of wo (side > 0) or from beyond.
  [[nodiscard]] Rgb transmittance_to_light(float side, float distance) const;

 private:
  void resolve_media(SurfacePoint& mutable_surface);
  void make_highlight() const;

  const World& world_;
  const LayerParameters* layers_ = nullptr; // null: the plain model
  float highlight_roughness_;
  bool blurred_;
  float wavelength_nm_ = 0.0f; // that refraction here takes on; 0: all
  Rgb wavelength_weight_{1.0f};
  mutable std::optional<SurfaceBsdf> exact_, highlight_;
};

} // namespace kindling
