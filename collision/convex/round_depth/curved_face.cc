#include "collision/convex/round_depth/curved_face.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/tolerances.h"

namespace leeway::collision {

namespace {

// Members that are looked at in a direction [count].
constexpr int kMixSteps = 32;
constexpr double kWeightUnit = 0x1p-52;

// The only axis of an ellipsoid that is no more than a segment, or -1.
int segmentAxis(const Vector& semi_axes) {
  int axis = 0;
  semi_axes.maxCoeff(&axis);
  return semi_axes[(axis + 1) % 3] == 0 && semi_axes[(axis + 2) % 3] == 0 ? axis : -1;
}

// Beside a direction: two coordinates, and what departing from parameters that are kept counts.
constexpr int kBeside = 2 + kMostCurvedParameters;
// As many as are independent there, and the one that joins them.
constexpr int kMostMembers = kBeside + 2;

// A member of the face that has one vertex of a hull, one end of each parameter and of each round
// part all of its arm or none: how much it gains, and what it has beside the direction.
struct Member {
  int vertex = 0;
  double parameter[kMostCurvedParameters] = {};
  double arm[2] = {0, 0};
  double weight = 0, gain = 0;
  double beside[kBeside] = {};
};

double product(const double (&v)[kBeside], const double (&w)[kBeside]) {
  double sum = 0;
  for (int i = 0; i < kBeside; ++i) sum += v[i] * w[i];
  return sum;
}

// What the mean of the members, their weights' sum 1, has beside the direction.
void meanOf(const Member* members, int count, double (&mean)[kBeside]) {
  for (double& m : mean) m = 0;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < kBeside; ++k) mean[k] += members[i].weight * members[i].beside[k];
  }
}

// Where the mean gains most less half of its square beside the direction, as changes of the
// weights; false where that grows along them for ever.
bool mostOf(const Member* members, int count, double (&change)[kMostMembers]) {
  double way[kMostMembers][kBeside], a[kMostMembers][kMostMembers], mean[kBeside];
  double whole[kMostMembers] = {}, right[kMostMembers] = {};
  int order[kMostMembers] = {};
  meanOf(members, count, mean);
  for (int i = 1; i < count; ++i) {
    for (int k = 0; k < kBeside; ++k) way[i][k] = members[i].beside[k] - members[0].beside[k];
    order[i] = i;
    right[i] = members[i].gain - members[0].gain - product(way[i], mean);
    for (int j = 1; j <= i; ++j) a[i][j] = a[j][i] = product(way[i], way[j]);
    whole[i] = a[i][i];
  }
  // Cholesky's steps, those first that leave the largest share of a square.
  int rank = 1;
  for (; rank < count; ++rank) {
    int best = rank;
    for (int i = rank + 1; i < count; ++i) {
      if (a[i][i] * whole[best] > a[best][best] * whole[i]) best = i;
    }
    if (!(a[best][best] > kSingularFace * whole[best])) break;
    std::swap(order[rank], order[best]);
    std::swap(whole[rank], whole[best]);
    std::swap(right[rank], right[best]);
    for (int i = 1; i < count; ++i) std::swap(a[rank][i], a[best][i]);
    for (int i = 1; i < count; ++i) std::swap(a[i][rank], a[i][best]);
    for (int i = rank + 1; i < count; ++i) {
      const double times = a[i][rank] / a[rank][rank];
      for (int j = rank + 1; j < count; ++j) a[i][j] -= times * a[rank][j];
      right[i] -= times * right[rank];
    }
  }
  const bool ends = rank == count;
  double c[kMostMembers] = {};
  if (!ends) c[rank] = 1;
  for (int i = rank - 1; i > 0; --i) {
    double sum = ends ? right[i] : -a[i][rank];
    for (int j = i + 1; j < rank; ++j) sum -= a[i][j] * c[j];
    c[i] = sum / a[i][i];
  }
  // (What is left on the right is what the way gains.)
  const double sign = !ends && right[rank] < 0 ? -1 : 1;
  change[0] = 0;
  for (int i = 1; i < count; ++i) {
    change[order[i]] = sign * c[i];
    change[0] -= sign * c[i];
  }
  return ends;
}

