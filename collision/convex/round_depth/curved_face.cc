#include "collision/convex/round_depth/curved_face.h"

#include <cmath>

#include "collision/base/tolerances.h"

namespace leeway::collision {

namespace {

// The axis of an ellipsoid that is a segment; -1 if it is not.
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
        // (A segment is not a round part, because |M x| is not smooth across it.)
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
      case Core::kPoint:
      case Core::kHalfSpace:  // not searched
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
      // (Otherwise it is the centre of a cap that is perpendicular to the direction.)
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
  choice.vertices = 0;
  if (hull_ >= 0) {
    choice.vertices = 1;
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

int CurvedFaces::edges(const CurvedChoice& choice, CurvedEdge edge[2]) const {
  int count = 0;
  for (int k = 0; k < parameters_ && count < 2; ++k) {
    if (choice.parameter[k] > low(k) && choice.parameter[k] < 1) edge[count++] = {k, 0, 0};
  }
  for (int i = 1; i < choice.vertices && count < 2; ++i) {
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
    for (int k = 1; k < choice.vertices; ++k) {
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
