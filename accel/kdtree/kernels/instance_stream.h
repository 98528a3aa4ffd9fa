// Streams through instances, and through the world's tree before.
//
// Each ray in flight goes first through the world's tree, then down the hierarchy of instances, and
// for each instance that it enters through the tree of its group, by the same steps. Rays that
// reach an instance wait until sixteen of them can be taken into object space at once. With rays in
// three places, more of them are needed in flight than in one tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/level_rays.h"
#include "accel/kdtree/kernels/stream_steps.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// A ray goes through one tree after another.
struct TreesInTurn {
  static constexpr uint32_t kSlots = 64;
  // Deeper hierarchies of instances do not fit onto the stacks of the rays.
  static constexpr uint32_t kMaxDepth = 16;
  struct alignas(64) Frame {
    std::array<float, kWideLanes> enter;
    std::array<uint32_t, kWideLanes> child;
  };
  struct Place {
    // The tree that the ray is in, and its instance; kNoId for the world's.
    const Tree* tree;
    uint32_t instance;
    const BoxNode* nodes;
    const LeafUnit* leaves;
    // The ray in the hierarchy. Its origin is displaced by the margin towards it at low faces, and
    // away from it at high faces.
    std::array<float, 3> low_origin, high_origin, reciprocal;
    float t_min, t_far;
    uint32_t top, signs;
    std::array<uint8_t, kMaxDepth + 2> rest; // by frame
    std::array<Frame, kMaxDepth + 2> stack;  // the lowest ends the ray

    void set_tree(const Tree& in, uint32_t of) {
      tree = &in;
      instance = of;
      nodes = in.nodes.data();
      leaves = in.leaves.data();
    }
  };

  static const BoxNode* nodes(const Place& place) { return place.nodes; }
  static const LeafUnit* leaves(const Place& place) { return place.leaves; }
  static CandidateFilter filter(const HitFilter& filter, const Ray& ray, const Place& place) {
    return {filter, ray, *place.tree, place.instance};
  }
};

// Returns a ray with another end.
inline Ray with_end(const Ray& ray, float t_max) {
  Ray out = ray;
  Float4 direction = load_direction(ray);
  direction[3] = t_max;
  std::memcpy(reinterpret_cast<char*>(&out) + offsetof(Ray, direction), &direction, sizeof(Float4));
  return out;
}

// The tree that a ray enters at an instance. Null: none, or one that a stream cannot trace.
struct Entered {
  const Tree* tree = nullptr;
  uint32_t instance = kNoId;
  bool is_apart = false; // to be traced by itself
};

// Transformed instances at rest.
struct TransformedInstances {
  const Structure& structure;

  [[nodiscard]] const InstanceLevel& level() const { return structure.instance_level; }
  void fetch(uint32_t number) const { prefetch(structure.transformed.data() + number); }
  static void fetch_keys(uint32_t) {}
  [[nodiscard]] Entered enter(uint32_t number, const Ray& world, float t_far, Ray& ray) const {
    const TransformedInstance& transformed = structure.transformed[number];
    ray = transformed.to_object(world, t_far);
    return {transformed.tree, transformed.instance};
  }
  // The same for rays of a mask; returns a mask of those to be traced.
  uint32_t enter_all(uint32_t number, const LevelRays& rays, uint32_t active, Ray* inside, Entered& in) const {
    const TransformedInstance& transformed = structure.transformed[number];
    in = {transformed.tree, transformed.instance};
    for (uint32_t rest = active; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(rest));
      inside[i] = transformed.to_object(*rays.ray[i], rays.lanes.t_max[i]);
    }
    return active;
  }
};

// Takes about 260 KB, meant for the stack; nothing is initialized before its use.
//
// `Instances` has level(), the hierarchy over instances; fetch(i) and later fetch_keys(i), which
// prefetch what enter() reads of instance i; and enter(i, ray, t_far), which returns the tree of
// instance i and the ray in its space up to t_far: see Entered.
template <bool kAny, class Instances>
class InstanceStream : StreamSteps<kAny, TreesInTurn, BestHits> {
  using Steps = StreamSteps<kAny, TreesInTurn, BestHits>;
  using typename Steps::Slot, typename Steps::Offsets, typename Steps::Queue;
  using Place = TreesInTurn::Place;
  using Steps::at_node_, Steps::at_leaf_, Steps::done_, Steps::done_count_, Steps::free_, Steps::free_count_,
      Steps::filter_, Steps::kSlots, Steps::prepared_, Steps::next_, Steps::waiting_;

