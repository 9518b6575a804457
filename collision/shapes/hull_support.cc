#include "collision/shapes/hull_support.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/shapes/hull_climb.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

namespace {

// Limit on the vertices that a cell lists. Directions perpendicular to a large flat face have more,
// and there a climb is faster.
constexpr std::size_t kMostOfCell = 64;
constexpr int kFewestSides = 8, kMostSides = 32;
// A hull is a needle if no vertex is farther from its axis than this share of its half length.
constexpr double kNeedle = 0.25;

}  // namespace

bool HullSupport::hasTable(const ConvexHull& hull) {
  const auto count = static_cast<std::int32_t>(hull.vertices().size());
  // (Large flat hulls have neither columns nor neighbour lists, so they get a scalar scan.)
  return count > kScanUpTo && hull.hasNeighbours() && count < HullCell::kMany;
}

std::int32_t HullSupport::sidesFor(std::size_t vertices) {
  return std::clamp(static_cast<int>(std::sqrt(static_cast<double>(vertices) / 2)), kFewestSides,
                    kMostSides);
}

HullSupport::HullSupport(const ConvexHull& hull) {
  fill(hull);
  if (hasTable(hull)) fillCells(hull);
}

HullSupport::HullSupport(const ConvexHull& hull, HullTable table)
    : cells_(std::move(table.cells)), more_(std::move(table.more)) {
  fill(hull);
}

bool HullSupport::isTable(const HullTable& table, const ConvexHull& hull) {
  if (!hasTable(hull)) return table.cells.empty() && table.more.empty();
  const std::size_t count = hull.vertices().size(), sides = at(sidesFor(count));
  if (table.cells.size() != 6 * sides * sides) return false;
  const auto namesVertices = [&](const HullCell& cell) {
    return std::all_of(std::begin(cell.vertex), std::end(cell.vertex),
                       [&](std::uint16_t v) { return v < count; });
  };
  const auto isCell = [&](const HullCell& cell) {
    if (cell.vertex[0] != HullCell::kMany) return namesVertices(cell);
    const std::size_t first = cell.vertex[2] + (std::size_t{cell.vertex[3]} << 16U),
                      listed = cell.vertex[1];
    return cell.vertex[4] < count && listed % 8 == 0 && listed <= kMostOfCell &&
           first <= table.more.size() && listed / 8 <= table.more.size() - first;
  };
  return std::all_of(table.cells.begin(), table.cells.end(), isCell) &&
         std::all_of(table.more.begin(), table.more.end(), namesVertices);
}

void HullSupport::fill(const ConvexHull& hull) {
  points_ = hull.vertices().data();
  const auto count = static_cast<std::int32_t>(hull.vertices().size());
  corners_.reserve(hull.vertices().size());
  for (const Vector& p : hull.vertices()) corners_.push_back({p.x(), p.y(), p.z(), 0});
  if (count <= kScanUpTo) {
    fillColumns(count);
    fillAxis(hull);
  } else if (hasTable(hull)) {
    sides_ = sidesFor(hull.vertices().size());
    fillEllipsoid(hull);
  }
}

void HullSupport::fillColumns(std::int32_t count) {
  length_ = (count + 7) / 8 * 8;
  columns_.resize(static_cast<std::size_t>(3 * length_ / 8));
  for (std::int32_t i = 0; i < length_; ++i) {
    const Vector& p = points_[i < count ? i : 0];
    for (std::int32_t axis = 0; axis < 3; ++axis) {
      const std::int32_t place = axis * length_ + i;
      columns_[static_cast<std::size_t>(place / 8)].value[place % 8] = p[axis];
    }
  }
  x_ = columns_[0].value;
}

