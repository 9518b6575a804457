// Construction of a LaneSweep.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/lanes/lane_sweep.h"
#include "collision/lanes/lane_sweep_impl.h"

namespace leeway::collision {
namespace {

/// The gap that a plane must leave in addition to radius, growth and slack; its rounding is derived
/// in lane_planes-inl.h.
float planeAbove(double threshold, double rounding) {
  return floatAbove(std::max(threshold, 0.0) + 4 * rounding);
}
/// The same for a plane computed in a lane, see gilbert_planes-inl.h.
float ownPlaneAbove(double threshold, double rounding) {
  return floatAbove(std::max(threshold, 0.0) + 5 * rounding);
}

/// Minimum number of pairs for a test of all of them together [count].
constexpr std::size_t kLeastBundle = 3;

/// Rounding of a centre to single precision, which is added to the radius.
double centerRounding(const Ball& ball) { return 0x1p-23 * ball.center.lpNorm<1>(); }

}  // namespace

LaneSweep::LaneSweep() : impl_(std::make_unique<Impl>()) {}
LaneSweep::~LaneSweep() = default;
LaneSweep::LaneSweep(LaneSweep&&) noexcept = default;
LaneSweep& LaneSweep::operator=(LaneSweep&&) noexcept = default;
LaneSweep::LaneSweep(const LaneSweep& begun) : impl_(std::make_unique<Impl>(*begun.impl_)) {
  impl_->owns_stock = false;
}

LaneSweep::Impl::Stock& LaneSweep::Impl::ownStock() {
  if (!owns_stock || stock.use_count() > 1) {
    stock = std::make_shared<Stock>(*stock);
    owns_stock = true;
    // Views borrow from the stock, which was shared.
    for (std::vector<LanePiece>* of : {&pieces, &parts})
      for (LanePiece& piece : *of) piece.view = piece.fine_view = {};
  }
  return *stock;
}

int LaneSweep::addPiece(const Piece& piece) {
  Impl::Stock& stock = impl_->ownStock();
  Impl::LanePiece lane{};
  lane.frame = piece.frame;
  lane.motion = piece.motion;
  lane.reach = piece.reach;
  const auto grown = [](const Ball& ball) {
    Impl::LaneBall result{};
    setSingle(ball.center, result.center);
    result.radius = floatAbove(ball.radius + centerRounding(ball));
    return result;
  };
  lane.outer = grown(piece.outer);
  lane.cover = static_cast<int>(stock.balls.size());
  for (const Ball& ball : piece.cover) stock.balls.push_back(grown(ball));
  lane.inner = static_cast<int>(stock.balls.size());
  for (const Ball& ball : piece.inner) {
    Impl::LaneBall result{};
    setSingle(ball.center, result.center);
    result.radius = floatBelow(ball.radius - centerRounding(ball));
    stock.balls.push_back(result);
  }
  lane.end = static_cast<int>(stock.balls.size());
  for (const Ball& ball : piece.inner)
    lane.inner_reach = std::max(
        lane.inner_reach, floatAbove((ball.center - piece.outer.center).norm() + ball.radius));
  impl_->addPoints(piece.points, lane);
  lane.parts_begin = static_cast<int>(impl_->parts.size());  // indices into `parts` until finish()
  for (const CoverPart& p : piece.parts) {
    Impl::LanePiece part{};
    part.frame = lane.frame;
    part.motion = lane.motion;
    part.reach = lane.reach;
    part.outer = grown(p.ball);
    impl_->addPoints(p.points, part);
    impl_->parts.push_back(part);
  }
  lane.parts_end = static_cast<int>(impl_->parts.size());
  impl_->pieces.push_back(lane);
  return static_cast<int>(impl_->pieces.size()) - 1;
}

void LaneSweep::addGroup(std::span<const int> pieces, std::span<const Ball> balls) {
  Piece group;
  group.frame = impl_->pieces[at(pieces.front())].frame;
  group.cover.assign(balls.begin(), balls.end());
  for (const Ball& ball : balls) {
    group.outer.center += ball.center / static_cast<double>(balls.size());
    group.reach = std::max(group.reach, ball.center.norm());
  }
  for (const Ball& ball : balls)
    group.outer.radius =
        std::max(group.outer.radius, (ball.center - group.outer.center).norm() + ball.radius);
  for (const int piece : pieces) {
    impl_->pieces[at(piece)].group = static_cast<std::int32_t>(impl_->groups.size());
    group.reach = std::max(group.reach, impl_->pieces[at(piece)].reach);
  }
  const auto begin = static_cast<std::int32_t>(impl_->group_members.size());
  impl_->group_members.insert(impl_->group_members.end(), pieces.begin(), pieces.end());
  impl_->groups.push_back(
      {addPiece(group), begin, static_cast<std::int32_t>(impl_->group_members.size())});
}

int LaneSweep::addObstacle(const Shape& shape, const Pose& X_WG, int place) {
  Impl::Obstacle o = Impl::obstacleOf(shape, X_WG);
  o.place = place;
  o.exact_shape = place < 0 ? Impl::keptExactOf(shape, X_WG) : Impl::exactOf(shape, X_WG);
  o.parts_begin = o.parts_end = static_cast<int>(impl_->obstacle_parts.size());
  if (shape.type() == ShapeType::kMesh) {
    for (const CoverPart& part : coverOf(shape)->parts) {
      impl_->obstacle_parts.push_back(Impl::partOf(part, X_WG));
      ++o.parts_end;
    }
  }
  impl_->obstacles.push_back(std::move(o));
  return static_cast<int>(impl_->obstacles.size()) - 1;
}

void LaneSweep::addPair(int piece, int obstacle, int balls, double threshold, bool by_parts,
                        std::uint8_t kind, bool has_proof) {
  const auto id = static_cast<int>(impl_->pairs.size());
  impl_->pairs.push_back(impl_->pairWith(id, piece, impl_->obstacles[at(obstacle)], obstacle, balls,
                                         threshold, by_parts));
  impl_->pairs.back().kind = kind;
  impl_->pairs.back().has_proof = has_proof;
}

LaneSweep::Impl::Pair LaneSweep::Impl::pairWith(int id, int piece, const Obstacle& o, int b,
                                                int balls_of, double threshold,
                                                bool by_parts) const {
  const LanePiece& a = pieces[at(piece)];
  const double rounding =
      kLaneSweepRounding * (a.reach + static_cast<double>(a.outer.radius) + o.scale);
  const bool has_points = a.frame >= 0 && a.points.begin < a.points.end;
  const bool deforms = o.deforms;
  return {id,
          piece,
          b,
          balls_of,
          a.motion,
          false,
          floatAbove(threshold + rounding),
          floatBelow(threshold - rounding),
          floatAbove(std::max(threshold, 0.0) + rounding),
          has_points && o.has_view ? planeAbove(threshold, rounding) : -1.0F,
          has_points && !deforms ? ownPlaneAbove(threshold, rounding) : -1.0F,
          by_parts && has_points && !deforms};
}

LaneSweep::Impl::Pair LaneSweep::Impl::pairWithWorld(std::int32_t number) const {
  const auto in_world =
      static_cast<std::uint32_t>(number - static_cast<std::int32_t>(pairs.size()));
  const auto of_row = static_cast<std::uint32_t>(places);
  const auto row = static_cast<int>(in_world / of_row), place = static_cast<int>(in_world % of_row);
  const std::optional<LaneWorld::Pair> of = world->pairOf(row, place);
  Pair pair{};
  pair.kind = 0;
  if (!of) return pair;
  const int added = obstacleAt(place);
  const int piece = rows[at(row)].piece;
  if (added < 0) {
    pair = pairWith(number, piece, obstacleIn(place), -1 - place, -1, of->threshold, of->by_parts);
  } else {
    const Obstacle& o = obstacles[at(added)];
    pair = pairWith(number, piece, o, added, o.balls, of->threshold, of->by_parts);
  }
  setParts(pair);
  return pair;
}

int LaneSweep::Impl::obstacleAt(std::int32_t place) const {
  const auto found =
      std::lower_bound(placed_obstacles.begin(), placed_obstacles.end(), place,
                       [&](int o, std::int32_t p) { return obstacles[at(o)].place < p; });
  return found != placed_obstacles.end() && obstacles[at(*found)].place == place ? *found : -1;
}

void LaneSweep::setWorld(std::shared_ptr<const LaneWorld> world, std::span<const Row> rows,
                         std::size_t places, std::shared_ptr<const ObstacleBoxes> boxes,
                         double scale) {
  impl_->world = std::move(world);
  impl_->rows.assign(rows.begin(), rows.end());
  impl_->places = places;
  impl_->boxes = std::move(boxes);
  impl_->scale_of_world = scale;
}

void LaneSweep::setBalls(int obstacle, int balls) { impl_->obstacles[at(obstacle)].balls = balls; }

void LaneSweep::addPiecePair(int a, int b, int motion, double threshold, bool by_parts,
                             std::uint8_t kind, bool has_proof) {
  const auto id = static_cast<int>(impl_->pairs.size());
  const Impl::LanePiece &x = impl_->pieces[at(a)], &y = impl_->pieces[at(b)];
  const double rounding =
      kLaneSweepRounding *
      (x.reach + y.reach + static_cast<double>(x.outer.radius + y.outer.radius));
  impl_->piece_pairs.push_back(static_cast<std::int32_t>(impl_->pairs.size()));
  const bool planes = x.frame >= 0 && y.frame >= 0 && x.points.begin < x.points.end &&
                      y.points.begin < y.points.end;
  impl_->pairs.push_back({id, a, b, b, motion, true, floatAbove(threshold + rounding),
                          floatBelow(threshold - rounding),
                          floatAbove(std::max(threshold, 0.0) + rounding),
                          planes ? planeAbove(threshold, rounding) : -1.0F, -1.0F,
                          by_parts && planes, has_proof, kind});
}

void LaneSweep::reservePairs(std::size_t count) { impl_->pairs.reserve(count); }

bool LaneSweep::canMeet(int pair, Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, nullptr, nullptr, 0};
  const Impl::Pair& p = kernel.pair(pair);
  const auto piece = [&](int i) -> const Impl::LanePiece& {
    return impl_->pieces[static_cast<std::size_t>(i)];
  };
  const Impl::LanePiece& a = piece(p.a);
  const bool exact = !p.pieces && kernel.obstacle(p).exact;
  const bool by_balls = exact || (p.balls >= 0 && piece(p.balls).inner < piece(p.balls).end);
  return (a.inner < a.end && by_balls) || (exact && a.frame >= 0 && a.own >= 0);
}

