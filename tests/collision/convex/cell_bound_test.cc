#include "collision/convex/round_depth/cell_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collision/convex/round_depth/curved_face.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;

constexpr ShapeType kRound[] = {ShapeType::kCylinder, ShapeType::kCone, ShapeType::kEllipsoid};
constexpr ShapeType kAny[] = {ShapeType::kCapsule,  ShapeType::kBox,  ShapeType::kConvexHull,
                              ShapeType::kCylinder, ShapeType::kCone, ShapeType::kEllipsoid};

CurvedCorner cornerAt(const CurvedFaces& faces, const Pose& X_BA, const Vector3d& x, double depth,
                      CurvedChoice& choice) {
  faces.blend(faces.along(x), depth, 1, choice);
  CurvedCorner c;
  c.x = x;
  c.center = faces.center(1, choice) - placed(X_BA, faces.center(0, choice));
  c.scaled[0] = faces.semiAxes(0).cwiseProduct(rotatedBack(X_BA.rotation, x));
  c.scaled[1] = faces.semiAxes(1).cwiseProduct(x);
  for (int k = 0; k < 2; ++k) c.share[k] = faces.share(k, choice);
  return c;
}

// Extended precision: eleven bits more than double.
using Wide = Eigen::Matrix<long double, 3, 1>;

Wide inA(const Pose& X_BA, const Wide& x) {
  return X_BA.rotation.cast<long double>().transpose() * x;
}

// The bound at a corner.
long double valueAt(const CurvedFaces& faces, const Pose& X_BA, const Vector3d& x_b,
                    const CurvedChoice& choice) {
  const Wide x = x_b.cast<long double>(), x_a = inA(X_BA, x);
  const Wide center_a = faces.center(0, choice).cast<long double>(),
             center_b = faces.center(1, choice).cast<long double>();
  long double value =
      x.dot(center_b) - x_a.dot(center_a) - x.dot(X_BA.translation.cast<long double>());
  const Wide local[2] = {x_a, x};
  for (int k = 0; k < 2; ++k) {
    const Wide scaled = faces.semiAxes(k).cast<long double>().cwiseProduct(local[k]);
    value += static_cast<long double>(faces.share(k, choice)) * scaled.norm();
  }
  return value;
}

// The reach of a core along d, from its definition.
long double mostOf(const ConvexView& view, const Wide& d) {
  const Wide size = view.size.cast<long double>();
  const long double beside = std::hypot(d.x(), d.y());
  switch (view.core) {
    case Core::kSegment:
      return size.z() * std::abs(d.z());
    case Core::kPoints: {
      long double most = view.points[0].cast<long double>().dot(d);
      for (int i = 1; i < view.count; ++i) {
        most = std::max(most, view.points[i].cast<long double>().dot(d));
      }
      return most;
    }
    case Core::kBox:
      return size.dot(d.cwiseAbs());
    case Core::kCylinder:
      return size.x() * beside + size.z() * std::abs(d.z());
    case Core::kCone:
      return std::max(size.z() * d.z(), size.x() * beside - size.z() * d.z());
    default:
      return size.cwiseProduct(d).norm();
  }
}

Shape nearlyBall(Random& random) {
  const double r = random.uniform(0.1, 1), longer = random.logUniform(1e-16, 1e-2);
  return Shape::ellipsoid({r, r * (1 + longer), r * (1 + random.unit() * longer)});
}

NearlyBall partOf(const Shape& shape) {
  NearlyBall ball;
  if (shape.type() != ShapeType::kEllipsoid) return ball;
  const Vector3d m = shape.halfExtents();
  const double r = m.minCoeff();
  if (m.maxCoeff() > 1.01 * r) return ball;
  ball.radius = r;
  ball.sum = r + m.maxCoeff();
  ball.spread = ((m.array() - r) * (m.array() + r)).sqrt() / m.array();
  return ball;
}

