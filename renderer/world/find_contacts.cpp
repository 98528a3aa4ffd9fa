// Contacts of large triangles: a hierarchy over them is searched for every triangle of the scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/find_contacts.h"

#include "accel/affine.h"
#include "renderer/world/ray_origins.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <tuple>
#include <utility>

namespace kindling {
namespace {

constexpr size_t kMaxLarge = 1U << 16;             // the largest ones are chosen from more
constexpr size_t kMaxInstanceTriangles = 1U << 22; // of all instances; beyond it their bounds count
constexpr size_t kGrain = 1U << 12;
constexpr size_t kInstanceGrain = 64;
constexpr double kSmallestArea = 1e-30;

// A convex polygon: a triangle after cuts by at most seven planes.
struct Polygon {
  std::array<V3d, 12> corners;
  size_t count = 0;

  void add(const V3d& corner) {
    if (count < corners.size()) corners[count++] = corner;
  }
  // Keeps the part where height(corner), a linear function, is not negative.
  template <typename Height>
  void clip(const Height& height) {
    Polygon rest;
    for (size_t i = 0; i < count; ++i) {
      const V3d &a = corners[i], &b = corners[(i + 1) % count];
      const double ha = height(a), hb = height(b);
      if (ha >= 0.0) rest.add(a);
      if ((ha < 0.0) != (hb < 0.0)) rest.add(a + (b - a) * (ha / (ha - hb)));
    }
    *this = rest;
  }
};

// A large triangle, in world space, with the coordinates in which others are seen from it.
struct Large {
  uint32_t mesh = 0;
  uint32_t triangle = 0;
  std::array<V3d, 3> corners;
  double margin = 0.0;          // meters
  V3d normal;                   // unit
  V3d u_axis, v_axis;           // (p - corners[0]) * axis: barycentric coordinates
  std::array<double, 3> height; // of the triangle over its edges, meters

  Large(uint32_t mesh_index, uint32_t triangle_index, const std::array<V3d, 3>& p, double margin_m)
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
  [[nodiscard]] double u(const V3d& p) const { return (p - corners[0]).dot(u_axis); }
  [[nodiscard]] double v(const V3d& p) const { return (p - corners[0]).dot(v_axis); }
  [[nodiscard]] double distance(const V3d& p) const { return (p - corners[0]).dot(normal); }
  [[nodiscard]] Box3f box() const {
    Box3f box;
    for (const V3d& p : corners) box.extendBy(V3f(p));
    const V3f border(static_cast<float>(margin) * 1.01f);
    return {box.min - border, box.max + border};
  }

  // Returns the cells that `part` comes near to, away from this triangle's own edges, where hits
  // are guarded anyway.
  [[nodiscard]] uint64_t cells_near(Polygon part) const {
    part.clip([this](const V3d& p) { return margin - distance(p); });
    part.clip([this](const V3d& p) { return margin + distance(p); });
    const double inset = 0.5 * margin; // within what counts as an edge
    part.clip([&](const V3d& p) { return u(p) * height[1] - inset; });
    part.clip([&](const V3d& p) { return v(p) * height[2] - inset; });
    part.clip([&](const V3d& p) { return (1.0 - u(p) - v(p)) * height[0] - inset; });
    uint64_t cells = 0;
    if (part.count == 0) return cells;
    constexpr double kSide = 1.0 / Contacts::kCells;
    const double du = margin / height[1], dv = margin / height[2]; // as far as a guarded hit may be away
    for (uint32_t row = 0; row < Contacts::kCells; ++row) {
      Polygon strip = part;
      strip.clip([&](const V3d& p) { return v(p) - (row * kSide - dv); });
      strip.clip([&](const V3d& p) { return (row + 1) * kSide + dv - v(p); });
      double low = 2.0, high = -1.0;
      for (size_t i = 0; i < strip.count; ++i) {
        low = std::min(low, u(strip.corners[i]) - du);
        high = std::max(high, u(strip.corners[i]) + du);
      }
      for (uint32_t column = 0; column < Contacts::kCells; ++column)
        if (low <= (column + 1) * kSide && high >= column * kSide)
          cells |= uint64_t{1} << (Contacts::kCells * row + column);
    }
    return cells;
  }