void LaneSweep::finishPieces() {
  impl_->makeViews(impl_->pieces);
  impl_->makeViews(impl_->parts);
}

void LaneSweep::finish() { impl_->finish(); }

void LaneSweep::Impl::addPoints(const PointCover& cover, LanePiece& piece) {
  Stock& own = ownStock();
  double rounding = cover.fine_radius;
  const auto add = [&](const std::vector<Eigen::Vector3d>& added, double radius) {
    LanePiece::Points result;
    result.begin = static_cast<int>(own.points.size());
    for (const Eigen::Vector3d& p : added) {
      own.points.push_back(p);
      for (int k = 0; k < 3; ++k) own.point[k].push_back(static_cast<float>(p[k]));
      rounding = std::max(rounding, cover.fine_radius + centerRounding({p, 0}));
    }
    result.end = static_cast<int>(own.points.size());
    result.radius = floatAbove(radius);
    return result;
  };
  piece.points = piece.fine = add(cover.points, cover.radius);
  if (!cover.fine.empty()) piece.fine = add(cover.fine, cover.fine_radius);
  if (cover.own) piece.own = floatAbove(rounding);
  piece.fine.clusters_begin = static_cast<int>(own.clusters.size());
  // Uses only clusters as clusterFine() makes them; any others are ignored.
  const std::vector<int>& ends = cover.clusters;
  const bool whole = ends.size() <= kMostClusters && !ends.empty() && ends.front() > 0 &&
                     std::is_sorted(ends.begin(), ends.end()) &&
                     ends.back() == static_cast<int>(cover.fine.size());
  int begin = 0;
  for (const int end : whole ? ends : std::vector<int>()) {
    addCluster(own, piece.fine.begin + begin, piece.fine.begin + end);
    begin = end;
  }
  piece.fine.clusters_end = static_cast<int>(own.clusters.size());
  if (cover.nearest.size() == cover.points.size()) {
    for (const int i : cover.nearest) own.nearest_fine.push_back(piece.fine.begin + i);
  }
  for (auto i = static_cast<int>(own.nearest_fine.size()); i < static_cast<int>(own.points.size());
       ++i)
    own.nearest_fine.push_back(i);
}

