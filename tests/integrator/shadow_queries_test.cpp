// Shadow rays take the faster call of an accelerator, whichever that is.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/shadow_queries.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling::test {
namespace {

// A clock that only accelerators move on.
struct TestClock {
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<TestClock, duration>;
  static inline time_point time;
  static time_point now() { return time; }
};

// Blocks every third ray. Its calls take a time for each ray.
class SlowAccelerator final : public accel::Accelerator {
 public:
  int64_t stream_ns, packets_ns; // for each ray
  bool alike = true;
  mutable size_t stream_calls = 0, packet_calls = 0;

  SlowAccelerator(int64_t of_stream_ns, int64_t of_packets_ns) : stream_ns(of_stream_ns), packets_ns(of_packets_ns) {}

  [[nodiscard]] accel::Hit intersect(const accel::Ray&) const override { return {}; }
  [[nodiscard]] bool occluded(const accel::Ray&) const override { return false; }
  void intersect(std::span<const accel::Ray>, std::span<accel::Hit>) const override {}
  [[nodiscard]] bool coherent_equals_single() const override { return alike; }
  void occluded(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const override {
    ++stream_calls;
    answer(rays, occluded, stream_ns);
  }
  void occluded_coherent(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const override {
    ++packet_calls;
    answer(rays, occluded, packets_ns);
  }
  [[nodiscard]] Imath::Box3f bounds() const override { return {}; }
  [[nodiscard]] accel::Statistics statistics() const override { return {}; }

 private:
  static void answer(std::span<const accel::Ray> rays, std::span<uint8_t> occluded, int64_t ray_ns) {
    for (size_t i = 0; i < rays.size(); ++i) occluded[i] = rays[i].index % 3 == 0 ? 1 : 0;
    TestClock::time += std::chrono::nanoseconds(ray_ns * static_cast<int64_t>(rays.size()));
  }
};

using Queries = ShadowQueriesBy<TestClock>;

void trace(Queries& queries, const SlowAccelerator& accelerator, size_t batches, size_t ray_count) {
  std::vector<accel::Ray> rays(ray_count);
  for (size_t i = 0; i < ray_count; ++i) rays[i].index = static_cast<uint32_t>(i);
  std::vector<uint8_t> occluded(ray_count, 2);
  for (size_t batch = 0; batch < batches; ++batch) {
    queries.trace(accelerator, rays, occluded);
    for (size_t i = 0; i < ray_count; ++i) ASSERT_EQ(occluded[i], i % 3 == 0 ? 1 : 0);
  }
}

TEST(ShadowQueries, MostBatchesTakeTheFasterCall) {
  for (const bool packets_win : {false, true}) {
    const SlowAccelerator accelerator(packets_win ? 200 : 150, packets_win ? 150 : 200);
    Queries queries;
    trace(queries, accelerator, 2 * Queries::kFirstTrials + 10 * Queries::kTrialPeriod, 1000);
    EXPECT_EQ(packets_win ? accelerator.stream_calls : accelerator.packet_calls, Queries::kFirstTrials + 10);
  }
}

TEST(ShadowQueries, TheChoiceFollowsAChangeOfTimes) {
  SlowAccelerator accelerator(150, 200);
  Queries queries;
  trace(queries, accelerator, 200, 1000);
  accelerator.stream_ns = 400;
  trace(queries, accelerator, 200, 1000); // streams have been slower for a while
  const size_t streams = accelerator.stream_calls;
  trace(queries, accelerator, 10 * Queries::kTrialPeriod, 1000);
  EXPECT_EQ(accelerator.stream_calls - streams, 10U);
}

TEST(ShadowQueries, OneLongPauseChangesNoChoice) {
  SlowAccelerator accelerator(150, 200);
  Queries queries;
  trace(queries, accelerator, 200, 1000);
  accelerator.stream_ns = 1'000'000; // the thread is suspended
  trace(queries, accelerator, 1, 1000);
  accelerator.stream_ns = 150;
  const size_t packets = accelerator.packet_calls;
  trace(queries, accelerator, Queries::kTrialPeriod, 1000);
  EXPECT_LE(accelerator.packet_calls - packets, 1U);
}

TEST(ShadowQueries, SmallBatchesAreNoTrials) {
  SlowAccelerator accelerator(200, 150);
  Queries queries;
  trace(queries, accelerator, 100, Queries::kMinTimedRays - 1);
  EXPECT_EQ(accelerator.packet_calls, 0U);
  trace(queries, accelerator, 2 * Queries::kFirstTrials, 1000);
  const size_t streams = accelerator.stream_calls;
  trace(queries, accelerator, 100, Queries::kMinTimedRays - 1);
  EXPECT_EQ(accelerator.stream_calls, streams);
}

TEST(ShadowQueries, PacketsThatMayAnswerDifferentlyAreNotUsed) {
  SlowAccelerator accelerator(200, 1);
  accelerator.alike = false;
  Queries queries;
  trace(queries, accelerator, 100, 1000);
  EXPECT_EQ(accelerator.packet_calls, 0U);
}

} // namespace
} // namespace kindling::test
