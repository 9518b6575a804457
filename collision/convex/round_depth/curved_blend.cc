#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/tolerances.h"
#include "collision/convex/gjk/tangents.h"
#include "collision/convex/round_depth/curved_face.h"
#include "collision/convex/round_depth/face_weights.h"

namespace leeway::collision {

namespace {

// Members tried in a direction [count].
constexpr int kMixSteps = 32;
constexpr double kWeightUnit = 0x1p-52;

// Puts the heaviest weight first and rounds the others to multiples of the unit; the first has the
// rest.
void roundWeights(CurvedChoice& choice) {
  for (int i = 1; i < choice.mixed; ++i) {
    if (choice.weight[i] > choice.weight[0]) {
      std::swap(choice.weight[0], choice.weight[i]);
      std::swap(choice.vertex[0], choice.vertex[i]);
    }
  }
  double left = 1;
  for (int i = 1; i < choice.mixed; ++i) {
    choice.weight[i] = std::min(std::floor(choice.weight[i] / kWeightUnit) * kWeightUnit, left);
    left -= choice.weight[i];
  }
  choice.weight[0] = left;
}

}  // namespace

// blend() for round parts of given shares. Wolfe's algorithm (1976): the best mean of few members,
// exactly, then the member that gains most beside it, until none does. (One piece after the other
// creeps where ways are nearly parallel; Frank and Wolfe's steps take thousands among the vertices
// of a needle.) |y|^2 across the direction counts by the inverse of the bend of pieces and round
// parts.
class CurvedFaces::Blend {
 public:
  Blend(const CurvedFaces& faces, const CurvedFace& face, double stiffness, double times,
        const double (&round)[2]);

  /// False when the bends are out of range.
  bool valid() const { return valid_; }
  /// Finds the members and their weights; `vertex`: where the hull's climbs start.
  void run(int vertex);
  /// Writes the choice that the members make; `round` becomes the share taken of each round part.
  void write(CurvedChoice& choice, double (&round)[2]) const;

 private:
  FaceMember farthest(int vertex) const;
  Vector slopeAt(const double (&mean)[kOffsets]) const;
  FaceMember bestAlong(const Vector& slope, const double (&mean)[kOffsets]) const;
  void complete(FaceMember& m) const;
  bool hasArm(const FaceMember& m, int part) const {
    return faces_.cone_[part] < 0 || m.parameter[faces_.cone_[part]] > 0;
  }

  const CurvedFaces& faces_;
  const CurvedFace& face_;
  const Tangents at_;
  double root_u_, lower_, root_v_;  // the root of the bends: a lower triangle
  double of_gain_;
  double evenly_[kMostCurvedParameters];
  bool valid_;
  FaceMember members_[kMostMembers];
  int count_ = 0;
};

CurvedFaces::Blend::Blend(const CurvedFaces& faces, const CurvedFace& face, double stiffness,
                          double times, const double (&round)[2])
    : faces_(faces), face_(face), at_(tangentsAt(face.e)), of_gain_(times * stiffness) {
  const auto& [u, v] = at_;
  const double uu = 1 + std::max(faces.bend(face, round, u, u), 0.0) / stiffness,
               vv = 1 + std::max(faces.bend(face, round, v, v), 0.0) / stiffness,
               uv = faces.bend(face, round, u, v) / stiffness;
  root_u_ = std::sqrt(uu);
  lower_ = uv / root_u_;
  root_v_ = std::sqrt(std::max(vv - lower_ * lower_, 1.0));
  valid_ = uu * vv < std::numeric_limits<double>::infinity();
  for (int k = 0; k < faces.parameters_; ++k) {
    evenly_[k] = std::sqrt(faces.evenly_) * face.way[k].norm();
  }
}

// Evaluates the gain and the offset of a member.
void CurvedFaces::Blend::complete(FaceMember& m) const {
  Vector y = face_.base;
  for (int k = 0; k < faces_.parameters_; ++k) {
    y += m.parameter[k] * face_.way[k];
    m.offset[2 + k] = evenly_[k] * (m.parameter[k] - faces_.kept_[k]);
  }
  for (int k = 0; k < 2; ++k) {
    if (hasArm(m, k)) y -= (1 - m.arm[k]) * face_.arm[k];
  }
  if (faces_.hasHull()) y += faces_.ofHull(faces_.vertex(m.vertex));
  m.gain = of_gain_ * face_.e.dot(y);
  m.offset[0] = at_.u.dot(y) / root_u_;
  m.offset[1] = (at_.v.dot(y) - lower_ * m.offset[0]) / root_v_;
}

FaceMember CurvedFaces::Blend::farthest(int vertex) const {
  FaceMember m;
  for (int k = 0; k < faces_.parameters_; ++k) {
    m.parameter[k] = face_.e.dot(face_.way[k]) >= 0 ? 1 : faces_.low(k);
  }
  m.arm[0] = m.arm[1] = m.weight = 1;
  if (faces_.hasHull()) m.vertex = vertex;
  complete(m);
  return m;
}

// The gradient of the gain less half the square, at the mean.
Vector CurvedFaces::Blend::slopeAt(const double (&mean)[kOffsets]) const {
  const double at_v = mean[1] / root_v_;
  return of_gain_ * face_.e - ((mean[0] - lower_ * at_v) / root_u_) * at_.u - at_v * at_.v;
}

// The member that gains most along the gradient.
FaceMember CurvedFaces::Blend::bestAlong(const Vector& slope,
                                         const double (&mean)[kOffsets]) const {
  FaceMember next;
  double dropped[2];
  for (int k = 0; k < 2; ++k) {
    dropped[k] = std::max(-slope.dot(face_.arm[k]), 0.0);
    next.arm[k] = dropped[k] > 0 ? 0 : 1;
  }
  for (int k = 0; k < faces_.parameters_; ++k) {
    double gain = slope.dot(face_.way[k]) - evenly_[k] * mean[2 + k];
    for (int part = 0; part < 2; ++part) {
      if (k == faces_.cone_[part]) gain += dropped[part];
    }
    next.parameter[k] = gain >= 0 ? 1 : faces_.low(k);
  }
  if (faces_.hasHull()) next.vertex = faces_.farthestOfHull(slope, members_[0].vertex);
  complete(next);
  return next;
}

void CurvedFaces::Blend::run(int vertex) {
  members_[0] = farthest(vertex);
  count_ = 1;
  for (int step = 0; step < kMixSteps && count_ < kMostMembers; ++step) {
    double mean[kOffsets];
    meanOf(members_, count_, mean);
    const Vector slope = slopeAt(mean);
    if (!(slope.squaredNorm() > 0)) break;
    const FaceMember next = bestAlong(slope, mean);
    double most = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < count_; ++i) {
      most = std::max(most, members_[i].gain - innerProduct(mean, members_[i].offset));
    }
    if (!(next.gain - innerProduct(mean, next.offset) > most)) break;
    members_[count_++] = next;
    weigh(members_, count_);
  }
}

