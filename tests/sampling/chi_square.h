// Pearson's chi-square test of two-dimensional sampling routines against their densities.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/sampling/random.h"

#include "renderer/base/math.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kindling::test {

struct Rect {
  double x0, x1, y0, y1;
};

struct ChiSquareOptions {
  uint64_t seed = 1;
  int pilot_samples = 16384; // number of samples that determine the bins
  int samples = 200000;      // number of samples that are counted
  int bins = 256;
  // Bins narrower than this are not split, because directions in single precision have too few
  // values there for exact counts.
  double min_extent = 1e-5;
  // Peak of a narrow lobe on top of a wide one, in the coordinates of the test (stereographic for a
  // hemisphere).
  std::optional<std::array<double, 2>> peak;
  // The routine may return nothing, with probability 1 minus the integral of the density.
  bool may_be_absorbed = false;
};

struct ChiSquareResult {
  double p_value = 0.0;  // of the counts, given the density
  double integral = 0.0; // of the density over the domain
  double absorbed = 0.0; // fraction of draws that returned nothing
  std::string summary;   // message for a failure
};

// Returns the level of each of `checks` tests for which at least one of them fails by chance with
// probability `level` (Sidak 1967).
inline double sidak_level(double level, int checks) { return 1.0 - std::pow(1.0 - level, 1.0 / checks); }

// Returns the upper tail of the chi-square distribution: the regularized incomplete gamma function
// Q(dof / 2, x / 2), by its series below the mean and its continued fraction (modified Lentz)
// above.
inline double chi_square_tail(double x, int dof) {
  const double a = 0.5 * dof;
  const double h = 0.5 * x;
  if (h <= 0.0) return 1.0;
  const double front = std::exp(a * std::log(h) - h - std::lgamma(a));
  if (h < a + 1.0) {
    double term = 1.0 / a;
    double sum = term;
    for (int n = 1; n < 100000 && term > sum * 1e-15; ++n) {
      term *= h / (a + n);
      sum += term;
    }
    return 1.0 - front * sum;
  }
  double b = h + 1.0 - a;
  double c = 1e300;
  double d = 1.0 / b;
  double f = d;
  for (int n = 1; n < 100000; ++n) {
    const double k = n * (a - n);
    b += 2.0;
    d = 1.0 / (k * d + b);
    c = b + k / c;
    const double change = c * d;
    f *= change;
    if (std::abs(change - 1.0) < 1e-15) break;
  }
  return front * f;
}

namespace detail {

// Tensor product of 3-point Gauss-Legendre rules.
template <typename Density>
double gauss_3x3(const Rect& r, const Density& density) {
  constexpr std::array<double, 3> kNodes = {-0.7745966692414834, 0.0, 0.7745966692414834};
  constexpr std::array<double, 3> kWeights = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  const double hx = 0.5 * (r.x1 - r.x0);
  const double hy = 0.5 * (r.y1 - r.y0);
  double sum = 0.0;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      sum += kWeights[i] * kWeights[j] * density(r.x0 + hx * (1.0 + kNodes[i]), r.y0 + hy * (1.0 + kNodes[j]));
    }
  }
  return sum * hx * hy;
}

template <typename Density>
double integrate(const Rect& r, const Density& density, double estimate, double tolerance, int depth) {
  const double mx = 0.5 * (r.x0 + r.x1);
  const double my = 0.5 * (r.y0 + r.y1);
  const std::array<Rect, 4> parts = {
      Rect{r.x0, mx, r.y0, my}, {mx, r.x1, r.y0, my}, {r.x0, mx, my, r.y1}, {mx, r.x1, my, r.y1}};
  std::array<double, 4> values;
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) sum += values[i] = gauss_3x3(parts[i], density);
  if (depth >= 10 || (depth >= 1 && std::abs(sum - estimate) <= tolerance)) return sum;
  sum = 0.0;
  for (int i = 0; i < 4; ++i) sum += integrate(parts[i], density, values[i], 0.5 * tolerance, depth + 1);
  return sum;
}

