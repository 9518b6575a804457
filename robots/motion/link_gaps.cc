#include "robots/motion/link_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "collision/base/sine_cosine.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/motion_bound.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {
namespace {

using collision::kTwoPi;
using collision::Shape;
using collision::sineCosine;
using Eigen::Vector3d;

constexpr int kGapArcs = LinkGap::kArcs;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The corners of a shape's triangles, three and three; empty where it has none.
std::vector<Vector3d> triangleCorners(const Geometry& g) {
  std::vector<Vector3d> corners;
  const auto add = [&](std::span<const Vector3d> vertices,
                       std::span<const std::array<std::int32_t, 3>> triangles) {
    for (const std::array<std::int32_t, 3>& t : triangles)
      for (const std::int32_t v : t) corners.push_back(g.X_BG * vertices[at(v)]);
  };
  if (g.shape.type() == collision::ShapeType::kMesh)
    add(g.shape.mesh()->vertices(), g.shape.mesh()->triangles());
  if (g.shape.type() == collision::ShapeType::kConvexHull)
    add(g.shape.hull()->vertices(), g.shape.hull()->facets());
  return corners;
}

/// Cylinders about the z axis that hold all that triangles pass through as they turn about it, and
/// all that they enclose.
std::vector<Geometry> stackAbout(const std::vector<Vector3d>& corners) {
  double low = corners.front().z(), high = low, size = 0;
  for (const Vector3d& p : corners) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
    size = std::max(size, p.lpNorm<1>());
  }
  const double slack = kGapSlack * (1 + size);
  const double thickness = (high - low) / kGapSlices + slack;
  std::array<double, kGapSlices> radius{};
  const auto slice = [&](double z) {
    return static_cast<int>(std::clamp((z - low) / thickness, 0.0, kGapSlices - 1.0));
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    // A triangle's part within a slice has its corners on the triangle's edges.
    const Vector3d &p = corners[i], &q = corners[i % 3 == 2 ? i - 2 : i + 1];
    const double rise = q.z() - p.z();
    const int last = slice(std::max(p.z(), q.z()) + slack);
    for (int k = slice(std::min(p.z(), q.z()) - slack); k <= last; ++k) {
      double from = 0, to = 1;
      if (std::abs(rise) > kGapLevel) {
        from = std::clamp((low + k * thickness - slack - p.z()) / rise, 0.0, 1.0);
        to = std::clamp((low + (k + 1) * thickness + slack - p.z()) / rise, 0.0, 1.0);
      }
      for (const double t : {from, to}) {
        const Vector3d x = p + t * (q - p);
        radius[at(k)] = std::max(radius[at(k)], std::hypot(x.x(), x.y()) + slack);
      }
    }
  }
  std::vector<Geometry> stack;
  for (int k = 0; k < kGapSlices;) {
    // Slices of nearly one radius make one cylinder.
    double most = radius[at(k)], least = most;
    int end = k + 1;
    for (; end < kGapSlices; ++end) {
      most = std::max(most, radius[at(end)]);
      least = std::min(least, radius[at(end)]);
      if (most - least > kLeastGap) break;
    }
    const double r = *std::max_element(radius.begin() + k, radius.begin() + end);
    if (r > 0) {
      Pose X;
      X.translation.z() = low + 0.5 * (k + end) * thickness;
      stack.push_back({Shape::cylinder(r, (end - k) * thickness / 2 + 2 * slack), X, ""});
    }
    k = end;
  }
  return stack;
}

/// How far geometries reach from the z axis, at most.
double reachFrom(const Geometry& g) {
  const Vector3d center = g.X_BG * g.shape.boundingCenter();
  return (std::hypot(center.x(), center.y()) + g.shape.boundingRadius()) * (1 + kGapSlack);
}

/// One pair of links, seen from what stands between the two joints.
class GapProof {
 public:
  GapProof(const Model& model, int link_a, int link_b)
      : model_(model), link_a_(link_a), link_b_(link_b) {}

