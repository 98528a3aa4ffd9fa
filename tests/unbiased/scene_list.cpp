// The list of all test scenes.
// SPDX-License-Identifier: Apache-2.0
#include "tests/unbiased/scenes.h"

namespace kindling::test {

std::span<const NamedScene> all_scenes() {
  static constexpr NamedScene kScenes[] = {{"hall_of_lamps", hall_of_lamps},
                                           {"room_with_window", room_with_window},
                                           {"metal_under_sun", metal_under_sun},
                                           {"textured_emitters", textured_emitters},
                                           {"veils", veils},
                                           {"kinds_of_lights", kinds_of_lights},
                                           {"sized_lights", sized_lights},
                                           {"layered_materials", layered_materials},
                                           {"caustics", caustics},
                                           {"coats_and_prisms", coats_and_prisms},
                                           {"glass_bell", glass_bell},
                                           {"moving_caustics", moving_caustics},
                                           {"moving_lamps", moving_lamps},
                                           {"cornell_box", cornell_box},
                                           {"material_grid", material_grid},
                                           {"interior", interior}};
  return kScenes;
}

} // namespace kindling::test