// Returns borders from x0 to x1 that include those of the core; the distance to the core triples
// with each step, which resolves a density that falls off around the core.
inline std::vector<double> graded(double x0, double core0, double core1, double x1) {
  std::vector<double> borders;
  const double unit = std::max(core1 - core0, 1e-7);
  std::vector<double> left;
  for (double step = 0.0; core0 - step > x0; step = step == 0.0 ? unit : 3.0 * step) left.push_back(core0 - step);
  borders.push_back(x0);
  borders.insert(borders.end(), left.rbegin(), left.rend());
  for (double step = 0.0; core1 + step < x1; step = step == 0.0 ? unit : 3.0 * step) borders.push_back(core1 + step);
  borders.push_back(x1);
  return borders;
}

// Adds borders around a peak, at distances that triple with each step.
inline void add_peak(std::vector<double>& borders, double peak) {
  const double x0 = borders.front();
  const double x1 = borders.back();
  for (double step = 1e-5; step < 0.1; step *= 3.0) {
    for (const double x : {peak - step, peak + step}) {
      if (x > x0 && x < x1) borders.push_back(x);
    }
  }
  std::sort(borders.begin(), borders.end());
}

using Point = std::array<double, 2>;

struct BinNode {
  Rect rect;
  int axis = -1; // -1: leaf
  double split = 0.0;
  int children[2] = {0, 0};
  int bin = -1;
};

// Bins of about equal probability, made by splitting at the median of the pilot samples along the
// axis of their wider spread.
class AdaptiveBins {
 public:
  AdaptiveBins(const Rect& domain, std::vector<Point> pilot, int bins, double min_extent) {
    nodes_.push_back({domain});
    bin_size_ = std::max<size_t>(pilot.size() / static_cast<size_t>(bins), 4);
    min_extent_ = min_extent;
    split(0, pilot, 0, pilot.size(), -1);
  }
  [[nodiscard]] int find(const Point& p) const {
    int n = 0;
    while (nodes_[n].bin < 0) n = nodes_[n].children[p[nodes_[n].axis] >= nodes_[n].split ? 1 : 0];
    return nodes_[n].bin;
  }
  [[nodiscard]] size_t bin_count() const { return bin_count_; }

