// Contacts of large triangles: a hierarchy over them is searched for every triangle of the scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/find_contacts.h"

#include "accel/affine.h"
#include "renderer/base/hash.h"
#include "renderer/world/large_triangles.h"
#include "renderer/world/ray_origins.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

namespace kindling {
namespace {

constexpr size_t kMaxLarge = 1U << 16;             // the largest ones are chosen from more
constexpr size_t kMaxInstanceTriangles = 1U << 22; // of all further instances; beyond it their bounds count
constexpr size_t kFreeEffort = 1U << 24;           // of small scenes, beside kContactEffort for each triangle
constexpr size_t kCrossingEffort = 64;             // of a triangle that crosses the plane of a large one
constexpr size_t kSamples = 256;                   // of triangles, to predict the effort
constexpr size_t kGrain = 1U << 12;
constexpr size_t kInstanceGrain = 64;

// Marked cells of large triangles. Memory is allocated for those that have any; all threads mark.
class CellMarks {
 public:
  explicit CellMarks(size_t large) : marks_(large) {}
  ~CellMarks() {
    for (std::atomic<Mark*>& mark : marks_) delete mark.load();
  }
  CellMarks(const CellMarks&) = delete;
  CellMarks& operator=(const CellMarks&) = delete;

  void add(size_t large, const Contacts::Rows& rows) {
    Mark* mark = marks_[large].load();
    if (!mark) {
      auto made = std::make_unique<Mark>();
      if (marks_[large].compare_exchange_strong(mark, made.get())) mark = made.release();
    }
    for (size_t row = 0; row < rows.size(); ++row)
      if (rows[row] != 0) (*mark)[row].fetch_or(rows[row], std::memory_order_relaxed);
  }
  // Returns true if all cells of a triangle are marked.
  [[nodiscard]] bool are_all(size_t large) const {
    const Mark* mark = marks_[large].load();
    if (!mark) return false;
    for (size_t row = 0; row < mark->size(); ++row) {
      const uint64_t inside = ~uint64_t{0} >> row; // where u + v may be at most 1
      if ((~(*mark)[row].load(std::memory_order_relaxed) & inside) != 0) return false;
    }
    return true;
  }
  // Returns the cells of a triangle; empty if none is marked.
  [[nodiscard]] std::optional<Contacts::Rows> of(size_t large) const {
    const Mark* mark = marks_[large].load();
    if (!mark) return std::nullopt;
    Contacts::Rows rows;
    for (size_t row = 0; row < rows.size(); ++row) rows[row] = (*mark)[row].load(std::memory_order_relaxed);
    return rows;
  }

 private:
  using Mark = std::array<std::atomic<uint64_t>, Contacts::kCells>;
  std::vector<std::atomic<Mark*>> marks_;
};

class ContactSearch {
 public:
  ContactSearch(const ContactInput& input, const CancelToken* cancel) : input_(input), cancel_(cancel) {}

  std::unique_ptr<const Contacts> run() {
    find_groups();
    find_large();
    if (large_.empty() || cancelled()) return nullptr;
    const LargeTree tree = limited_tree();
    CellMarks marks(large_.size());
    for_each_instance([&](size_t i, const WorldInstance& instance) {
      if (!counts_by_bounds(i))
        mark_triangles(instance, tree, marks);
      else if (!repeats_the_one_before(i))
        mark(bounds_of(instance), tree, marks);
    });
    if (cancelled()) return nullptr;
    return joined(marks);
  }

 private:
  [[nodiscard]] bool cancelled() const { return cancel_ && cancel_->cancelled(); }

  // Finds for each group its box over the shutter, in object space, its number of triangles, and
  // its first instance at rest.
  void find_groups() {
    boxes_.resize(input_.groups.size());
    counts_.resize(input_.groups.size());
    first_instances_.assign(input_.groups.size(), accel::kNoId);
    tbb::parallel_for(size_t{0}, boxes_.size(), [&](size_t g) {
      const accel::MeshGroup& group = input_.groups[g];
      for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
        const Geometry& geometry = input_.geometries[m];
        const auto extend = [&](std::span<const V3f> positions) {
          for (const V3f& p : positions)
            if (is_finite(p)) boxes_[g].extendBy(p);
        };
        extend(geometry.positions);
        for (const std::span<const V3f> key : geometry.later_positions) extend(key);
        counts_[g] += geometry.indices.size() / 3;
      }
    });
    size_t repeated = 0;
    for (size_t i = 0; i < input_.instances.size(); ++i) {
      const WorldInstance& instance = input_.instances[i];
      if (instance.moving) continue;
      if (first_instances_[instance.group] == accel::kNoId)
        first_instances_[instance.group] = static_cast<uint32_t>(i);
      else
        repeated += counts_[instance.group];
    }
    repeats_by_bounds_ = repeated > kMaxInstanceTriangles;
  }

  [[nodiscard]] bool counts_by_bounds(size_t i) const {
    const WorldInstance& instance = input_.instances[i];
    return instance.moving || (repeats_by_bounds_ && first_instances_[instance.group] != i);
  }

