// Recorder of reflections and light samples along paths, the training data of a guide.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide_record.h"
#include "renderer/guiding/light_selection_tree.h"
#include "renderer/integrator/stages/path_state.h"
#include "renderer/world/world.h"

#include <cassert>
#include <cstdint>
#include <vector>

namespace kindling {

// Belongs to one thread. The path tracer fills it through PathContext::recorder; records accumulate
// until cleared.
class PathRecorder {
 public:
  static constexpr size_t kMaxReflections = 8; // later reflections of a path are not recorded

  explicit PathRecorder(size_t batch_size) : paths_(batch_size), reflections_(batch_size * kMaxReflections) {}

  void start_path(size_t slot) { paths_[slot] = {}; }
  // Starts the record of a reflection; arrive() adds its hit, and finish_path() the light that it
  // brought.
  void reflect(size_t slot, const GuideRecord& record) {
    assert(slot < paths_.size() && !paths_[slot].in_flight);
    Path& path = paths_[slot];
    path.in_flight = path.count < kMaxReflections;
    if (path.in_flight) reflections_[slot * kMaxReflections + path.count++] = {record, 0.0f};
  }
  // Called when the ray of the last reflection has hit a surface, or ended (null), before any light
  // found there is added.
  void arrive(size_t slot, const PathState& state, const SurfacePoint* surface) {
    if (surface) {
      const bool sampled = surface->alpha < 1.0f || surface->has_thin_wall() || !is_black(surface->emitted);
      arrive_at(slot, state, surface->position, facing_of(surface->geometric_normal), kOnSurface, sampled);
    } else
      drop(slot);
  }
  // Called when that ray, of a unit direction, has left the scene instead. `bounds` contains the
  // scene.
  void escape(size_t slot, const PathState& state, const V3f& direction, const Box3f& bounds);
  // Light samples of one stage, numbered from 0: offered in order, then taken if their shadow rays
  // are unoccluded.
  void start_lights() { offered_lights_.clear(); }
  void offer_light(const LightRecord& record) { offered_lights_.push_back(record); }
  void accept_light(size_t number) {
    assert(number < offered_lights_.size());
    if (offered_lights_[number].moment > 0.0f) light_records.push_back(offered_lights_[number]);
  }
  // `found` is the radiance of the whole path.
  void finish_path(size_t slot, const Rgb& found);

  std::vector<GuideRecord> records;       // reflections that brought light; contribution2 is absolute
  std::vector<LightRecord> light_records; // moments are absolute
  double luminance_sum = 0.0;             // over the finished paths

 private:
  struct Path {
    uint32_t count = 0;
    bool in_flight = false;
  };
  struct Reflection {
    GuideRecord record;
    float found_before = 0.0f; // luminance
  };
  // Completes the record of the reflection in flight, if there is one; or drops it, because there
  // is no position that other paths could be guided to. `sampled`: light samples find light there
  // or behind it, too.
  void arrive_at(size_t slot, const PathState& state, const V3f& hit, uint32_t hit_facing, uint8_t hit_kind,
                 bool sampled);
  void drop(size_t slot);

  std::vector<LightRecord> offered_lights_;
  std::vector<Path> paths_;
  std::vector<Reflection> reflections_;
};

} // namespace kindling