// To where the members' plane, or line, gives most, or to where the weight of one is gone: true
// then.
bool weigh(Member* members, int& count) {
  double change[kMostMembers];
  const bool ends = mostOf(members, count, change);
  double step = ends ? 1 : std::numeric_limits<double>::infinity();
  int gone = -1;
  for (int i = 0; i < count; ++i) {
    if (!(change[i] < 0 && -members[i].weight > step * change[i])) continue;
    step = members[i].weight / -change[i];
    gone = i;
  }
  if (!std::isfinite(step)) return false;
  for (int i = 0; i < count; ++i) {
    members[i].weight = std::max(members[i].weight + step * change[i], 0.0);
  }
  if (gone < 0) return false;
  members[gone] = members[--count];
  return true;
}

// The heaviest first, and multiples of the unit, of which it has what is left.
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

CurvedFaces::CurvedFaces(const Difference<false>& difference, double evenly)
    : pose_(difference.pose()), evenly_(evenly) {
  const ConvexView* views[2] = {&difference.viewA(), &difference.viewB()};
  for (int k = 0; k < 2; ++k) {
    Part& part = part_[k];
    part.view = views[k];
    part.first = parameters_;
    switch (views[k]->core) {
      case Core::kEllipsoid:
        part.semi_axes = views[k]->size;
        part.axis = segmentAxis(part.semi_axes);
        // (A segment is no round part: what |M x| does across it is not smooth.)
        if (part.axis >= 0) part.semi_axes.setZero(), part.count = 1;
        break;
      case Core::kCone:
        cone_[k] = parameters_;
        [[fallthrough]];
      case Core::kCylinder:
        part.semi_axes = Vector(views[k]->size.x(), views[k]->size.x(), 0);
        [[fallthrough]];
      case Core::kSegment:
        part.count = 1;
        break;
      case Core::kBox:
        part.count = 3;
        break;
      case Core::kPoints:
        hull_ = k;
        break;
      default:
        break;
    }
    parameters_ += part.count;
  }
  for (int k = 0; k < parameters_; ++k) kept_[k] = 0.5 * (low(k) + 1);
}

void CurvedFaces::keepNear(const CurvedChoice& choice) {
  for (int k = 0; k < parameters_; ++k) kept_[k] = choice.parameter[k];
}

CurvedFace CurvedFaces::along(const Vector& direction) const {
  CurvedFace face;
  face.e = direction / direction.norm();
  face.base = -pose_.translation;
  for (int k = 0; k < 2; ++k) {
    const Part& part = part_[k];
    const ConvexView& view = *part.view;
    face.arm[k].setZero();
    if (isRound(view.core)) {
      const Vector scaled = part.semi_axes.cwiseProduct(turnedBack(k, face.e));
      const double length = scaled.norm();
      // (The centre of a cap that is met squarely.)
      if (length > (view.core == Core::kEllipsoid ? 0 : kFlatRim * view.size.x())) {
        face.length[k] = length;
        face.arm[k] = turned(k, part.semi_axes.cwiseProduct(scaled) / length);
      }
    }
    if (view.core == Core::kCone) {
      const Vector apex = turned(k, Vector(0, 0, k == 0 ? -view.size.z() : view.size.z()));
      face.base += apex;
      face.way[part.first] = face.arm[k] - 2 * apex;
    } else {
      face.base += face.arm[k];
      for (int i = 0; i < part.count; ++i) {
        const int axis = part.count == 1 ? part.axis : i;
        face.way[part.first + i] = turned(k, view.size[axis] * Vector::Unit(axis));
      }
    }
  }
  return face;
}

int CurvedFaces::farthestOfHull(const Vector& direction, int hint) const {
  const Vector d = direction / direction.norm();
  return farthestPoint(*part_[hull_].view, hull_ == 0 ? Vector(-turnedBack(0, d)) : d, hint);
}

double CurvedFaces::support(const CurvedFace& face, CurvedChoice& choice) const {
  double most = face.e.dot(face.base);
  for (int k = 0; k < parameters_; ++k) {
    const double gain = face.e.dot(face.way[k]);
    choice.parameter[k] = gain >= 0 ? 1 : low(k);
    most += gain * choice.parameter[k];
  }
  choice.mixed = 0;
  if (hull_ >= 0) {
    choice.mixed = 1;
    choice.vertex[0] = farthestOfHull(face.e, 0);
    choice.weight[0] = 1;
    most += face.e.dot(ofHull(vertex(choice.vertex[0])));
  }
  return most;
}

double CurvedFaces::bend(const CurvedFace& face, const CurvedChoice& choice, const Vector& v,
                         const Vector& w) const {
  const double shares[2] = {share(0, choice), share(1, choice)};
  return bend(face, shares, v, w);
}

