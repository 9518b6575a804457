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

// Limit on the major cycles of Wolfe's algorithm in one direction, each of which adds a member
// [count].
constexpr int kMajorCycles = 32;
// Weights of vertices are multiples of this, so that their sum is exactly 1.
constexpr double kWeightUnit = 0x1p-52;

// Puts the heaviest weight first and rounds the others to multiples of the unit; the first gets the
// rest.
void roundWeights(CurvedChoice& choice) {
  for (int i = 1; i < choice.vertices; ++i) {
    if (choice.weight[i] > choice.weight[0]) {
      std::swap(choice.weight[0], choice.weight[i]);
      std::swap(choice.vertex[0], choice.vertex[i]);
    }
  }
  double rest = 1;
  for (int i = 1; i < choice.vertices; ++i) {
    choice.weight[i] = std::min(std::floor(choice.weight[i] / kWeightUnit) * kWeightUnit, rest);
    rest -= choice.weight[i];
  }
  choice.weight[0] = rest;
}

}  // namespace

// blend() for round parts of given shares. Wolfe's algorithm (1976) finds the best mean of a few
// members exactly, then adds the member that gains most, until none does. (Optimizing one piece
// after the other converges slowly where ways are nearly parallel; Frank and Wolfe's steps take
// thousands of steps among the vertices of a needle.) |y|^2 across the direction is weighted by the
// inverse of the bend of pieces and round parts.
class CurvedFaces::Blend {
 public:
  Blend(const CurvedFaces& faces, const CurvedFace& face, double stiffness, double scale,
        const double (&shares)[2]);

  /// False if the bends are out of range.
  bool valid() const { return valid_; }
  /// Finds the members and their weights; `vertex`: the start of the hull's climbs.
  void run(int vertex);
  /// Writes the choice that the members form; `shares` becomes the share taken of each round part.
  void write(CurvedChoice& choice, double (&shares)[2]) const;

 private:
  FaceMember farthestMember(int vertex) const;
  Vector gradientAt(const double (&mean)[kOffsets]) const;
  FaceMember bestAlong(const Vector& gradient, const double (&mean)[kOffsets]) const;
  void complete(FaceMember& m) const;
  bool hasArm(const FaceMember& m, int part) const {
    return faces_.cone_[part] < 0 || m.parameter[faces_.cone_[part]] > 0;
  }

  const CurvedFaces& faces_;
  const CurvedFace& face_;
  const Tangents tangents_;
  // Cholesky's factor, a lower triangle, of 1 + bend / stiffness on the tangents u and v.
  double factor_uu_, factor_vu_, factor_vv_;
  double gain_scale_;
  double penalty_root_[kMostCurvedParameters];
  bool valid_;
  FaceMember members_[kMostMembers];
  int count_ = 0;
};

CurvedFaces::Blend::Blend(const CurvedFaces& faces, const CurvedFace& face, double stiffness,
                          double scale, const double (&shares)[2])
    : faces_(faces), face_(face), tangents_(tangentsAt(face.e)), gain_scale_(scale * stiffness) {
  const auto& [u, v] = tangents_;
  const double uu = 1 + std::max(faces.bend(face, shares, u, u), 0.0) / stiffness,
               vv = 1 + std::max(faces.bend(face, shares, v, v), 0.0) / stiffness,
               uv = faces.bend(face, shares, u, v) / stiffness;
  factor_uu_ = std::sqrt(uu);
  factor_vu_ = uv / factor_uu_;
  factor_vv_ = std::sqrt(std::max(vv - factor_vu_ * factor_vu_, 1.0));
  valid_ = uu * vv < std::numeric_limits<double>::infinity();
  for (int k = 0; k < faces.parameters_; ++k) {
    penalty_root_[k] = std::sqrt(faces.evenly_) * face.way[k].norm();
  }
}

// Evaluates the gain and the offset of a member.
void CurvedFaces::Blend::complete(FaceMember& m) const {
  Vector y = face_.base;
  for (int k = 0; k < faces_.parameters_; ++k) {
    y += m.parameter[k] * face_.way[k];
    m.offset[2 + k] = penalty_root_[k] * (m.parameter[k] - faces_.kept_[k]);
  }
  for (int k = 0; k < 2; ++k) {
    if (hasArm(m, k)) y -= (1 - m.arm[k]) * face_.arm[k];
  }
  if (faces_.hasHull()) y += faces_.ofHull(faces_.vertex(m.vertex));
  m.gain = gain_scale_ * face_.e.dot(y);
  m.offset[0] = tangents_.u.dot(y) / factor_uu_;
  m.offset[1] = (tangents_.v.dot(y) - factor_vu_ * m.offset[0]) / factor_vv_;
}

FaceMember CurvedFaces::Blend::farthestMember(int vertex) const {
  FaceMember m;
  for (int k = 0; k < faces_.parameters_; ++k) {
    m.parameter[k] = face_.e.dot(face_.way[k]) >= 0 ? 1 : faces_.low(k);
  }
  m.arm[0] = m.arm[1] = m.weight = 1;
  if (faces_.hasHull()) m.vertex = vertex;
  complete(m);
  return m;
}