  // The same for everything inside of a box: a rectangle of cells around it.
  [[nodiscard]] uint64_t cells_near(const Box3f& box) const {
    double low[3] = {1e300, 1e300, 1e300}, high[3] = {-1e300, -1e300, -1e300};
    for (int corner = 0; corner < 8; ++corner) {
      const V3d p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                  (corner & 4) ? box.max.z : box.min.z);
      const double values[3] = {distance(p), u(p), v(p)};
      for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], values[i]), high[i] = std::max(high[i], values[i]);
    }
    uint64_t cells = 0;
    if (low[0] > margin || high[0] < -margin) return cells;
    constexpr double kSide = 1.0 / Contacts::kCells;
    const double du = margin / height[1], dv = margin / height[2];
    for (uint32_t row = 0; row < Contacts::kCells; ++row)
      for (uint32_t column = 0; column < Contacts::kCells; ++column)
        if (low[1] - du <= (column + 1) * kSide && high[1] + du >= column * kSide && low[2] - dv <= (row + 1) * kSide &&
            high[2] + dv >= row * kSide)
          cells |= uint64_t{1} << (Contacts::kCells * row + column);
    return cells;
  }
};

// A balanced tree over the boxes of the large triangles, its nodes in preorder: a subtree of n
// leaves has 2 n - 1 nodes. A leaf holds one triangle.
class LargeTree {
 public:
  explicit LargeTree(const std::vector<Large>& large) : order_(large.size()), nodes_(2 * large.size()) {
    std::vector<Box3f> boxes;
    for (const Large& triangle : large) boxes.push_back(triangle.box());
    std::iota(order_.begin(), order_.end(), 0U);
    build(boxes, 0, large.size(), 0);
  }

  // Calls visit(index) for every triangle whose box overlaps `box`.
  template <typename Visit>
  void for_each_near(const Box3f& box, const Visit& visit) const {
    search(box, 0, order_.size(), 0, visit);
  }

 private:
  static size_t middle_of(size_t first, size_t end) { return first + (end - first) / 2; }

  void build(const std::vector<Box3f>& boxes, size_t first, size_t end, size_t node) {
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

  template <typename Visit>
  void search(const Box3f& box, size_t first, size_t end, size_t node, const Visit& visit) const {
    if (!nodes_[node].intersects(box)) return;
    if (end - first == 1) {
      visit(order_[first]);
      return;
    }
    const size_t middle = middle_of(first, end);
    search(box, first, middle, node + 1, visit);
    search(box, middle, end, node + 2 * (middle - first), visit);
  }

  std::vector<uint32_t> order_; // indices of triangles
  std::vector<Box3f> nodes_;
};

class ContactSearch {
 public:
  explicit ContactSearch(const ContactInput& input) : input_(input) {}

  std::unique_ptr<const Contacts> run() {
    find_group_boxes();
    find_large();
    if (large_.empty()) return nullptr;
    const LargeTree tree(large_);
    cells_ = std::vector<std::atomic<uint64_t>>(large_.size());
    size_t in_instances = 0;
    for (const WorldInstance& instance : input_.instances)
      if (!instance.identity) in_instances += triangle_count(instance);
    const bool by_bounds = in_instances > kMaxInstanceTriangles;
    for_each_instance([&](uint32_t, const WorldInstance& instance) {
      if (instance.moving || (by_bounds && !instance.identity))
        mark(bounds_of(instance), tree);
      else
        mark_triangles(instance, tree);
    });
    std::vector<Contacts::Entry> entries;
    for (size_t i = 0; i < large_.size(); ++i)
      if (cells_[i] != 0) entries.push_back({large_[i].mesh, large_[i].triangle, cells_[i]});
    if (entries.empty()) return nullptr;
    // Instances of one mesh share its cells.
    const auto id = [](const Contacts::Entry& entry) { return std::pair(entry.mesh, entry.triangle); };
    std::sort(entries.begin(), entries.end(),
              [&](const Contacts::Entry& a, const Contacts::Entry& b) { return id(a) < id(b); });
    std::vector<Contacts::Entry> joined;
    for (const Contacts::Entry& entry : entries) {
      if (!joined.empty() && id(joined.back()) == id(entry))
        joined.back().cells |= entry.cells;
      else
        joined.push_back(entry);
    }
    return std::make_unique<const Contacts>(joined);
  }

