#include "collision/mesh/convex_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/convex_distance.h"
#include "collision/mesh/components.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/mesh/point_in_solid.h"
#include "collision/shapes/hull_builder.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

// False for triangles that name a vertex twice: those are no part of the surface around a solid,
// see components.h.
bool isProper(const TriangleMesh::Triangle& t) {
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

// For each triangle of a closed component the triangles across its edges, edge k from corner k to
// corner k + 1; -1 where the component is open or the triangle is not proper.
std::vector<std::array<std::int32_t, 3>> neighboursOf(const TriangleMesh& mesh) {
  std::vector<EdgeUse> edges = sortedEdges(mesh.triangles(), mesh.vertices().size());
  std::erase_if(edges,
                [&](const EdgeUse& e) { return !mesh.isClosed(mesh.component(e.triangle)); });
  std::vector<std::array<std::int32_t, 3>> neighbours(mesh.triangles().size(), {-1, -1, -1});
  for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
    const EdgeUse &e = edges[i], &f = edges[i + 1];
    neighbours[index(e.triangle)][index(e.side)] = f.triangle;
    neighbours[index(f.triangle)][index(f.side)] = e.triangle;
  }
  return neighbours;
}

// How many of the triangles in a run of slots are in the patch, by a Fenwick tree: O(log n).
class SlotCount {
 public:
  explicit SlotCount(std::size_t slots) : sum_(slots + 1, 0) {}
  void add(std::int32_t slot, std::int32_t change) {
    for (std::size_t i = index(slot) + 1; i < sum_.size(); i += i & (~i + 1)) sum_[i] += change;
  }
  std::int32_t in(std::int32_t begin, std::int32_t end) const { return upTo(end) - upTo(begin); }

 private:
  std::int32_t upTo(std::int32_t end) const {
    std::int32_t sum = 0;
    for (std::size_t i = index(end); i > 0; i -= i & (~i + 1)) sum += sum_[i];
    return sum;
  }
  std::vector<std::int32_t> sum_;
};

// Sets that are emptied at once.
class Marks {
 public:
  explicit Marks(std::size_t size) : stamp_(size, 0) {}
  void clear() { ++now_; }
  bool has(std::int32_t i) const { return stamp_[index(i)] == now_; }
  void remove(std::int32_t i) { stamp_[index(i)] = now_ - 1; }
  void add(std::int32_t i) { stamp_[index(i)] = now_; }

 private:
  std::vector<std::int32_t> stamp_;
  std::int32_t now_ = 1;
};

// Vectors with a number each, coordinates side by side: planes, or points.
class Columns {
 public:
  void clear() {
    for (auto& column : column_) column.clear();
  }
  void push(const Vector& v, double offset) {
    for (Eigen::Index k = 0; k < 3; ++k) column_[static_cast<std::size_t>(k)].push_back(v[k]);
    column_[3].push_back(offset);
  }
  void pop() {
    for (auto& column : column_) column.pop_back();
  }
  std::size_t size() const { return column_[3].size(); }
  // Whether v . w - offset > limit for one of them.
  bool above(const Vector& w, double limit) const {
    const double wx = w.x(), wy = w.y(), wz = w.z();
    const double *x = column_[0].data(), *y = column_[1].data(), *z = column_[2].data(),
                 *d = column_[3].data();
    constexpr std::size_t kBlock = 256;
    for (std::size_t begin = 0; begin < size(); begin += kBlock) {
      const std::size_t end = std::min(begin + kBlock, size());
      std::int64_t count = 0;
      for (std::size_t i = begin; i < end; ++i) {
        count += x[i] * wx + y[i] * wy + z[i] * wz - d[i] > limit ? 1 : 0;
      }
      if (count > 0) return true;
    }
    return false;
  }

 private:
  std::array<std::vector<double>, 4> column_;
};

// The hull of a patch, with the planes of its facets.
class PatchHull {
 public:
  // n . x <= offset for every point x of the hull, with n a unit vector to within rounding that
  // `doubt` covers.
  struct Plane {
    Vector normal, point;
    double doubt;
  };

