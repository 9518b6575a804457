#include "collision/node_volumes.h"

#include <algorithm>
#include <cmath>

#include "collision/motion_input.h"
#include "collision/round_up.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

const Vector3d& at(std::span<const Vector3d> field, std::int32_t v) {
  return field[static_cast<std::size_t>(v)];
}

// Around the middle of the box: a mode's mean in the sense of the least largest departure along
// every axis.
BoundingBall ballOf(std::span<const Vector3d> field, std::span<const std::int32_t> vertices) {
  Vector3d low = at(field, vertices[0]), high = low;
  for (const std::int32_t v : vertices) {
    low = low.cwiseMin(at(field, v));
    high = high.cwiseMax(at(field, v));
  }
  BoundingBall ball{0.5 * (low + high), 0};
  double farthest_squared = 0;
  for (const std::int32_t v : vertices)
    farthest_squared = std::max(farthest_squared, squaredLength(at(field, v) - ball.center));
  ball.radius = roundedUp(std::sqrt(farthest_squared), 12);
  return ball;
}

Dop18 dopOf(std::span<const Vector3d> field, std::span<const std::int32_t> vertices) {
  Dop18 dop;
  dop.low = dop.high = alongDop(at(field, vertices[0]));
  for (const std::int32_t v : vertices) {
    const std::array<double, Dop18::kDirections> along = alongDop(at(field, v));
    for (std::size_t k = 0; k < Dop18::kDirections; ++k) {
      dop.low[k] = std::min(dop.low[k], along[k]);
      dop.high[k] = std::max(dop.high[k], along[k]);
    }
  }
  return dop;
}

double sizeOf(std::span<const Vector3d> field, std::span<const std::int32_t> vertices) {
  double size = 0;
  for (const std::int32_t v : vertices) size = std::max(size, at(field, v).cwiseAbs().maxCoeff());
  return size;
}

}  // namespace

std::array<double, Dop18::kDirections> alongDop(const Vector3d& p) {
  return {p.x(),         p.y(),         p.z(),         p.x() + p.y(), p.x() - p.y(),
          p.y() + p.z(), p.y() - p.z(), p.z() + p.x(), p.z() - p.x()};
}

BlendedVolumes::BlendedVolumes(const BlendedMotion& motion, std::span<const std::int32_t> vertices)
    : has_base_(!motion.base().empty()) {
  const auto add = [&](const BlendedMotion::Field& field) {
    fields_.push_back({ballOf(field, vertices), dopOf(field, vertices), sizeOf(field, vertices)});
  };
  if (has_base_) add(motion.base());
  for (const BlendedMotion::Field& field : motion.fields()) add(field);
}

// One rounding a product and sum, of the vertices and of the volumes, and one of alongDop(): of
// numbers that are at most twice the sum of magnitudes; the factor 2 for a length is in it.
double BlendedVolumes::rounding(std::span<const double> parameters) const {
  double size = has_base_ ? fields_[0].size : 0;
  const std::size_t first = has_base_ ? 1 : 0;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    size += std::abs(parameters[k]) * fields_[first + k].size;
  return roundedUp(8 * (static_cast<double>(fields_.size()) + 6) * kUnitRoundoff * size, 8);
}

BoundingBall BlendedVolumes::ball(std::span<const double> parameters) const {
  BoundingBall sum;
  std::size_t field = 0;
  if (has_base_) sum = fields_[field++].ball;
  for (std::size_t k = 0; k < parameters.size(); ++k, ++field) {
    sum.center += parameters[k] * fields_[field].ball.center;
    sum.radius += std::abs(parameters[k]) * fields_[field].ball.radius;
  }
  const auto operations = 2 * static_cast<double>(fields_.size());
  return {sum.center, roundedUp(sum.radius + rounding(parameters), operations)};
}

Dop18 BlendedVolumes::dop(std::span<const double> parameters) const {
  Dop18 sum;
  std::size_t field = 0;
  if (has_base_) sum = fields_[field++].dop;
  for (std::size_t k = 0; k < parameters.size(); ++k, ++field) {
    const Dop18& dop = fields_[field].dop;
    const double p = parameters[k];
    for (std::size_t i = 0; i < Dop18::kDirections; ++i) {
      sum.low[i] += p * (p >= 0 ? dop.low[i] : dop.high[i]);
      sum.high[i] += p * (p >= 0 ? dop.high[i] : dop.low[i]);
    }
  }
  const double error = rounding(parameters);
  for (double& low : sum.low) low -= error;
  for (double& high : sum.high) high += error;
  return sum;
}