  // For quadrature, bins are split further into cells of a few pilot samples each, in which the
  // density varies little. The core is the part of a cell around its samples, so that a lobe in the
  // corner of a large cell is not missed.
  struct Cell {
    Rect all;
    Rect core;
    size_t bin;
  };
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }

 private:
  template <typename Iterator>
  static Rect core(const Rect& all, Iterator first, Iterator last) {
    if (first == last) return all;
    Rect box = {1e300, -1e300, 1e300, -1e300};
    for (auto p = first; p != last; ++p) {
      box = {std::min(box.x0, (*p)[0]), std::max(box.x1, (*p)[0]), std::min(box.y0, (*p)[1]),
             std::max(box.y1, (*p)[1])};
    }
    const double mx = 0.3 * (box.x1 - box.x0);
    const double my = 0.3 * (box.y1 - box.y0);
    return {std::max(box.x0 - mx, all.x0), std::min(box.x1 + mx, all.x1), std::max(box.y0 - my, all.y0),
            std::min(box.y1 + my, all.y1)};
  }

  // Returns the axis of the wider spread between the quartiles; -1 if there are fewer than
  // min_points or neither axis spreads by min_extent.
  template <typename Iterator>
  static int wider_axis(Iterator first, Iterator last, size_t n, size_t min_points, double min_extent) {
    if (n < min_points) return -1;
    int axis = -1;
    double widest = min_extent;
    for (size_t a = 0; a < 2; ++a) {
      const auto below = [a](const Point& p, const Point& q) { return p[a] < q[a]; };
      const auto quarter = first + static_cast<ptrdiff_t>(n / 4);
      const auto three_quarters = first + static_cast<ptrdiff_t>(3 * n / 4);
      std::nth_element(first, quarter, last, below);
      const double low = (*quarter)[a];
      std::nth_element(first, three_quarters, last, below);
      const double spread = (*three_quarters)[a] - low;
      if (spread > widest) {
        widest = spread;
        axis = static_cast<int>(a);
      }
    }
    return axis;
  }

  // Splits a node; `bin` is the bin that contains it, or -1 above the level of bins.
  void split(int node, std::vector<Point>& points, size_t begin, size_t end, int bin) {
    constexpr size_t kCellSize = 8;
    const auto first = points.begin() + static_cast<ptrdiff_t>(begin);
    const auto last = points.begin() + static_cast<ptrdiff_t>(end);
    const size_t n = end - begin;
    int axis = wider_axis(first, last, n, 2 * bin_size_, min_extent_);
    if (bin < 0 && axis < 0) bin = nodes_[node].bin = static_cast<int>(bin_count_++);
    if (bin >= 0) axis = wider_axis(first, last, n, 2 * kCellSize, 1e-9);
    if (axis < 0) {
      cells_.push_back({nodes_[node].rect, core(nodes_[node].rect, first, last), static_cast<size_t>(bin)});
      return;
    }
    const auto middle = first + static_cast<ptrdiff_t>(n / 2);
    std::nth_element(first, middle, last, [axis](const Point& p, const Point& q) { return p[axis] < q[axis]; });
    const double at = (*middle)[axis];
    Rect left = nodes_[node].rect;
    Rect right = left;
    (axis == 0 ? left.x1 : left.y1) = at;
    (axis == 0 ? right.x0 : right.y0) = at;
    const int child = static_cast<int>(nodes_.size());
    nodes_.push_back({left});
    nodes_.push_back({right});
    nodes_[node].axis = axis;
    nodes_[node].split = at;
    nodes_[node].children[0] = child;
    nodes_[node].children[1] = child + 1;
    split(child, points, begin, begin + n / 2, bin);
    split(child + 1, points, begin + n / 2, end, bin);
  }

  std::vector<BinNode> nodes_;
  std::vector<Cell> cells_;
  size_t bin_count_ = 0;
  size_t bin_size_ = 0;
  double min_extent_ = 0.0;
};

} // namespace detail

// Tests draw(Random&) -> std::optional<std::array<double, 2>>, a point of the domain, against
// density(x, y), per unit of x times unit of y. Bins are built from separate samples; expected
// counts come from adaptive quadrature; bins that expect fewer than 8 samples are pooled.
template <typename Draw, typename Density>
ChiSquareResult chi_square_test(const Rect& domain, const Draw& draw, const Density& density,
                                const ChiSquareOptions& options) {
  Random random(options.seed);
  std::vector<detail::Point> pilot;
  for (int i = 0; i < options.pilot_samples; ++i) {
    if (const auto p = draw(random)) pilot.push_back(*p);
  }
  const detail::AdaptiveBins bins(domain, pilot, options.bins, options.min_extent);

  struct Bin {
    double expected;
    double observed;
  };
  ChiSquareResult result;
  std::vector<Bin> counted;
  const double noise =
      std::sqrt(1.0 / (static_cast<double>(options.samples) * static_cast<double>(bins.cells().size())));
  counted.resize(bins.bin_count(), {0.0, 0.0});
  for (const auto& [all, core, bin] : bins.cells()) {
    std::vector<double> xs = detail::graded(all.x0, core.x0, core.x1, all.x1);
    std::vector<double> ys = detail::graded(all.y0, core.y0, core.y1, all.y1);
    if (options.peak) {
      detail::add_peak(xs, (*options.peak)[0]);
      detail::add_peak(ys, (*options.peak)[1]);
    }
    double mass = 0.0;
    for (size_t i = 0; i + 1 < xs.size(); ++i) {
      for (size_t j = 0; j + 1 < ys.size(); ++j) {
        const Rect part = {xs[i], xs[i + 1], ys[j], ys[j + 1]};
        mass += detail::integrate(part, density, detail::gauss_3x3(part, density), 0.02 * noise, 0);
      }
    }
    result.integral += mass;
    counted[bin].expected += mass * options.samples;
  }
  double absorbed = 0.0;
  for (int i = 0; i < options.samples; ++i) {
    if (const auto p = draw(random)) {
      counted[static_cast<size_t>(bins.find(*p))].observed += 1.0;
    } else {
      absorbed += 1.0;
    }
  }
  result.absorbed = absorbed / options.samples;
  if (options.may_be_absorbed) {
    counted.push_back({std::max(1.0 - result.integral, 0.0) * options.samples, absorbed});
  } else if (absorbed > 0.0) {
    result.summary = "draws were absorbed";
    return result;
  }

  std::sort(counted.begin(), counted.end(), [](const Bin& a, const Bin& b) { return a.expected < b.expected; });
  double statistic = 0.0;
  int cells = 0;
  Bin pool{0.0, 0.0};
  const auto close = [&](const Bin& b) {
    statistic += (b.observed - b.expected) * (b.observed - b.expected) / b.expected;
    ++cells;
  };
  for (const Bin& b : counted) {
    if (b.expected >= 8.0 && pool.expected == 0.0 && pool.observed == 0.0) {
      close(b);
      continue;
    }
    pool.expected += b.expected;
    pool.observed += b.observed;
    if (pool.expected >= 8.0) {
      close(pool);
      pool = {0.0, 0.0};
    }
  }
  // The rest of the pool has a tiny expectation; a single sample where the density is zero is a
  // failure.
  if (pool.expected > 0.0 || pool.observed > 0.0) close({std::max(pool.expected, 1e-3), pool.observed});
  const int dof = std::max(cells - 1, 1);
  result.p_value = chi_square_tail(statistic, dof);
  result.summary = "seed " + std::to_string(options.seed) + ", chi-square " + std::to_string(statistic) + " with " +
                   std::to_string(dof) + " degrees of freedom, p " + std::to_string(result.p_value) +
                   ", integral of the density " + std::to_string(result.integral) + ", absorbed " +
                   std::to_string(result.absorbed);
  return result;
}

