// The instructions that a warp issues for threads on different ways.
// SPDX-License-Identifier: Apache-2.0
#include "tests/device/ptx/count_steps.h"

#include <gtest/gtest.h>

#include <array>

namespace ptx {
namespace {

// Block 1 may repeat itself. All ways meet in block 3 of the function, and in block 2 of the called
// one.
constexpr std::array<u32, 4> kInstructions{10, 5, 7, 1}, kMeetings{3, 3, 3, 4};
constexpr std::array<u32, 3> kOfCalled{100, 30, 3}, kMeetingsOfCalled{2, 2, 3};
constexpr Function kFunction{"function", kInstructions.data(), kMeetings.data()};
constexpr Function kCalled{"called", kOfCalled.data(), kMeetingsOfCalled.data()};

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

TEST(CountSteps, ThreadsWaitWhereTheirWaysMeetHoweverOftenOthersGoAround) {
  // Block 0 leads to 1 or 2, both lead to 3, and 3 back to 0 or to the end.
  const std::vector<Step> one{at(0), at(1), at(3), at(0), at(2), at(3)}, other{at(0), at(2), at(3)};
  EXPECT_EQ(issued_by_warp({one, other}), 10U + 5 + 7 + 1 + 10 + 7 + 1);
}

TEST(CountSteps, ThreadsThatReturnDoNotMeetTheOthers) {
  constexpr std::array<u32, 4> never{4, 4, 4, 4}; // some way from each block ends the function
  const Function leaving{"leaving", kInstructions.data(), never.data()};
  const auto step = [&](u32 block) { return Step{&leaving, block, 0}; };
  EXPECT_EQ(issued_by_warp({{step(0), step(1)}, {step(0), step(1), step(3)}, {step(0), step(2), step(3)}}),
            10U + 5 + 1 + 7 + 1);
}

} // namespace
} // namespace ptx
