// Operations on eight lanes give the bits of the operations on one float.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/frame.h"
#include "renderer/base/lanes.h"
#include "tests/base/result_hash.h"
#include "tests/base/same_bits.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::same_bits;

// Calls compare(lane, a, b, lanes of a, lanes of b) for a million pairs, special numbers among
// them.
template <typename Compare>
void for_million_pairs(const Compare& compare) {
  test::Inputs inputs{test::Random(5), true};
  for (int i = 0; i < 1'000'000 / static_cast<int>(Lanes::kCount); ++i) {
    LaneNumbers a, b;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      a[lane] = inputs.any(-4.0f, 4.0f);
      b[lane] = inputs.any(-4.0f, 4.0f);
    }
    compare(a, b);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Lanes, GiveTheBitsOfOneFloat) {
  for_million_pairs([](const LaneNumbers& a, const LaneNumbers& b) {
    const Lanes x = a.load(), y = b.load();
    const Lanes sum = x + y, difference = x - y, product = x * y, quotient = x / y, negative = -x;
    const Lanes larger = maximum(x, y), smaller = minimum(x, y), positive = absolute(x), root = square_root(positive);
    const Lanes with_sign = with_sign_of(x, y), selected = select(x < y, x, y), angle = elementary::atan2(x, y);
    const LaneMask less = x<y, greater = x> y, at_most = x <= y, at_least = x >= y;
    for (size_t i = 0; i < Lanes::kCount; ++i) {
      const float p = a[i], q = b[i];
      EXPECT_TRUE(same_bits(sum[i], p + q) && same_bits(difference[i], p - q) && same_bits(product[i], p * q) &&
                  same_bits(quotient[i], p / q) && same_bits(negative[i], -p))
          << p << " and " << q;
      EXPECT_TRUE(same_bits(larger[i], std::max(p, q)) && same_bits(smaller[i], std::min(p, q))) << p << " and " << q;
      EXPECT_TRUE(same_bits(positive[i], std::fabs(p)) && same_bits(root[i], std::sqrt(std::fabs(p)))) << p;
      EXPECT_TRUE(same_bits(with_sign[i], std::copysign(p, q)) && same_bits(selected[i], p < q ? p : q))
          << p << " and " << q;
      EXPECT_TRUE(same_bits(angle[i], elementary::atan2(p, q))) << p << " and " << q;
      EXPECT_TRUE((less[i] != 0) == (p < q) && (greater[i] != 0) == (p > q) && (at_most[i] != 0) == (p <= q) &&
                  (at_least[i] != 0) == (p >= q))
          << p << " and " << q;
    }
    EXPECT_EQ(packed(less), packed(lane_mask(packed(less))));
    const Int8 cells = cells_of(x, 7);
    const Lanes mixed = lerp(x, y, x), squared = square(x), safe_root = safe_sqrt(x);
    const auto twice = [&] { return x + x; };
    const Lanes doubled = select_result(less, twice, [&] { return y; });
    for (size_t i = 0; i < Lanes::kCount; ++i) {
      const float p = a[i], q = b[i];
      EXPECT_EQ(static_cast<uint32_t>(cells[i]), cell_of(p, 7)) << p;
      EXPECT_TRUE(same_bits(mixed[i], lerp(p, q, p)) && same_bits(squared[i], square(p))) << p << " and " << q;
      EXPECT_TRUE(same_bits(safe_root[i], safe_sqrt(p)) && same_bits(doubled[i], p < q ? p + p : q))
          << p << " and " << q;
    }
    bool some = false, every = true;
    for (size_t i = 0; i < Lanes::kCount; ++i) some |= a[i] < b[i], every &= a[i] < b[i];
    EXPECT_EQ(any(less), some);
    EXPECT_EQ(all(less), every);
  });
}