 public:
  static bool can_trace(const InstanceLevel& level) { return level.depth() <= TreesInTurn::kMaxDepth; }

  // `world`: null if the rays have been through it.
  InstanceStream(const Instances& instances, const HitFilter& filter, const Tree* world)
      : Steps({}, filter, {}), instances_(instances), level_(instances.level()), world_(world) {
    assert(can_trace(level_));
  }

  // Traces rays by these members of `calls`: end_of(i) returns the end of ray i, negative to leave
  // it out; merge(i, tree, instance, hit) takes the best hit of ray i in a tree, up to its end so
  // far, or, if kAny, any hit; trace_alone(i) traces a ray that a stream cannot trace; and
  // trace_in(i, number, t_far) one that it cannot trace through an instance, and narrows t_far or,
  // if kAny, makes it negative.
  template <class Calls>
  void trace(std::span<const Ray> rays, const Calls& calls) {
    this->free_all_slots();
    const auto prepare_rays = [&] { prepare(rays, calls); };
    const auto begin_ray = [this](uint32_t offset, uint32_t i) { begin(offset, i); };
    while (true) {
      this->fill(rays.size(), prepare_rays, begin_ray);
      if (free_count_ == kSlots || filter_.abandoned()) break;
      descend_level();
      if (at_box_.count >= kRayLanes || at_node_.count + at_leaf_.count + at_level_.count < kRayLanes)
        enter_instances(rays, calls);
      this->descend();
      this->test_leaves(rays);
      for (uint32_t k = 0; k < done_count_; ++k) {
        Slot& ended = this->slot(done_[k]);
        if (ended.primitive != kNoId) {
          calls.merge(ended.ray, *ended.place.tree, ended.place.instance, ended.best());
          ended.place.t_far = ended.at.t_far;
        }
        leave(done_[k]);
      }
      done_count_ = 0;
    }
  }

 private:
  void leave(uint32_t offset) {
    if (kAny && this->slot(offset).place.t_far < 0.0f)
      free_[free_count_++] = offset;
    else
      leaving_[leaving_count_++] = offset;
  }