  bool build(std::vector<Vector> points) {
    points_ = std::move(points);
    const HullBuilder builder(points_);
    if (builder.dimension() < 3) return false;
    facets_ = builder.facets();
    vertices_ = builder.vertices();
    corners_.clear();
    Vector low = points_[index(vertices_[0])], high = low, mean = Vector::Zero();
    for (const std::int32_t v : vertices_) {
      const Vector& p = points_[index(v)];
      corners_.push_back(p);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
      mean += p / static_cast<double>(vertices_.size());
    }
    low_ = low;
    high_ = high;
    size_ = (high - low).norm();
    makePlanes();
    // The centroid of the volume, of tetrahedra from the mean.
    Vector sum = Vector::Zero();
    double volume = 0;
    for (const auto& f : facets_) {
      const Vector a = points_[index(f[0])] - mean, b = points_[index(f[1])] - mean,
                   c = points_[index(f[2])] - mean;
      const double v = a.dot(cross(b, c));
      volume += v;
      sum += v * (a + b + c);
    }
    center_ = volume > 0 ? Vector(mean + sum / (4 * volume)) : mean;
    reach_ = 0;
    for (const Vector& p : corners_) reach_ = std::max(reach_, (p - center_).norm());
    reach_ *= 1 + kRelativeRounding;
    return center_.allFinite();
  }

  const std::vector<std::array<std::int32_t, 3>>& facets() const { return facets_; }
  const std::vector<std::int32_t>& vertices() const { return vertices_; }
  const std::vector<Vector>& corners() const { return corners_; }
  const Plane& plane(std::int32_t facet) const { return planes_[index(facet)]; }
  std::span<const std::int32_t> facetsAt(std::int32_t point) const {
    return {around_.data() + first_[index(point)], around_.data() + first_[index(point) + 1]};
  }
  const Vector& low() const { return low_; }
  const Vector& high() const { return high_; }
  const Vector& center() const { return center_; }
  double size() const { return size_; }    // no two points are farther apart
  double reach() const { return reach_; }  // no point is farther from the centre
  ConvexView view() const {
    return viewOfPoints(corners_.data(), static_cast<int>(corners_.size()), 0);
  }

 private:
  // The exact plane of facet abc supports the hull: (b - a) x (c - a) . (x - a) <= 0. The product
  // as computed errs by less than 16 units of |b - a| |c - a|, and so do its dot products by that
  // times |x - a|.
  void makePlanes() {
    planes_.clear();
    first_.assign(points_.size() + 1, 0);
    for (const auto& f : facets_) {
      const Vector &a = points_[index(f[0])], &b = points_[index(f[1])], &c = points_[index(f[2])];
      const Vector normal = cross(b - a, c - a);
      const double length = normal.norm();
      const double error = 16 * kUnitRoundoff * (b - a).norm() * (c - a).norm();
      planes_.push_back({length > 0 ? Vector(normal / length) : Vector::UnitX(), a,
                         length > 0 ? size_ * (error / length + 16 * kUnitRoundoff) : kInfinity});
      for (const std::int32_t v : f) ++first_[index(v) + 1];
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    around_.resize(3 * facets_.size());
    std::vector<std::int32_t> fill(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      for (const std::int32_t v : facets_[i]) {
        around_[index(fill[index(v)]++)] = static_cast<std::int32_t>(i);
      }
    }
  }

  std::vector<Vector> points_, corners_;
  std::vector<std::array<std::int32_t, 3>> facets_;
  std::vector<std::int32_t> vertices_;
  std::vector<Plane> planes_;
  std::vector<std::int32_t> first_, around_;  // facets at a point
  Vector low_, high_, center_;
  double size_ = 0, reach_ = 0;
};

class Decomposition {
 public:
  explicit Decomposition(const TriangleMesh& mesh)
      : mesh_(mesh),
        tree_(mesh.tree()),
        neighbours_(neighboursOf(mesh)),
        inside_patch_(mesh.triangles().size()),
        rejected_(mesh.triangles().size()),
        queued_(mesh.triangles().size()),
        local_mark_(mesh.vertices().size()),
        taken_(mesh.triangles().size(), 0),
        local_(mesh.vertices().size(), -1),
        slots_(mesh.triangles().size()) {
    const MeshNode& root = tree_.node(0);
    largest_ = kPieceTolerance * (root.high - root.low).norm();
    work_left_ =
        std::min(kPieceWork * static_cast<double>(mesh.triangles().size()), kPieceMostWork);
    for (const TriangleMesh::Triangle& t : mesh.triangles()) {
      const Vector &a = at(t[0]), &b = at(t[1]), &c = at(t[2]);
      const Vector normal = cross(b - a, c - a);
      const double length = normal.norm();
      // A sliver's normal is anything; the planes through it are valid all the same.
      normals_.push_back(length > 0 ? Vector(normal / length) : Vector::UnitX());
      offsets_.push_back(normals_.back().dot(a));
    }
  }