  /// By the angle of the joint that tells more; none of it where nothing is proven.
  LinkGap run() {
    LinkGap none;
    // Joints without room, too: a passive one may stand outside its limits.
    const std::vector<VariableRange> ranges(model_.variables.size(), {-1, 1});
    const RelativeMotion motion =
        relativeMotion(model_, link_a_, link_b_, Vector3d::Zero(), 0, ranges);
    if (motion.terms.size() != 2) return none;
    for (const RelativeMotion::Term& term : motion.terms) {
      const JointType type = model_.joints[at(term.joint)].type;
      if (type != JointType::kRevolute && type != JointType::kContinuous) return none;
    }
    std::vector<Pose> X_WL(model_.links.size());
    forwardKinematics(model_, model_.defaultConfiguration(), X_WL);
    // b turns about the axis of the first joint, a about that of the second; as the joint's angle
    // grows, what is on its child's side turns forwards, seen from the other side.
    const Side a = sideOf(link_a_, motion.terms[1].joint, !motion.terms[1].inverted, X_WL);
    const Side b = sideOf(link_b_, motion.terms[0].joint, motion.terms[0].inverted, X_WL);
    const bool a_turns = prepare(a, b);
    const int apart = a_turns ? samplesApart() : 0;
    const bool b_turns = apart < kGapSamples && prepare(b, a) && samplesApart() > apart;
    if (!b_turns && (apart == 0 || !prepare(a, b))) return none;
    LinkGap gap;
    gap.link_a = link_a_;
    gap.link_b = link_b_;
    gap.joint = motion.terms[b_turns ? 0 : 1].joint;
    gap.other = motion.terms[b_turns ? 1 : 0].joint;
    gap.gaps.assign(kGapArcs, 0.0F);
    queries_ = 0;
    constexpr int kWhole = kGapArcs / kGapSamples;
    for (int arc = 0; arc < kGapArcs; arc += kWhole) prove(arc, kWhole, gap.gaps);
    gap.cell_gap = static_cast<float>(kCellGap * kGapInwards);
    gap.cells.assign(at(kGapArcs) * at(kGapArcs), 0);
    queries_ = 0;
    if (!staysNear(gap.gaps) || !isMostlyApart(gap.gaps)) return gap;
    for (int i = 0; i < kGapArcs; i += kGapBlock)
      for (int k = 0; k < kGapArcs; k += kGapBlock) proveCells({i, kGapBlock}, {k, kGapBlock}, gap);
    return gap;
  }

 private:
  /// A link's geometries in the frame of the axis that it turns about, its z axis.
  struct Side {
    Pose X_WF;
    std::vector<Geometry> geometries;
    double sign, angle;  // it stands as it does here at that angle of the joint [rad]
  };

  Side sideOf(int link, int joint, bool forwards, std::span<const Pose> X_WL) const {
    Side side;
    const Joint& j = model_.joints[at(joint)];
    Vector3d u, v;
    planeAxes(j.axis, u, v);
    Pose X_LF;
    X_LF.rotation << u, v, j.axis;
    side.X_WF = X_WL[at(j.child_link)] * X_LF;
    side.geometries = model_.links[at(link)].geometries;
    for (Geometry& g : side.geometries) g.X_BG = side.X_WF.inverse() * X_WL[at(link)] * g.X_BG;
    side.sign = forwards ? 1 : -1;
    const KinematicStep& step = model_.steps[at(joint)];
    side.angle = step.multiplier * model_.defaultConfiguration()[at(step.variable)] + step.offset;
    return side;
  }

  /// Sets out to prove how far apart `turning` and the other, however it is turned, stay. False
  /// when the other is not made of triangles.
  bool prepare(const Side& turning, const Side& held) {
    stack_.clear();
    for (const Geometry& g : held.geometries) {
      const std::vector<Vector3d> corners = triangleCorners(g);
      if (corners.empty()) return false;
      for (Geometry& cylinder : stackAbout(corners)) stack_.push_back(std::move(cylinder));
    }
    X_HT_ = held.X_WF.inverse() * turning.X_WF;
    turning_ = &turning;
    held_ = &held;
    return true;
  }