void LaneSweep::Impl::addCluster(Stock& stock, int begin, int end) {
  Cluster cluster{{}, 0, begin, end};
  Eigen::AlignedBox3d box;
  for (int i = begin; i < end; ++i) box.extend(stock.points[at(i)]);
  setSingle(box.center(), cluster.center);
  const auto place = [](const float* p) {
    return Eigen::Vector3d(static_cast<double>(p[0]), static_cast<double>(p[1]),
                           static_cast<double>(p[2]));
  };
  const Eigen::Vector3d center = place(cluster.center);
  double radius = 0;
  for (int i = begin; i < end; ++i) {
    const float p[3] = {stock.point[0][at(i)], stock.point[1][at(i)], stock.point[2][at(i)]};
    radius = std::max(radius, (place(p) - center).norm());
  }
  // Derived in lane_planes-inl.h.
  cluster.radius = floatAbove((radius + 0x1p-20 * (center.norm() + radius)) * (1 + 0x1p-20));
  stock.clusters.push_back(cluster);
}

void LaneSweep::Impl::addParts() {
  wholes = pieces.size();
  const auto shift = static_cast<int>(wholes);
  for (LanePiece& piece : pieces) {
    piece.parts_begin += shift;
    piece.parts_end += shift;
  }
  pieces.insert(pieces.end(), parts.begin(), parts.end());
  parts.clear();
  whole_obstacles = obstacles.size();
  const auto shift_obstacles = static_cast<int>(whole_obstacles);
  for (Obstacle& obstacle : obstacles) {
    obstacle.parts_begin += shift_obstacles;
    obstacle.parts_end += shift_obstacles;
  }
  std::move(obstacle_parts.begin(), obstacle_parts.end(), std::back_inserter(obstacles));
  obstacle_parts.clear();
  for (Pair& pair : pairs) {
    setParts(pair);
    if (pair.parts == 0) continue;
    pairs_with_parts = at(pair.id) + 1;
    most_parts = std::max(most_parts, at(pair.parts));
  }
}