SkinnedBall::SkinnedBall(const SkinnedVertices& motion, std::span<const std::int32_t> vertices)
    : rest_(ballOf(motion.rest(), vertices)) {
  struct Seen {
    double least = 0, largest = 0;
    std::size_t count = 0;
  };
  std::vector<Seen> seen(static_cast<std::size_t>(motion.boneCount()));
  for (const std::int32_t v : vertices) {
    terms_ = std::max(terms_, static_cast<double>(motion.influences(v).size()));
    for (const SkinnedVertices::Influence& influence : motion.influences(v)) {
      if (!(influence.weight > 0)) continue;
      Seen& s = seen[static_cast<std::size_t>(influence.bone)];
      s.least = s.count == 0 ? influence.weight : std::min(s.least, influence.weight);
      s.largest = std::max(s.largest, influence.weight);
      ++s.count;
    }
  }
  double sum = 0;
  for (std::size_t b = 0; b < seen.size(); ++b) {
    if (seen[b].count == 0) continue;
    const double least = seen[b].count == vertices.size() ? seen[b].least : 0;
    parts_.push_back({static_cast<std::int32_t>(b), 0.5 * (least + seen[b].largest),
                      0.5 * (seen[b].largest - least)});
    sum += parts_.back().mean;
  }
  // The means are to add up to 1: each takes its share of what is missing.
  const double missing = (1 - sum) / static_cast<double>(parts_.size());
  for (Part& part : parts_) {
    part.mean += missing;
    part.range = (part.range + std::abs(missing)) * (1 + 8 * kUnitRoundoff) + 4 * kUnitRoundoff;
  }
  terms_ = std::max(terms_, static_cast<double>(parts_.size()));
}

// x = sum_b w_b T_b r = sum_b w_b T_b c + sum_b w_b R_b (r - c). The second sum is at most the
// radius times the largest norm of a bone's R (1 but for rounding: its Frobenius norm over sqrt(3)
// would do for rotations; the norm of R^T R - 1 bounds what it may be more). The first is a convex
// combination of the centre's images q_b = T_b c; with C = sum_b m_b q_b, the means m_b and
// |w_b - m_b| <= h_b, both summing to 1, it is within
//     min( max_b |q_b - C|,  sum_b h_b |q_b - C| )
// of C.
BoundingBall SkinnedBall::ball(std::span<const double> parameters) const {
  Vector3d center = Vector3d::Zero();
  double stretch = 1, size = 0;
  const auto image = [&](const Part& part) {
    const double* X = parameters.data() + 12 * static_cast<std::size_t>(part.bone);
    Vector3d q;
    for (int k = 0; k < 3; ++k) {
      q[k] = X[3 * k] * rest_.center.x() + X[3 * k + 1] * rest_.center.y() +
             X[3 * k + 2] * rest_.center.z() + X[9 + k];
    }
    return q;
  };
  const double reach = rest_.center.cwiseAbs().maxCoeff() + rest_.radius;
  for (const Part& part : parts_) {
    const double* X = parameters.data() + 12 * static_cast<std::size_t>(part.bone);
    double departure_squared = 0;  // of R^T R from 1
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double product = X[i] * X[j] + X[3 + i] * X[3 + j] + X[6 + i] * X[6 + j];
        const double d = product - (i == j ? 1 : 0);
        departure_squared += d * d;
      }
      double row = std::abs(X[9 + i]);
      for (int j = 0; j < 3; ++j) row += std::abs(X[3 * i + j]) * reach;
      size = std::max(size, row);
    }
    stretch = std::max(stretch, std::sqrt(1 + std::sqrt(departure_squared) + 64 * kUnitRoundoff));
    center += part.mean * image(part);
  }
  double farthest = 0, spread = 0;
  for (const Part& part : parts_) {
    const double away = std::sqrt(squaredLength(image(part) - center));
    farthest = std::max(farthest, away);
    spread += part.range * away;
  }
  const double radius = rest_.radius * stretch + std::min(farthest, spread);
  // As SkinnedBounds: 64 (terms + 12) units of the size, twice for a length.
  const double rounding = 128 * (terms_ + 12) * kUnitRoundoff * size;
  return {center, roundedUp(radius + rounding, 2 * terms_ + 32)};
}

}  // namespace leeway::collision