  ConvexPieces run() {
    ConvexPieces result;
    const auto count = static_cast<double>(mesh_.triangles().size());
    const std::vector<std::int32_t> order = seeds();
    const auto closed = static_cast<double>(order.size());
    double units = count - closed, done = units, held = 0;
    for (const std::int32_t seed : order) {
      if (taken_[index(seed)] != 0) continue;
      if (work_left_ < 0) {
        result = {};
        result.summary.use = PieceSummary::Use::kLaborious;
        return result;
      }
      ConvexPiece piece;
      grow(seed, piece);
      const auto size = static_cast<double>(patch_.size());
      for (const std::int32_t t : patch_) {
        taken_[index(t)] = 1;
        slots_.add(tree_.slotOf(t), -1);
      }
      done += size;
      units += piece.hull != nullptr ? 1 : size;
      if (kPieceTriangles * units > std::min(done + kPieceTriangles * kPieceHeadStart, count)) {
        result = {};
        result.summary.use = PieceSummary::Use::kConcave;
        return result;
      }
      if (piece.hull == nullptr) continue;
      held += size;
      result.summary.excess = std::max(result.summary.excess, piece.excess);
      result.pieces.push_back(std::move(piece));
    }
    result.summary.use = PieceSummary::Use::kUsed;
    result.summary.pieces = static_cast<int>(result.pieces.size());
    result.summary.loose_triangles = static_cast<int>(count - held);
    return result;
  }

 private:
  struct Obstacle;
  const Vector& at(std::int32_t v) const { return mesh_.vertices()[index(v)]; }
  const TriangleMesh::Triangle& corners(std::int32_t t) const {
    return mesh_.triangles()[index(t)];
  }

  // How far the corners of `other` stand out of the plane of `t` at the most.
  double above(std::int32_t t, std::int32_t other) const {
    double most = -kInfinity;
    for (const std::int32_t v : corners(other)) {
      most = std::max(most, normals_[index(t)].dot(at(v)) - offsets_[index(t)]);
    }
    return most;
  }
  bool reflex(std::int32_t t, std::int32_t other) const {
    return above(t, other) > largest_ || above(other, t) > largest_;
  }

  // Triangles of closed components, those farthest from reflex edges (in steps across edges) first.
  std::vector<std::int32_t> seeds() const {
    const auto count = static_cast<std::int32_t>(mesh_.triangles().size());
    std::vector<std::int32_t> depth(index(count), -1), queue;
    for (std::int32_t t = 0; t < count; ++t) {
      if (!mesh_.isClosed(mesh_.component(t))) continue;
      for (const std::int32_t other : neighbours_[index(t)]) {
        if (other < 0 || depth[index(t)] >= 0 || !reflex(t, other)) continue;
        depth[index(t)] = 0;
        queue.push_back(t);
      }
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
      for (const std::int32_t other : neighbours_[index(queue[head])]) {
        if (other < 0 || depth[index(other)] >= 0) continue;
        depth[index(other)] = depth[index(queue[head])] + 1;
        queue.push_back(other);
      }
    }
    std::vector<std::int32_t> order;
    for (std::int32_t t = 0; t < count; ++t) {
      if (mesh_.isClosed(mesh_.component(t))) order.push_back(t);
    }
    // (Convex components have no reflex edge.)
    std::stable_sort(order.begin(), order.end(), [&](std::int32_t l, std::int32_t r) {
      const auto key = [&](std::int32_t t) {
        return depth[index(t)] < 0 ? count : depth[index(t)];
      };
      return key(l) > key(r);
    });
    return order;
  }