  [[nodiscard]] Box3f bounds_of(const WorldInstance& instance) const {
    const Box3f& box = boxes_[instance.group];
    if (instance.motion != accel::kNoId) return accel::transform_bounds(input_.motions[instance.motion], box);
    return accel::transform_bounds(instance.object_to_world, box);
  }

  // Calls visit(index, instance), in parallel.
  template <typename Visit>
  void for_each_instance(const Visit& visit) const {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, input_.instances.size(), kInstanceGrain),
                      [&](const tbb::blocked_range<size_t>& range) {
                        for (size_t i = range.begin(); i != range.end() && !cancelled(); ++i)
                          visit(i, input_.instances[i]);
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

  static Box3f box_of(const std::array<V3d, 3>& p) {
    Box3f box;
    for (const V3d& corner : p) box.extendBy(V3f(corner));
    return box;
  }

  // Calls visit(mesh, triangle, corners) for the triangles of a static instance, in parallel.
  template <typename Visit>
  void for_each_triangle(const WorldInstance& instance, const Visit& visit) const {
    const accel::MeshGroup& group = input_.groups[instance.group];
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
      const Geometry& geometry = input_.geometries[m];
      tbb::parallel_for(tbb::blocked_range<size_t>(0, geometry.indices.size() / 3, kGrain),
                        [&](const tbb::blocked_range<size_t>& range) {
                          for (size_t t = range.begin(); t != range.end() && !cancelled(); ++t)
                            visit(m, static_cast<uint32_t>(t), corners_of(geometry, instance, t));
                        });
    }
  }

  struct Candidate {
    float size;
    uint32_t mesh, triangle, instance;

    // Larger ones first; of equal ones those that come first.
    bool operator<(const Candidate& other) const {
      return std::tuple(-size, mesh, triangle, instance) <
             std::tuple(-other.size, other.mesh, other.triangle, other.instance);
    }
  };

  // Keeps the largest ones, sorted.
  static void keep_largest(std::vector<Candidate>& candidates) {
    if (candidates.size() > kMaxLarge) {
      std::nth_element(candidates.begin(), candidates.begin() + kMaxLarge, candidates.end());
      candidates.resize(kMaxLarge);
    }
  }

