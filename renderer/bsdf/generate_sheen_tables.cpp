// Generator of sheen_tables.cpp: albedos of the sheen lobe and the fit of its sampling density.
// Run it after changes of the lobe or of the parametrization in sheen_lobe.h:
//   cmake --build BUILD --target kindling_generate_sheen_tables &&
//   BUILD/.../kindling_generate_sheen_tables > renderer/bsdf/sheen_tables.cpp
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/sheen_lobe.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

// The empty table satisfies the declaration that is a default argument of the lobe.
namespace kindling {
const SheenNode kSheenTable[kSheenRoughnessNodes * kSheenMuNodes] = {};
} // namespace kindling

namespace {

using namespace kindling;

// Midpoint quadrature over half of the hemisphere (the other half mirrors it), graded towards the
// horizon and towards the azimuth of wo, where smooth sheen concentrates.
constexpr int kRows = 320;
constexpr int kColumns = 192;
struct Point {
  V3f wi;
  double measure; // solid angle, both halves
};
std::vector<Point> make_points() {
  std::vector<Point> points;
  for (int i = 0; i < kRows; ++i) {
    const double u = (i + 0.5) / kRows;
    const double z = u * u * u;
    const double dz = 3.0 * u * u / kRows;
    const double r = std::sqrt(1.0 - z * z);
    for (int j = 0; j < kColumns; ++j) {
      const double v = (j + 0.5) / kColumns;
      const double phi = std::numbers::pi * v * v;
      const double dphi = 2.0 * std::numbers::pi * v / kColumns;
      points.push_back(
          {V3f(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)), static_cast<float>(z)),
           2.0 * dz * dphi});
    }
  }
  return points;
}

float node_roughness(uint32_t i) {
  return kMinSheenRoughness + (1.0f - kMinSheenRoughness) * static_cast<float>(i) / (kSheenRoughnessNodes - 1);
}
V3f node_view(uint32_t i) {
  // The lobe is undefined at mu = 0: the first node stands for the smallest cosine in use.
  const float mu = std::max(square(static_cast<float>(i) / (kSheenMuNodes - 1)), 1e-4f);
  return {std::sqrt(1.0f - mu * mu), 0.0f, mu};
}

using Parameters = std::array<double, 3>; // logarithms of the stretches, shear

// Returns the second moment of the weights f / p up to a factor, which the fit minimizes.
double second_moment(const std::vector<Point>& points, const std::vector<double>& values, const Parameters& p) {
  const double sx = std::exp(p[0]);
  const double sy = std::exp(p[1]);
  double sum = 0.0;
  for (size_t i = 0; i < points.size(); i += 3) { // a third of the points suffices for a fit
    if (values[i] <= 0.0) continue;
    const V3f& w = points[i].wi;
    const double x = sx * static_cast<double>(w.x) - p[2] * static_cast<double>(w.z);
    const double y = sy * static_cast<double>(w.y);
    const double z = static_cast<double>(w.z);
    const double length2 = x * x + y * y + z * z;
    const double density = sx * sy * z / (std::numbers::pi * length2 * length2);
    sum += values[i] * values[i] / density * points[i].measure;
  }
  return sum;
}

// Nelder and Mead 1965.
template <typename F>
Parameters minimize(const F& f, const Parameters& start) {
  struct Vertex {
    Parameters p;
    double value;
  };
  std::array<Vertex, 4> s;
  s[0] = {start, f(start)};
  for (size_t i = 0; i < 3; ++i) {
    Parameters p = start;
    p[i] += 0.4;
    s[i + 1] = {p, f(p)};
  }
  for (int step = 0; step < 90; ++step) {
    std::sort(s.begin(), s.end(), [](const Vertex& a, const Vertex& b) { return a.value < b.value; });
    Parameters middle{};
    for (size_t i = 0; i < 3; ++i) {
      for (size_t k = 0; k < 3; ++k) middle[k] += s[i].p[k] / 3.0;
    }
    const auto towards = [&](double t) {
      Parameters p;
      for (size_t k = 0; k < 3; ++k) p[k] = middle[k] + t * (s[3].p[k] - middle[k]);
      return Vertex{p, f(p)};
    };
    const Vertex reflected = towards(-1.0);
    if (reflected.value < s[0].value) {
      const Vertex expanded = towards(-2.0);
      s[3] = expanded.value < reflected.value ? expanded : reflected;
    } else if (reflected.value < s[2].value) {
      s[3] = reflected;
    } else {
      const Vertex contracted = towards(0.5);
      if (contracted.value < s[3].value) {
        s[3] = contracted;
      } else {
        for (size_t i = 1; i < 4; ++i) {
          for (size_t k = 0; k < 3; ++k) s[i].p[k] = 0.5 * (s[i].p[k] + s[0].p[k]);
          s[i].value = f(s[i].p);
        }
      }
    }
  }
  std::sort(s.begin(), s.end(), [](const Vertex& a, const Vertex& b) { return a.value < b.value; });
  return s[0].p;
}