  /// At how many of as many angles as are sampled the two are apart.
  int samplesApart() {
    int apart = 0;
    for (int i = 0; i < kGapSamples; ++i)
      if (isApart(angleOf((i + 0.5) * kGapArcs / kGapSamples), kLeastGap)) ++apart;
    return apart;
  }

  static double angleOf(double arc) { return kTwoPi / kGapArcs * arc; }

  /// Fills in [arc, arc + count).
  void prove(int arc, int count, std::vector<float>& gaps) {
    const double near = distanceAt(angleOf(arc + 0.5 * count));  // neither inside the other
    for (double gap = kGapShare * near; gap >= kLeastGap; gap /= 2) {
      if (staysApart(angleOf(arc), angleOf(count), gap)) {
        const auto told = static_cast<float>(gap * kGapInwards);  // below it, rounded, too
        std::fill_n(gaps.begin() + arc, count, told);
        return;
      }
      if (count > 1) break;
    }
    if (count == 1 || queries_ > kGapQueries) return;
    prove(arc, count / 2, gaps);
    prove(arc + count / 2, count / 2, gaps);
  }

  /// A geometry in the frame of its axis, and of the turning link in that of the held one's.
  static Pose turnedIn(const Side& side, const Geometry& g, double angle) {
    Pose X;
    double sine, cosine;
    collision::sineCosine(side.sign * (angle - side.angle), sine, cosine);
    X.rotation << cosine, -sine, 0, sine, cosine, 0, 0, 0, 1;
    return X * g.X_BG;
  }
  Pose turned(const Geometry& g, double angle) const {
    return X_HT_ * turnedIn(*turning_, g, angle);
  }

  struct Arcs {
    int first, count;
    double begin() const { return angleOf(first); }
    double width() const { return angleOf(count); }
    double middle() const { return begin() + width() / 2; }
  };

  /// Fills in cells whose first arc has no gap of its own.
  void proveCells(const Arcs& arcs, const Arcs& others, LinkGap& gap) {
    const auto begin = gap.gaps.begin() + arcs.first;
    if (std::all_of(begin, begin + arcs.count, [](float g) { return g > 0; })) return;
    if (queries_ > kGapQueries) return;
    if (keepsCell(arcs, others)) {
      for (int i = arcs.first; i < arcs.first + arcs.count; ++i)
        std::fill_n(gap.cells.begin() + i * kGapArcs + others.first, others.count, 1);
      return;
    }
    if (arcs.count <= kLeastBlock && others.count <= kLeastBlock) return;
    if (arcs.count <= 2 * kLeastBlock && others.count <= 2 * kLeastBlock &&
        !isApartHalfway(arcs, others))
      return;
    // The held link's points leave its middle place at once, the others' chords slowly.
    const bool halves_other =
        others.count > kLeastBlock && (arcs.count <= kLeastBlock || 2 * others.count > arcs.count);
    for (int half = 0; half < 2; ++half) {
      Arcs a = arcs, b = others;
      Arcs& halved = halves_other ? b : a;
      halved.count /= 2;
      halved.first += half * halved.count;
      proveCells(a, b, gap);
    }
  }

  /// Bodies that are farther apart as a rule are parted for less.
  static bool staysNear(std::vector<float> gaps) {
    std::nth_element(gaps.begin(), gaps.begin() + kGapArcs / 2, gaps.end());
    return static_cast<double>(gaps[kGapArcs / 2]) < kNearGap;
  }

  /// Samples of what one angle does not tell: where bodies meet as a rule, little is proven.
  bool isMostlyApart(const std::vector<float>& gaps) {
    int apart = 0, samples = 0;
    for (int i = 0; i < kGapArcs; i += kGapBlock / 2)
      for (int k = 0; k < kGapArcs && !(gaps[at(i)] > 0); k += 2 * kGapBlock) {
        ++samples;
        if (isApartHalfway({i, 1}, {k, 1})) ++apart;
      }
    return 2 * apart > samples;
  }

