// Records of the paths of a block, reflection by reflection: what the training of a guide learns from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide_record.h"
#include "renderer/guiding/light_selection_tree.h"
#include "renderer/integrator/path_state.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <vector>

namespace kindling {

// Belongs to one thread. A context that has one fills it; its records gather until somebody takes them.
class PathRecorder {
 public:
  static constexpr size_t kMaxReflections = 8; // later ones of a path are not recorded

  explicit PathRecorder(size_t batch_size) : paths_(batch_size), reflections_(batch_size * kMaxReflections) {}

  void start_path(size_t slot) { paths_[slot] = {}; }
  // All of the record but where it hit and what it brought.
  void reflect(size_t slot, const GuideRecord& record) {
    Path& path = paths_[slot];
    path.on_the_way = path.count < kMaxReflections;
    if (path.on_the_way) reflections_[slot * kMaxReflections + path.count++] = {record, 0.0f};
  }
  // The ray has met a surface, or nothing (null), and what is there is not added to the state yet.
  void arrive(size_t slot, const PathState& state, const SurfacePoint* surface) {
    Path& path = paths_[slot];
    if (!path.on_the_way) return;
    path.on_the_way = false;
    if (!surface || surface->position == reflections_[slot * kMaxReflections + path.count - 1].record.position) {
      // No place to send others to.
      --path.count;
      return;
    }
    Reflection& reflection = reflections_[slot * kMaxReflections + path.count - 1];
    reflection.record.hit = surface->position;
    reflection.record.hit_facing = facing_of(surface->geometric_normal);
    reflection.found_before = luminance(state.light[0] + state.light[1] + state.light[2]);
  }
  // Light samples wait for their shadow rays, all that are on the way numbered from 0.
  void start_lights() { offered_lights_.clear(); }
  void offer_light(const LightRecord& record) { offered_lights_.push_back(record); }
  void take_light(size_t number) {
    if (offered_lights_[number].moment > 0.0f) light_records.push_back(offered_lights_[number]);
  }
  // `found`: by the whole path.
  void finish_path(size_t slot, const Rgb& found);

  std::vector<GuideRecord> records;       // those that brought something; contribution2 is not relative yet
  std::vector<LightRecord> light_records; // moments not relative yet
  double luminance_sum = 0.0;             // of the finished paths

 private:
  struct Path {
    uint32_t count = 0;
    bool on_the_way = false;
  };
  struct Reflection {
    GuideRecord record;
    float found_before = 0.0f; // luminance
  };
  std::vector<LightRecord> offered_lights_;
  std::vector<Path> paths_;
  std::vector<Reflection> reflections_;
};

} // namespace kindling
