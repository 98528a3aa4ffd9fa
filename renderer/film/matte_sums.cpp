// Terms of pixels in linked lists over a growing pool, and their ranks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/matte_sums.h"

#include <tbb/concurrent_vector.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <new>
#include <utility>

namespace kindling {

// Elements keep their addresses while other threads add some.
struct MatteSums::Pool {
  tbb::concurrent_vector<Link> links;
};

MatteSums::MatteSums() = default;
MatteSums::MatteSums(size_t pixels) : first_(pixels), pool_(std::make_unique<Pool>()) {}
MatteSums::MatteSums(const MatteSums& other)
    : first_(other.first_), pool_(other.pool_ ? std::make_unique<Pool>(*other.pool_) : nullptr) {}
MatteSums::MatteSums(MatteSums&&) noexcept = default;
MatteSums& MatteSums::operator=(MatteSums other) noexcept {
  first_ = std::move(other.first_);
  pool_ = std::move(other.pool_);
  return *this;
}
MatteSums::~MatteSums() = default;

FilmUnitSum& MatteSums::term(size_t pixel, const MatteIds& ids) {
  Link* link = &first_[pixel];
  if (link->ids.none()) link->ids = ids;
  for (;;) {
    if (link->ids == ids) return link->weight;
    if (link->next == 0) break;
    link = &pool_->links[link->next - 1];
  }
  const auto added = pool_->links.push_back(Link{.ids = ids});
  const auto place = static_cast<uint64_t>(added - pool_->links.begin()) + 1;
  if (place > std::numeric_limits<uint32_t>::max()) throw std::bad_alloc();
  link->next = static_cast<uint32_t>(place);
  return added->weight;
}

void MatteSums::add(size_t pixel, const MatteIds& ids, float weight) {
  assert(!ids.none());
  term(pixel, ids).add(static_cast<double>(weight));
}

void MatteSums::add(size_t pixel, const MatteSums& other, size_t other_pixel) {
  for (const Link* link = &other.first_[other_pixel]; !link->ids.none(); link = &other.pool_->links[link->next - 1]) {
    term(pixel, link->ids).add(link->weight);
    if (link->next == 0) return;
  }
}

void MatteSums::list(size_t pixel, std::vector<MatteTerm>& terms) const {
  terms.clear();
  for (const Link* link = &first_[pixel]; !link->ids.none(); link = &pool_->links[link->next - 1]) {
    terms.push_back({link->ids, 0, link->weight});
    if (link->next == 0) break;
  }
  std::ranges::sort(terms, {}, &MatteTerm::ids);
}

size_t MatteSums::memory_bytes() const { return (first_.size() + (pool_ ? pool_->links.size() : 0)) * sizeof(Link); }

FlatMattes MatteSums::flat() const {
  FlatMattes flat;
  flat.counts.reserve(first_.size());
  if (pool_) flat.terms.reserve(first_.size() + pool_->links.size());
  std::vector<MatteTerm> terms;
  for (size_t pixel = 0; pixel < first_.size(); ++pixel) {
    list(pixel, terms);
    flat.counts.push_back(static_cast<uint32_t>(terms.size()));
    flat.terms.insert(flat.terms.end(), terms.begin(), terms.end());
  }
  return flat;
}

void MatteSums::set(const FlatMattes& flat) {
  *this = MatteSums(first_.size());
  std::span<const MatteTerm> rest = flat.terms;
  for (size_t pixel = 0; pixel < std::min(flat.counts.size(), first_.size()); ++pixel) {
    const size_t count = std::min<size_t>(flat.counts[pixel], rest.size());
    for (const MatteTerm& known : rest.first(count))
      if (!known.ids.none()) term(pixel, known.ids).add(known.weight);
    rest = rest.subspan(count);
  }
}

namespace {

struct Coverage {
  uint32_t id = 0;
  double value = 0.0;
};

} // namespace

void rank_mattes(std::span<const MatteTerm> terms, Matte matte, double divisor, std::span<float> ranks) {
  std::ranges::fill(ranks, 0.0f);
  if (terms.empty()) return;
  // Exact sums by id: several combinations may have the same.
  std::vector<std::pair<uint32_t, FilmUnitSum>> sums;
  for (const MatteTerm& term : terms) {
    const uint32_t id = term.ids.of(matte);
    const auto known = std::ranges::find(sums, id, &std::pair<uint32_t, FilmUnitSum>::first);
    if (known == sums.end())
      sums.emplace_back(id, term.weight);
    else
      known->second.add(term.weight);
  }
  std::vector<Coverage> covered;
  double total = 0.0, positive = 0.0;
  std::ranges::sort(sums, {}, &std::pair<uint32_t, FilmUnitSum>::first); // so that totals are rounded alike
  for (const auto& [id, sum] : sums) {
    const double value = sum.value() / divisor;
    total += value;
    if (value <= 0.0) continue;
    positive += value;
    covered.push_back({id, value});
  }
  const double wanted = std::clamp(total, 0.0, 1.0);
  if (wanted == 0.0) return;
  if (wanted != positive)
    for (Coverage& coverage : covered) coverage.value *= wanted / positive;
  std::ranges::stable_sort(covered, std::greater{}, &Coverage::value);
  for (size_t i = 0; i < std::min(covered.size(), ranks.size() / 2); ++i) {
    ranks[2 * i] = std::bit_cast<float>(covered[i].id);
    ranks[2 * i + 1] = static_cast<float>(covered[i].value);
  }
}

} // namespace kindling