  // Chooses the largest triangles.
  void find_large() {
    const float min_size = kLargeTriangle * input_.bounds.size().length();
    tbb::enumerable_thread_specific<std::vector<Candidate>> found;
    for_each_instance([&](size_t index, const WorldInstance& instance) {
      if (counts_by_bounds(index)) return;
      if (!instance.identity && !(bounds_of(instance).size().length() >= min_size)) return;
      for_each_triangle(instance, [&](uint32_t mesh, uint32_t triangle, const std::array<V3d, 3>& p) {
        const double longest2 =
            std::max((p[1] - p[0]).length2(), std::max((p[2] - p[0]).length2(), (p[2] - p[1]).length2()));
        const auto size = static_cast<float>(std::sqrt(longest2));
        if (!(size >= min_size) || !std::isfinite(size)) return;
        std::vector<Candidate>& candidates = found.local();
        candidates.push_back({size, mesh, triangle, static_cast<uint32_t>(index)});
        if (candidates.size() >= 2 * kMaxLarge) keep_largest(candidates);
      });
    });
    std::vector<Candidate> candidates;
    for (const std::vector<Candidate>& part : found) candidates.insert(candidates.end(), part.begin(), part.end());
    keep_largest(candidates);
    std::sort(candidates.begin(), candidates.end());
    large_.reserve(candidates.size());
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

  // True for one of many instances in one place, which have the same bounds.
  [[nodiscard]] bool repeats_the_one_before(size_t i) const {
    if (i == 0) return false;
    const WorldInstance &instance = input_.instances[i], &before = input_.instances[i - 1];
    return !instance.moving && !before.moving && instance.group == before.group &&
           instance.object_to_world == before.object_to_world;
  }

  // What the tree is searched for: a triangle, or the bounds of an instance.
  struct Searched {
    Box3f box;
    std::optional<std::array<V3d, 3>> corners;
  };

  [[nodiscard]] size_t searches_of(size_t i) const {
    return counts_by_bounds(i) ? 1 : counts_[input_.instances[i].group];
  }
  [[nodiscard]] Searched searched(size_t i, size_t triangle) const {
    const WorldInstance& instance = input_.instances[i];
    if (counts_by_bounds(i)) return {bounds_of(instance), std::nullopt};
    uint32_t m = input_.groups[instance.group].first_mesh;
    for (; triangle >= input_.geometries[m].indices.size() / 3; ++m)
      triangle -= input_.geometries[m].indices.size() / 3;
    const std::array<V3d, 3> corners = corners_of(input_.geometries[m], instance, triangle);
    return {box_of(corners), corners};
  }

  // Returns evenly chosen searches of `total`.
  [[nodiscard]] std::vector<Searched> sample_searches(size_t total) const {
    const size_t stride = total / kSamples + 1;
    std::vector<Searched> samples;
    const auto next = [&] {
      return samples.size() * stride + hash_u32(static_cast<uint32_t>(samples.size())) % stride;
    };
    size_t before = 0;
    for (size_t i = 0; i < input_.instances.size(); ++i) {
      const size_t end = before + searches_of(i);
      while (next() < end) samples.push_back(searched(i, next() - before));
      before = end;
    }
    return samples;
  }

  // Returns the tree over as many of the large triangles as the effort allows.
  [[nodiscard]] LargeTree limited_tree() {
    size_t total = 0;
    for (size_t i = 0; i < input_.instances.size(); ++i) total += searches_of(i);
    const std::vector<Searched> samples = sample_searches(total);
    const size_t allowed = kFreeEffort + kContactEffort * total;
    for (;;) {
      LargeTree tree(large_);
      std::atomic<size_t> effort{0};
      tbb::parallel_for(size_t{0}, samples.size(), [&](size_t i) {
        const Searched& sample = samples[i];
        size_t found = 0;
        if (sample.box.isEmpty() || cancelled()) return;
        tree.for_each_near(sample.box, [&](size_t l) {
          found += !sample.corners || large_[l].crosses_plane(*sample.corners) ? kCrossingEffort : 1;
        });
        effort += found;
      });
      const size_t predicted = effort / std::max<size_t>(samples.size(), 1) * total;
      if (predicted <= allowed || large_.size() == 1 || cancelled()) return tree;
      large_.erase(large_.begin() + static_cast<ptrdiff_t>(large_.size() / 2), large_.end());
    }
  }

  void mark(const Box3f& box, const LargeTree& tree, CellMarks& marks) const {
    if (box.isEmpty()) return;
    Contacts::Rows rows;
    tree.for_each_near(box, [&](size_t i) {
      if (!marks.are_all(i) && large_[i].mark_near(box, rows)) marks.add(i, rows);
    });
  }

  void mark_triangles(const WorldInstance& instance, const LargeTree& tree, CellMarks& marks) const {
    for_each_triangle(instance, [&](uint32_t mesh, uint32_t triangle, const std::array<V3d, 3>& p) {
      Contacts::Rows rows;
      tree.for_each_near(box_of(p), [&](size_t i) {
        const LargeTriangle& large = large_[i];
        if (large.mesh == mesh && large.triangle == triangle && large.corners == p) return;
        if (!marks.are_all(i) && large.mark_near(p, rows)) marks.add(i, rows);
      });
    });
  }

  // Instances of one mesh share its cells.
  [[nodiscard]] std::unique_ptr<const Contacts> joined(const CellMarks& marks) const {
    struct Touched {
      uint32_t mesh, triangle;
      Contacts::Rows rows;
    };
    std::vector<Touched> touched;
    for (size_t i = 0; i < large_.size(); ++i)
      if (const auto rows = marks.of(i)) touched.push_back({large_[i].mesh, large_[i].triangle, *rows});
    if (touched.empty()) return nullptr;
    const auto id = [](const Touched& of) { return std::pair(of.mesh, of.triangle); };
    std::sort(touched.begin(), touched.end(), [&](const Touched& a, const Touched& b) { return id(a) < id(b); });
    std::vector<Contacts::Marked> marked;
    size_t last = 0;
    for (size_t i = 0; i < touched.size(); ++i) {
      if (!marked.empty() && id(touched[last]) == id(touched[i])) {
        for (size_t row = 0; row < Contacts::kCells; ++row) touched[last].rows[row] |= touched[i].rows[row];
        continue;
      }
      marked.push_back({touched[i].mesh, touched[i].triangle, &touched[i].rows});
      last = i;
    }
    return std::make_unique<const Contacts>(marked);
  }

  const ContactInput& input_;
  const CancelToken* cancel_;
  std::vector<Box3f> boxes_;              // by group
  std::vector<size_t> counts_;            // of triangles, by group
  std::vector<uint32_t> first_instances_; // by group, at rest
  bool repeats_by_bounds_ = false;        // further instances of a group count by their bounds
  std::vector<LargeTriangle> large_;
};

} // namespace

Contacts::Contacts(std::span<const Marked> marked) {
  size_t size = 2;
  while (size < 2 * marked.size()) size *= 2;
  std::vector<Entry> entries(size);
  std::vector<uint64_t> words;
  for (const Marked& triangle : marked) {
    size_t i = slot_of(triangle.mesh, triangle.triangle) & (size - 1);
    while (entries[i].mesh != accel::kNoId) i = (i + 1) & (size - 1);
    Entry& entry = entries[i];
    entry = {triangle.mesh, triangle.triangle, 0, words.size()};
    for (uint32_t row = 0; row < kCells; ++row) {
      if ((*triangle.rows)[row] == 0) continue;
      entry.rows |= uint64_t{1} << row;
      words.push_back((*triangle.rows)[row]);
    }
  }
  table = arrays_.keep(std::move(entries));
  rows = arrays_.keep(std::move(words));
}

std::unique_ptr<const Contacts> find_contacts(const ContactInput& input, const CancelToken* cancel) {
  return ContactSearch(input, cancel).run();
}

} // namespace kindling