double CurvedFaces::bend(const CurvedFace& face, const double (&shares)[2], const Vector& v,
                         const Vector& w) const {
  double sum = 0;
  for (int k = 0; k < 2; ++k) {
    if (!(shares[k] > 0 && face.length[k] > 0)) continue;
    const Vector mv = part_[k].semi_axes.cwiseProduct(turnedBack(k, v));
    const Vector mw = part_[k].semi_axes.cwiseProduct(turnedBack(k, w));
    sum += shares[k] * (mv.dot(mw) - face.arm[k].dot(v) * face.arm[k].dot(w)) / face.length[k];
  }
  return sum;
}

// blend() for round parts that count with these shares, which become what is taken of them: the
// member of most gain among few, exactly, and the one that gains most beside these, until none does
// (Wolfe 1976; one piece after the other creeps where ways are nearly parallel, and Frank and
// Wolfe's steps take thousands among the vertices of a needle). |y|^2 beside the direction counts
// by the inverse of what pieces and round parts bend by.
void CurvedFaces::mix(const CurvedFace& face, double stiffness, double times, double (&round)[2],
                      CurvedChoice& choice) const {
  const Vector& e = face.e;
  const Vector helper = std::abs(e.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
  Vector u = cross(e, helper);
  u /= u.norm();
  const Vector v = cross(e, u);
  // The root of the bends, as a triangle.
  const double uu = 1 + std::max(bend(face, round, u, u), 0.0) / stiffness,
               vv = 1 + std::max(bend(face, round, v, v), 0.0) / stiffness,
               uv = bend(face, round, u, v) / stiffness;
  const double root_u = std::sqrt(uu), lower = uv / root_u,
               root_v = std::sqrt(std::max(vv - lower * lower, 1.0));
  if (!(uu * vv < std::numeric_limits<double>::infinity())) return;
  const double of_gain = times * stiffness;
  double evenly[kMostCurvedParameters];
  for (int k = 0; k < parameters_; ++k) evenly[k] = std::sqrt(evenly_) * face.way[k].norm();
  const auto complete = [&](Member& m) {
    Vector y = face.base;
    for (int k = 0; k < parameters_; ++k) {
      y += m.parameter[k] * face.way[k];
      m.beside[2 + k] = evenly[k] * (m.parameter[k] - kept_[k]);
    }
    for (int k = 0; k < 2; ++k) {
      if (cone_[k] < 0 || m.parameter[cone_[k]] > 0) y -= (1 - m.arm[k]) * face.arm[k];
    }
    if (hull_ >= 0) y += ofHull(vertex(m.vertex));
    m.gain = of_gain * e.dot(y);
    m.beside[0] = u.dot(y) / root_u;
    m.beside[1] = (v.dot(y) - lower * m.beside[0]) / root_v;
  };
  Member members[kMostMembers];
  int count = 1;
  for (int k = 0; k < parameters_; ++k) {
    members[0].parameter[k] = face.e.dot(face.way[k]) >= 0 ? 1 : low(k);
  }
  members[0].arm[0] = members[0].arm[1] = members[0].weight = 1;
  if (hull_ >= 0) members[0].vertex = choice.vertex[0];
  complete(members[0]);
  for (int step = 0; step < kMixSteps && count < kMostMembers; ++step) {
    double mean[kBeside];
    meanOf(members, count, mean);
    const double at_v = mean[1] / root_v;
    const Vector slope = of_gain * e - ((mean[0] - lower * at_v) / root_u) * u - at_v * v;
    if (!(slope.squaredNorm() > 0)) break;
    Member next;
    double dropped[2];
    for (int k = 0; k < 2; ++k) {
      dropped[k] = std::max(-slope.dot(face.arm[k]), 0.0);
      next.arm[k] = dropped[k] > 0 ? 0 : 1;
    }
    for (int k = 0; k < parameters_; ++k) {
      double gain = slope.dot(face.way[k]) - evenly[k] * mean[2 + k];
      for (int part = 0; part < 2; ++part) {
        if (k == cone_[part]) gain += dropped[part];
      }
      next.parameter[k] = gain >= 0 ? 1 : low(k);
    }
    if (hull_ >= 0) next.vertex = farthestOfHull(slope, members[0].vertex);
    complete(next);
    double most = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
      most = std::max(most, members[i].gain - product(mean, members[i].beside));
    }
    if (!(next.gain - product(mean, next.beside) > most)) break;
    members[count++] = next;
    while (count > 1 && weigh(members, count)) {
    }
  }
  choice.mixed = 0;
  for (int k = 0; k < parameters_; ++k) choice.parameter[k] = 0;
  round[0] = round[1] = 0;
  for (int i = 0; i < count; ++i) {
    const Member& m = members[i];
    for (int k = 0; k < parameters_; ++k) choice.parameter[k] += m.weight * m.parameter[k];
    for (int k = 0; k < 2; ++k) {
      if (cone_[k] < 0 || m.parameter[cone_[k]] > 0) round[k] += m.weight * m.arm[k];
    }
    if (hull_ < 0) continue;
    int k = 0;
    while (k < choice.mixed && choice.vertex[k] != m.vertex) ++k;
    if (k == kMostMixed) continue;
    if (k == choice.mixed) {
      choice.vertex[choice.mixed] = m.vertex;
      choice.weight[choice.mixed++] = 0;
    }
    choice.weight[k] += m.weight;
  }
  for (int k = 0; k < parameters_; ++k) {
    choice.parameter[k] = std::clamp(choice.parameter[k], low(k), 1.0);
  }
  if (hull_ >= 0) roundWeights(choice);
}

