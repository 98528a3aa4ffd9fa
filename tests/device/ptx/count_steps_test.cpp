// The instructions that a warp issues for threads on different ways.
// SPDX-License-Identifier: Apache-2.0
#include "tests/device/ptx/count_steps.h"

#include <gtest/gtest.h>

#include <array>

namespace ptx {
namespace {

constexpr std::array<u32, 4> kInstructions{10, 5, 7, 1}, kOfCalled{100, 30, 3, 0};
constexpr Function kFunction{"function", kInstructions.data()}, kCalled{"called", kOfCalled.data()};

Step at(u32 block) { return {&kFunction, block, 0}; }
Step in_call(u32 block) { return {&kCalled, block, 1}; }

TEST(CountSteps, OneWayIsIssuedOnce) {
  EXPECT_EQ(issued_by_warp({}), 0U);
  EXPECT_EQ(issued_by_warp({{at(0), at(3)}}), 11U);
  EXPECT_EQ(issued_by_warp({{at(0), at(3)}, {at(0), at(3)}, {at(0), at(3)}}), 11U);
}

TEST(CountSteps, BothSidesOfABranchAreIssuedAndMeetBehindIt) {
  EXPECT_EQ(issued_by_warp({{at(0), at(1), at(3)}, {at(0), at(2), at(3)}}), 10U + 5 + 7 + 1);
  EXPECT_EQ(issued_by_warp({{at(0), at(3)}, {at(0), at(2), at(3)}}), 10U + 7 + 1);
}

TEST(CountSteps, ALoopIsIssuedAsOftenAsItsLongestThreadNeeds) {
  EXPECT_EQ(issued_by_warp({{at(0), at(1), at(1), at(1), at(3)}, {at(0), at(1), at(3)}, {at(0), at(3)}}),
            10U + 3 * 5 + 1);
}

TEST(CountSteps, ThreadsThatCallMeetTheOthersAfterTheirReturn) {
  EXPECT_EQ(issued_by_warp({{at(0), in_call(0), in_call(2), at(1)}, {at(0), at(1)}}), 10U + 100 + 3 + 5);
  EXPECT_EQ(issued_by_warp({{at(0), in_call(0), in_call(1), at(1)}, {at(0), in_call(0), in_call(2), at(1)}}),
            10U + 100 + 30 + 3 + 5);
}

} // namespace
} // namespace ptx
