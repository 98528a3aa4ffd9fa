// Copies the arrays of a kd-tree's view, and answers rays from the copy.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/compact_copy.h"

#include "accel/kdtree/compact/queries.h"
#include "accel/kdtree/kdtree_accelerator.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace kindling::accel::testing {
namespace {

// The filter of the structure as an object.
struct FilterCall {
  const HitFilter& filter;

  bool operator()(const Ray& ray, const Hit& candidate) const {
    return filter.accept == nullptr || filter.accept(filter.context, ray, candidate);
  }
};

class CompactAccelerator final : public Accelerator {
 public:
  explicit CompactAccelerator(std::unique_ptr<Accelerator> kdtree) : kdtree_(std::move(kdtree)), queries_(*kdtree_) {}

  [[nodiscard]] Hit intersect(const Ray& ray) const override { return queries_.intersect(ray); }
  [[nodiscard]] bool occluded(const Ray& ray) const override { return queries_.occluded(ray); }
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    std::transform(rays.begin(), rays.end(), hits.begin(), [&](const Ray& ray) { return intersect(ray); });
  }
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    std::transform(rays.begin(), rays.end(), blocked.begin(),
                   [&](const Ray& ray) { return static_cast<uint8_t>(occluded(ray) ? 1 : 0); });
  }
  [[nodiscard]] Imath::Box3f bounds() const override { return kdtree_->bounds(); }
  [[nodiscard]] Statistics statistics() const override { return kdtree_->statistics(); }

 private:
  std::unique_ptr<Accelerator> kdtree_;
  CompactCopy queries_;
};

} // namespace

template <class T>
void CompactCopy::copy(std::span<const T>& array) {
  if (array.empty()) {
    array = {};
    return;
  }
  constexpr size_t kAlignment = 64;
  static_assert(alignof(T) <= kAlignment);
  const size_t size = array.size_bytes() + kAlignment;
  Block& block = blocks_.emplace_back(Block{std::make_unique<std::byte[]>(size), size});
  void* place = block.bytes.get();
  size_t space = size;
  place = std::align(kAlignment, array.size_bytes(), place, space);
  std::memcpy(place, array.data(), array.size_bytes());
  array = {static_cast<const T*>(place), array.size()};
}

CompactCopy::CompactCopy(const Accelerator& accelerator) {
  const auto tables = view_of(accelerator);
  if (tables == nullptr) throw std::invalid_argument("the accelerator is no kd-tree");
  view_ = tables->view();
  filter_ = tables->filter();
  const auto copy_array = [&](auto& array) { copy(array); };
  std::vector<kd::TreeView> trees(view_.trees.begin(), view_.trees.end());
  for (kd::TreeView& tree : trees) for_each_array(tree, copy_array);
  view_.trees = trees;
  for_each_array(view_, copy_array);
}

Hit CompactCopy::intersect(const Ray& ray) const { return kd::compact::intersect(view_, ray, FilterCall{filter_}); }

bool CompactCopy::occluded(const Ray& ray) const { return kd::compact::occluded(view_, ray, FilterCall{filter_}); }

bool CompactCopy::contains(const void* address) const {
  const auto* byte = static_cast<const std::byte*>(address);
  return std::any_of(blocks_.begin(), blocks_.end(), [&](const Block& block) {
    return byte >= block.bytes.get() && byte < block.bytes.get() + block.size;
  });
}

std::unique_ptr<Accelerator> with_compact_queries(std::unique_ptr<Accelerator> kdtree) {
  return std::make_unique<CompactAccelerator>(std::move(kdtree));
}

} // namespace kindling::accel::testing
