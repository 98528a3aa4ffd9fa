// Smooth glass and lamps without a size: what manifold sampling joins, as all devices read it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/emission_view.h"

#include <cstdint>
#include <span>

namespace kindling {

struct ManifoldView {
  std::span<const EmissionTarget> targets; // spheres around all smooth boundaries of glass; walks start towards them
  std::span<const uint32_t> lamps;         // lights without a size, as indices into LightSetView::punctuals
};

} // namespace kindling
