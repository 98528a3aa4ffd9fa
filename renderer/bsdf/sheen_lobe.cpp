// Evaluation and sampling of the sheen lobe.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/sheen_lobe.h"

#include "renderer/base/on_gpu.h"
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

// Interpolates between two rows.
template <typename Real>
Real interpolate(const Real (&corners)[4], const Real& s, float fraction) {
  const Real upper = corners[0] + (corners[1] - corners[0]) * s, lower = corners[2] + (corners[3] - corners[2]) * s;
  return upper + (lower - upper) * fraction;
}

// The first row is `row`.
float at_column(const SheenNode* row, const Column& column, float fraction, float SheenNode::*member) {
  const SheenNode* n = row + column.index;
  const SheenNode* m = n + kSheenMuNodes;
  return interpolate({n[0].*member, n[1].*member, m[0].*member, m[1].*member}, column.s, fraction);
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

template <typename Real>
Real SheenLobe::shadowing(const Real& mu) const {
  const auto low = mu < 0.5f;
  const Real x = select(low, mu, maximum(Real(1.0f - mu), Real(0.0f)));
  const Real l = a_ / (1.0f + b_ * fast_pow(x, c_)) + d_ * x + e_;
  return fast_exp2(select(low, l, Real(twice_half_ - l)));
}

float SheenLobe::interpolated(float SheenNode::*member, float mu) const {
  return at_column(row_, column_of(mu), fraction_, member);
}
#if !KINDLING_ON_GPU
Lanes SheenLobe::interpolated(float SheenNode::*member, const Lanes& mu) const {
  LaneNumbers corners[4], s;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    const Column column = column_of(mu[lane]);
    const SheenNode* const n = row_ + column.index;
    const SheenNode* const m = n + kSheenMuNodes;
    corners[0][lane] = n[0].*member, corners[1][lane] = n[1].*member;
    corners[2][lane] = m[0].*member, corners[3][lane] = m[1].*member;
    s[lane] = column.s;
  }
  return interpolate({corners[0].load(), corners[1].load(), corners[2].load(), corners[3].load()}, s.load(), fraction_);
}
#endif

template <typename Real>
Real SheenLobe::raw_value(const Imath::Vec3<Real>& wi) const {
  const Real x = wo_.x + wi.x, y = wo_.y + wi.y, z = wo_.z + wi.z;
  const Real across2 = x * x + y * y;
  const Real sin2 = minimum(Real(across2 / (across2 + z * z)), Real(1.0f));
  const Real d = fast_pow(sin2, 0.5f * inverse_alpha_);
  return norm_ * d / (1.0f + shadowing_o_ + shadowing(wi.z));
}

template <typename Real>
Real SheenLobe::pdf(const Imath::Vec3<Real>& wi) const {
  const Real x = stretch_x_ * (cos_azimuth_ * wi.x + sin_azimuth_ * wi.y) - shear_ * wi.z;
  const Real y = stretch_y_ * (cos_azimuth_ * wi.y - sin_azimuth_ * wi.x);
  const Real length2 = x * x + y * y + wi.z * wi.z;
  return pdf_norm_ * wi.z / (length2 * length2);
}

template <typename Real>
SheenLobe::EvalOf<Real> SheenLobe::eval(const Imath::Vec3<Real>& wi) const {
  Real value = raw_value(wi);
  if (gain_) value = value / maximum(Real(raw_o_), interpolated(&SheenNode::raw, wi.z));
  return {value, pdf(wi)};
}

template float SheenLobe::raw_value(const V3f&) const;
template SheenLobe::Eval SheenLobe::eval(const V3f&) const;
#if !KINDLING_ON_GPU
template SheenLobe::EvalOf<Lanes> SheenLobe::eval(const Imath::Vec3<Lanes>&) const;
#endif

V3f SheenLobe::sample(const V2f& u) const {
  const V3f w = sample_cosine_hemisphere(u);
  const float x = (w.x + shear_ * w.z) / stretch_x_;
  const float y = w.y / stretch_y_;
  const V3f local(x * cos_azimuth_ - y * sin_azimuth_, x * sin_azimuth_ + y * cos_azimuth_, w.z);
  return local * (1.0f / local.length());
}

} // namespace kindling
