// Prints hashes of light tree nodes, their importances and spheres seen, for compare_compilers.py.
//
// It includes the sources themselves, so that it needs no library but Imath's headers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/equirect.h"
#include "renderer/light/light_node.cpp"
#include "renderer/light/light_tree.cpp"
#include "renderer/light/sphere_seen.h"
#include "tests/base/result_hash.h"

#include <array>

namespace {

using namespace kindling;
using test::Inputs;
using test::ResultHash;

LightFamily family_of(Inputs& inputs) {
  LightFamily f;
  f.center = inputs.any_3d(-10.0f, 10.0f);
  f.radius = inputs.between(0.0f, 2.0f);
  f.axis = sample_uniform_sphere(inputs.random.next_2d());
  f.cos_reach = inputs.between(-1.0f, 1.0f);
  f.even = inputs.any(1e-6f, 2.0f);
  f.odd = inputs.pick();
  f.flat = inputs.pick();
  return f;
}

void print_importances(const char* name, bool special, int count) {
  Inputs inputs{test::Random(1), special};
  Inputs usual{test::Random(2)};
  ResultHash hash;
  for (int i = 0; i < count / 4; ++i) {
    LightNode node{};
    std::array<LightFamily, LightNode::kWidth> families;
    for (LightFamily& f : families) f = family_of(usual); // builds have finite emitters only
    node.store(std::span(families).first(1 + static_cast<size_t>(i) % LightNode::kWidth));
    for (uint32_t lane = 0; lane < LightNode::kWidth; ++lane) {
      hash.add(node.x[lane] | node.y[lane] << 8 | node.z[lane] << 16 | node.radius[lane] << 24);
      hash.add(node.axis_x[lane]);
      hash.add(node.cos_reach[lane]);
      hash.add(node.even[lane]);
    }
    for (int k = 0; k < 4; ++k) {
      const V3f point = inputs.any_3d(-12.0f, 12.0f);
      V3f normal = sample_uniform_sphere(inputs.random.next_2d());
      if (k == 3) normal = inputs.any_3d(-1.0f, 1.0f);
      const Float8 sums = running_sums(importances(node, point, normal));
      for (int lane = 0; lane < 8; ++lane) hash.add(sums[lane]);
      hash.add(count_up_to(sums, inputs.any(0.0f, 1.0f)));
    }
  }
  hash.print(name);
}

void print_directions(const char* name, bool special, int count) {
  Inputs inputs{test::Random(3), special};
  ResultHash hash;
  for (int i = 0; i < count; ++i) {
    const V3f w = inputs.any_3d(-1.0f, 1.0f);
    hash.add(atan2_turns(w.z, w.x));
    hash.add(acos_half_turns(w.y));
  }
  hash.print(name);
}

} // namespace

int main(int argc, char** argv) {
  const int count = test::input_count(argc, argv, 100000);
  test::print_usual_and_special("importances", count, print_importances);
  test::print_usual_and_special("equirect", count, print_directions);
  return 0;
}
