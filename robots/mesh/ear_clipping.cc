#include "robots/mesh/ear_clipping.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>

#include "collision/base/exact_predicates.h"
#include "collision/base/numbers.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;

/// A clipper in the plane: the third coordinate is 0, as the predicates require.
class Clipper {
 public:
  /// `points`: the projected corners. `ring`: places of the corners, in positive orientation; no
  /// two neighbours are equal.
  Clipper(std::span<const Vector3d> corners, std::vector<Vector3d> points,
          const std::vector<std::int32_t>& ring)
      : corners_(corners),
        points_(std::move(points)),
        nodes_(ring.size()),
        left_(ring.size()),
        searches_left_(static_cast<int>(
            std::clamp(1e7 / static_cast<double>(ring.size() * ring.size()), 8.0, 1000.0))) {
    for (const std::int32_t i : ring)
      rounding_ = std::max(rounding_, kPlanarRounding * points_[at(i)].cwiseAbs().maxCoeff());
    const auto count = static_cast<std::int32_t>(ring.size());
    for (std::int32_t i = 0; i < count; ++i)
      nodes_[at(i)] = {ring[at(i)], (i + count - 1) % count, (i + 1) % count};
  }

  CutPolygon run() {
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(nodes_.size()); ++i) push(i);
    while (left_ > 3)
      if (searches_left_ == 0)
        clip(first());
      else if (!clipEars())
        clipTheLeastWrong();
    const std::int32_t last = first(), before = nodes_[at(last)].previous;
    emit(last);
    if (turn(before, last, nodes_[at(last)].next) < 0)
      cut_.crossing = std::max(cut_.crossing, wrongness(last));
    return std::move(cut_);
  }

 private:
  struct Node {
    std::int32_t corner, previous, next;
    bool gone = false;
    std::int32_t pushed = 0;  // number of insertions; older queue entries are skipped
  };
  enum class Ear {
    kNo,
    kStraight,  // without area
    kTouched,   // an edge or corner lies on the line that cuts it off
    kYes
  };

  const Vector3d& point(std::int32_t node) const { return points_[at(nodes_[at(node)].corner)]; }
  int turn(std::int32_t a, std::int32_t b, std::int32_t c) const {
    return turnOf(point(a), point(b), point(c));
  }
  static int turnOf(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    return collision::turn(a, b, c, 0, 1);
  }

  std::int32_t first() const {
    std::int32_t node = 0;
    while (nodes_[at(node)].gone) ++node;
    return node;
  }

  void push(std::int32_t node) { queue_.emplace_back(node, ++nodes_[at(node)].pushed); }

  /// Clips ears for as long as one is found: first, among the waiting corners, those that nothing
  /// touches. If there are none, it tries touched ones among all corners, then triangles without
  /// area. False if none is left.
  bool clipEars() {
    for (const Ear least : {Ear::kYes, Ear::kTouched, Ear::kStraight}) {
      if (least != Ear::kYes) pushAll();
      bool clipped = false;
      while (!queue_.empty() && left_ > 3) {
        const auto [node, pushed] = queue_.front();
        queue_.pop_front();
        if (nodes_[at(node)].gone || nodes_[at(node)].pushed != pushed) continue;
        int winding = 1;
        if (look(node, winding) < least) continue;
        if (winding > 1) cut_.crossing = std::max(cut_.crossing, heightOf(node));
        clip(node);
        clipped = true;
      }
      if (clipped) return true;
    }
    return false;
  }

  void pushAll() {
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(nodes_.size()); ++i)
      if (!nodes_[at(i)].gone) push(i);
  }

  /// `winding`: how often the polygon winds around the ear, if it has an area.
  Ear look(std::int32_t node, int& winding) const {
    const std::int32_t a = nodes_[at(node)].previous, c = nodes_[at(node)].next;
    const int turned = turn(a, node, c);
    if (turned < 0) return Ear::kNo;
    if (turned == 0) return turnsBack(a, node, c) ? Ear::kYes : Ear::kStraight;
    const Ear ear = look(a, node, c);
    if (ear == Ear::kNo) return ear;
    // Where edges overlap, an empty triangle may be outside.
    winding = windingIn(a, node, c);
    return winding < 1 ? Ear::kNo : ear;
  }

  /// How often the remaining polygon winds around the inside of a triangle that has the polygon's
  /// orientation and intersects no edge. 1 if the triangle is so thin that no point in it is found.
  int windingIn(std::int32_t a, std::int32_t b, std::int32_t c) const {
    const Vector3d &p = point(a), &q = point(b), &r = point(c);
    for (const Vector3d& share : {Vector3d(0.375, 0.25, 0.375), Vector3d(0.25, 0.25, 0.5),
                                  Vector3d(0.5, 0.25, 0.25), Vector3d(0.25, 0.5, 0.25)}) {
      const Vector3d v = share[0] * p + share[1] * q + share[2] * r;
      if (turnOf(p, q, v) > 0 && turnOf(q, r, v) > 0 && turnOf(r, p, v) > 0)
        return windingAbout(v, a);
    }
    return 1;
  }

  int windingAbout(const Vector3d& v, std::int32_t begin) const {
    int winding = 0;
    std::int32_t node = begin;
    do {
      const std::int32_t next = nodes_[at(node)].next;
      const Vector3d &s = point(node), &t = point(next);
      const bool from_above = s.y() > v.y(), to_above = t.y() > v.y();
      if (from_above != to_above && turnOf(s, t, v) == (to_above ? 1 : -1))
        winding += to_above ? 1 : -1;
      node = next;
    } while (node != begin);
    return winding;
  }

  /// Whether b, one of three points on a line, is not between the others.
  bool turnsBack(std::int32_t a, std::int32_t b, std::int32_t c) const {
    return (point(a) - point(b)).dot(point(c) - point(b)) > 0;
  }

  void emit(std::int32_t node) {
    const Node& n = nodes_[at(node)];
    cut_.triangles.push_back({nodes_[at(n.previous)].corner, n.corner, nodes_[at(n.next)].corner});
  }

  void remove(std::int32_t node) {
    Node& n = nodes_[at(node)];
    n.gone = true;
    nodes_[at(n.previous)].next = n.next;
    nodes_[at(n.next)].previous = n.previous;
    --left_;
  }

  /// Clips an ear. Its neighbours wait behind all others, so that ears of round polygons are not
  /// all at one corner.
  void clip(std::int32_t node) {
    const std::int32_t a = nodes_[at(node)].previous, c = nodes_[at(node)].next;
    emit(node);
    remove(node);
    if (left_ > 3 && corners_[at(nodes_[at(a)].corner)] == corners_[at(nodes_[at(c)].corner)]) {
      const std::int32_t next = nodes_[at(c)].next;
      remove(c);
      push(next);
    } else {
      push(c);
    }
    push(a);
  }

  /// Tests the triangle of a corner and its neighbours.
  Ear look(std::int32_t a, std::int32_t b, std::int32_t c) const {
    const Vector3d &p = point(a), &q = point(b), &r = point(c);
    Ear ear = Ear::kYes;
    eachEdgeNear(a, b, c, [&](const Vector3d& s, const Vector3d& t) {
      if (meets(p, q, r, s, t)) ear = Ear::kNo;
      if (ear == Ear::kYes && turnOf(r, p, s) == 0 && (p - s).dot(r - s) < 0) ear = Ear::kTouched;
      return ear != Ear::kNo;
    });
    return ear;
  }

  /// Calls visit(from, to) for all edges whose box intersects that of a corner's triangle, except
  /// the two of that corner, until it returns false.
  template <class Visit>
  void eachEdgeNear(std::int32_t a, std::int32_t b, std::int32_t c, const Visit& visit) const {
    const Vector3d low = point(a).cwiseMin(point(b)).cwiseMin(point(c)),
                   high = point(a).cwiseMax(point(b)).cwiseMax(point(c));
    for (std::int32_t node = c; node != a; node = nodes_[at(node)].next) {
      const Vector3d &s = point(node), &t = point(nodes_[at(node)].next);
      if (std::max(s.x(), t.x()) < low.x() || std::min(s.x(), t.x()) > high.x() ||
          std::max(s.y(), t.y()) < low.y() || std::min(s.y(), t.y()) > high.y())
        continue;
      if (!visit(s, t)) return;
    }
  }

  /// Whether a segment intersects the inside of a triangle with positive orientation: true unless a
  /// side of the triangle or the segment itself separates them.
  static bool meets(const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s,
                    const Vector3d& t) {
    const auto isBeyond = [&](const Vector3d& a, const Vector3d& b) {
      return turnOf(a, b, s) <= 0 && turnOf(a, b, t) <= 0;
    };
    if (isBeyond(p, q) || isBeyond(q, r) || isBeyond(r, p)) return false;
    const int sides[3] = {turnOf(s, t, p), turnOf(s, t, q), turnOf(s, t, r)};
    return std::max({sides[0], sides[1], sides[2]}) > 0 &&
           std::min({sides[0], sides[1], sides[2]}) < 0;
  }

  // ----------------------------------------------------------------------------------------------
  // polygons that cross themselves

  /// Clips one corner although its triangle is not an ear.
  void clipTheLeastWrong() {
    std::int32_t best = first(), node = best;
    double least = kInfinity;
    for (std::size_t i = 0; i < left_ && least > rounding_; ++i, node = nodes_[at(node)].next) {
      const double wrong = wrongness(node);
      if (wrong >= least) continue;
      least = wrong;
      best = node;
    }
    if (--searches_left_ == 0) least = kInfinity;  // the search limit is reached
    cut_.crossing = std::max(cut_.crossing, least);
    clip(best);
  }

  /// How far other edges enter a corner's triangle, or how far a triangle that counts -1 reaches.
  double wrongness(std::int32_t b) const {
    const std::int32_t a = nodes_[at(b)].previous, c = nodes_[at(b)].next;
    const Vector3d &p = point(a), &q = point(b), &r = point(c);
    if (turn(a, b, c) <= 0) return heightOf(b);
    double wrong = windingIn(a, b, c) < 1 ? heightOf(b) : 0;
    eachEdgeNear(a, b, c, [&](const Vector3d& s, const Vector3d& t) {
      if (meets(p, q, r, s, t)) wrong = std::max(wrong, overlap(p, q, r, s, t));
      return true;
    });
    return wrong;
  }

  static double cross(const Vector3d& a, const Vector3d& b) {
    return a.x() * b.y() - a.y() * b.x();
  }

  /// The least height of a corner's triangle.
  double heightOf(std::int32_t b) const {
    const Vector3d &p = point(nodes_[at(b)].previous), &q = point(b),
                   &r = point(nodes_[at(b)].next);
    const double longest = std::max({(q - p).norm(), (r - q).norm(), (p - r).norm()});
    return longest > 0 ? std::abs(cross(q - p, r - p)) / longest : 0;
  }

  /// The distance by which a segment would have to move to leave a triangle that it intersects.
  static double overlap(const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s,
                        const Vector3d& t) {
    const auto beyond = [&](const Vector3d& a, const Vector3d& b) {
      return std::max(cross(b - a, s - a), cross(b - a, t - a)) / (b - a).norm();
    };
    double least = std::min({beyond(p, q), beyond(q, r), beyond(r, p)});
    if (const double length = (t - s).norm(); length > 0) {
      const double sides[3] = {cross(t - s, p - s), cross(t - s, q - s), cross(t - s, r - s)};
      least = std::min({least, std::max({sides[0], sides[1], sides[2]}) / length,
                        -std::min({sides[0], sides[1], sides[2]}) / length});
    }
    return std::max(least, 0.0);
  }

  std::span<const Vector3d> corners_;
  std::vector<Vector3d> points_;
  std::vector<Node> nodes_;
  std::size_t left_;
  std::deque<std::pair<std::int32_t, std::int32_t>> queue_;
  double rounding_ = 0;  // smaller crossings are ignored
  // Each search tests all corners, and all edges for each of them; a few seconds in total.
  int searches_left_;
  CutPolygon cut_;
};

}  // namespace