// A direction in a cell is a positive combination of the cell's corners. A vertex that is farthest
// along it is therefore, at some corner, no worse than the vertex that is farthest along the cell's
// middle. From the middle to that direction, the farthest vertex changes only along edges, so all
// candidates are connected by edges.
void HullSupport::fillCells(const ConvexHull& hull) {
  const std::span<const Vector> vertices = hull.vertices();
  double extent = 0;
  for (const Vector& p : vertices) extent = std::max(extent, p.norm());
  const double margin = 2 * kRelativeRounding * extent;
  cells_.reserve(std::size_t{6} * static_cast<std::size_t>(sides_) *
                 static_cast<std::size_t>(sides_));
  std::vector<std::int32_t> seen(vertices.size(), -1);
  std::vector<std::uint16_t> candidates;
  int best = 0;
  for (std::int32_t cell = 0; cell < 6 * sides_ * sides_; ++cell) {
    const int face = cell / (sides_ * sides_), axis = face / 2;
    const int u = cell / sides_ % sides_, v = cell % sides_;
    const auto direction = [&](double across_u, double across_v) {
      Vector d;
      d[axis] = face % 2 == 0 ? 1 : -1;
      d[(axis + 1) % 3] = (u + across_u) * 2 / sides_ - 1;
      d[(axis + 2) % 3] = (v + across_v) * 2 / sides_ - 1;
      return d;
    };
    const Vector middle = direction(0.5, 0.5);
    const Vector corners[4] = {direction(-kCellRim, -kCellRim), direction(-kCellRim, 1 + kCellRim),
                               direction(1 + kCellRim, -kCellRim),
                               direction(1 + kCellRim, 1 + kCellRim)};
    const auto beatenBy = [&](int winner, int loser) {
      const Vector d = points_[winner] - points_[loser];
      return std::all_of(std::begin(corners), std::end(corners),
                         [&](const Vector& corner) { return corner.dot(d) > margin; });
    };
    best = climbFarthest(hull, points_, static_cast<int>(vertices.size()), middle, best, 0);
    candidates.assign(1, static_cast<std::uint16_t>(best));
    seen[static_cast<std::size_t>(best)] = cell;
    for (std::size_t i = 0; i < candidates.size() && i <= kMostOfCell; ++i) {
      for (const std::int32_t j : hull.neighbours(candidates[i])) {
        if (seen[static_cast<std::size_t>(j)] == cell) continue;
        seen[static_cast<std::size_t>(j)] = cell;
        if (!beatenBy(best, j)) candidates.push_back(static_cast<std::uint16_t>(j));
      }
    }
    if (candidates.size() > 8 && candidates.size() <= kMostOfCell) {
      const std::vector<std::uint16_t> all = candidates;
      std::erase_if(candidates, [&](std::uint16_t loser) {
        return std::any_of(all.begin(), all.end(),
                           [&](std::uint16_t winner) { return beatenBy(winner, loser); });
      });
    }
    store(candidates);
  }
}

// The ellipsoid whose surface has the vertices' mean and covariance. The covariance of a sphere's
// surface is a third of its radius squared in every direction.
void HullSupport::fillEllipsoid(const ConvexHull& hull) {
  const double count = static_cast<double>(hull.vertices().size());
  for (const Vector& p : hull.vertices()) middle_ += p / count;
  for (const Vector& p : hull.vertices()) {
    spread_ += 3 / count * ((p - middle_) * (p - middle_).transpose());
  }
}

// The axis runs from the vertex farthest from the first one to the vertex farthest from that, moved
// to the vertices' mean.
void HullSupport::fillAxis(const ConvexHull& hull) {
  const std::span<const Vector> vertices = hull.vertices();
  const auto farthestFrom = [&](const Vector& p) {
    return *std::max_element(vertices.begin(), vertices.end(),
                             [&](const Vector& q, const Vector& r) {
                               return (q - p).squaredNorm() < (r - p).squaredNorm();
                             });
  };
  const Vector end = farthestFrom(vertices[0]), half = 0.5 * (farthestFrom(end) - end);
  for (const Vector& p : vertices) middle_ += p / static_cast<double>(vertices.size());
  const double length = half.norm();
  if (!(length > 0)) return;
  const Vector axis = half / length;
  middle_ += axis.dot(end + half - middle_) * axis;
  for (const Vector& p : vertices) {
    if (!(cross(p - middle_, axis).norm() <= kNeedle * length)) return;
  }
  axis_ = axis;
  half_length_ = length;
}

void HullSupport::store(std::vector<std::uint16_t>& candidates) {
  HullCell cell{};
  const std::uint16_t first = candidates[0];
  const std::size_t count = candidates.size() <= kMostOfCell ? (candidates.size() + 7) / 8 * 8 : 0;
  candidates.resize(count, first);
  if (count == 8) {
    std::copy(candidates.begin(), candidates.end(), cell.vertex);
    cells_.push_back(cell);
    return;
  }
  cell.vertex[0] = HullCell::kMany;
  cell.vertex[1] = static_cast<std::uint16_t>(count);
  cell.vertex[2] = static_cast<std::uint16_t>(more_.size() & 0xffffU);
  cell.vertex[3] = static_cast<std::uint16_t>(more_.size() >> 16U);
  cell.vertex[4] = first;
  cells_.push_back(cell);
  for (std::size_t i = 0; i < count; i += 8) {
    HullCell part{};
    std::copy_n(candidates.begin() + static_cast<std::ptrdiff_t>(i), 8, part.vertex);
    more_.push_back(part);
  }
}

}  // namespace leeway::collision
