// Finds openings through which light comes: rectangles where it is less spread than at its origin.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/learn_guide.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <tuple>
#include <utility>

namespace kindling {
namespace {

constexpr size_t kMinCrossings = 64;    // of an opening
constexpr size_t kMaxSearched = 4096;   // records that are searched
constexpr size_t kPlanes = 32;          // that are tried across an axis
constexpr int kRefinements = 2;         // of the best one: planes between its neighbors
constexpr int kRefinedPlanes = 16;      // of each
constexpr size_t kSorted = 256;         // targets of which a rectangle is found
constexpr double kMainShare = 0.7;      // of the moment of an opening is in the shortest such interval;
constexpr float kMore = 0.25f;          // the rest is at most this part of it farther, if it is evenly spread
constexpr int kCells = 16;              // across a rectangle, in each direction
constexpr float kMinCosine = 0.2f;      // between a direction and the normal of an opening
constexpr float kMinAreaCosine = 0.05f; // bounds the area that a grazing direction covers
constexpr double kMaxSpread = 0.7;      // of an opening's crossings, relative to that of the hits
constexpr float kEnds = 1e-3f;          // crossings are farther from both ends of a segment, relative to it

// A plane across an axis, crossed along the axis (side 0) or against it (1).
struct Plane {
  int axis = 0;
  uint32_t side = 0;
  float at = 0.0f;
  [[nodiscard]] uint32_t facing() const { return 2 * static_cast<uint32_t>(axis) + 1 - side; }
};

// A place on a surface or plane towards which a record's direction leads.
struct Target {
  V3f at;
  uint32_t facing = 0;
  const GuideRecord* record = nullptr;
  float solid_angle = 0.0f; // of a unit area there, seen from the record's position
};

Target target_of(const GuideRecord& record, const V3f& at, uint32_t facing) {
  const V3f way = at - record.position;
  const float length2 = way.length2();
  const float cosine = std::fabs(way[static_cast<int>(facing / 2)]) / std::sqrt(length2);
  return {at, facing, &record, std::max(cosine, kMinAreaCosine) / length2};
}

// Returns where the segment from the position to the hit crosses the plane, as a fraction of it; at
// most 0 if it does not.
float crossing(const GuideRecord& record, const Plane& plane) {
  const float from = record.position[plane.axis], way = record.hit[plane.axis] - from;
  if ((way > 0.0f) != (plane.side == 0)) return 0.0f;
  if (!(std::fabs(way) > kMinCosine * (record.hit - record.position).length())) return 0.0f;
  const float t = (plane.at - from) / way;
  return t > kEnds && t < 1.0f - kEnds ? t : 0.0f;
}

// A rectangle across an axis, in the two axes that follow it.
struct Rectangle {
  std::array<float, 2> low{}, high{};
};

float coordinate(const V3f& at, int axis, int k) { return at[(axis + 1 + k) % 3]; }

// A coordinate of a target, and its moment.
struct Weighted {
  float at = 0.0f;
  float moment = 0.0f;
};

std::vector<Weighted> sorted_coordinates(std::span<const Target> targets, int axis, int k) {
  std::vector<Weighted> some;
  const size_t step = targets.size() / kSorted + 1;
  for (size_t i = 0; i < targets.size(); i += step)
    some.push_back({coordinate(targets[i].at, axis, k), targets[i].record->contribution2});
  std::sort(some.begin(), some.end(), [](const Weighted& a, const Weighted& b) {
    return std::tie(a.at, a.moment) < std::tie(b.at, b.moment); // one order, whatever the library's sort does
  });
  return some;
}

// Returns the rectangle that contains all but the outermost targets.
Rectangle nearly_all(std::span<const Target> targets, int axis) {
  Rectangle result;
  for (int k = 0; k < 2; ++k) {
    const std::vector<Weighted> some = sorted_coordinates(targets, axis, k);
    const size_t outside = some.size() / 50;
    result.low[static_cast<size_t>(k)] = some[outside].at;
    result.high[static_cast<size_t>(k)] = some[some.size() - 1 - outside].at;
  }
  return result;
}

// Returns the first and last coordinate of the shortest interval that has kMainShare of the moment.
std::pair<float, float> shortest_interval(std::span<const Weighted> sorted) {
  double all = 0.0;
  for (const Weighted& w : sorted) all += static_cast<double>(w.moment);
  std::pair<float, float> best(sorted.front().at, sorted.back().at);
  double inside = 0.0;
  for (size_t first = 0, last = 0; first < sorted.size(); ++first) {
    while (last < sorted.size() && inside < kMainShare * all) inside += static_cast<double>(sorted[last++].moment);
    if (inside < kMainShare * all) break;
    if (sorted[last - 1].at - sorted[first].at < best.second - best.first)
      best = {sorted[first].at, sorted[last - 1].at};
    inside -= static_cast<double>(sorted[first].moment);
  }
  return best;
}

// Returns the rectangle of an opening: the shortest intervals that have most of the moment of the
// crossings, and some more to either side. Removes the crossings outside.
Rectangle take_opening(std::vector<Target>& crossings, int axis) {
  Rectangle result;
  for (int k = 0; k < 2 && !crossings.empty(); ++k) {
    const auto which = static_cast<size_t>(k);
    const auto [low, high] = shortest_interval(sorted_coordinates(crossings, axis, k));
    result.low[which] = low - kMore * (high - low);
    result.high[which] = high + kMore * (high - low);
    std::erase_if(crossings, [&](const Target& target) {
      const float place = coordinate(target.at, axis, k);
      return place < result.low[which] || place > result.high[which];
    });
  }
  return result;
}

// Returns how widely the targets, of one facing, are spread: the root of the second moment that the
// best density would have which is constant in each cell, the sum over cells of the root of moment
// times solid angle.
double spread_of(std::span<const Target> targets) {
  if (targets.empty()) return 0.0;
  const auto axis = static_cast<int>(targets.front().facing / 2);
  const Rectangle range = nearly_all(targets, axis);
  const auto extent = [&](size_t k) { return range.high[k] - range.low[k]; };
  struct Cell {
    double moment = 0.0, solid_angle = 0.0, count = 0.0;
  };
  std::array<Cell, kCells * kCells> cells;
  for (const Target& target : targets) {
    size_t number = 0;
    for (int k = 0; k < 2; ++k) {
      const auto which = static_cast<size_t>(k);
      const float place =
          extent(which) > 0.0f ? (coordinate(target.at, axis, k) - range.low[which]) / extent(which) : 0.0f;
      number = number * kCells + static_cast<size_t>(std::clamp(static_cast<int>(place * kCells), 0, kCells - 1));
    }
    Cell& cell = cells[number];
    cell.moment += static_cast<double>(target.record->contribution2);
    cell.solid_angle += static_cast<double>(target.solid_angle);
    cell.count += 1.0;
  }
  const double area = static_cast<double>(extent(0)) * static_cast<double>(extent(1)) / (kCells * kCells);
  double sum = 0.0;
  for (const Cell& cell : cells)
    if (cell.count > 0.0) sum += std::sqrt(cell.moment * area * cell.solid_angle / cell.count);
  return sum;
}

// An opening, and how much denser directions are there.
struct Opening {
  Plane plane;
  Rectangle rectangle;
  double gain = 0.0;
  double spread = 1.0; // of the crossings, relative to that of the hits