Vector3d polygonNormal(std::span<const Vector3d> corners) {
  constexpr double kHardly = 1e-6;
  Vector3d normal = Vector3d::Zero(), farthest = Vector3d::Zero();
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vector3d corner = corners[i] - corners[0];
    normal += (corners[i - 1] - corners[0]).cross(corner);
    if (corner.squaredNorm() > farthest.squaredNorm()) farthest = corner;
  }
  if (normal.norm() > kHardly * farthest.squaredNorm()) return normal;
  Vector3d widest = Vector3d::Zero();
  for (const Vector3d& corner : corners) {
    const Vector3d across = farthest.cross(corner - corners[0]);
    if (across.squaredNorm() > widest.squaredNorm()) widest = across;
  }
  return normal.norm() > kHardly * widest.norm() ? normal : widest;
}

CutPolygon cutPolygon(std::span<const Vector3d> corners) {
  const auto count = static_cast<std::int32_t>(corners.size());
  std::vector<std::int32_t> ring;
  for (std::int32_t i = 0; i < count; ++i)
    if (ring.empty() || corners[at(ring.back())] != corners[at(i)]) ring.push_back(i);
  while (ring.size() > 1 && corners[at(ring.back())] == corners[at(ring.front())]) ring.pop_back();
  CutPolygon cut;
  if (ring.size() <= 3) {  // a point or a segment is a triangle without area
    cut.triangles.push_back(
        {ring.front(), ring[std::min<std::size_t>(1, ring.size() - 1)], ring.back()});
    return cut;
  }
  Eigen::Index axis;
  const Vector3d normal = polygonNormal(corners);
  normal.cwiseAbs().maxCoeff(&axis);
  Eigen::Index i = (axis + 1) % 3, j = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(i, j);
  std::vector<Vector3d> points;
  points.reserve(corners.size());
  const auto flushed = [](double x) { return std::abs(x) < collision::kSmallestExact ? 0 : x; };
  for (const Vector3d& corner : corners)
    points.emplace_back(flushed(corner[i]), flushed(corner[j]), 0);
  cut = Clipper(corners, points, ring).run();
  if (cut.crossing == 0) return cut;
  // The orientation of a polygon with almost no area may be reversed.
  for (Vector3d& point : points) std::swap(point.x(), point.y());
  CutPolygon other = Clipper(corners, std::move(points), ring).run();
  return other.crossing < cut.crossing ? other : cut;
}

}  // namespace leeway::robots