// Sets the means of the greater albedo in a row whose albedos are set, as the lobe interpolates
// them.
void set_greater_albedos(SheenNode* row) {
  constexpr int kSteps = 1 << 16;
  for (uint32_t column = 0; column < kSheenMuNodes; ++column) {
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double root = (i + 0.5) / kSteps; // of mu
      const double x = root * (kSheenMuNodes - 1);
      const auto n = static_cast<uint32_t>(x);
      const double at = x - n;
      const double e = (1.0 - at) * static_cast<double>(row[n].albedo) + at * static_cast<double>(row[n + 1].albedo);
      sum += 4.0 * root * root * root * std::max(e, static_cast<double>(row[column].albedo));
    }
    row[column].greater = static_cast<float>(sum / kSteps);
  }
}

} // namespace

int main() {
  const std::vector<Point> points = make_points();
  std::vector<SheenNode> table(size_t{kSheenRoughnessNodes} * kSheenMuNodes,
                               SheenNode{0.0f, 1.0f, 0.0f, 1.0f, 1.0f, 0.0f});

  // The specification's albedo comes first, for all nodes: the lobe divides by its interpolation.
  for (uint32_t row = 0; row < kSheenRoughnessNodes; ++row) {
    for (uint32_t column = 0; column < kSheenMuNodes; ++column) {
      const SheenLobe lobe(node_roughness(row), node_view(column), table.data());
      double sum = 0.0;
      for (const Point& p : points) sum += static_cast<double>(lobe.raw_value(p.wi)) * p.measure;
      table[row * kSheenMuNodes + column].raw = static_cast<float>(sum);
    }
  }
  std::vector<double> values(points.size());
  Parameters row_start{};
  for (uint32_t row = kSheenRoughnessNodes; row-- > 0;) {
    Parameters fit = row_start;
    for (uint32_t column = kSheenMuNodes; column-- > 0;) {
      const SheenLobe lobe(node_roughness(row), node_view(column), table.data());
      double sum = 0.0;
      double greatest = 0.0;
      for (size_t i = 0; i < points.size(); ++i) {
        values[i] = static_cast<double>(lobe.eval(points[i].wi).value);
        sum += values[i] * points[i].measure;
        greatest = std::max(greatest, values[i]);
      }
      SheenNode& node = table[row * kSheenMuNodes + column];
      node.albedo = static_cast<float>(sum);
      if (sum > 1e-6) {
        for (double& v : values) v /= sum;
        fit = minimize([&](const Parameters& p) { return second_moment(points, values, p); }, fit);
      }
      node.stretch_x = static_cast<float>(std::exp(fit[0]));
      node.stretch_y = static_cast<float>(std::exp(fit[1]));
      node.shear = static_cast<float>(fit[2]);
      if (column == kSheenMuNodes - 1) row_start = fit;
      if (column % 6 == 1) {
        std::fprintf(stderr, "roughness %.3f mu %.4f E %.4f raw %.4f variance %.4f cosine %.4f\n",
                     static_cast<double>(node_roughness(row)), static_cast<double>(node_view(column).z), sum,
                     static_cast<double>(node.raw), second_moment(points, values, fit) * 3.0 - 1.0,
                     second_moment(points, values, {0.0, 0.0, 0.0}) * 3.0 - 1.0);
      }
    }
    set_greater_albedos(table.data() + row * kSheenMuNodes);
  }

  std::printf("// Albedo and sampling density of the sheen, generated by generate_sheen_tables.cpp. Do not edit.\n"
              "// SPDX-License-Identifier: Apache-2.0\n"
              "#include \"renderer/bsdf/sheen_lobe.h\"\n\n"
              "namespace kindling {\n\n"
              "// clang-format off\n"
              "// Rows of %u nodes in mu, for %u roughnesses.\n"
              "const SheenNode kSheenTable[kSheenRoughnessNodes * kSheenMuNodes] = {\n",
              kSheenMuNodes, kSheenRoughnessNodes);
  for (size_t i = 0; i < table.size(); ++i) {
    const SheenNode& n = table[i];
    std::printf("{%.6ff,%.6ff,%.6ff,%.6gf,%.6gf,%.6ff},%s", static_cast<double>(n.albedo), static_cast<double>(n.raw),
                static_cast<double>(n.greater), static_cast<double>(n.stretch_x) + 0.0,
                static_cast<double>(n.stretch_y), static_cast<double>(n.shear), i % 3 == 2 ? "\n" : " ");
  }
  std::printf("};\n// clang-format on\n\n} // namespace kindling\n");
}