  [[nodiscard]] bool contains(const V3f& at) const {
    for (int k = 0; k < 2; ++k) {
      const auto which = static_cast<size_t>(k);
      const float place = coordinate(at, plane.axis, k);
      if (place < rectangle.low[which] || place > rectangle.high[which]) return false;
    }
    return true;
  }
  // Moves the hit of a record whose direction leads through the opening there.
  void take(GuideRecord& record, uint8_t kind) const {
    const float t = crossing(record, plane);
    if (!(t > 0.0f)) return;
    V3f at = record.position + (record.hit - record.position) * t;
    at[plane.axis] = plane.at;
    if (!contains(at)) return;
    record.hit = at;
    record.hit_facing = plane.facing();
    record.hit_kind = kind;
  }
};

// Searches the planes across one axis, seen from one side.
class PlaneSearch {
 public:
  PlaneSearch(std::span<const GuideRecord> records, int axis, uint32_t side) : best_{.plane = {axis, side, 0.0f}} {
    const size_t step = records.size() / kMaxSearched + 1;
    for (size_t i = 0; i < records.size(); i += step) records_.push_back(&records[i]);
  }

  Opening find() {
    const std::vector<float> planes = first_planes();
    size_t best = 0;
    for (size_t i = 0; i < planes.size(); ++i)
      if (try_plane(planes[i])) best = i;
    if (!(best_.gain > 0.0)) return best_;
    float below = planes[best == 0 ? 0 : best - 1], above = planes[std::min(best + 1, planes.size() - 1)];
    for (int refinement = 0; refinement < kRefinements; ++refinement) {
      const float low = below, step = (above - below) / kRefinedPlanes;
      for (int i = 1; i < kRefinedPlanes; ++i) {
        const float at = low + static_cast<float>(i) * step;
        if (try_plane(at)) below = at - step, above = at + step;
      }
    }
    return best_;
  }
  // Returns the opening in one plane.
  Opening at(float plane) {
    try_plane(plane);
    return best_;
  }

