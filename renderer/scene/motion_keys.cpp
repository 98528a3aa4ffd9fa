// Doubles the number of keys until what is between them is close to the truth.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/motion_keys.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace kindling {
namespace {

constexpr float kRelativeTolerance = 1e-3f; // of radii of meshes, of ways of cameras
constexpr float kAxisTolerance = 1e-4f;
constexpr float kRounding = 1e-6f; // of coordinates: what moves less does not move
constexpr size_t kMaxKeyframes = 256;

// What is known of the motion of one probe.
struct Track {
  std::vector<std::vector<V3f>> keys; // the points at the keys of the level at hand
  float radius = 0.0f;                // the largest of all times
  float magnitude = 0.0f;             // likewise, of coordinates
  float way = 0.0f;       // how far from where it was at the opening: of its points, of frames their position
  float turn = 0.0f;      // of frames: likewise their axes
  float deviation = 0.0f; // of points between keys, relative to what is allowed
};

// Fractions of the shutter at which keyframes of animated nodes lie, without its ends; of very many, some.
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
  // Calls visit(probe, points) for all that are open, at a fraction of the shutter; in parallel.
  template <typename Visit>
  void at(double fraction, const Visit& visit) {
    nodes_.set_time(shutter_.open_s + (shutter_.close_s - shutter_.open_s) * fraction);
    tbb::parallel_for(size_t{0}, open_.size(), [&](size_t i) {
      std::vector<V3f> points;
      probes_[open_[i]].points(scene_, nodes_, points);
      visit(open_[i], std::move(points));
    });
  }

  // Extent and way of each motion.
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
            track.turn = std::max(track.turn, moved);
            continue;
          }
          track.way = std::max(track.way, moved);
          track.magnitude = std::max(track.magnitude, max_abs(points[p]));
          track.radius = std::max(track.radius, (points[p] - center).length());
        }
      });
    }
  }
  [[nodiscard]] bool is_static(size_t i) const {
    return tracks_[i].way <= kRounding * tracks_[i].magnitude && tracks_[i].turn <= kRounding;
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
            std::max(kRelativeTolerance * (frame ? track.way : track.radius), kRounding * track.magnitude);
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
  std::vector<size_t> open_; // probes whose number is not known yet
};

} // namespace

std::vector<uint32_t> choose_motion_segments(const Scene& scene, const Shutter& shutter,
                                             std::span<const MotionProbe> probes, AnimatedNodes& nodes) {
  if (!(shutter.close_s > shutter.open_s) || probes.empty()) return std::vector<uint32_t>(probes.size(), 0);
  return KeyChooser(scene, shutter, probes, nodes).choose();
}

} // namespace kindling