  // Begins with a prepared ray, in the world's tree if it enters that.
  void begin(uint32_t offset, uint32_t prepared) {
    Slot& s = this->slot(offset);
    s.ray = numbers_[prepared];
    begin_level(s);
    if (world_ != nullptr && ((prepared_.enter >> prepared) & 1U) != 0) {
      s.place.set_tree(*world_, kNoId);
      this->begin_tree(offset, world_->root);
    } else {
      leave(offset);
    }
  }
  // Prepares the ray of a slot, which is in world space, to begin at the root of the hierarchy.
  void begin_level(Slot& s) const {
    Place& place = s.place;
    const float margin = level_.margin({s.at.origin[0], s.at.origin[1], s.at.origin[2]});
    place.signs = 0;
    for (size_t k = 0; k < 3; ++k) {
      place.low_origin[k] = s.at.origin[k] + margin;
      place.high_origin[k] = s.at.origin[k] - margin;
      place.reciprocal[k] = s.at.reciprocal[k];
      place.signs |= (std::signbit(s.at.reciprocal[k]) ? 1U : 0U) << k;
    }
    place.t_min = s.at.t_min * kBefore;
    place.t_far = s.at.t_far;
    place.top = 2;
    place.rest[0] = place.rest[1] = 1;
    place.stack[0].enter[0] = std::numeric_limits<float>::quiet_NaN();
    place.stack[0].child[0] = 0; // never visited, only prefetched
    place.stack[1].enter[0] = place.t_min;
    place.stack[1].child[0] = 0;
  }
  template <class Calls>
  void prepare(std::span<const Ray> rays, const Calls& calls) {
    std::array<Ray, kRayLanes> part;
    uint32_t count = 0;
    for (; count < kRayLanes && next_ < rays.size(); ++next_) {
      const float end = calls.end_of(next_);
      if (!(end >= 0.0f)) continue;
      part[count] = with_end(rays[next_], end);
      numbers_[count++] = static_cast<uint32_t>(next_);
    }
    if (count == 0) return;
    const Imath::Box3f bounds = world_ != nullptr ? world_->clip_bounds : Imath::Box3f();
    prepared_.prepare(std::span<const Ray>(part).first(count), bounds);
    waiting_ = prepared_.valid;
    for (uint32_t apart = prepared_.apart; apart != 0; apart &= apart - 1)
      calls.trace_alone(numbers_[static_cast<size_t>(std::countr_zero(apart))]);
  }
  // Takes every ray at a node of the hierarchy down by one node, and every ray that has left a tree
  // to its next child.
  void descend_level() {
    Queue& queue = at_level_;
    uint32_t count = queue.count;
    std::array<uint8_t, kSlots> entered;
    for (uint32_t k = 0; k < count; ++k) {
      Place& place = this->slot(queue.slot[k]).place;
      const InstanceNode& node = level_.node(queue.child[k]);
      Lanes8 enter(place.t_min), leave(place.t_far * kWiden);
      for (size_t axis = 0; axis < 3; ++axis) {
        const Lanes8 reciprocal(place.reciprocal[axis]);
        const Lanes8 low = (Lanes8::load(node.low[axis]) - Lanes8(place.low_origin[axis])) * reciprocal,
                     high = (Lanes8::load(node.high[axis]) - Lanes8(place.high_origin[axis])) * reciprocal;
        enter = max(enter, min(low, high));
        leave = min(leave, max(low, high));
      }
      const IntLanes8 order = shift_by_nibbles(IntLanes8(node.order[place.signs]));
      enter = permute(enter, order);
      leave = permute(leave, order);
      assert(place.top < place.stack.size());
      TreesInTurn::Frame& frame = place.stack[place.top];
      enter.store(frame.enter.data());
      permute(IntLanes8::load(node.child.data()), order).store(frame.child.data());
      entered[k] = static_cast<uint8_t>(at_most(enter, leave * Lanes8(kWiden)));
    }
    for (uint32_t k = 0; k < leaving_count_; ++k, ++count) {
      entered[count] = 0;
      queue.slot[count] = leaving_[k];
    }
    leaving_count_ = 0;
    for (uint32_t k = 0; k < count; ++k) {
      Place& place = this->slot(queue.slot[k]).place;
      const bool descends = entered[k] != 0;
      const uint32_t top = place.top;
      const uint32_t rest = this->select_bits(descends, place.rest[top - 1], entered[k]), left = rest & (rest - 1);
      const size_t at = top - 1 + static_cast<size_t>(descends);
      const auto next = static_cast<size_t>(std::countr_zero(rest));
      place.rest[at] = static_cast<uint8_t>(left);
      queue.child[k] = place.stack[at].child[next];
      queue.enter[k] = place.stack[at].enter[next];
      queue.far[k] = place.t_far * kWiden;
      place.top = top + static_cast<uint32_t>(descends) - static_cast<uint32_t>(left == 0);
    }
    const uint32_t old_boxes = at_box_.count;
    Offsets ended;
    uint32_t ends = 0;
    queue.count = 0;
    this->sort(queue, count, queue, queue.count, at_box_, at_box_.count, ended, ends);
    for (uint32_t k = 0; k < ends; ++k) { // either at its end or at a box beyond it
      const bool ends_here = this->slot(ended[k]).place.top == 0;
      free_[free_count_] = leaving_[leaving_count_] = ended[k];
      free_count_ += static_cast<uint32_t>(ends_here);
      leaving_count_ += static_cast<uint32_t>(!ends_here);
    }
    for (uint32_t k = 0; k < queue.count; ++k) {
      const auto* node = reinterpret_cast<const std::byte*>(&level_.node(queue.child[k]));
      for (size_t line = 0; line < sizeof(InstanceNode) / 64; ++line) prefetch(node + 64 * line);
    }
    for (uint32_t k = old_boxes; k < at_box_.count; ++k) instances_.fetch(at_box_.child[k] & ~InstanceLevel::kBoxBit);
  }

