#include "collision/curved_face.h"

#include <algorithm>
#include <cmath>

namespace leeway::collision {

namespace {

// Rounds through several parameters, where any choice will do and where one member is wanted, and
// steps between vertices of a hull in each [count].
constexpr int kRounds = 4;
constexpr int kMoreRounds = 16;
constexpr int kMixSteps = 8;
constexpr double kWeightUnit = 0x1p-52;
// |M e| below this share of a rim's radius: all of its disc is farthest. (It only says which member
// is told.)
constexpr double kFlat = 1e-8;

// The only axis of an ellipsoid that is no more than a segment, or -1.
int segmentAxis(const Vector& semi_axes) {
  int axis = 0;
  semi_axes.maxCoeff(&axis);
  return semi_axes[(axis + 1) % 3] == 0 && semi_axes[(axis + 2) % 3] == 0 ? axis : -1;
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
      if (length > (view.core == Core::kEllipsoid ? 0 : kFlat * view.size.x())) {
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
  double sum = 0;
  for (int k = 0; k < 2; ++k) {
    const double of = share(k, choice);
    if (!(of > 0 && face.length[k] > 0)) continue;
    const Vector mv = part_[k].semi_axes.cwiseProduct(turnedBack(k, v));
    const Vector mw = part_[k].semi_axes.cwiseProduct(turnedBack(k, w));
    sum += of * (mv.dot(mw) - face.arm[k].dot(v) * face.arm[k].dot(w)) / face.length[k];
  }
  return sum;
}

// The parameters' part of blend().
void CurvedFaces::slide(const CurvedFace& face, double stiffness, CurvedChoice& choice,
                        Vector& y) const {
  double* const parameter = choice.parameter;
  Vector beside[kMostCurvedParameters];
  double gain[kMostCurvedParameters], evenly[kMostCurvedParameters];
  for (int k = 0; k < parameters_; ++k) {
    gain[k] = face.e.dot(face.way[k]);
    beside[k] = face.way[k] - gain[k] * face.e;
    evenly[k] = evenly_ * face.way[k].squaredNorm();
  }
  // Along parameter k, and against l as far as that keeps the sum of what is beside e: both exact.
  const auto move = [&](int k, int l, double against) {
    const Vector way = beside[k] - against * beside[l];
    const double along = gain[k] - against * gain[l], squared = way.squaredNorm();
    const double stiff =
        stiffness > 0 ? stiffness * squared + std::max(bend(face, choice, way, way), 0.0) : 0;
    // (stiff / squared: a stiffness that the round parts' bend is added to.)
    double wanted = squared > 0 ? along * (stiff / squared) - way.dot(y) : along * stiffness;
    double per_step = squared + evenly[k];
    wanted -= evenly[k] * (parameter[k] - kept_[k]);
    if (against != 0) {
      wanted += against * evenly[l] * (parameter[l] - kept_[l]);
      per_step += against * against * evenly[l];
    }
    double most = wanted > 0 ? 1 - parameter[k] : low(k) - parameter[k];
    if (against != 0) {
      const double end = (wanted > 0) == (against > 0) ? low(l) : 1.0;
      const double other = (parameter[l] - end) / against;
      if (std::abs(other) < std::abs(most)) most = other;
    }
    double step = most;
    if (std::abs(wanted) < std::abs(most) * per_step) step = wanted / per_step;
    if (!(std::abs(step) <= 2)) return;
    const auto moved = [&](int m, double by) {
      const double next = std::clamp(parameter[m] + by, low(m), 1.0);
      y += (next - parameter[m]) * face.way[m];
      parameter[m] = next;
    };
    moved(k, step);
    if (against != 0) moved(l, -against * step);
  };
  for (int k = 0; k < parameters_; ++k) {
    move(k, k, 0);
    for (int l = 0; l < k; ++l) {
      const double squared = beside[l].squaredNorm();
      if (squared > 0) move(k, l, beside[k].dot(beside[l]) / squared);
    }
  }
}

// The hull's part of blend(): weight goes from the vertex that gives least to the one that would
// give most (Frank and Wolfe's steps between pairs; Lacoste-Julien and Jaggi 2015), each as far as
// is best. False when there was nothing to gain.
bool CurvedFaces::mix(const CurvedFace& face, double stiffness, CurvedChoice& choice,
                      Vector& y) const {
  int* const vertices = choice.vertex;
  double* const weight = choice.weight;
  bool gained = false;
  for (int step = 0; step < kMixSteps; ++step) {
    const Vector across = y - face.e.dot(y) * face.e;
    const double squared_across = across.squaredNorm();
    const double bent =
        squared_across > 0 ? std::max(bend(face, choice, across, across), 0.0) / squared_across : 0;
    Vector slope = (stiffness + bent) * face.e - across;
    const double length = slope.norm();
    if (!(stiffness > 0 && length > 0)) break;
    slope /= length;
    const int to = farthestOfHull(slope, vertices[0]);
    int from = 0, slot = -1, lightest = 0;
    double least = 0;
    for (int i = 0; i < choice.mixed; ++i) {
      const double along = slope.dot(ofHull(vertex(vertices[i])));
      if (i == 0 || along < least) least = along, from = i;
      if (weight[i] < weight[lightest]) lightest = i;
      if (vertices[i] == to) slot = i;
    }
    const Vector way = ofHull(vertex(to) - vertex(vertices[from]));
    if (slot == from || !(slope.dot(way) > 0)) break;
    const double gain = face.e.dot(way);
    const Vector beside = way - gain * face.e;
    const double squared = beside.squaredNorm();
    const double stiff = stiffness * squared + std::max(bend(face, choice, beside, beside), 0.0);
    const double wanted = squared > 0 ? gain * (stiff / squared) - beside.dot(y) : gain * stiffness;
    double moved = weight[from];
    if (wanted < moved * squared) moved = std::floor(wanted / squared / kWeightUnit) * kWeightUnit;
    if (!(moved > 0)) break;
    gained = true;
    y += moved * way;
    weight[from] -= moved;
    if (slot < 0) {
      if (weight[from] == 0) {
        slot = from;
      } else if (choice.mixed < kMostMixed) {
        slot = choice.mixed++;
      } else {
        slot = lightest;
        y += weight[slot] * ofHull(vertex(to) - vertex(vertices[slot]));
        moved += weight[slot];
      }
      vertices[slot] = to;
      weight[slot] = 0;
    }
    weight[slot] += moved;
    // (The first has what is left of 1, and is no less than 0.)
    if (weight[from] == 0) {
      --choice.mixed;
      vertices[from] = vertices[choice.mixed];
      weight[from] = weight[choice.mixed];
    }
  }
  return gained;
}

Vector CurvedFaces::blend(const CurvedFace& face, double stiffness, CurvedChoice& choice) const {
  support(face, choice);
  Vector y = face.base;
  for (int k = 0; k < parameters_; ++k) y += choice.parameter[k] * face.way[k];
  if (hull_ >= 0) y += ofHull(vertex(choice.vertex[0]));
  const int several = evenly_ > 0 ? kRounds : kMoreRounds;
  const int rounds = parameters_ + (hull_ >= 0 ? 1 : 0) > 1 ? several : 1;
  for (int i = 0; i < rounds; ++i) {
    slide(face, stiffness, choice, y);
    if (hull_ >= 0 && !mix(face, stiffness, choice, y)) break;
  }
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

double CurvedFaces::share(int part, const CurvedChoice& choice) const {
  const Core core = part_[part].view->core;
  if (core == Core::kCone) return choice.parameter[part_[part].first];
  return isRound(core) ? 1 : 0;
}

}  // namespace leeway::collision
