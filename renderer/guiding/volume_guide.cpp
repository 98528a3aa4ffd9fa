// Builds the regions and quadtrees of a volume guide.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/volume_guide.h"

#include "renderer/base/frame.h"
#include "renderer/guiding/position_moments.h"
#include "renderer/sampling/sincos_turns.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr size_t kMaxRegionRecords = 4096; // of a region: in larger regions lamps are seen in too different directions
constexpr uint32_t kMaxRegionDepth = 24;   // of regions
constexpr size_t kMinLights = 64;          // of a square that is divided: a light is a third of a record
constexpr uint32_t kMaxLevels = 10;        // of squares: a two-hundredth of a radian

// Each record is spread by up to this angle, radians. Light at the edge of a beam that no record
// has would be found by the phase function alone, with a large weight.
constexpr float kBlur = 0.1f;

// A direction is bright if its radiance is kContrast times that of the background, which is reached
// by kBackground of all directions.
constexpr double kBackground = 0.6, kContrast = 2.5;
constexpr size_t kMinBrightLights = 4; // of a flat square that counts as bright

// Bright directions are chosen a little less often than their light suggests: walks may lead to
// better records. Small shares are not worth their lookups.
constexpr double kShareFactor = 0.6, kMinShare = 0.02, kMaxShare = 0.9;

using Quarters = VolumeGuideView::Quarters;

// A tree of regions while it grows, and the records of each.
struct GrowingRegions {
  void grow(uint32_t node, std::span<VolumeRecord> records, uint32_t depth);

  std::vector<RegionNode> nodes{1};
  std::vector<std::span<VolumeRecord>> regions;
};

// Splits at the mean along the axis of the largest variance.
void GrowingRegions::grow(uint32_t node, std::span<VolumeRecord> records, uint32_t depth) {
  if (records.size() > kMaxRegionRecords && depth < kMaxRegionDepth) {
    const PositionMoments moments{std::span<const VolumeRecord>(records)};
    const V3d &mean = moments.mean, &variance = moments.variance;
    const uint32_t axis = variance.x >= variance.y && variance.x >= variance.z ? 0 : variance.y >= variance.z ? 1 : 2;
    const auto split = static_cast<float>(mean[static_cast<int>(axis)]);
    const auto middle = std::stable_partition(records.begin(), records.end(), [&](const VolumeRecord& record) {
      return record.position[static_cast<int>(axis)] < split;
    });
    const auto left = static_cast<size_t>(middle - records.begin());
    if (left > 0 && left < records.size()) {
      const auto children = static_cast<uint32_t>(nodes.size());
      nodes.resize(nodes.size() + 2);
      nodes[node].split = split;
      nodes[node].axis = axis;
      nodes[node].next = children;
      grow(children, records.first(left), depth + 1);
      grow(children + 1, records.subspan(left), depth + 1);
      return;
    }
  }
  nodes[node].next = static_cast<uint32_t>(regions.size());
  regions.push_back(records);
}

// A part of a record in the square of directions.
struct Light {
  V2f point;
  float weight;
};

// Half of each record in its direction, and a quarter each in two others nearby.
std::vector<Light> spread(std::span<const VolumeRecord> records) {
  constexpr float kGoldenTurn = 0.61803399f;
  std::vector<Light> lights;
  lights.reserve(3 * records.size());
  float turn = 0.0f;
  for (const VolumeRecord& record : records) {
    lights.push_back({point_of_direction(record.direction), 0.5f * record.weight});
    const Frame frame = Frame::around(record.direction);
    for (const float distance : {kBlur, 0.5f * kBlur}) {
      turn += kGoldenTurn;
      if (turn >= 1.0f) turn -= 1.0f;
      const SinCos phi = sincos_turns(turn);
      const V3f direction = record.direction + (frame.tangent * phi.cos + frame.bitangent * phi.sin) * distance;
      lights.push_back({point_of_direction(direction), 0.25f * record.weight});
    }
  }
  return lights;
}

