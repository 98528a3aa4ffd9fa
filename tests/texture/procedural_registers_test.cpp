// Programs give the same values after their results have moved to few registers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/procedural_registers.h"

#include "renderer/texture/texture.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>
#include <vector>

namespace kindling::test {
namespace {

using Op = ProceduralOp;

// A program whose operands are still instructions, with its one stream.
struct Numbered {
  ProceduralProgram program;

  int16_t emit(Op op, std::array<int16_t, 4> operands, std::array<int16_t, 4> i = {}) {
    program.instructions.push_back({.op = op, .operands = operands, .i = i});
    return static_cast<int16_t>(program.instructions.size() - 1);
  }
};

const std::array<Float4, 1> kStream{Float4{0.3f, -0.7f, 1.9f, 0.1f}};

Float4 value_of(const Numbered& numbered, int16_t result) {
  const ProceduralProgramView view = numbered.program.view();
  const ProceduralPoint point{.values = kStream, .across = {}};
  std::vector<Float4> values;
  const auto operand = [&](int16_t o) {
    return o < 0 ? view.constants[static_cast<size_t>(~o)] : values[static_cast<size_t>(o)];
  };
  for (const ProceduralInstruction& instruction : view.instructions) {
    std::array<Float4, 4> operands{};
    for (size_t o = 0; o < 4; ++o)
      if (instruction.operands[o] < static_cast<int16_t>(values.size())) operands[o] = operand(instruction.operands[o]);
    values.push_back(run(instruction, operands, view, point, {}));
  }
  return operand(result);
}

void expect_same_value(const Numbered& numbered, int16_t result) {
  const Float4 expected = value_of(numbered, result);
  ProceduralProgram program = numbered.program;
  program.result = result;
  assign_registers(program);
  ASSERT_LE(program.register_count, static_cast<int16_t>(kMaxProceduralRegisters));
  const Float4 found = run(program.view(), {.values = kStream, .across = {}}, {});
  ASSERT_EQ(std::memcmp(&found, &expected, sizeof expected), 0);
}

TEST(ProceduralRegisters, RandomProgramsKeepTheirValues) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    Numbered numbered;
    for (const float constant : {0.5f, -2.0f, 3.25f})
      numbered.program.constants.push_back(Float4{constant, 1.0f, constant, 0.25f});
    const int count = 1 + static_cast<int>(random() % 60);
    numbered.emit(Op::stream, {});
    for (int k = 1; k < count; ++k) {
      const auto any = [&] { // one of the newer results, or a constant
        const int16_t back = static_cast<int16_t>(random() % 12);
        return random() % 8 == 0 ? static_cast<int16_t>(~static_cast<int>(random() % 3))
                                 : static_cast<int16_t>(std::max(k - 1 - back, 0));
      };
      constexpr std::array kOps{Op::add, Op::multiply, Op::subtract, Op::min, Op::mix, Op::greater, Op::absolute};
      if (random() % 5 == 0) {
        std::array<int16_t, 4> channels;
        for (int16_t& channel : channels) channel = static_cast<int16_t>(random() % 8); // of the first two operands
        numbered.emit(Op::swizzle, {any(), any()}, channels);
      } else {
        numbered.emit(kOps[random() % kOps.size()], {any(), any(), any(), any()});
      }
    }
    expect_same_value(numbered, static_cast<int16_t>(count - 1));
    if (HasFatalFailure()) FAIL() << "trial " << trial;
  }
}

TEST(ProceduralRegisters, AConstantNeedsNone) {
  Numbered numbered;
  numbered.program.constants.push_back(Float4{1.0f, 2.0f, 3.0f, 4.0f});
  numbered.emit(Op::stream, {});
  expect_same_value(numbered, int16_t{-1});
  numbered.program.result = -1;
  assign_registers(numbered.program);
  EXPECT_EQ(numbered.program.register_count, 0);
  EXPECT_TRUE(numbered.program.instructions.empty());
}

// All leaves come first in the file; a sum in pairs needs one register for each level of the tree.
TEST(ProceduralRegisters, ATreeNeedsItsDepth) {
  Numbered numbered;
  std::vector<int16_t> row;
  for (int16_t leaf = 0; leaf < 512; ++leaf) row.push_back(numbered.emit(Op::stream, {}));
  while (row.size() > 1) {
    std::vector<int16_t> sums;
    for (size_t i = 0; i < row.size(); i += 2) sums.push_back(numbered.emit(Op::add, {row[i], row[i + 1]}));
    row = sums;
  }
  ASSERT_EQ(numbered.program.instructions.size(), 1023U);
  expect_same_value(numbered, row[0]);
  numbered.program.result = row[0];
  assign_registers(numbered.program);
  EXPECT_EQ(numbered.program.register_count, 10);
}

// Values that are all needed again after all have been read cannot share registers.
TEST(ProceduralRegisters, ValuesThatAreNeededTogetherHaveTheirOwn) {
  Numbered numbered;
  std::vector<int16_t> values;
  constexpr int16_t kValues = 70;
  for (int16_t k = 0; k < kValues; ++k) values.push_back(numbered.emit(Op::stream, {}));
  int16_t sum = values[0], product = values[0];
  for (int16_t k = 1; k < kValues; ++k) sum = numbered.emit(Op::add, {sum, values[static_cast<size_t>(k)]});
  product = sum;
  for (const int16_t value : values) product = numbered.emit(Op::multiply, {product, value});
  numbered.program.result = product;
  assign_registers(numbered.program);
  EXPECT_GE(numbered.program.register_count, kValues);
}

} // namespace
} // namespace kindling::test
