// The material variants of a file: which one is shown.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

namespace kindling {

// Gives every primitive the material that it has in `variant`, an index into Scene::variants; those that the variant says nothing
// about keep theirs (KHR_materials_variants). Once for a scene: a second variant would start from the first.
void apply_variant(Scene& scene, int variant);

} // namespace kindling
