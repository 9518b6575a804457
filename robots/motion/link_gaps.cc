#include "robots/motion/link_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/collision/distance.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/motion_bound.h"
#include "robots/base/tolerances.h"
#include "robots/motion/revolution_cover.h"

namespace leeway::robots {
namespace {

using collision::kTwoPi;
using Eigen::Vector3d;

constexpr int kGapArcs = LinkGap::kArcs;

/// The proof for one pair of links between which two joints turn, seen from the link between these
/// joints: each of the pair turns about an axis at rest. One of them is replaced by its solid of
/// revolution, which holds it at any angle; the gap then depends on the other's angle alone.
class GapProof {
 public:
  GapProof(const Model& model, int link_a, int link_b)
      : model_(model), link_a_(link_a), link_b_(link_b) {}

  /// By the angle of the joint that proves more; without gaps where nothing is proven.
  LinkGap run() {
    LinkGap none;
    const RelativeMotion motion = motionBetween();
    if (!hasTwoTurns(motion)) return none;
    std::vector<Pose> X_WL(model_.links.size());
    forwardKinematics(model_, model_.defaultConfiguration(), X_WL);
    // b turns about the axis of the first joint, a about that of the second. As a joint's angle
    // grows, its child's side turns forwards, seen from the other side.
    const TurningLink a =
        turningLink(link_a_, motion.terms[1].joint, !motion.terms[1].inverted, X_WL);
    const TurningLink b =
        turningLink(link_b_, motion.terms[0].joint, motion.terms[0].inverted, X_WL);
    const bool a_turns = choose(a, b);
    const int apart = a_turns ? samplesApart() : 0;
    const bool b_turns = apart < kGapSamples && choose(b, a) && samplesApart() > apart;
    if (!b_turns && (apart == 0 || !choose(a, b))) return none;
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
  /// A link's geometries in frame F, whose z axis is the one that it turns about.
  struct TurningLink {
    Pose X_WF;
    std::vector<Geometry> geometries;
    double sign;   // -1: it turns backwards as the joint's angle grows
    double angle;  // of the joint, at which the geometries stand like this [rad]
  };

  RelativeMotion motionBetween() const {
    // Ranges of some width for all joints: a passive one may stand outside its limits.
    const std::vector<VariableRange> ranges(model_.variables.size(), {-1, 1});
    return relativeMotion(model_, link_a_, link_b_, Vector3d::Zero(), 0, ranges);
  }

  bool hasTwoTurns(const RelativeMotion& motion) const {
    const auto turns = [&](const RelativeMotion::Term& term) {
      const JointType type = model_.joints[at(term.joint)].type;
      return type == JointType::kRevolute || type == JointType::kContinuous;
    };
    return motion.terms.size() == 2 && std::all_of(motion.terms.begin(), motion.terms.end(), turns);
  }

  TurningLink turningLink(int link, int joint, bool forwards, std::span<const Pose> X_WL) const {
    TurningLink side;
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

  /// Takes `turning` as it turns, and `covered` by its solid of revolution. False when `covered`
  /// is not made of triangles.
  bool choose(const TurningLink& turning, const TurningLink& covered) {
    std::optional<std::vector<Geometry>> cover = revolutionCover(covered.geometries);
    if (!cover) return false;
    cover_ = std::move(*cover);
    X_CT_ = covered.X_WF.inverse() * turning.X_WF;
    turning_ = &turning;
    covered_ = &covered;
    return true;
  }

  /// The number of sampled angles, of kGapSamples, at which the two are apart.
  int samplesApart() {
    int apart = 0;
    for (int i = 0; i < kGapSamples; ++i)
      if (isApart(angleOf((i + 0.5) * kGapArcs / kGapSamples), kLeastGap)) ++apart;
    return apart;
  }

  static double angleOf(double arc) { return kTwoPi / kGapArcs * arc; }

  /// Fills in gaps of arcs [arc, arc + count), halving what is not proven at once.
  void prove(int arc, int count, std::vector<float>& gaps) {
    // A positive distance also means that neither is inside the other: staysApart() needs that.
    const double distance = distanceAt(angleOf(arc + 0.5 * count));
    for (double gap = kGapShare * distance; gap >= kLeastGap; gap /= 2) {
      if (staysApart(angleOf(arc), angleOf(count), gap)) {
        std::fill_n(gaps.begin() + arc, count, static_cast<float>(gap * kGapInwards));
        return;
      }
      if (count > 1) break;
    }
    if (count == 1 || queries_ > kGapQueries) return;
    prove(arc, count / 2, gaps);
    prove(arc + count / 2, count / 2, gaps);
  }

  /// The pose of a link's geometry in frame F at an angle of its joint [rad].
  static Pose turnedIn(const TurningLink& side, const Geometry& g, double angle) {
    Pose X;
    double sine, cosine;
    collision::sineCosine(side.sign * (angle - side.angle), sine, cosine);
    X.rotation << cosine, -sine, 0, sine, cosine, 0, 0, 0, 1;
    return X * g.X_BG;
  }
  /// The pose of the turning link's geometry in the covered link's frame F.
  Pose turned(const Geometry& g, double angle) const {
    return X_CT_ * turnedIn(*turning_, g, angle);
  }

  struct Arcs {
    int first, count;
    double begin() const { return angleOf(first); }
    double width() const { return angleOf(count); }
    double middle() const { return begin() + width() / 2; }
  };

  /// Fills in the cells of a block, halving it where it is not proven at once. Arcs with a gap of
  /// their own need none.
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
    // The other angle costs more: its bound falls with the width, that of `arcs` with its square.
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

  /// True where cells pay: for half of the angles the gap is small. Wide gaps already decide most
  /// queries.
  static bool staysNear(std::vector<float> gaps) {
    std::nth_element(gaps.begin(), gaps.begin() + kGapArcs / 2, gaps.end());
    return static_cast<double>(gaps[kGapArcs / 2]) < kNearGap;
  }

  /// True when the two are apart in most samples of arcs without a gap: else cells prove little.
  bool isMostlyApart(const std::vector<float>& gaps) {
    int apart = 0, samples = 0;
    for (int i = 0; i < kGapArcs; i += kGapBlock / 2)
      for (int k = 0; k < kGapArcs && !(gaps[at(i)] > 0); k += 2 * kGapBlock) {
        ++samples;
        if (isApartHalfway({i, 1}, {k, 1})) ++apart;
      }
    return 2 * apart > samples;
  }

  /// Whether more than kCellGap is kept at the middle of both.
  bool isApartHalfway(const Arcs& arcs, const Arcs& others) {
    collision::DistanceRequest request;
    request.depth = false;
    request.threshold = kCellGap;
    for (const Geometry& g : turning_->geometries)
      for (const Geometry& h : covered_->geometries) {
        ++queries_;
        if (!(collision::distance(g.shape, turned(g, arcs.middle()), h.shape,
                                  turnedIn(*covered_, h, others.middle()), request, scratch_)
                  .distance.lower > kCellGap))
          return false;
      }
    return true;
  }

  /// Whether more than kCellGap is kept over arcs of both angles. Over an arc of h radians the
  /// turning link's points stay within h^2 / 8 times their axis distance of their chords; the other
  /// link's within h / 2 times theirs of where they are at its middle.
  bool keepsCell(const Arcs& arcs, const Arcs& others) {
    collision::DistanceRequest request;
    request.depth = false;
    for (const Geometry& g : turning_->geometries)
      for (const Geometry& h : covered_->geometries) {
        queries_ += 2;
        request.threshold = kCellGap + kApartSlack + others.width() / 2 * axisReach(h);
        const Pose X_GH = turnedIn(*covered_, h, others.middle()).inverse();
        const Pose X0 = X_GH * turned(g, arcs.begin()),
                   X1 = X_GH * turned(g, arcs.begin() + arcs.width());
        const double growth = arcs.width() * arcs.width() / 8 * axisReach(g);
        // Apart at the beginning with neither inside the other, and surfaces apart from there on.
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
      for (const Geometry& c : cover_)
        if (!(collision::distance(g.shape, turned(g, angle), c.shape, c.X_BG, request, scratch_)
                  .distance.lower > gap))
          return false;
    return true;
  }

  /// A lower bound of the distance at an angle, kMostGap at most; 0 or less where they meet [m].
  double distanceAt(double angle) {
    double most = kMostGap;
    for (const Geometry& g : turning_->geometries)
      for (const Geometry& c : cover_) {
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

  /// Whether surfaces keep more than `gap` over an arc. So do the bodies if at one angle of it
  /// neither is inside the other.
  bool staysApart(double angle, double arc, double gap) {
    collision::DistanceRequest request;
    request.depth = false;
    request.threshold = gap + kApartSlack;
    for (const Geometry& g : turning_->geometries) {
      const double growth = arc * arc / 8 * axisReach(g);
      for (const Geometry& c : cover_) {
        ++queries_;
        const Pose X_GC = c.X_BG.inverse();
        const Pose X0 = X_GC * turned(g, angle), X1 = X_GC * turned(g, angle + arc);
        if (!(collision::sweptDistance(g.shape, X0, X1, growth, c.shape, request, scratch_)
                  .distance.lower > request.threshold))
          return false;
      }
    }
    return true;
  }

  const Model& model_;
  int link_a_, link_b_, queries_ = 0;
  const TurningLink *turning_ = nullptr, *covered_ = nullptr;
  Pose X_CT_;                    // of the two frames F, covered to turning
  std::vector<Geometry> cover_;  // in the covered link's frame F
  collision::Scratch scratch_;
};

int parentOf(const Model& model, int link) { return model.joints[at(link)].parent_link; }

int depthOf(const Model& model, int link) {
  int depth = 0;
  for (int up = parentOf(model, link); up >= 0; up = parentOf(model, up)) ++depth;
  return depth;
}

/// Whether at most two joints that move stand between two links.
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

std::vector<LinkGap> provenGaps(const Model& model, const Stop& stop) {
  std::vector<LinkGap> gaps;
  const auto links = static_cast<int>(model.links.size());
  std::vector<int> depth;
  std::vector<bool> has_triangles;
  for (int link = 0; link < links; ++link) {
    depth.push_back(depthOf(model, link));
    has_triangles.push_back(areTriangles(model.links[at(link)].geometries));
  }
  for (int a = 0; a < links; ++a)
    for (int b = 0; b < a; ++b) {
      if (model.links[at(a)].geometries.empty() || model.links[at(b)].geometries.empty()) continue;
      const auto isPair = [a, b](int x, int y) { return (x == a && y == b) || (x == b && y == a); };
      if (parentOf(model, a) == b || parentOf(model, b) == a ||
          std::any_of(model.disabled_pairs.begin(), model.disabled_pairs.end(),
                      [&](const DisabledPair& d) { return isPair(d.link_a, d.link_b); }))
        continue;
      if (!(has_triangles[at(a)] || has_triangles[at(b)]) || !areNear(model, depth, a, b)) continue;
      throwIfStopped(stop, "links were proven apart");
      LinkGap gap = GapProof(model, a, b).run();
      if (!gap.gaps.empty()) gaps.push_back(std::move(gap));
    }
  return gaps;
}

}  // namespace leeway::robots