double solid_angle(const V2f& corner, float size) {
  constexpr int kSteps = 8;
  double sum = 0.0;
  for (int y = 0; y < kSteps; ++y)
    for (int x = 0; x < kSteps; ++x) {
      const V2f within(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      sum += static_cast<double>(steradians_per_area(direction_of_point(corner + within * (size / kSteps))));
    }
  return sum * static_cast<double>(size) * static_cast<double>(size) / (kSteps * kSteps);
}

// The quadtree of one region: finds its bright directions.
class Directions {
 public:
  explicit Directions(std::span<const VolumeRecord> records) {
    std::vector<Light> lights = spread(records);
    divide(0, lights, V2f(0.0f), 1.0f, 0);
    find_bright();
    if (!(region.share > 0.0f)) return;
    find_mean(records);
    for (const Square& square : squares_) quarters.push_back(quarters_of(square));
  }

  VolumeGuideView::Region region;
  std::vector<Quarters> quarters; // the root first; none without bright directions

 private:
  struct Square {
    std::array<uint32_t, 4> inside{}; // 0: a quarter is flat
    std::array<double, 4> bright{};   // light of each quarter beyond the background
    size_t light_count = 0;
  };
  // A quarter that is not divided.
  struct Flat {
    uint32_t square;
    uint32_t quarter;
    size_t light_count;
    double weight;
    double solid_angle;
    [[nodiscard]] double radiance() const { return weight / solid_angle; }
  };

  void divide(uint32_t at, std::span<Light> lights, const V2f& corner, float size, uint32_t level);
  void find_bright();
  double sum_bright(uint32_t at);
  void find_mean(std::span<const VolumeRecord> records);
  [[nodiscard]] bool is_bright(V2f point) const;
  [[nodiscard]] static Quarters quarters_of(const Square& square);

  std::vector<Square> squares_{1}; // each before those inside of it
  std::vector<Flat> flats_;
};

void Directions::divide(uint32_t at, std::span<Light> lights, const V2f& corner, float size, uint32_t level) {
  const float half = 0.5f * size;
  const V2f middle = corner + V2f(half);
  const auto across = [&](auto first, auto end) {
    return std::stable_partition(first, end, [&](const Light& light) { return light.point.x < middle.x; });
  };
  const auto above =
      std::stable_partition(lights.begin(), lights.end(), [&](const Light& light) { return light.point.y < middle.y; });
  const std::array borders{lights.begin(), across(lights.begin(), above), above, across(above, lights.end()),
                           lights.end()};
  squares_[at].light_count = lights.size();
  for (uint32_t q = 0; q < 4; ++q) {
    const std::span<Light> here(borders[q], borders[q + 1]);
    const V2f corner_here = corner + V2f((q & 1U) != 0 ? half : 0.0f, (q & 2U) != 0 ? half : 0.0f);
    if (here.size() >= kMinLights && level + 1 < kMaxLevels) {
      const auto inside = static_cast<uint32_t>(squares_.size());
      squares_[at].inside[q] = inside;
      squares_.emplace_back();
      divide(inside, here, corner_here, half, level + 1);
      continue;
    }
    double weight = 0.0;
    for (const Light& light : here) weight += static_cast<double>(light.weight);
    flats_.push_back({at, q, here.size(), weight, solid_angle(corner_here, half)});
  }
}

void Directions::find_bright() {
  std::vector<Flat> darkest_first = flats_;
  std::stable_sort(darkest_first.begin(), darkest_first.end(),
                   [](const Flat& a, const Flat& b) { return a.radiance() < b.radiance(); });
  double whole = 0.0, total = 0.0;
  for (const Flat& flat : flats_) {
    whole += flat.solid_angle;
    total += flat.weight;
  }
  double background = 0.0, covered = 0.0;
  for (const Flat& flat : darkest_first) {
    background = flat.radiance();
    covered += flat.solid_angle;
    if (covered >= kBackground * whole) break;
  }
  for (const Flat& flat : flats_)
    if (flat.radiance() > kContrast * background && flat.light_count >= kMinBrightLights)
      squares_[flat.square].bright[flat.quarter] = flat.weight - background * flat.solid_angle;
  const double share = kShareFactor * sum_bright(0) / total;
  if (share > kMinShare) region.share = static_cast<float>(std::min(share, kMaxShare));
}

// Fills in the quarters that have squares inside.
double Directions::sum_bright(uint32_t at) {
  double sum = 0.0;
  for (uint32_t q = 0; q < 4; ++q) {
    if (squares_[at].inside[q] != 0) squares_[at].bright[q] = sum_bright(squares_[at].inside[q]);
    sum += squares_[at].bright[q];
  }
  return sum;
}

void Directions::find_mean(std::span<const VolumeRecord> records) {
  V3d sum(0.0);
  double weight = 0.0;
  for (const VolumeRecord& record : records) {
    if (!is_bright(point_of_direction(record.direction))) continue;
    sum += V3d(record.direction) * static_cast<double>(record.weight);
    weight += static_cast<double>(record.weight);
  }
  if (weight > 0.0) region.mean = V3f(sum / weight);
}

bool Directions::is_bright(V2f point) const {
  for (uint32_t at = 0;;) {
    const uint32_t quarter = quarter_of(point);
    if (squares_[at].inside[quarter] == 0) return squares_[at].bright[quarter] > 0.0;
    at = squares_[at].inside[quarter];
    point = point_in_quarter(point, quarter);
  }
}

// Each quarter counts as if it had one more light: what is rare may still exist there.
Quarters Directions::quarters_of(const Square& square) {
  Quarters result{};
  double total = 0.0;
  for (const double bright : square.bright) total += bright;
  const double unseen = total > 0.0 ? total / static_cast<double>(square.light_count) : 1.0;
  for (uint32_t q = 0; q < 4; ++q) {
    result.shares[q] = static_cast<float>((square.bright[q] + unseen) / (total + 4.0 * unseen));
    result.inside[q] = square.bright[q] > 0.0 ? square.inside[q] : 0;
  }
  return result;
}

} // namespace

VolumeGuide::VolumeGuide(std::span<VolumeRecord> records) {
  if (records.empty()) return;
  GrowingRegions space;
  space.grow(0, records, 0);
  std::vector<std::optional<Directions>> found(space.regions.size());
  tbb::parallel_for(size_t{0}, found.size(), [&](size_t region) { found[region].emplace(space.regions[region]); });
  std::vector<Region> all_regions;
  std::vector<Quarters> all_quarters;
  for (const std::optional<Directions>& directions : found) {
    const auto root = static_cast<uint32_t>(all_quarters.size());
    all_regions.push_back(directions->region);
    all_regions.back().root = root;
    for (Quarters square : directions->quarters) {
      for (uint32_t& inside : square.inside) inside = inside == 0 ? 0 : root + inside;
      all_quarters.push_back(square);
    }
  }
  nodes = arrays_.keep(std::move(space.nodes));
  regions = arrays_.keep(std::move(all_regions));
  quarters = arrays_.keep(std::move(all_quarters));
}

} // namespace kindling
