// Faults that exporters are known to write, one per file, with what a render and a strict load do.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/import/gltf_builder.h"

#include <span>
#include <string_view>

namespace kindling::test {

// A change of the JSON of sound_file().
struct Slip {
  std::string_view name;
  std::string_view pointer; // JSON pointer; missing objects on the way are created, "-" appends
  std::string_view value;   // JSON text; empty: removed
  // Part of the only warning of a load, and of the error of a strict one.
  std::string_view fault;
  std::string_view remedy; // the end of the warning; empty: every load refuses the file
};

// A change of the data or of several places.
struct DataSlip {
  std::string_view name;
  void (*change)(GltfBuilder& builder);
  std::string_view fault;
  std::string_view remedy;
};

// A change of the bytes of sound_file() as a .glb.
struct ContainerSlip {
  std::string_view name;
  void (*change)(std::string& bytes);
  std::string_view fault;
  std::string_view remedy;
};

[[nodiscard]] std::span<const Slip> slips();
[[nodiscard]] std::span<const DataSlip> data_slips();
[[nodiscard]] std::span<const ContainerSlip> container_slips();

// Returns a valid file with a little of everything, all of it in view:
//   nodes      0 textured triangle, 1 camera 0, 2 spot light, 3 skinned triangle, 4 and 5 its
//              joints, 6 triangle with a morph target, 7 point light, 8 camera 1, 9 node with a
//              matrix
//   accessors  0 POSITION, 1 NORMAL, 2 TEXCOORD_0, 3 COLOR_0, 4 indices, 5 JOINTS_0, 6 WEIGHTS_0, 7
//              inverse bind matrices, 8 times, 9 translations, 10 weights, 11 rotations, 12 deltas;
//              each has the bufferView of its index
//   materials  0 of node 0, 1 with all extensions that can be combined, 2 specular-glossiness
//   animation  channels 0 translation of node 0, 1 weights of node 6, 2 rotation of node 4
[[nodiscard]] GltfBuilder sound_file();

[[nodiscard]] GltfBuilder with_slip(const Slip& slip);

} // namespace kindling::test