  void take(std::int32_t t) {
    patch_.push_back(t);
    inside_patch_.add(t);
    slots_.add(tree_.slotOf(t), 1);
    planes_.push(normals_[index(t)], offsets_[index(t)]);
    for (const std::int32_t v : corners(t)) points_.push(at(v), 0);
  }

  void untake() {
    const std::int32_t t = patch_.back();
    patch_.pop_back();
    inside_patch_.remove(t);
    slots_.add(tree_.slotOf(t), -1);
    planes_.pop();
    for (int k = 0; k < 3; ++k) points_.pop();
  }

  // The largest patch found around a seed; its hull, where it is worth one.
  void grow(std::int32_t seed, ConvexPiece& piece) {
    patch_.clear();
    planes_.clear();
    points_.clear();
    inside_patch_.clear();
    rejected_.clear();
    component_ = mesh_.component(seed);
    has_hull_ = false;
    obstacles_.clear();
    take(seed);
    has_hull_ = accept();
    std::size_t step = 1;
    int failures = 0;
    bool filtered = false;
    while (has_hull_ && work_left_ > 0) {
      const std::size_t before = patch_.size();
      gather(step, filtered);
      const std::size_t size = patch_.size() - before;
      if (size == 0) break;
      if (accept()) {
        step = std::max(2 * step, filtered ? 0 : before / 2);
        continue;
      }
      if (size == 1) rejected_.add(patch_.back());
      while (patch_.size() > before) untake();
      if (++failures >= kPieceFailures) break;
      // What is known of an obstacle now keeps out what would meet it; else fewer are tried.
      const bool learnt = culprit_ >= 0 && learn(culprit_);
      if (filtered && !learnt) step = std::max<std::size_t>(size / 2, 1);
      filtered = true;
    }
    if (!has_hull_ || patch_.size() < 4) return;
    piece.hull = ConvexHull::compute(hull_.corners());
    piece.excess = excess_;
    piece.triangles = patch_;
    std::sort(piece.triangles.begin(), piece.triangles.end());
  }

  // Adds up to `limit` triangles to the patch, breadth first across edges that are not reflex. With
  // `filtered`, what certainly does not fit is left out.
  void gather(std::size_t limit, bool filtered) {
    queue_.clear();
    queued_.clear();
    const std::size_t before = patch_.size();
    work_left_ -= 0.05 * static_cast<double>(before);
    const auto reach = [&](std::int32_t from) {
      for (const std::int32_t t : neighbours_[index(from)]) {
        if (t < 0 || taken_[index(t)] != 0 || inside_patch_.has(t) || queued_.has(t) ||
            rejected_.has(t))
          continue;
        if (reflex(from, t)) continue;
        queued_.add(t);
        queue_.push_back(t);
      }
    };
    for (std::size_t i = 0; i < before; ++i) reach(patch_[i]);
    spanned_ = hull_.corners();
    for (std::size_t head = 0; head < queue_.size() && patch_.size() < before + limit; ++head) {
      const std::int32_t t = queue_[head];
      if ((filtered && conflicts(t)) || meetsObstacle(t)) {
        rejected_.add(t);
        continue;
      }
      take(t);
      reach(t);
    }
  }

  // Whether a triangle does not fit those in the patch: a corner of it stands out of the plane of
  // one, or a corner of one out of its own.
  bool conflicts(std::int32_t t) {
    work_left_ -= 0.01 * static_cast<double>(planes_.size() + points_.size());
    for (const std::int32_t v : corners(t)) {
      if (planes_.above(at(v), fit_)) return true;
    }
    return points_.above(normals_[index(t)], offsets_[index(t)] + fit_);
  }