 private:
  [[nodiscard]] size_t triangle_count(const WorldInstance& instance) const {
    const accel::MeshGroup& group = input_.groups[instance.group];
    size_t count = 0;
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m)
      count += input_.geometries[m].indices.size() / 3;
    return count;
  }

  // Boxes of all groups over the shutter, in object space.
  void find_group_boxes() {
    boxes_.resize(input_.groups.size());
    tbb::parallel_for(size_t{0}, boxes_.size(), [&](size_t g) {
      const accel::MeshGroup& group = input_.groups[g];
      for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
        const Geometry& geometry = input_.geometries[m];
        const auto extend = [&](std::span<const V3f> positions) {
          for (const V3f& p : positions)
            if (is_finite(p)) boxes_[g].extendBy(p);
        };
        extend(geometry.position_span());
        for (size_t key = 0; key < geometry.later_positions.size(); ++key) extend(geometry.later_position_span(key));
      }
    });
  }

  [[nodiscard]] Box3f bounds_of(const WorldInstance& instance) const {
    const Box3f& box = boxes_[instance.group];
    if (instance.motion != accel::kNoId)
      return accel::transform_bounds(std::span<const M44f>(input_.motions[instance.motion]), box);
    return accel::transform_bounds(instance.object_to_world, box);
  }

  // Calls visit(index, instance), in parallel.
  template <typename Visit>
  void for_each_instance(const Visit& visit) const {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, input_.instances.size(), kInstanceGrain),
                      [&](const tbb::blocked_range<size_t>& range) {
                        for (size_t i = range.begin(); i != range.end(); ++i)
                          visit(static_cast<uint32_t>(i), input_.instances[i]);
                      });
  }

  static std::array<V3d, 3> corners_of(const Geometry& geometry, const WorldInstance& instance, size_t triangle) {
    std::array<V3d, 3> corners;
    for (size_t c = 0; c < 3; ++c) {
      const V3f& p = geometry.positions[geometry.indices[3 * triangle + c]];
      corners[c] = V3d(instance.identity ? p : transform_point(instance.object_to_world, p));
    }
    return corners;
  }

  // Calls visit(mesh, triangle, corners) for the triangles of a static instance, in parallel.
  template <typename Visit>
  void for_each_triangle(const WorldInstance& instance, const Visit& visit) const {
    const accel::MeshGroup& group = input_.groups[instance.group];
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
      const Geometry& geometry = input_.geometries[m];
      tbb::parallel_for(tbb::blocked_range<size_t>(0, geometry.indices.size() / 3, kGrain),
                        [&](const tbb::blocked_range<size_t>& range) {
                          for (size_t t = range.begin(); t != range.end(); ++t)
                            visit(m, static_cast<uint32_t>(t), corners_of(geometry, instance, t));
                        });
    }
  }

  // Chooses the largest triangles; of equal ones those that come first.
  void find_large() {
    struct Candidate {
      float size;
      uint32_t mesh, triangle, instance;
    };
    const float min_size = kLargeTriangle * input_.bounds.size().length();
    tbb::enumerable_thread_specific<std::vector<Candidate>> found;
    for_each_instance([&](uint32_t index, const WorldInstance& instance) {
      if (instance.moving) return;
      if (!instance.identity && !(bounds_of(instance).size().length() >= min_size)) return;
      for_each_triangle(instance, [&](uint32_t mesh, uint32_t triangle, const std::array<V3d, 3>& p) {
        const double longest2 =
            std::max((p[1] - p[0]).length2(), std::max((p[2] - p[0]).length2(), (p[2] - p[1]).length2()));
        const auto size = static_cast<float>(std::sqrt(longest2));
        if (size >= min_size && std::isfinite(size)) found.local().push_back({size, mesh, triangle, index});
      });
    });
    std::vector<Candidate> candidates;
    for (const std::vector<Candidate>& part : found) candidates.insert(candidates.end(), part.begin(), part.end());
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return std::tuple(-a.size, a.mesh, a.triangle, a.instance) < std::tuple(-b.size, b.mesh, b.triangle, b.instance);
    });
    if (candidates.size() > kMaxLarge) candidates.resize(kMaxLarge);
    for (const Candidate& chosen : candidates) {
      const Geometry& geometry = input_.geometries[chosen.mesh];
      const WorldInstance& instance = input_.instances[chosen.instance];
      const std::array<V3d, 3> p = corners_of(geometry, instance, chosen.triangle);
      large_.emplace_back(chosen.mesh, chosen.triangle, p,
                          kEdgeMargin * error_bound(geometry, instance, chosen.triangle, p));
    }
  }

  // Returns an upper bound of SurfacePoint::position_error on a triangle.
  static double error_bound(const Geometry& geometry, const WorldInstance& instance, size_t triangle,
                            const std::array<V3d, 3>& p) {
    float world = 0.0f, object = 0.0f;
    for (size_t c = 0; c < 3; ++c) {
      world = std::max(world, max_abs(V3f(p[c])));
      object = std::max(object, max_abs(geometry.positions[geometry.indices[3 * triangle + c]]));
    }
    return static_cast<double>(instance.identity ? position_bound(world)
                                                 : position_bound(instance.object_to_world, object, world));
  }

  void mark(const Box3f& box, const LargeTree& tree) {
    if (box.isEmpty()) return;
    tree.for_each_near(box,
                       [&](size_t i) { cells_[i].fetch_or(large_[i].cells_near(box), std::memory_order_relaxed); });
  }

  void mark_triangles(const WorldInstance& instance, const LargeTree& tree) {
    for_each_triangle(instance, [&](uint32_t mesh, uint32_t triangle, const std::array<V3d, 3>& p) {
      Box3f box;
      Polygon polygon;
      for (const V3d& corner : p) {
        box.extendBy(V3f(corner));
        polygon.add(corner);
      }
      tree.for_each_near(box, [&](size_t i) {
        const Large& large = large_[i];
        if (large.mesh == mesh && large.triangle == triangle && large.corners == p) return;
        const uint64_t cells = large.cells_near(polygon);
        if (cells != 0) cells_[i].fetch_or(cells, std::memory_order_relaxed);
      });
    });
  }

  const ContactInput& input_;
  std::vector<Box3f> boxes_; // by group
  std::vector<Large> large_;
  std::vector<std::atomic<uint64_t>> cells_; // by large triangle
};

} // namespace

Contacts::Contacts(const std::vector<Entry>& entries) {
  size_t size = 2;
  while (size < 2 * entries.size()) size *= 2;
  table_.resize(size);
  mask_ = size - 1;
  for (const Entry& entry : entries) {
    size_t i = slot_of(entry.mesh, entry.triangle);
    while (table_[i].mesh != accel::kNoId) i = (i + 1) & mask_;
    table_[i] = entry;
  }
}

std::unique_ptr<const Contacts> find_contacts(const ContactInput& input) { return ContactSearch(input).run(); }

} // namespace kindling
