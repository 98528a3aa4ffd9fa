// Evaluation and sampling of the sheen lobe.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/sheen_lobe.h"

#include "renderer/sampling/warp.h"

namespace kindling {

namespace {

constexpr float kLog2E = std::numbers::log2e_v<float>;

// Position of sqrt(mu) in a row of the table.
struct Column {
  uint32_t index;
  float s;
};
Column column_of(float mu) {
  const float x = std::sqrt(std::min(mu, 1.0f)) * static_cast<float>(kSheenMuNodes - 1);
  const uint32_t index = cell_of(x, kSheenMuNodes - 2);
  return {index, x - static_cast<float>(index)};
}

// Interpolates between two rows, the first of which is `row`.
float at_column(const SheenNode* row, const Column& column, float fraction, float SheenNode::*member) {
  const SheenNode* n = row + column.index;
  const SheenNode* m = n + kSheenMuNodes;
  return lerp(lerp(n[0].*member, n[1].*member, column.s), lerp(m[0].*member, m[1].*member, column.s), fraction);
}

} // namespace

SheenLobe::SheenLobe(float roughness, const V3f& wo, const SheenNode* table)
    : wo_(wo), gain_(roughness < kSheenGainRoughness) {
  const float alpha = roughness * roughness;
  inverse_alpha_ = 1.0f / alpha;
  norm_ = (2.0f + inverse_alpha_) * (0.125f * kInvPi) / wo.z;

  const float t = square(1.0f - alpha);
  a_ = lerp(21.5473f, 25.3245f, t) * kLog2E;
  b_ = lerp(3.82987f, 3.32435f, t);
  c_ = lerp(0.19823f, 0.16801f, t);
  d_ = lerp(-1.97760f, -1.27393f, t) * kLog2E;
  e_ = lerp(-4.32054f, -4.85967f, t) * kLog2E;
  twice_half_ = 2.0f * (a_ / (1.0f + b_ * fast_exp2(-c_)) + 0.5f * d_ + e_);
  shadowing_o_ = shadowing(wo.z);

  const float y = (roughness - kMinSheenRoughness) * ((kSheenRoughnessNodes - 1) / (1.0f - kMinSheenRoughness));
  const uint32_t row = cell_of(y, kSheenRoughnessNodes - 2);
  row_ = table + row * kSheenMuNodes;
  fraction_ = y - static_cast<float>(row);

  const Column column = column_of(wo.z);
  const auto seen = [&](float SheenNode::*member) { return at_column(row_, column, fraction_, member); };
  albedo_ = seen(&SheenNode::albedo);
  greater_ = seen(&SheenNode::greater);
  if (gain_) raw_o_ = std::max(1.0f, seen(&SheenNode::raw));
  stretch_x_ = seen(&SheenNode::stretch_x);
  stretch_y_ = seen(&SheenNode::stretch_y);
  shear_ = seen(&SheenNode::shear);
  pdf_norm_ = stretch_x_ * stretch_y_ * kInvPi;

  const float length = std::sqrt(wo.x * wo.x + wo.y * wo.y);
  cos_azimuth_ = length > 1e-12f ? wo.x / length : 1.0f;
  sin_azimuth_ = length > 1e-12f ? wo.y / length : 0.0f;
}

float SheenLobe::shadowing(float mu) const {
  const bool low = mu < 0.5f;
  const float x = low ? mu : std::max(1.0f - mu, 0.0f);
  const float l = a_ / (1.0f + b_ * fast_pow(x, c_)) + d_ * x + e_;
  return fast_exp2(low ? l : twice_half_ - l);
}

float SheenLobe::interpolated(float SheenNode::*member, float mu) const {
  return at_column(row_, column_of(mu), fraction_, member);
}

float SheenLobe::raw_value(const V3f& wi) const {
  const V3f sum = wo_ + wi;
  const float sin2 = std::min((sum.x * sum.x + sum.y * sum.y) / sum.length2(), 1.0f);
  const float d = fast_pow(sin2, 0.5f * inverse_alpha_);
  return norm_ * d / (1.0f + shadowing_o_ + shadowing(wi.z));
}

float SheenLobe::pdf(const V3f& wi) const {
  const float x = cos_azimuth_ * wi.x + sin_azimuth_ * wi.y;
  const float y = cos_azimuth_ * wi.y - sin_azimuth_ * wi.x;
  const float length2 = square(stretch_x_ * x - shear_ * wi.z) + square(stretch_y_ * y) + wi.z * wi.z;
  return pdf_norm_ * wi.z / (length2 * length2);
}

SheenLobe::Eval SheenLobe::eval(const V3f& wi) const {
  float value = raw_value(wi);
  if (gain_) value /= std::max(raw_o_, interpolated(&SheenNode::raw, wi.z));
  return {value, pdf(wi)};
}

V3f SheenLobe::sample(const V2f& u) const {
  const V3f w = sample_cosine_hemisphere(u);
  const float x = (w.x + shear_ * w.z) / stretch_x_;
  const float y = w.y / stretch_y_;
  const V3f local(x * cos_azimuth_ - y * sin_azimuth_, x * sin_azimuth_ + y * cos_azimuth_, w.z);
  return local * (1.0f / local.length());
}

} // namespace kindling