  // How deep a triangle is in the hull of some points: no deeper than -(lower end) along -(normal).
  DistanceResult depthIn(std::int32_t t, const ConvexView& hull, double allowed) {
    const auto& c = corners(t);
    const Vector triangle[3] = {at(c[0]), at(c[1]), at(c[2])};
    DistanceRequest request;
    request.threshold = -allowed;
    request.tolerance = 0.1 * allowed;
    request.iteration_limit = 64;
    work_left_ -= 8 + 0.05 * hull.count;
    return convexDistance(viewOfPoints(triangle, 3, 0), Pose{}, hull, request, scratch_, nullptr);
  }

  // Keeps in mind that this triangle, outside of the patch, must stay outside of its hull. False
  // when it was known.
  bool learn(std::int32_t t) {
    for (const Obstacle& o : obstacles_) {
      if (o.triangle == t) return false;
    }
    obstacles_.push_back({t, Vector::Zero(), 0});
    const auto& points = hull_.corners();
    partFrom(obstacles_.back(), viewOfPoints(points.data(), static_cast<int>(points.size()), 0));
    return true;
  }

  // Finds a plane that parts an obstacle from the hull of some points. False when there is none.
  bool partFrom(Obstacle& o, const ConvexView& hull) {
    const DistanceResult r = depthIn(o.triangle, hull, fit_);
    if (!(r.distance.lower > -fit_)) return false;
    o.normal = -r.normal;
    o.limit = kInfinity;
    for (const std::int32_t v : corners(o.triangle)) {
      o.limit = std::min(o.limit, o.normal.dot(at(v)) + fit_);
    }
    return true;
  }

  // Whether the hull would meet a known obstacle if it had triangle t, too. If not, t is spanned.
  bool meetsObstacle(std::int32_t t) {
    const std::size_t before = spanned_.size();
    for (const std::int32_t v : corners(t)) spanned_.push_back(at(v));
    for (Obstacle& o : obstacles_) {
      bool clear = true;
      for (const std::int32_t v : corners(t)) clear = clear && o.normal.dot(at(v)) <= o.limit;
      if (clear || partFrom(o, viewOfPoints(spanned_.data(), static_cast<int>(spanned_.size()), 0)))
        continue;
      spanned_.resize(before);
      return true;
    }
    return false;
  }

  // Whether the hull of the patch is proven to leave the solid by no more than allowed; then it is
  // the new hull_. A patch that is flat gets a point inside the solid, below it.
  bool accept() {
    if (proven(nullptr)) return true;
    if (!thin_) return false;
    Vector middle = Vector::Zero(), normal = Vector::Zero();
    double area = 0;
    for (const std::int32_t t : patch_) {
      const auto& c = corners(t);
      const double a = cross(at(c[1]) - at(c[0]), at(c[2]) - at(c[0])).norm();
      middle += a / 3 * (at(c[0]) + at(c[1]) + at(c[2]));
      normal += a * normals_[index(t)];
      area += a;
    }
    if (!(area > 0 && normal.norm() > 0)) return false;
    for (double depth = 0.25; depth > 0.01; depth *= 0.25) {
      Vector apex = middle / area - depth * std::sqrt(area) * normal.normalized();
      for (int k = 0; k < 3; ++k) {
        if (std::abs(apex[k]) < kSmallestExact) apex[k] = 0;
      }
      if (proven(&apex)) return true;
    }
    return false;
  }