void CurvedFaces::Blend::write(CurvedChoice& choice, double (&round)[2]) const {
  choice.mixed = 0;
  for (int k = 0; k < faces_.parameters_; ++k) choice.parameter[k] = 0;
  round[0] = round[1] = 0;
  for (int i = 0; i < count_; ++i) {
    const FaceMember& m = members_[i];
    for (int k = 0; k < faces_.parameters_; ++k) choice.parameter[k] += m.weight * m.parameter[k];
    for (int k = 0; k < 2; ++k) {
      if (hasArm(m, k)) round[k] += m.weight * m.arm[k];
    }
    if (!faces_.hasHull()) continue;
    int k = 0;
    while (k < choice.mixed && choice.vertex[k] != m.vertex) ++k;
    if (k == kMostMixed) continue;
    if (k == choice.mixed) {
      choice.vertex[choice.mixed] = m.vertex;
      choice.weight[choice.mixed++] = 0;
    }
    choice.weight[k] += m.weight;
  }
  for (int k = 0; k < faces_.parameters_; ++k) {
    choice.parameter[k] = std::clamp(choice.parameter[k], faces_.low(k), 1.0);
  }
  if (faces_.hasHull()) roundWeights(choice);
}

Vector CurvedFaces::blend(const CurvedFace& face, double stiffness, double times,
                          CurvedChoice& choice) const {
  support(face, choice);
  if (stiffness > 0 && (parameters_ > 0 || hull_ >= 0)) {
    // The bend of round parts depends on the shares taken: repeated where these differ much from
    // the guess.
    const double guess[2] = {cone_[0] >= 0 ? 0.5 : 1, cone_[1] >= 0 ? 0.5 : 1};
    double round[2] = {guess[0], guess[1]};
    const int first = hull_ >= 0 ? choice.vertex[0] : 0;
    const auto mix = [&] {
      Blend blend(*this, face, stiffness, times, round);
      if (!blend.valid()) return;
      blend.run(first);
      blend.write(choice, round);
    };
    mix();
    const auto far = [&](int k) {
      return face.length[k] > 0 && std::abs(round[k] - guess[k]) > kRoundTaken;
    };
    if (far(0) || far(1)) mix();
  }
  Vector y = face.base;
  for (int k = 0; k < parameters_; ++k) y += choice.parameter[k] * face.way[k];
  for (int i = 0; i < choice.mixed; ++i) y += choice.weight[i] * ofHull(vertex(choice.vertex[i]));
  return y;
}

}  // namespace leeway::collision
