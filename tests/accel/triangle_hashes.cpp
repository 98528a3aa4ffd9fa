// Prints hashes of triangle tests, transforms of rays and motion, for compare_compilers.py.
// SPDX-License-Identifier: Apache-2.0
#include "accel/affine.h"
#include "accel/motion.h"
#include "accel/triangle.h"
#include "tests/base/result_hash.h"

#include <array>

namespace {

using namespace kindling;
using test::Inputs;
using test::ResultHash;

void add_test(ResultHash& hash, const accel::RayShear& shear, const std::array<V3f, 3>& p, float t_min, float t_max) {
  float t = -1.0f, u = -1.0f, v = -1.0f;
  hash.add(accel::intersect_triangle(shear, p[0], p[1], p[2], t_min, t_max, t, u, v));
  hash.add(V3f(t, u, v));
  hash.add(accel::can_be_hit(p[0], p[1], p[2]));
}

void print_triangles(const char* name, bool special, int count) {
  Inputs inputs{test::Random(1), special};
  ResultHash hash;
  for (int i = 0; i < count; ++i) {
    std::array<V3f, 3> p;
    for (V3f& corner : p) corner = inputs.any_3d(-1.0f, 1.0f);
    accel::Ray ray;
    ray.origin = inputs.any_3d(-2.0f, 2.0f);
    const float u = inputs.number(), v = inputs.number();
    const V3f target = p[0] + (p[1] - p[0]) * u + (p[2] - p[0]) * v; // half of them inside
    ray.direction = target - ray.origin;
    if (i % 7 == 0) ray.direction = inputs.any_3d(-1.0f, 1.0f);
    ray.t_min = special ? inputs.any(0.0f, 0.5f) : 0.0f;
    ray.t_max = inputs.any(0.5f, 4.0f);
    hash.add(accel::can_hit(ray));
    if (!accel::can_hit(ray)) continue; // as all accelerators do
    add_test(hash, accel::RayShear(ray.origin, ray.direction), p, ray.t_min, ray.t_max);
  }
  hash.print(name);
}

void print_transforms(const char* name, bool special, int count) {
  Inputs inputs{test::Random(2), special};
  ResultHash hash;
  for (int i = 0; i < count / 4; ++i) {
    std::array<M44f, 3> keys;
    for (M44f& key : keys)
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 3; ++column) key[row][column] = inputs.any(-2.0f, 2.0f);
    hash.add(accel::is_finite(keys));
    const M44f m = accel::matrix_at(keys, inputs.any(-0.1f, 1.1f));
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) hash.add(m[row][column]);
    const V3f a = inputs.any_3d(-1.0f, 1.0f), b = inputs.any_3d(-1.0f, 1.0f);
    hash.add(accel::between(a, b, inputs.number()));
    accel::RayToObject to_object;
    hash.add(to_object.set_inverse_of(m));
    accel::Ray ray;
    ray.origin = a;
    ray.direction = b;
    const accel::Ray inside = to_object(ray);
    hash.add(inside.origin);
    hash.add(inside.direction);
  }
  hash.print(name);
}

} // namespace

int main(int argc, char** argv) {
  const int count = test::input_count(argc, argv, 100000);
  test::print_usual_and_special("triangles", count, print_triangles);
  test::print_usual_and_special("motion", count, print_transforms);
  return 0;
}