// Tests directions of the hemisphere around +z, in the stereographic plane: the projection is
// conformal, so a narrow lobe stays round at any place. draw(Random&) -> std::optional<V3f>;
// density(V3f) is by solid angle and called above the horizon only.
template <typename Draw, typename Density>
ChiSquareResult chi_square_hemisphere(const Draw& draw, const Density& density, const ChiSquareOptions& options) {
  const auto draw_plane = [&](Random& random) -> std::optional<detail::Point> {
    const std::optional<V3f> w = draw(random);
    if (!w) return std::nullopt;
    const double scale = 1.0 / (1.0 + static_cast<double>(w->z));
    return detail::Point{static_cast<double>(w->x) * scale, static_cast<double>(w->y) * scale};
  };
  const auto density_plane = [&](double x, double y) {
    const double r2 = x * x + y * y;
    if (r2 >= 1.0) return 0.0;
    const double scale = 2.0 / (1.0 + r2);
    const V3f w(static_cast<float>(x * scale), static_cast<float>(y * scale),
                static_cast<float>((1.0 - r2) / (1.0 + r2)));
    return static_cast<double>(density(w)) * scale * scale;
  };
  return chi_square_test({-1.0, 1.0, -1.0, 1.0}, draw_plane, density_plane, options);
}

// Tests directions of the whole sphere, by z and azimuth.
template <typename Draw, typename Density>
ChiSquareResult chi_square_sphere(const Draw& draw, const Density& density, const ChiSquareOptions& options) {
  constexpr double kPiDouble = std::numbers::pi;
  const auto draw_plane = [&](Random& random) -> std::optional<detail::Point> {
    const std::optional<V3f> w = draw(random);
    if (!w) return std::nullopt;
    return detail::Point{static_cast<double>(w->z), std::atan2(static_cast<double>(w->y), static_cast<double>(w->x))};
  };
  const auto density_plane = [&](double z, double phi) {
    const double r = std::sqrt(std::max(1.0 - z * z, 0.0));
    return static_cast<double>(density(
        V3f(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)), static_cast<float>(z))));
  };
  return chi_square_test({-1.0, 1.0, -kPiDouble, kPiDouble}, draw_plane, density_plane, options);
}

} // namespace kindling::test
