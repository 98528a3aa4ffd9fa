// Applies a material variant to all primitives.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/variants.h"

namespace kindling {

void apply_variant(Scene& scene, int variant) {
  for (Mesh& mesh : scene.meshes) {
    for (Primitive& primitive : mesh.primitives) {
      for (const VariantMaterial& choice : primitive.variant_materials) {
        if (choice.variant == variant) primitive.material = choice.material;
      }
    }
  }
}

} // namespace kindling