Vector CurvedFaces::blend(const CurvedFace& face, double stiffness, double times,
                          CurvedChoice& choice) const {
  support(face, choice);
  if (stiffness > 0 && (parameters_ > 0 || hull_ >= 0)) {
    // What round parts bend by depends on how much of them is taken: once more where that turns out
    // to be much more or less.
    const double guess[2] = {cone_[0] >= 0 ? 0.5 : 1, cone_[1] >= 0 ? 0.5 : 1};
    double round[2] = {guess[0], guess[1]};
    const int first = choice.vertex[0];
    mix(face, stiffness, times, round, choice);
    const auto far = [&](int k) {
      return face.length[k] > 0 && std::abs(round[k] - guess[k]) > kRoundTaken;
    };
    if (far(0) || far(1)) {
      choice.vertex[0] = first;
      mix(face, stiffness, times, round, choice);
    }
  }
  Vector y = face.base;
  for (int k = 0; k < parameters_; ++k) y += choice.parameter[k] * face.way[k];
  for (int i = 0; i < choice.mixed; ++i) y += choice.weight[i] * ofHull(vertex(choice.vertex[i]));
  return y;
}

int CurvedFaces::edges(const CurvedChoice& choice, CurvedEdge edge[2]) const {
  int count = 0;
  for (int k = 0; k < parameters_ && count < 2; ++k) {
    if (choice.parameter[k] > low(k) && choice.parameter[k] < 1) edge[count++] = {k, 0, 0};
  }
  for (int i = 1; i < choice.mixed && count < 2; ++i) {
    edge[count++] = {-1, choice.vertex[0], choice.vertex[i]};
  }
  return count;
}

Vector CurvedFaces::wayOf(const CurvedFace& face, const CurvedEdge& edge) const {
  return edge.parameter >= 0 ? face.way[edge.parameter]
                             : ofHull(vertex(edge.to) - vertex(edge.from));
}

Vector CurvedFaces::center(int part, const CurvedChoice& choice) const {
  const Part& p = part_[part];
  const ConvexView& view = *p.view;
  Vector center = Vector::Zero();
  if (part == hull_) {
    const Vector& first = vertex(choice.vertex[0]);
    center = first;
    for (int k = 1; k < choice.mixed; ++k) {
      center += choice.weight[k] * (vertex(choice.vertex[k]) - first);
    }
    return center;
  }
  const double* of = choice.parameter + p.first;
  if (view.core == Core::kCone) {
    // (Twice the parameter is exact.)
    center.z() = view.size.z() * (1 - 2 * of[0]);
    return center;
  }
  for (int i = 0; i < p.count; ++i) {
    const int axis = p.count == 1 ? p.axis : i;
    center[axis] = (part == 0 ? -view.size[axis] : view.size[axis]) * of[i];
  }
  return center;
}

double CurvedFaces::share(int part, const CurvedChoice& choice) const {
  const Core core = part_[part].view->core;
  if (core == Core::kCone) return choice.parameter[part_[part].first];
  return isRound(core) ? 1 : 0;
}

}  // namespace leeway::collision
