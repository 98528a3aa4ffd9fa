// Applies a material variant (KHR_materials_variants).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

namespace kindling {

// Gives every primitive its material in `variant`, an index into Scene::variants. Primitives
// without an entry for the variant keep theirs. Apply at most one variant per scene: a second one
// would start from the first.
void apply_variant(Scene& scene, int variant);

} // namespace kindling