// The gradient of the gain minus half the square, at the mean.
Vector CurvedFaces::Blend::gradientAt(const double (&mean)[kOffsets]) const {
  const double along_v = mean[1] / factor_vv_;
  return gain_scale_ * face_.e - ((mean[0] - factor_vu_ * along_v) / factor_uu_) * tangents_.u -
         along_v * tangents_.v;
}

// The member that gains most along the gradient.
FaceMember CurvedFaces::Blend::bestAlong(const Vector& gradient,
                                         const double (&mean)[kOffsets]) const {
  FaceMember next;
  double gain_without_arm[2];
  for (int k = 0; k < 2; ++k) {
    gain_without_arm[k] = std::max(-gradient.dot(face_.arm[k]), 0.0);
    next.arm[k] = gain_without_arm[k] > 0 ? 0 : 1;
  }
  for (int k = 0; k < faces_.parameters_; ++k) {
    double gain = gradient.dot(face_.way[k]) - penalty_root_[k] * mean[2 + k];
    for (int part = 0; part < 2; ++part) {
      if (k == faces_.cone_[part]) gain += gain_without_arm[part];
    }
    next.parameter[k] = gain >= 0 ? 1 : faces_.low(k);
  }
  if (faces_.hasHull()) next.vertex = faces_.farthestOfHull(gradient, members_[0].vertex);
  complete(next);
  return next;
}

void CurvedFaces::Blend::run(int vertex) {
  members_[0] = farthestMember(vertex);
  count_ = 1;
  for (int cycle = 0; cycle < kMajorCycles && count_ < kMostMembers; ++cycle) {
    double mean[kOffsets];
    meanOf(members_, count_, mean);
    const Vector gradient = gradientAt(mean);
    if (!(gradient.squaredNorm() > 0)) break;
    const FaceMember next = bestAlong(gradient, mean);
    double best_held = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < count_; ++i) {
      best_held = std::max(best_held, members_[i].gain - innerProduct(mean, members_[i].offset));
    }
    if (!(next.gain - innerProduct(mean, next.offset) > best_held)) break;
    members_[count_++] = next;
    weigh(members_, count_);
  }
}

void CurvedFaces::Blend::write(CurvedChoice& choice, double (&shares)[2]) const {
  choice.vertices = 0;
  for (int k = 0; k < faces_.parameters_; ++k) choice.parameter[k] = 0;
  shares[0] = shares[1] = 0;
  for (int i = 0; i < count_; ++i) {
    const FaceMember& m = members_[i];
    for (int k = 0; k < faces_.parameters_; ++k) choice.parameter[k] += m.weight * m.parameter[k];
    for (int k = 0; k < 2; ++k) {
      if (hasArm(m, k)) shares[k] += m.weight * m.arm[k];
    }
    if (!faces_.hasHull()) continue;
    int slot = 0;
    while (slot < choice.vertices && choice.vertex[slot] != m.vertex) ++slot;
    if (slot == kMostBlendedVertices) continue;
    if (slot == choice.vertices) {
      choice.vertex[choice.vertices] = m.vertex;
      choice.weight[choice.vertices++] = 0;
    }
    choice.weight[slot] += m.weight;
  }
  for (int k = 0; k < faces_.parameters_; ++k) {
    choice.parameter[k] = std::clamp(choice.parameter[k], faces_.low(k), 1.0);
  }
  if (faces_.hasHull()) roundWeights(choice);
}

Vector CurvedFaces::blend(const CurvedFace& face, double stiffness, double scale,
                          CurvedChoice& choice) const {
  support(face, choice);
  if (stiffness > 0 && (parameters_ > 0 || hull_ >= 0)) {
    // The bend of round parts depends on the shares taken, so the loop repeats if these differ much
    // from the guess.
    const double guess[2] = {cone_[0] >= 0 ? 0.5 : 1, cone_[1] >= 0 ? 0.5 : 1};
    double shares[2] = {guess[0], guess[1]};
    const int first = hull_ >= 0 ? choice.vertex[0] : 0;
    const auto selectMembers = [&] {
      Blend blend(*this, face, stiffness, scale, shares);
      if (!blend.valid()) return;
      blend.run(first);
      blend.write(choice, shares);
    };
    selectMembers();
    const auto differs = [&](int k) {
      return face.length[k] > 0 && std::abs(shares[k] - guess[k]) > kRoundTaken;
    };
    if (differs(0) || differs(1)) selectMembers();
  }
  Vector y = face.base;
  for (int k = 0; k < parameters_; ++k) y += choice.parameter[k] * face.way[k];
  for (int i = 0; i < choice.vertices; ++i)
    y += choice.weight[i] * ofHull(vertex(choice.vertex[i]));
  return y;
}

}  // namespace leeway::collision