TEST(Lanes, LengthsAreThoseOfSingleVectors) {
  test::Inputs inputs{test::Random(6), true};
  int tiny = 0;
  for (int i = 0; i < 125'000; ++i) {
    LaneVectors v;
    const float scale = i % 3 == 0 ? 1e-21f : 1.0f; // squares of tiny vectors underflow
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) v.set(lane, inputs.any_3d(-2.0f, 2.0f) * scale);
    const Lanes length = length_of(v.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      ASSERT_TRUE(same_bits(length[lane], v[lane].length())) << v[lane];
      tiny += v[lane].length2() < 1e-38f && v[lane].length() > 0.0f ? 1 : 0;
    }
  }
  EXPECT_GT(tiny, 1000);
}

TEST(Lanes, VectorsHaveTheBitsOfSingleOnes) {
  test::Inputs inputs{test::Random(7), true};
  for (int i = 0; i < 125'000; ++i) {
    LaneVectors v, w;
    LaneNumbers t;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      v.set(lane, i % 5 == 0 ? V3f(0.0f) : inputs.any_3d(-2.0f, 2.0f));
      w.set(lane, inputs.any_3d(-2.0f, 2.0f));
      t[lane] = inputs.any(-1.0f, 1.0f);
    }
    const Lanes largest = max_component(v.load()), largest_size = max_abs(v.load());
    const LaneMask black = is_black(v.load());
    const Imath::Vec3<Lanes> mixed = lerp(v.load(), w.load(), t.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      ASSERT_TRUE(same_bits(largest[lane], max_component(v[lane])) && same_bits(largest_size[lane], max_abs(v[lane])))
          << v[lane];
      ASSERT_EQ(black[lane] != 0, is_black(v[lane])) << v[lane];
      ASSERT_TRUE(same_bits(lane_of(mixed, lane), lerp(v[lane], w[lane], t[lane]))) << v[lane] << w[lane];
    }
  }
}

// Normals of all directions, those along the axes among them.
TEST(Lanes, FramesHaveTheBitsOfSingleOnes) {
  test::Random random(8);
  for (int i = 0; i < 125'000; ++i) {
    LaneVectors normals, vectors;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const auto number = [&] { return random.next_u64() % 4 == 0 ? 0.0f : random.next_1d() - 0.5f; };
      V3f n(number(), number(), number());
      if (n.length() == 0.0f) n.z = -0.5f;
      normals.set(lane, n.normalized());
      vectors.set(lane, V3f(number(), number(), number()));
    }
    const auto together = FrameOf<Lanes>::around(normals.load());
    const auto local = together.to_local(vectors.load()), world = together.to_world(vectors.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const Frame alone = Frame::around(normals[lane]);
      ASSERT_TRUE(same_bits(lane_of(together.tangent, lane), alone.tangent) &&
                  same_bits(lane_of(together.bitangent, lane), alone.bitangent) &&
                  same_bits(lane_of(together.normal, lane), alone.normal))
          << normals[lane];
      ASSERT_TRUE(same_bits(lane_of(local, lane), alone.to_local(vectors[lane])) &&
                  same_bits(lane_of(world, lane), alone.to_world(vectors[lane])))
          << normals[lane] << vectors[lane];
    }
  }
}

TEST(Lanes, ColumnsBecomeRows) {
  Lanes columns[Lanes::kCount];
  for (size_t i = 0; i < Lanes::kCount; ++i)
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) columns[i].v[lane] = static_cast<float>(10 * lane + i);
  LaneRows rows;
  rows.store_columns(columns);
  for (size_t row = 0; row < Lanes::kCount; ++row)
    for (size_t i = 0; i < Lanes::kCount; ++i) EXPECT_EQ(rows[row][i], static_cast<float>(10 * row + i));
}

TEST(Lanes, ColumnsOfRowsAtAnyAddress) {
  std::array<float, 64> numbers;
  for (size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<float>(i);
  const std::array<size_t, Lanes::kCount> starts{0, 5, 9, 14, 60, 33, 2, 47};
  std::array<const float*, Lanes::kCount> rows;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) rows[lane] = numbers.data() + starts[lane];
  const std::array<Lanes, 4> columns = load_columns(rows);
  for (size_t lane = 0; lane < Lanes::kCount; ++lane)
    for (size_t i = 0; i < 4; ++i) EXPECT_EQ(columns[i][lane], static_cast<float>(starts[lane] + i));
}

} // namespace
} // namespace kindling
