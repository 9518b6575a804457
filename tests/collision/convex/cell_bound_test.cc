#include "collision/convex/round_depth/cell_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collision/convex/gjk/sharp.h"
#include "collision/convex/round_depth/curved_face.h"
#include "tests/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;

constexpr ShapeType kRound[] = {ShapeType::kCylinder, ShapeType::kCone, ShapeType::kEllipsoid};
constexpr ShapeType kAny[] = {ShapeType::kCapsule,  ShapeType::kBox,  ShapeType::kConvexHull,
                              ShapeType::kCylinder, ShapeType::kCone, ShapeType::kEllipsoid};

CurvedCorner<Vector> cornerAt(const CurvedFaces& faces, const Pose& X_BA, const Vector3d& x,
                              double depth, CurvedChoice& choice) {
  faces.blend(faces.along(x), depth, 1, choice);
  double of_a[3], of_b[3];
  faces.center(0, choice, of_a);
  faces.center(1, choice, of_b);
  CurvedCorner<Vector> c;
  c.x = x;
  c.center = Vector3d(of_b[0], of_b[1], of_b[2]) - placed(X_BA, {of_a[0], of_a[1], of_a[2]});
  c.scaled[0] = faces.semiAxes(0).cwiseProduct(rotatedBack(X_BA.rotation, x));
  c.scaled[1] = faces.semiAxes(1).cwiseProduct(x);
  for (int k = 0; k < 2; ++k) c.share[k] = faces.share(k, choice);
  return c;
}

// The bound at a corner, for the world's poses.
DoubleDouble valueAt(const CurvedFaces& faces, const SharpDifference& sharp, const Vector3d& x_b,
                     const CurvedChoice& choice) {
  const DoubleDoubleVector x = sharp.inWorld(x_b);
  DoubleDouble of_a[3], of_b[3];
  faces.center(0, choice, of_a);
  faces.center(1, choice, of_b);
  DoubleDouble value =
      dot(x, sharp.memberOf({of_a[0], of_a[1], of_a[2]}, {of_b[0], of_b[1], of_b[2]}));
  const DoubleDoubleVector local[2] = {sharp.inA(x), sharp.inB(x)};
  for (int k = 0; k < 2; ++k) {
    const Vector3d& m = faces.semiAxes(k);
    value = value + faces.share(k, choice) *
                        norm({m.x() * local[k].x, m.y() * local[k].y, m.z() * local[k].z});
  }
  return value;
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

// What it says of a cell, and the support function itself in many of its directions, to twice the
// precision; cells lie in valleys, and depths are about what is there.
TEST(CellBound, WhatIsProvenHoldsInEveryDirection) {
  Random random(171);
  int proven = 0, refused = 0, gained = 0, hulls = 0, balls_proven = 0;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    Shape a = oracle::randomShape(random, kRound[random.below(3)], Flavour::kPlain);
    Shape b = oracle::randomShape(random, kAny[random.below(6)], Flavour::kPlain);
    // Nearly balls, taken apart in every second case.
    const bool nearly = random.chance(0.3);
    if (nearly) a = nearlyBall(random);
    if (nearly && random.chance(0.5)) b = nearlyBall(random);
    if (random.chance(0.5)) std::swap(a, b);
    const ConvexView view_a = viewOf(a), view_b = viewOf(b);
    const Pose X_WA{random.rotation(), random.direction()};
    Pose X_WB{random.chance(0.4) ? X_WA.rotation : random.rotation(),
              X_WA.translation + random.logUniform(1e-6, 0.3) * random.direction()};
    const SharpDifference sharp(view_a, X_WA, view_b, X_WB);
    const Pose X_BA = sharp.X_BA();
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
    CurvedCorner<Vector> corners[3];
    CurvedChoice choices[3];
    Vector3d x[3];
    for (int k = 0; k < 3; ++k) {
      x[k] = random.uniform(0.6, 1) * Vector3d(nearest + width * random.direction()).normalized();
      corners[k] = cornerAt(faces, X_BA, x[k], reach, choices[k]);
    }
    const double room = random.chance(0.5) ? random.logUniform(1e-15, 1e-3)
                                           : std::pow(width, 4) * random.logUniform(1e-3, 10);
    const double depth = reach - room * size;
    double margins[3];
    for (int k = 0; k < 3; ++k) {
      margins[k] =
          (valueAt(faces, sharp, x[k], choices[k]) - depth * norm(sharp.inWorld(x[k]))).high;
    }
    const double sizes[2] = {view_a.extent, view_b.extent};
    const NearlyBall parts[2] = {partOf(a), partOf(b)};
    const bool taken_apart = nearly && i % 2 == 0;
    const NearlyBall* const balls = taken_apart ? parts : nullptr;
    if (!CellBound(corners, sizes, roundoff, sharp.moved(), balls).proves(margins, depth)) {
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
      const DoubleDoubleVector n = sharp.inWorld(mu[0] * x[0] + mu[1] * x[1] + mu[2] * x[2]);
      const DoubleDouble rest = sharp.mostAlong(n) - depth * norm(n);
      EXPECT_GE(rest.high, 0) << "case " << i;
    }
  }
  EXPECT_GT(proven, casesToAsk(500));
  EXPECT_GT(refused, casesToAsk(500));
  EXPECT_GE(gained, casesToAsk(5));
  EXPECT_GT(hulls, casesToAsk(50));
  EXPECT_GT(balls_proven, casesToAsk(50));
}

// A cell across the pole of a cap, whose corners lie on either side of it: what M x is off by moves
// |M x| and the part along the middle against each other, where the angle's sine is all but none.
TEST(CellBound, CellsAcrossThePoleOfACapHoldWhatCornersAreOffBy) {
  struct Case {
    double off, moved, wide, shift;
  };
  for (const Case& c : {Case{1e-8, 1.1e-8, 1e-4, 0.01}, Case{8e-16, 0, 1e-9, 0.6}}) {
    const double depth = 1e-3, size = 1.1, roundoff = kUnitRoundoff * size;
    const Vector3d x[3] = {{0.9 * -c.wide, 0, 0.9},
                           {0.9 * c.wide, 0.9 * -1e-5 * c.wide, 0.9},
                           {0.9 * c.wide, 0.9 * 1e-5 * c.wide, 0.9}};
    const double shift = c.shift * c.off;
    const Vector3d center(-(1 - c.off / c.wide + 0.2 * shift / c.wide), 0, depth + shift);
    // What M x is, and what it is said to be.
    const auto truly = [&](const Vector3d& d) {
      return d.dot(center) + std::hypot(d.x() - c.off * d.z(), d.y()) - depth * d.norm();
    };
    CurvedCorner<Vector> corners[3];
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
    // In the cell, and below 0.
    const double mu = 0.5 * (1 + c.off / c.wide);
    const Vector3d pole = (1 - mu) * x[0] + 0.5 * mu * (x[1] + x[2]);
    EXPECT_LT(truly(pole), 0) << c.off;
    const double sizes[2] = {1, 0};
    EXPECT_FALSE(CellBound(corners, sizes, roundoff, c.moved).proves(margins, depth)) << c.off;
  }
}

}  // namespace
}  // namespace leeway::collision
