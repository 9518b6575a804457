#include "collision/curved_face.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "leeway/collision/tolerances.h"

namespace leeway::collision {

namespace {

// Rounds through several parameters, where any choice will do and where one member is wanted, and
// steps between vertices of a hull in each [count].
constexpr int kRounds = 4;
constexpr int kMoreRounds = 16;
constexpr int kMixSteps = 32;
constexpr double kWeightUnit = 0x1p-52;

// The only axis of an ellipsoid that is no more than a segment, or -1.
int segmentAxis(const Vector& semi_axes) {
  int axis = 0;
  semi_axes.maxCoeff(&axis);
  return semi_axes[(axis + 1) % 3] == 0 && semi_axes[(axis + 2) % 3] == 0 ? axis : -1;
}

// Where gain . c - c . squares c / 2 is most, `count` numbers c; false where it grows along c for
// ever.
bool mostOf(const Eigen::Matrix3d& squares, const Vector& gain, int count, Vector& c) {
  c.setZero();
  const double s00 = squares(0, 0), s01 = squares(0, 1), s11 = squares(1, 1);
  if (count == 1) {
    c[0] = s00 > 0 ? gain[0] / s00 : gain[0];
    return s00 > 0;
  }
  if (count == 2) {
    const double determinant = s00 * s11 - s01 * s01;
    if (determinant > kSingularFace * s00 * s11) {
      c[0] = (s11 * gain[0] - s01 * gain[1]) / determinant;
      c[1] = (s00 * gain[1] - s01 * gain[0]) / determinant;
      return true;
    }
    c = s00 > s11 ? Vector(-s01, s00, 0) : Vector(s11, -s01, 0);
  } else {
    // (Of ways in a plane.)
    const Vector row[3] = {squares.col(0), squares.col(1), squares.col(2)};
    for (int i = 0; i < 3; ++i) {
      const Vector across = cross(row[i], row[(i + 1) % 3]);
      if (across.squaredNorm() > c.squaredNorm()) c = across;
    }
    const double length = c.norm();
    if (length > 0) c /= length;
  }
  if (gain.dot(c) < 0) c = -c;
  return false;
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
void CurvedFaces::slide(const CurvedFace& face, double stiffness, double times,
                        CurvedChoice& choice, Vector& y) const {
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
        stiffness > 0 ? times * (stiffness * squared + std::max(bend(face, choice, way, way), 0.0))
                      : 0;
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

// The hull's part of blend(): the nearest points among few vertices, exactly, and the vertex that
// gains most beside these, until none does (Wolfe 1976; Frank and Wolfe's steps take thousands
// among the vertices of a needle). False when there was nothing to gain.
bool CurvedFaces::mix(const CurvedFace& face, double stiffness, double times, CurvedChoice& choice,
                      Vector& y) const {
  if (!(stiffness > 0)) return false;
  const Vector& e = face.e;
  const Vector across = y - e.dot(y) * e;
  const double squared_across = across.squaredNorm();
  if (squared_across > 0) {
    stiffness += std::max(bend(face, choice, across, across), 0.0) / squared_across;
  }
  stiffness *= times;
  bool gained = false;
  for (int step = 0; step < kMixSteps; ++step) {
    Vector slope = stiffness * e - (y - e.dot(y) * e);
    const double length = slope.norm();
    if (!(length > 0)) break;
    slope /= length;
    const int to = farthestOfHull(slope, choice.vertex[0]);
    double most = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < choice.mixed; ++i) {
      most = std::max(most, slope.dot(ofHull(vertex(choice.vertex[i]))));
    }
    if (!(slope.dot(ofHull(vertex(to))) > most) || choice.mixed == kMostMixed) break;
    choice.vertex[choice.mixed] = to;
    choice.weight[choice.mixed++] = 0;
    gained = true;
    while (choice.mixed > 1 && weigh(face, stiffness, choice, y)) {
    }
  }
  if (gained) roundWeights(choice);
  return gained;
}

// To where the mixed vertices' plane, or line, gives most, or to where the first one's weight is
// gone: true then.
bool CurvedFaces::weigh(const CurvedFace& face, double stiffness, CurvedChoice& choice,
                        Vector& y) const {
  const Vector& e = face.e;
  const int count = choice.mixed - 1;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Vector gain = Vector::Zero(), way[3], beside[3];
  for (int i = 0; i < count; ++i) {
    way[i] = ofHull(vertex(choice.vertex[i + 1]) - vertex(choice.vertex[0]));
    const double along = e.dot(way[i]);
    beside[i] = way[i] - along * e;
    gain[i] = stiffness * along - beside[i].dot(y);
    for (int j = 0; j <= i; ++j) squares(i, j) = squares(j, i) = beside[i].dot(beside[j]);
  }
  Vector change;
  const bool ends = mostOf(squares, gain, count, change);
  double step = ends ? 1 : std::numeric_limits<double>::infinity();
  int gone = -1;
  const double first = -change.head(count).sum();
  for (int i = 0; i <= count; ++i) {
    const double per_step = i == 0 ? first : change[i - 1];
    if (!(per_step < 0 && -choice.weight[i] > step * per_step)) continue;
    step = choice.weight[i] / -per_step;
    gone = i;
  }
  if (!std::isfinite(step)) return false;
  for (int i = 0; i <= count; ++i) {
    choice.weight[i] = std::max(choice.weight[i] + step * (i == 0 ? first : change[i - 1]), 0.0);
    if (i > 0) y += step * change[i - 1] * way[i - 1];
  }
  if (gone < 0) return false;
  choice.vertex[gone] = choice.vertex[count];
  choice.weight[gone] = choice.weight[count];
  choice.mixed = count;
  return true;
}

Vector CurvedFaces::blend(const CurvedFace& face, double stiffness, double times,
                          CurvedChoice& choice) const {
  support(face, choice);
  Vector y = face.base;
  for (int k = 0; k < parameters_; ++k) y += choice.parameter[k] * face.way[k];
  if (hull_ >= 0) y += ofHull(vertex(choice.vertex[0]));
  const int several = evenly_ > 0 ? kRounds : kMoreRounds;
  const int rounds = parameters_ + (hull_ >= 0 ? 1 : 0) > 1 ? several : 1;
  for (int i = 0; i < rounds; ++i) {
    slide(face, stiffness, times, choice, y);
    if (hull_ >= 0 && !mix(face, stiffness, times, choice, y)) break;
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