 private:
  // Returns planes that divide positions and hits into parts of equal number, ascending: they are
  // dense where the scene is.
  [[nodiscard]] std::vector<float> first_planes() const {
    std::vector<float> ends;
    for (const GuideRecord* record : records_) {
      ends.push_back(record->position[best_.plane.axis]);
      ends.push_back(record->hit[best_.plane.axis]);
    }
    std::sort(ends.begin(), ends.end());
    std::vector<float> planes;
    for (size_t i = 1; i < kPlanes && !ends.empty(); ++i) planes.push_back(ends[i * ends.size() / kPlanes]);
    planes.erase(std::unique(planes.begin(), planes.end()), planes.end());
    return planes;
  }

  // True if it is better than all before.
  bool try_plane(float at) {
    Plane plane = best_.plane;
    plane.at = at;
    crossings_.clear();
    for (const GuideRecord* record : records_)
      if (const float t = crossing(*record, plane); t > 0.0f)
        crossings_.push_back(
            target_of(*record, record->position + (record->hit - record->position) * t, plane.facing()));
    if (crossings_.size() < kMinCrossings) return false;
    const Rectangle rectangle = take_opening(crossings_, plane.axis);
    if (crossings_.size() < kMinCrossings) return false;
    for (std::vector<Target>& targets : hits_) targets.clear();
    for (const Target& target : crossings_) {
      const GuideRecord& record = *target.record;
      hits_[record.hit_group()].push_back(target_of(record, record.hit, record.hit_facing));
    }
    double of_hits = 0.0;
    for (const std::vector<Target>& targets : hits_) of_hits += spread_of(targets);
    const double spread = spread_of(crossings_);
    const double gain = of_hits - spread;
    if (!(spread < kMaxSpread * of_hits && gain > best_.gain)) return false;
    best_ = {plane, rectangle, gain, spread / of_hits};
    return true;
  }

  std::vector<const GuideRecord*> records_;
  Opening best_;
  std::vector<Target> crossings_;
  std::array<std::vector<Target>, size_t{kFacings} * kFirstOpening> hits_; // by group
};

} // namespace

bool move_to_openings(std::span<GuideRecord> records) {
  std::array<Opening, kFacings> openings;
  tbb::parallel_for(uint32_t{0}, kFacings,
                    [&](uint32_t i) { openings[i] = PlaneSearch(records, static_cast<int>(i / 2), i % 2).find(); });
  // The tightest first: a plane outside, which light from two windows crosses, is wider.
  std::stable_sort(openings.begin(), openings.end(),
                   [](const Opening& a, const Opening& b) { return a.spread < b.spread; });
  uint8_t kind = kFirstOpening;
  for (const Opening& found : openings) {
    if (!(found.gain > 0.0)) break; // like all after it
    // Others may have taken what it was found for.
    std::vector<GuideRecord> left;
    std::copy_if(records.begin(), records.end(), std::back_inserter(left),
                 [](const GuideRecord& record) { return record.hit_kind < kFirstOpening; });
    const Opening opening = PlaneSearch(left, found.plane.axis, found.plane.side).at(found.plane.at);
    if (!(opening.gain > 0.0)) continue;
    for (GuideRecord& record : records)
      if (record.hit_kind < kFirstOpening) opening.take(record, kind);
    ++kind;
  }
  return kind > kFirstOpening;
}

} // namespace kindling
