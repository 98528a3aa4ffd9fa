// Doubles the number of motion keys until interpolation between them is accurate.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/motion_keys.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace kindling {
namespace {

constexpr float kRelativeTolerance = 1e-3f; // of mesh radii and of camera displacements
constexpr float kAxisTolerance = 1e-4f;
constexpr float kRounding = 1e-6f; // of coordinates: smaller motion counts as static
constexpr size_t kMaxKeyframes = 256;

// Measured motion of one probe.
struct Track {
  std::vector<std::vector<V3f>> keys; // points at the keys of the current level
  float radius = 0.0f;                // maximum over all times
  float magnitude = 0.0f;             // maximum over all times, of coordinates
  float displacement = 0.0f;          // maximum distance from the position at the opening; for frames of the origin
  float axis_change = 0.0f;           // likewise for the axes of frames
  float deviation = 0.0f;             // maximum error between keys, relative to the tolerance
};

// Returns the fractions of the shutter, excluding its ends, at which animated nodes have keyframes;
// a subset if there are more than kMaxKeyframes.
std::vector<double> keyframes_inside(const Scene& scene, const Shutter& shutter) {
  std::set<double> times;
  for (const Animation& animation : scene.animations) {
    for (const AnimationChannel& channel : animation.channels) {
      if (channel.node == kNone || channel.property == AnimatedProperty::visible) continue;
      for (const float t : channel.times_s)
        if (t > shutter.open_s && t < shutter.close_s) times.insert(t);
    }
  }
  const size_t step = (times.size() + kMaxKeyframes - 1) / kMaxKeyframes;
  std::vector<double> fractions;
  size_t i = 0;
  for (const double t : times)
    if (i++ % step == 0) fractions.push_back((t - shutter.open_s) / (shutter.close_s - shutter.open_s));
  return fractions;
}

class KeyChooser {
 public:
  KeyChooser(const Scene& scene, const Shutter& shutter, std::span<const MotionProbe> probes, AnimatedNodes& nodes)
      : scene_(scene), shutter_(shutter), probes_(probes), nodes_(nodes), keyframes_(keyframes_inside(scene, shutter)),
        tracks_(probes.size()), segments_(probes.size(), 0) {
    for (size_t i = 0; i < probes.size(); ++i) open_.push_back(i);
  }

  std::vector<uint32_t> choose() {
    measure();
    std::erase_if(open_, [&](size_t i) { return is_static(i); });
    for (uint32_t segments = 1; !open_.empty(); segments *= 2) {
      for (const size_t i : open_) segments_[i] = segments;
      if (segments == kMaxMotionSegments) break;
      place_keys(segments);
      compare(segments);
      std::erase_if(open_, [&](size_t i) { return !(tracks_[i].deviation > 1.0f); });
    }
    return segments_;
  }

 private:
  // Calls visit(probe, points) in parallel for all open probes at a fraction of the shutter.
  template <typename Visit>
  void at(double fraction, const Visit& visit) {
    nodes_.set_time(shutter_.open_s + (shutter_.close_s - shutter_.open_s) * fraction);
    tbb::parallel_for(size_t{0}, open_.size(), [&](size_t i) {
      std::vector<V3f> points;
      probes_[open_[i]].points(scene_, nodes_, points);
      visit(open_[i], std::move(points));
    });
  }

  // Measures extent and displacement of each motion.
  void measure() {
    at(0.0, [&](size_t i, std::vector<V3f>&& points) { tracks_[i].keys = {std::move(points)}; });
    std::vector<double> fractions{0.0, 0.25, 0.5, 0.75, 1.0};
    fractions.insert(fractions.end(), keyframes_.begin(), keyframes_.end());
    for (const double fraction : fractions) {
      at(fraction, [&](size_t i, std::vector<V3f>&& points) {
        Track& track = tracks_[i];
        const size_t positions = probes_[i].is_frame() ? 1 : points.size();
        V3f center(0.0f);
        for (size_t p = 0; p < positions; ++p) center += points[p] * (1.0f / static_cast<float>(positions));
        for (size_t p = 0; p < points.size(); ++p) {
          const float moved = (points[p] - track.keys[0][p]).length();
          if (p >= positions) {
            track.axis_change = std::max(track.axis_change, moved);
            continue;
          }
          track.displacement = std::max(track.displacement, moved);
          track.magnitude = std::max(track.magnitude, max_abs(points[p]));
          track.radius = std::max(track.radius, (points[p] - center).length());
        }
      });
    }
  }
  [[nodiscard]] bool is_static(size_t i) const {
    return tracks_[i].displacement <= kRounding * tracks_[i].magnitude && tracks_[i].axis_change <= kRounding;
  }

  void place_keys(uint32_t segments) {
    for (const size_t i : open_) tracks_[i].keys.assign(segments + 1, {}), tracks_[i].deviation = 0.0f;
    for (uint32_t key = 0; key <= segments; ++key)
      at(static_cast<double>(key) / segments,
         [&](size_t i, std::vector<V3f>&& points) { tracks_[i].keys[key] = std::move(points); });
  }
  void compare(uint32_t segments) {
    std::vector<double> fractions = keyframes_;
    for (uint32_t i = 0; i < 4 * segments; ++i)
      if (i % 4 != 0) fractions.push_back(static_cast<double>(i) / (4 * segments));
    for (const double fraction : fractions) {
      const double position = fraction * segments;
      const uint32_t key = std::min(static_cast<uint32_t>(position), segments - 1);
      const auto t = static_cast<float>(position - key);
      at(fraction, [&](size_t i, std::vector<V3f>&& points) {
        Track& track = tracks_[i];
        const bool frame = probes_[i].is_frame();
        const float allowed =
            std::max(kRelativeTolerance * (frame ? track.displacement : track.radius), kRounding * track.magnitude);
        for (size_t p = 0; p < points.size(); ++p) {
          const float off = (lerp(track.keys[key][p], track.keys[key + 1][p], t) - points[p]).length();
          track.deviation = std::max(track.deviation, off / (frame && p > 0 ? kAxisTolerance : allowed));
        }
      });
    }
  }

  const Scene& scene_;
  const Shutter& shutter_;
  std::span<const MotionProbe> probes_;
  AnimatedNodes& nodes_;
  std::vector<double> keyframes_;
  std::vector<Track> tracks_;
  std::vector<uint32_t> segments_;
  std::vector<size_t> open_; // probes whose number of keys is not yet known
};

} // namespace

std::vector<uint32_t> choose_motion_segments(const Scene& scene, const Shutter& shutter,
                                             std::span<const MotionProbe> probes, AnimatedNodes& nodes) {
  if (!(shutter.close_s > shutter.open_s) || probes.empty()) return std::vector<uint32_t>(probes.size(), 0);
  return KeyChooser(scene, shutter, probes, nodes).choose();
}

} // namespace kindling