  /// Whether more than kCellGap is kept where both are halfway.
  bool isApartHalfway(const Arcs& arcs, const Arcs& others) {
    collision::DistanceRequest request;
    request.depth = false;
    request.threshold = kCellGap;
    for (const Geometry& g : turning_->geometries)
      for (const Geometry& h : held_->geometries) {
        ++queries_;
        if (!(collision::distance(g.shape, turned(g, arcs.middle()), h.shape,
                                  turnedIn(*held_, h, others.middle()), request, scratch_)
                  .distance.lower > kCellGap))
          return false;
      }
    return true;
  }

  /// Whether more than kCellGap is kept over arcs of both angles.
  bool keepsCell(const Arcs& arcs, const Arcs& others) {
    collision::DistanceRequest request;
    request.depth = false;
    for (const Geometry& g : turning_->geometries)
      for (const Geometry& h : held_->geometries) {
        queries_ += 2;
        request.threshold = kCellGap + kApartSlack + others.width() / 2 * reachFrom(h);
        const Pose X_GH = turnedIn(*held_, h, others.middle()).inverse();
        const Pose X0 = X_GH * turned(g, arcs.begin()),
                   X1 = X_GH * turned(g, arcs.begin() + arcs.width());
        const double growth = arcs.width() * arcs.width() / 8 * reachFrom(g);
        // Apart at one end, with neither inside the other, and surfaces apart from there on.
        if (!(collision::distance(g.shape, X0, h.shape, Pose{}, request, scratch_).distance.lower >
              request.threshold) ||
            !(collision::sweptDistance(g.shape, X0, X1, growth, h.shape, request, scratch_)
                  .distance.lower > request.threshold))
          return false;
      }
    return true;
  }

  bool isApart(double angle, double gap) {
    collision::DistanceRequest request;
    request.depth = false;
    request.threshold = gap;
    for (const Geometry& g : turning_->geometries)
      for (const Geometry& c : stack_)
        if (!(collision::distance(g.shape, turned(g, angle), c.shape, c.X_BG, request, scratch_)
                  .distance.lower > gap))
          return false;
    return true;
  }

  /// At an angle, kMostGap at most; 0 and less where they meet.
  double distanceAt(double angle) {
    double most = kMostGap;
    for (const Geometry& g : turning_->geometries)
      for (const Geometry& c : stack_) {
        ++queries_;
        collision::DistanceRequest request;
        request.depth = false;
        request.threshold = most;
        const Pose X = turned(g, angle);
        const auto distance = [&] {
          return collision::distance(g.shape, X, c.shape, c.X_BG, request, scratch_).distance.lower;
        };
        if (distance() > most) continue;
        request.threshold = std::numeric_limits<double>::quiet_NaN();
        request.tolerance = kLeastGap / 4;
        most = std::min(most, distance());
        if (most < kLeastGap) return most;
      }
    return most;
  }

  /// Whether more than `gap` is kept over an arc by surfaces, which suffices where they are apart
  /// without one inside the other anywhere on it.
  bool staysApart(double angle, double arc, double gap) {
    collision::DistanceRequest request;
    request.depth = false;
    request.threshold = gap + kApartSlack;
    for (const Geometry& g : turning_->geometries) {
      const double growth = arc * arc / 8 * reachFrom(g);
      for (const Geometry& c : stack_) {
        ++queries_;
        const Pose X_CH = c.X_BG.inverse();
        const Pose X_C0 = X_CH * turned(g, angle), X_C1 = X_CH * turned(g, angle + arc);
        if (!(collision::sweptDistance(g.shape, X_C0, X_C1, growth, c.shape, request, scratch_)
                  .distance.lower > request.threshold))
          return false;
      }
    }
    return true;
  }

  const Model& model_;
  int link_a_, link_b_, queries_ = 0;
  const Side *turning_ = nullptr, *held_ = nullptr;
  Pose X_HT_;
  std::vector<Geometry> stack_;
  collision::Scratch scratch_;
};