void LaneSweep::Impl::setParts(Pair& pair) const {
  if (!pair.by_parts) return;
  const int count = partsOfA(pair).size() * partsOfB(pair).size();
  if (count > 1 && count <= kMostPartPairs) pair.parts = count;
}

void LaneSweep::Impl::makeViews(std::vector<LanePiece>& of) const {
  for (LanePiece& piece : of) {
    if (piece.points.begin == piece.points.end || piece.view.count > 0) continue;
    const auto view = [&](const LanePiece::Points& p) {
      return viewOfPoints(&stock->points[at(p.begin)], p.end - p.begin, 0);
    };
    piece.view = view(piece.points);
    piece.fine_view = view(piece.fine);
  }
}

void LaneSweep::Impl::finish() {
  addParts();
  makeViews(pieces);
  balls = stock->balls.data();
  points = stock->points.data();
  for (int k = 0; k < 3; ++k) point[k] = stock->point[k].data();
  nearest_fine = stock->nearest_fine.data();
  clusters = stock->clusters.data();
  findBundles();
  findLoosePairs();
  if (world) findRows();
}

void LaneSweep::Impl::findBundles() {
  if (groups.empty()) return;
  struct Member {
    std::int32_t group, other, pair;
  };
  std::vector<Member> members;
  members.reserve(piece_pairs.size());
  std::vector<std::int32_t> loose;
  for (const std::int32_t p : piece_pairs) {
    const Pair& pair = pairs[at(p)];
    const std::int32_t of_a = pieces[at(pair.a)].group, of_b = pieces[at(pair.b)].group;
    if (of_a >= 0)
      members.push_back({of_a, pair.b, p});
    else if (of_b >= 0)
      members.push_back({of_b, pair.a, p});
    else
      loose.push_back(p);
  }
  std::sort(members.begin(), members.end(), [](const Member& x, const Member& y) {
    return std::tuple(x.group, x.other, x.pair) < std::tuple(y.group, y.other, y.pair);
  });
  piece_pairs.clear();
  std::vector<std::int32_t> of_one;
  for (std::size_t i = 0; i < members.size(); ++i) {
    of_one.push_back(members[i].pair);
    if (i + 1 < members.size() && members[i + 1].group == members[i].group &&
        members[i + 1].other == members[i].other)
      continue;
    const std::size_t before = bundles.size();
    addBundle(members[i].group, members[i].other, of_one);
    std::vector<std::int32_t>& to = bundles.size() > before ? piece_pairs : loose;
    to.insert(to.end(), of_one.begin(), of_one.end());
    of_one.clear();
  }
  piece_pairs.insert(piece_pairs.end(), loose.begin(), loose.end());
}