  bool proven(const Vector* apex) {
    thin_ = false;
    culprit_ = -1;
    trial_points_.clear();
    local_mark_.clear();
    for (const std::int32_t t : patch_) {
      for (const std::int32_t v : corners(t)) {
        if (local_mark_.has(v)) continue;
        local_mark_.add(v);
        local_[index(v)] = static_cast<std::int32_t>(trial_points_.size());
        trial_points_.push_back(at(v));
      }
    }
    if (apex != nullptr) trial_points_.push_back(*apex);
    work_left_ -= 1 + 2 * static_cast<double>(trial_points_.size());
    if (trial_points_.size() < 4 || !trial_.build(trial_points_)) {
      thin_ = true;
      return false;
    }
    // No point of the hull's surface is nearer to the centre than this.
    ConvexView point;
    point.core = Core::kPoint;
    Pose X;
    X.translation = trial_.center();
    const ConvexView view = trial_.view();
    DistanceRequest request;
    request.tolerance = 0.01 * trial_.reach();
    const double inradius =
        -convexDistance(point, X, view, request, scratch_, nullptr).distance.upper;
    thin_ = !(inradius > kPieceThin * trial_.reach());
    if (!(inradius > 0)) return false;
    // A triangle this deep in the hull asks for the largest excess.
    allowed_ = largest_ * inradius / trial_.reach();
    deepest_ = 0;
    last_ = 0;
    for (const std::int32_t t : patch_) {
      if (!shallow(t, view)) return false;
    }
    if (!othersShallow(view)) return false;
    if (sideOf(mesh_, component_, trial_.center()) != Side::kInside) return false;
    // A triangle that is no deeper than h in the direction n, n . x >= max(n . hull) - h, does not
    // meet the interior of the hull shrunk about its centre by the share h / inradius; no point of
    // the hull is farther than share times reach from that.
    excess_ = deepest_ / inradius * trial_.reach() * (1 + 16 * kUnitRoundoff);
    if (!(excess_ <= largest_)) return false;
    std::swap(hull_, trial_);
    fit_ = allowed_;
    return true;
  }

  // Whether triangle t is no deeper in the hull than allowed: in some direction no point of the
  // hull is farther than that above it. Planes of facets near to it and its own come first.
  bool shallow(std::int32_t t, const ConvexView& view) {
    const auto& c = corners(t);
    double best = kInfinity;
    const double rounding = 16 * kUnitRoundoff * trial_.size();
    const auto offer = [&](std::int32_t facet) {
      const PatchHull::Plane& plane = trial_.plane(facet);
      // Corners of triangles outside of the patch may be far away.
      double deep = -kInfinity, far_squared = 0;
      for (const std::int32_t v : c) {
        const Vector down = plane.point - at(v);
        deep = std::max(deep, plane.normal.dot(down));
        far_squared = std::max(far_squared, down.squaredNorm());
      }
      deep += plane.doubt + 8 * kUnitRoundoff * (std::sqrt(far_squared) + trial_.size());
      if (deep < best) {
        best = deep;
        last_ = facet;
      }
    };
    work_left_ -= 1;
    offer(last_);
    for (std::size_t k = 0; k < 3 && best > rounding; ++k) {
      if (!local_mark_.has(c[k])) continue;
      for (const std::int32_t facet : trial_.facetsAt(local_[index(c[k])])) {
        const auto& f = trial_.facets()[index(facet)];
        const auto is = [&](std::size_t i) {
          return local_mark_.has(c[i]) &&
                 std::find(f.begin(), f.end(), local_[index(c[i])]) != f.end();
        };
        if (is(0) && is(1) && is(2)) {  // exactly
          last_ = facet;
          return true;
        }
        offer(facet);
      }
    }
    if (best > allowed_) {
      const Vector& n = normals_[index(t)];
      const Vector& origin = at(c[0]);
      double high = -kInfinity, low = kInfinity, own_high = 0, own_low = 0, far_squared = 0;
      for (const Vector& p : trial_.corners()) {
        const Vector way = p - origin;
        const double h = n.dot(way);
        high = std::max(high, h);
        low = std::min(low, h);
        far_squared = std::max(far_squared, way.squaredNorm());
      }
      for (const std::int32_t v : c) {
        const Vector way = at(v) - origin;
        own_high = std::max(own_high, n.dot(way));
        own_low = std::min(own_low, n.dot(way));
        far_squared = std::max(far_squared, way.squaredNorm());
      }
      const double error = 16 * kUnitRoundoff * std::sqrt(far_squared);
      best = std::min({best, high - own_low + error, own_high - low + error});
      work_left_ -= 0.02 * static_cast<double>(trial_.corners().size());
    }
    if (best > allowed_) best = std::min(best, -depthIn(t, view, allowed_).distance.lower);
    if (best > allowed_) return false;
    deepest_ = std::max(deepest_, best);
    return true;
  }