  // Takes rays that wait into the spaces of their instances, sixteen at a time.
  template <class Calls>
  void enter_instances(std::span<const Ray> rays, const Calls& calls) {
    while (at_box_.count != 0) {
      const uint32_t count = std::min(kRayLanes, at_box_.count), first = at_box_.count - count;
      std::array<Ray, kRayLanes> part;
      std::array<Entered, kRayLanes> entered;
      std::array<uint32_t, kRayLanes> numbers, offsets;
      uint32_t entering = 0;
      for (uint32_t i = 0; i < count; ++i) instances_.fetch_keys(at_box_.child[first + i] & ~InstanceLevel::kBoxBit);
      for (uint32_t i = 0; i < count; ++i) {
        const uint32_t offset = at_box_.slot[first + i], number = at_box_.child[first + i] & ~InstanceLevel::kBoxBit;
        Slot& s = this->slot(offset);
        const Entered now = instances_.enter(number, rays[s.ray], s.place.t_far, part[entering]);
        if (now.tree != nullptr) {
          entered[entering] = now;
          numbers[entering] = number;
          offsets[entering++] = offset;
          continue;
        }
        if (now.is_apart) calls.trace_in(s.ray, number, s.place.t_far);
        leave(offset);
      }
      if (entering != 0) entering_.prepare(std::span<const Ray>(part).first(entering), BoundsOf{entered, entering});
      for (uint32_t i = 0; i < entering; ++i) {
        const uint32_t offset = offsets[i];
        Slot& s = this->slot(offset);
        if (((entering_.enter >> i) & 1U) != 0) {
          s.at = entering_.rays[i];
          s.place.set_tree(*entered[i].tree, entered[i].instance);
          this->begin_tree(offset, entered[i].tree->root);
          continue;
        }
        if (((entering_.apart >> i) & 1U) != 0) [[unlikely]]
          calls.trace_in(s.ray, numbers[i], s.place.t_far);
        leave(offset);
      }
      at_box_.count = first;
      if (first < kRayLanes) break;
    }
  }
  // The bounds of sixteen trees.
  struct BoundsOf {
    alignas(64) std::array<std::array<float, kRayLanes>, 8> faces; // min.x, y, z, max.x; min.z, max.x, y, z

    BoundsOf(const std::array<Entered, kRayLanes>& entered, uint32_t count) {
      const auto load = [&](uint32_t i, size_t from) {
        Float4 vector;
        std::memcpy(&vector, &entered[std::min(i, count - 1)].tree->clip_bounds.min.x + from, sizeof(Float4));
        return vector;
      };
      transpose16([&](uint32_t i) { return load(i, 0); },
                  {faces[0].data(), faces[1].data(), faces[2].data(), faces[3].data()});
      transpose16([&](uint32_t i) { return load(i, 2); },
                  {faces[4].data(), faces[5].data(), faces[6].data(), faces[7].data()});
    }
    [[nodiscard]] Lanes16 low(int axis) const { return Lanes16::load(faces[static_cast<size_t>(axis)].data()); }
    [[nodiscard]] Lanes16 high(int axis) const { return Lanes16::load(faces[static_cast<size_t>(axis) + 5].data()); }
  };

  const Instances instances_;
  const InstanceLevel& level_;
  const Tree* world_;
  Queue at_level_, at_box_;
  std::array<uint32_t, kSlots> leaving_; // rays that have left a tree
  uint32_t leaving_count_ = 0;
  PreparedRays entering_;
  std::array<uint32_t, kRayLanes> numbers_; // of the prepared rays
};

// The calls of a stream through instances for the answers of a batch, a hit or a byte for each ray.
// `Queries` has trace_whole<kAny>(i, hit) and trace_one<kAny>(i, number, t_far, hit), which return
// true if an any-hit ray is blocked.
template <bool kAny, class Queries, class Answer>
struct BatchAnswers {
  Queries queries;
  std::span<Answer> answers;

  [[nodiscard]] float end_of(size_t i) const {
    const float t_max = queries.rays[i].t_max;
    if constexpr (kAny)
      return answers[i] == 0 ? t_max : -1.0f;
    else
      return answers[i].is_hit() ? answers[i].t : t_max;
  }
  void merge(size_t i, const Tree& tree, uint32_t instance, const TreeHit& found) const {
    if constexpr (kAny)
      answers[i] = 1;
    else
      merge_hit(CandidateFilter{queries.s.filter, queries.rays[i], tree, instance}, found, answers[i]);
  }
  void trace_alone(size_t i) const {
    if constexpr (kAny) {
      Hit hit;
      answers[i] = queries.template trace_whole<true>(i, hit) ? 1 : 0;
    } else {
      queries.template trace_whole<false>(i, answers[i]);
    }
  }
  void trace_in(size_t i, uint32_t number, float& t_far) const {
    answer(i, t_far, [&](Hit& hit) { return queries.template trace_one<kAny>(i, number, t_far, hit); });
  }
  // Traces a ray from a node of the hierarchy on.
  void visit(size_t i, uint32_t node, float& t_far) const {
    answer(i, t_far, [&](Hit& hit) { return queries.template visit<kAny>(i, node, t_far, hit); });
  }

 private:
  template <class Trace>
  [[gnu::always_inline]] void answer(size_t i, float& t_far, const Trace& trace) const {
    if constexpr (kAny) {
      Hit hit;
      if (!trace(hit)) return;
      answers[i] = 1;
      t_far = -1.0f;
    } else {
      trace(answers[i]);
    }
  }
};

} // namespace kindling::accel::kd::KINDLING_SIMD