bool isOfTriangles(const Link& link) {
  return std::all_of(link.geometries.begin(), link.geometries.end(), [](const Geometry& g) {
    return g.shape.type() == collision::ShapeType::kMesh ||
           g.shape.type() == collision::ShapeType::kConvexHull;
  });
}

int parentOf(const Model& model, int link) { return model.joints[at(link)].parent_link; }

int depthOf(const Model& model, int link) {
  int depth = 0;
  for (int up = parentOf(model, link); up >= 0; up = parentOf(model, up)) ++depth;
  return depth;
}

/// Whether no more than two joints that move stand between two links.
bool areNear(const Model& model, const std::vector<int>& depth, int a, int b) {
  int moving = 0;
  while (a != b && a >= 0 && b >= 0 && moving <= 2) {
    int& deeper = depth[at(a)] >= depth[at(b)] ? a : b;
    if (model.joints[at(deeper)].type != JointType::kFixed) ++moving;
    deeper = parentOf(model, deeper);
  }
  return a == b && moving <= 2;
}

}  // namespace

std::vector<LinkGap> provenGaps(const Model& model) {
  std::vector<LinkGap> gaps;
  const auto links = static_cast<int>(model.links.size());
  std::vector<int> depth;
  std::vector<bool> has_stack;
  for (int link = 0; link < links; ++link) {
    depth.push_back(depthOf(model, link));
    has_stack.push_back(isOfTriangles(model.links[at(link)]));
  }
  for (int a = 0; a < links; ++a)
    for (int b = 0; b < a; ++b) {
      if (model.links[at(a)].geometries.empty() || model.links[at(b)].geometries.empty()) continue;
      const auto isPair = [a, b](int x, int y) { return (x == a && y == b) || (x == b && y == a); };
      if (parentOf(model, a) == b || parentOf(model, b) == a ||
          std::any_of(model.disabled_pairs.begin(), model.disabled_pairs.end(),
                      [&](const DisabledPair& d) { return isPair(d.link_a, d.link_b); }))
        continue;
      if (!(has_stack[at(a)] || has_stack[at(b)]) || !areNear(model, depth, a, b)) continue;
      LinkGap gap = GapProof(model, a, b).run();
      if (!gap.gaps.empty()) gaps.push_back(std::move(gap));
    }
  return gaps;
}

namespace {

/// Arcs that hold all angles of a range, rounding included; of more than all of them, one.
struct ArcRange {
  std::int64_t first = 0;
  int count = LinkGap::kArcs;

  explicit ArcRange(const LinkGap::Range& range) {
    const double slack = kGapSlack * (1 + std::abs(range.from) + std::abs(range.to));
    constexpr double kScale = LinkGap::kArcs / kTwoPi;
    const double low = std::floor((std::min(range.from, range.to) - slack) * kScale),
                 high = std::floor((std::max(range.from, range.to) + slack) * kScale);
    if (!(high - low < LinkGap::kArcs) || !(std::abs(low) < 1e9)) return;  // NaN, too
    first = static_cast<std::int64_t>(low);
    count = static_cast<int>(high - low) + 1;
  }
  std::size_t operator[](int i) const {
    return static_cast<std::size_t>(((first + i) % LinkGap::kArcs + LinkGap::kArcs) %
                                    LinkGap::kArcs);
  }
};

}  // namespace

double LinkGap::over(const Range& angles, const Range& others) const {
  const ArcRange arcs(angles), other_arcs(others);
  float least = std::numeric_limits<float>::infinity();
  for (int i = 0; i < arcs.count; ++i) {
    const std::size_t arc = arcs[i];
    if (gaps[arc] > 0) {
      least = std::min(least, gaps[arc]);
      continue;
    }
    for (int k = 0; k < other_arcs.count; ++k)
      if (cells[arc * kArcs + other_arcs[k]] == 0) return 0;
    least = std::min(least, cell_gap);
  }
  return static_cast<double>(least);
}

}  // namespace leeway::robots