// The bundle's motions, which bound how far centres leave their chords. A pair's motion is that of
// A's points in B's frame. If the other piece is A, the group is one body for it, and this motion
// is sufficient. If the other piece is B, a point of the group is a mean of points of the pieces.
// Its deviation from its chord is the mean of theirs, so it is at most the longest of these, for
// which each piece must have a pair.
void LaneSweep::Impl::addBundle(std::int32_t group, std::int32_t other,
                                std::span<const std::int32_t> of) {
  const Group& g = groups[at(group)];
  const std::uint8_t kind = pairs[at(of.front())].kind;
  const auto first_motion = static_cast<std::int32_t>(bundle_motions.size());
  double above = 0;
  bool is_whole = true;
  std::int32_t of_other = -1;
  for (const std::int32_t p : of) {
    const Pair& pair = pairs[at(p)];
    if (pair.a == other) of_other = pair.motion;
    is_whole = is_whole && pair.kind == kind;
    above = greatest(static_cast<double>(pair.cover_above), above);
  }
  const bool all_pieces = of.size() == at(g.end - g.begin);
  if (of.size() < kLeastBundle || !is_whole || (of_other < 0 && !all_pieces)) return;
  if (of_other >= 0) {
    bundle_motions.push_back(of_other);
  } else {
    for (const std::int32_t p : of) bundle_motions.push_back(pairs[at(p)].motion);
  }
  const LanePiece &x = pieces[at(g.piece)], &y = pieces[at(other)];
  const double rounding =
      kLaneSweepRounding *
      (x.reach + y.reach + static_cast<double>(x.outer.radius + y.outer.radius));
  const auto begin = static_cast<std::int32_t>(piece_pairs.size());
  bundles.push_back({group, other, begin, begin + static_cast<std::int32_t>(of.size()),
                     first_motion, static_cast<std::int32_t>(bundle_motions.size()),
                     floatAbove(above + rounding), kind});
}

// Boxes are rounded outwards; comparing them rounds by less than the pair's own rounding, which
// free_above includes.
void LaneSweep::Impl::findLoosePairs() {
  int obstacle = -1;  // the last one; many pairs in a row have the same
  Eigen::AlignedBox3d box;
  for (const Pair& pair : pairs) {
    if (pair.pieces) continue;
    if (std::exchange(obstacle, pair.b) != pair.b) {
      const Exact& exact = obstacles[at(pair.b)].exact_shape;
      box = boxOf(*exact.shape, exact.X_WG);
    }
    // A threshold of NaN is never kept, so such an obstacle counts as near everything.
    const double grown = std::isnan(pair.free_above) ? std::numeric_limits<double>::infinity()
                                                     : static_cast<double>(pair.free_above);
    Loose loose{pair.id, {}, {}};
    for (int k = 0; k < 3; ++k) {
      loose.low[k] = std::max(floatBelow(box.min()[k] - grown), -kFar);
      loose.high[k] = std::min(floatAbove(box.max()[k] + grown), kFar);
    }
    loose_pairs.push_back(loose);
  }
}

void LaneSweep::Impl::findRows() {
  std::size_t most_of_obstacles = 1, most_of_pieces = 1;
  for (std::size_t o = 0; o < whole_obstacles; ++o) {
    if (obstacles[o].place < 0) continue;
    placed_obstacles.push_back(static_cast<int>(o));
    most_of_obstacles =
        std::max(most_of_obstacles, at(partsOf(obstacles, static_cast<int>(o)).size()));
  }
  std::sort(placed_obstacles.begin(), placed_obstacles.end(),
            [&](int x, int y) { return obstacles[at(x)].place < obstacles[at(y)].place; });
  for (std::size_t row = 0; row < rows.size(); ++row) {
    LanePiece& piece = pieces[at(rows[row].piece)];
    piece.row = static_cast<std::int32_t>(row);
    // As in pairWith(). A threshold that is never kept counts as near everything.
    const double above =
        rows[row].most_threshold +
        kLaneSweepRounding *
            (piece.reach + static_cast<double>(piece.outer.radius) + scale_of_world);
    piece.row_above =
        std::isnan(above) ? std::numeric_limits<float>::infinity() : floatAbove(above);
    most_of_pieces = std::max(most_of_pieces, at(partsOf(pieces, rows[row].piece).size()));
  }
  if (most_of_obstacles * most_of_pieces == 1) return;
  pairs_with_parts = std::max(pairs_with_parts, pairs.size() + rows.size() * places);
  most_parts =
      std::max(most_parts, std::min(most_of_obstacles * most_of_pieces, at(kMostPartPairs)));
}

std::size_t LaneSweep::bytes() const {
  return impl_->pieces.size() * sizeof(Impl::LanePiece) +
         impl_->stock->balls.size() * sizeof(Impl::LaneBall) +
         impl_->stock->points.size() *
             (sizeof(Eigen::Vector3d) + 3 * sizeof(float) + sizeof(std::int32_t)) +
         impl_->stock->clusters.size() * sizeof(Impl::Cluster) +
         impl_->obstacles.size() * sizeof(Impl::Obstacle) +
         (impl_->boxes ? impl_->boxes->bytes() : 0) + impl_->pairs.size() * sizeof(Impl::Pair);
}

}  // namespace leeway::collision
