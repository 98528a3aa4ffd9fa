// Cells of large triangles that others come near to; construction of their hierarchy.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/large_triangles.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace kindling {
namespace {

constexpr double kSmallestArea = 1e-30;
constexpr double kCellsD = Contacts::kCells;
constexpr double kBorder = 1e-9; // a point on the border of two cells counts for both

// Returns the cell of a coordinate: beyond the triangle the first or last; of NaN the first.
uint32_t cell_of(double coordinate) {
  const double scaled = coordinate * kCellsD;
  return !(scaled > 0.0) ? 0U : scaled >= kCellsD ? Contacts::kCells - 1 : static_cast<uint32_t>(scaled);
}

// Bits `first` to `last`.
uint64_t bits(uint32_t first, uint32_t last) { return (~uint64_t{0} << first) & (~uint64_t{0} >> (63U - last)); }

} // namespace

LargeTriangle::LargeTriangle(uint32_t mesh_index, uint32_t triangle_index, const std::array<V3d, 3>& p, double margin_m)
    : mesh(mesh_index), triangle(triangle_index), corners(p), margin(margin_m) {
  const V3d a = p[1] - p[0], b = p[2] - p[0], n = a.cross(b);
  const double area2 = std::max(n.length2(), kSmallestArea);
  normal = n / std::sqrt(area2);
  u_axis = b.cross(n) / area2;
  v_axis = n.cross(a) / area2;
  u_axis *= u_axis.dot(a) < 0.0 ? -1.0 : 1.0;
  v_axis *= v_axis.dot(b) < 0.0 ? -1.0 : 1.0;
  const double area = std::sqrt(area2);
  for (size_t i = 0; i < 3; ++i) height[i] = area / std::max((p[(i + 1) % 3] - p[(i + 2) % 3]).length(), 1e-30);
}

Box3f LargeTriangle::box() const {
  Box3f box;
  for (const V3d& p : corners) box.extendBy(V3f(p));
  const V3f border(static_cast<float>(margin) * 1.01f);
  return {box.min - border, box.max + border};
}

bool LargeTriangle::crosses_plane(const std::array<V3d, 3>& p) const {
  const double d0 = distance(p[0]), d1 = distance(p[1]), d2 = distance(p[2]);
  return !(std::min({d0, d1, d2}) > margin || std::max({d0, d1, d2}) < -margin);
}

bool LargeTriangle::mark_near(const std::array<V3d, 3>& p, Contacts::Rows& rows) const {
  if (!crosses_plane(p)) return false;
  Polygon part;
  for (const V3d& corner : p) part.add(corner);
  part.clip([this](const V3d& q) { return margin - distance(q); });
  part.clip([this](const V3d& q) { return margin + distance(q); });
  const double inset = 0.5 * margin; // within what counts as an edge
  part.clip([&](const V3d& q) { return u(q) * height[1] - inset; });
  part.clip([&](const V3d& q) { return v(q) * height[2] - inset; });
  part.clip([&](const V3d& q) { return (1.0 - u(q) - v(q)) * height[0] - inset; });
  if (part.count == 0) return false;
  mark_cells(part, rows);
  return true;
}

// The part of a convex polygon in a row reaches as far as those of its edges.
void LargeTriangle::mark_cells(const Polygon& part, Contacts::Rows& rows) const {
  constexpr double kSide = 1.0 / kCellsD;
  const double du = margin / height[1], dv = margin / height[2]; // as far as a guarded hit may be away
  std::array<double, Contacts::kCells> low, high;
  low.fill(2.0);
  high.fill(-1.0);
  for (size_t i = 0; i < part.count; ++i) {
    Imath::V2d a(u(part.corners[i]), v(part.corners[i]));
    const V3d& next = part.corners[(i + 1) % part.count];
    Imath::V2d b(u(next), v(next));
    if (a.y > b.y) std::swap(a, b);
    const double height_inv = b.y > a.y ? 1.0 / (b.y - a.y) : 0.0;
    const uint32_t last_row = cell_of(b.y + dv);
    for (uint32_t row = cell_of(a.y - dv - kBorder); row <= last_row; ++row) {
      const double from = (row * kSide - dv - a.y) * height_inv, to = ((row + 1) * kSide + dv - a.y) * height_inv;
      const double u_from = from > 0.0 ? a.x + (b.x - a.x) * std::min(from, 1.0) : a.x;
      const double u_to = to < 1.0 && height_inv > 0.0 ? a.x + (b.x - a.x) * std::max(to, 0.0) : b.x;
      low[row] = std::min({low[row], u_from, u_to});
      high[row] = std::max({high[row], u_from, u_to});
    }
  }
  for (size_t row = 0; row < rows.size(); ++row)
    rows[row] = low[row] <= high[row] ? bits(cell_of(low[row] - du - kBorder), cell_of(high[row] + du)) : 0;
}

bool LargeTriangle::mark_near(const Box3f& box, Contacts::Rows& rows) const {
  double low[3] = {1e300, 1e300, 1e300}, high[3] = {-1e300, -1e300, -1e300};
  for (int corner = 0; corner < 8; ++corner) {
    const V3d p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                (corner & 4) ? box.max.z : box.min.z);
    const double values[3] = {distance(p), u(p), v(p)};
    for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], values[i]), high[i] = std::max(high[i], values[i]);
  }
  if (low[0] > margin || high[0] < -margin) return false;
  const double du = margin / height[1], dv = margin / height[2];
  if (low[1] - du > 1.0 || high[1] + du < 0.0 || low[2] - dv > 1.0 || high[2] + dv < 0.0) return false;
  rows.fill(0);
  const uint64_t columns = bits(cell_of(low[1] - du), cell_of(high[1] + du));
  const uint32_t last_row = cell_of(high[2] + dv);
  for (uint32_t row = cell_of(low[2] - dv); row <= last_row; ++row) rows[row] = columns;
  return true;
}

LargeTree::LargeTree(const std::vector<LargeTriangle>& large) : order_(large.size()), nodes_(2 * large.size()) {
  std::vector<Box3f> boxes;
  boxes.reserve(large.size());
  for (const LargeTriangle& triangle : large) boxes.push_back(triangle.box());
  std::iota(order_.begin(), order_.end(), 0U);
  build(boxes, 0, large.size(), 0);
}

void LargeTree::build(const std::vector<Box3f>& boxes, size_t first, size_t end, size_t node) {
  Box3f box, centers;
  for (size_t i = first; i < end; ++i) {
    box.extendBy(boxes[order_[i]]);
    centers.extendBy(boxes[order_[i]].center());
  }
  nodes_[node] = box;
  if (end - first == 1) return;
  const unsigned axis = centers.majorAxis();
  const size_t middle = middle_of(first, end);
  const auto at = [this](size_t i) { return order_.begin() + static_cast<ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    return std::pair(boxes[a].center()[axis], a) < std::pair(boxes[b].center()[axis], b);
  });
  build(boxes, first, middle, node + 1);
  build(boxes, middle, end, node + 2 * (middle - first));
}

} // namespace kindling