  // The same for all triangles of the component that are not in the patch.
  bool othersShallow(const ConvexView& view) {
    std::array<int, 2 * MeshTree::kMaxDepth> stack;
    std::size_t size = 0;
    stack[size++] = 0;
    DistanceRequest request;
    request.tolerance = kDefaultTolerance;
    request.threshold = 0;
    request.depth = false;
    while (size > 0) {
      const int id = stack[--size];
      const MeshNode& node = tree_.node(id);
      if (node.component >= 0 && node.component != component_) continue;
      if ((node.low.array() > trial_.high().array()).any() ||
          (node.high.array() < trial_.low().array()).any())
        continue;
      const std::int32_t count = node.triangle_end - node.triangle_begin;
      if (slots_.in(node.triangle_begin, node.triangle_end) == count) continue;
      work_left_ -= 0.1;
      if (!node.isLeaf()) {
        if (count > 4) {
          work_left_ -= 2 + 0.02 * static_cast<double>(trial_.corners().size());
          const DistanceResult r =
              convexDistance(tree_.nodeView(node), Pose{}, view, request, scratch_, nullptr);
          if (r.distance.lower > 0) continue;
        }
        stack[size++] = node.right;
        stack[size++] = id + 1;
        continue;
      }
      for (int slot = node.triangle_begin; slot < node.triangle_end; ++slot) {
        const std::int32_t t = tree_.triangleOf(slot);
        if (mesh_.component(t) != component_ || inside_patch_.has(t) || !isProper(corners(t)))
          continue;
        if (shallow(t, view)) continue;
        culprit_ = t;
        return false;
      }
    }
    return true;
  }

  const TriangleMesh& mesh_;
  const MeshTree& tree_;
  std::vector<std::array<std::int32_t, 3>> neighbours_;
  std::vector<Vector> normals_;  // of triangles
  std::vector<double> offsets_;
  double largest_ = 0;  // excess allowed [m]
  double work_left_ = 0;
  Marks inside_patch_, rejected_, queued_, local_mark_;
  std::vector<std::uint8_t> taken_;
  std::vector<std::int32_t> local_;  // number of a vertex in the hull in hand
  SlotCount slots_;
  Scratch scratch_;
  // A triangle outside of the patch and a plane with all that is spanned on its lower side.
  struct Obstacle {
    std::int32_t triangle;
    Vector normal;
    double limit;
  };
  std::vector<Obstacle> obstacles_;
  std::vector<Vector> spanned_;
  // The patch in hand.
  std::vector<std::int32_t> patch_, queue_;
  Columns planes_, points_;  // of the triangles in the patch, and their corners
  double fit_ = 0;           // what may stand out of a plane [m]
  int component_ = 0;
  PatchHull hull_;  // as accepted last
  double excess_ = 0;
  bool has_hull_ = false;
  // A hull that is tried.
  PatchHull trial_;
  std::vector<Vector> trial_points_;
  double allowed_ = 0, deepest_ = 0;
  std::int32_t culprit_ = -1;  // a triangle outside of the patch that is too deep in its hull
  std::int32_t last_ = 0;      // the facet that was best for the last triangle
  bool thin_ = false;
};

}  // namespace

ConvexPieces convexPieces(const TriangleMesh& mesh) {
  ConvexPieces none;
  if (mesh.closedComponentCount() == 0) {
    none.summary.use = PieceSummary::Use::kOpen;
    return none;
  }
  const double extent = mesh.tree().extent();
  if (!(extent >= kSmallestBoxScale && extent <= kLargestBoxScale)) {
    none.summary.use = PieceSummary::Use::kExtreme;
    return none;
  }
  if (mesh.triangles().size() < static_cast<std::size_t>(kLeastDecomposed)) return none;
  return Decomposition(mesh).run();
}

}  // namespace leeway::collision