// The bound of a cell against the support function in many of its directions, in extended
// precision. Cells lie in valleys, and depths are close to those there.
TEST(CellBound, WhatIsProvenHoldsInEveryDirection) {
  Random random(171);
  int proven = 0, refused = 0, gained = 0, hulls = 0, balls_proven = 0;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    Shape a = oracle::randomShape(random, kRound[random.below(3)], Flavour::kPlain);
    Shape b = oracle::randomShape(random, kAny[random.below(6)], Flavour::kPlain);
    // Nearly balls; every second case treats them as NearlyBall.
    const bool nearly = random.chance(0.3);
    if (nearly) a = nearlyBall(random);
    if (nearly && random.chance(0.5)) b = nearlyBall(random);
    if (random.chance(0.5)) std::swap(a, b);
    const ConvexView view_a = viewOf(a), view_b = viewOf(b);
    const Pose X_WA{random.rotation(), random.direction()};
    Pose X_WB{random.chance(0.4) ? X_WA.rotation : random.rotation(),
              X_WA.translation + random.logUniform(1e-6, 0.3) * random.direction()};
    const Pose X_BA = relativePose(X_WA, X_WB).X_BA;
    Difference<false> difference(view_a, view_b, X_BA, X_BA);
    const CurvedFaces faces(difference, 1e-8);
    const double size = view_a.extent + view_b.extent + X_BA.translation.norm();
    const double roundoff = kUnitRoundoff * size;
    // Downhill on the sphere.
    Vector3d nearest = random.direction();
    for (int k = 0; k < 100; ++k) {
      SupportPoint s;
      difference.support(-nearest, s);
      const Vector3d slope = s.w - nearest.dot(s.w) * nearest;
      nearest = Vector3d(nearest - 0.5 / (1 + k) / size * slope).normalized();
    }
    CurvedChoice choice;
    const double reach = nearest.dot(faces.blend(faces.along(nearest), 0.3 * size, 1, choice));
    if (!(reach > 1e-3 * size)) continue;
    const double width = random.logUniform(1e-4, 0.3);
    CurvedCorner corners[3];
    CurvedChoice choices[3];
    Vector3d x[3];
    for (int k = 0; k < 3; ++k) {
      x[k] = random.uniform(0.6, 1) * Vector3d(nearest + width * random.direction()).normalized();
      corners[k] = cornerAt(faces, X_BA, x[k], reach, choices[k]);
    }
    const double room = random.chance(0.5) ? random.logUniform(1e-15, 1e-3)
                                           : std::pow(width, 4) * random.logUniform(1e-3, 10);
    const double depth = reach - room * size;
    const auto wide_depth = static_cast<long double>(depth);
    double margins[3];
    for (int k = 0; k < 3; ++k) {
      margins[k] = static_cast<double>(valueAt(faces, X_BA, x[k], choices[k]) -
                                       wide_depth * x[k].cast<long double>().norm());
    }
    const double sizes[2] = {view_a.extent, view_b.extent};
    const NearlyBall parts[2] = {partOf(a), partOf(b)};
    const bool taken_apart = nearly && i % 2 == 0;
    const NearlyBall* const balls = taken_apart ? parts : nullptr;
    if (!CellBound(corners, sizes, roundoff, balls).proves(margins, depth)) {
      ++refused;
      continue;
    }
    ++proven;
    balls_proven += taken_apart;
    hulls += view_a.core == Core::kPoints || view_b.core == Core::kPoints;
    gained += !provesCell(corners, sizes, depth, 128 * roundoff);
    for (int k = 0; k < 60; ++k) {
      double mu[3] = {random.unit(), random.unit(), random.unit()};
      if (k < 20) mu[k % 3] = 0;
      const Wide n = (mu[0] * x[0] + mu[1] * x[1] + mu[2] * x[2]).cast<long double>();
      const long double rest = mostOf(view_b, n) + mostOf(view_a, -inA(X_BA, n)) -
                               n.dot(X_BA.translation.cast<long double>()) - wide_depth * n.norm();
      EXPECT_GE(rest, -0.01L * static_cast<long double>(roundoff)) << "case " << i;
    }
  }
  EXPECT_GT(proven, casesToAsk(500));
  EXPECT_GT(refused, casesToAsk(500));
  EXPECT_GE(gained, casesToAsk(5));
  EXPECT_GT(hulls, casesToAsk(50));
  EXPECT_GT(balls_proven, casesToAsk(50));
}

// A cell across the pole of a cap, with corners on both sides. An error of M x moves |M x| and the
// part along the middle in opposite directions, although the sine of the angle is nearly 0.
TEST(CellBound, CellsAcrossThePoleOfACapHoldWhatCornersAreOffBy) {
  struct Case {
    double off, wide, shift;
  };
  for (const Case& c : {Case{8e-16, 1e-9, 0.6}}) {
    const double depth = 1e-3, size = 1.1, roundoff = kUnitRoundoff * size;
    const Vector3d x[3] = {{0.9 * -c.wide, 0, 0.9},
                           {0.9 * c.wide, 0.9 * -1e-5 * c.wide, 0.9},
                           {0.9 * c.wide, 0.9 * 1e-5 * c.wide, 0.9}};
    const double shift = c.shift * c.off;
    const Vector3d center(-(1 - c.off / c.wide + 0.2 * shift / c.wide), 0, depth + shift);
    // M x, and M x with an error.
    const auto truly = [&](const Vector3d& d) {
      return d.dot(center) + std::hypot(d.x() - c.off * d.z(), d.y()) - depth * d.norm();
    };
    CurvedCorner corners[3];
    double margins[3];
    for (int i = 0; i < 3; ++i) {
      corners[i].x = x[i];
      corners[i].center = center;
      corners[i].scaled[0] = Vector3d(x[i].x(), x[i].y(), 0);
      corners[i].scaled[1].setZero();
      corners[i].share[0] = 1;
      corners[i].share[1] = 0;
      margins[i] = truly(x[i]);
    }
    // A direction in the cell, where the bound is below 0.
    const double mu = 0.5 * (1 + c.off / c.wide);
    const Vector3d pole = (1 - mu) * x[0] + 0.5 * mu * (x[1] + x[2]);
    EXPECT_LT(truly(pole), 0) << c.off;
    const double sizes[2] = {1, 0};
    EXPECT_FALSE(CellBound(corners, sizes, roundoff).proves(margins, depth)) << c.off;
  }
}

}  // namespace
}  // namespace leeway::collision
