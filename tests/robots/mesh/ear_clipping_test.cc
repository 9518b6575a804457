// Triangulated polygons against the even-odd rule at random points.

#include "robots/mesh/ear_clipping.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/from_environment.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/quad.h"

namespace leeway::robots {
namespace {

using collision::testing::Random;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector2d>;

// ------------------------------------------------------------------------------------------------
// truth

/// Sign of the turn a, b, c; 0 if quadruple precision cannot decide.
int sideOf(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  using oracle::Quad;
  using oracle::wide;
  const double l = (b.x() - a.x()) * (c.y() - a.y()), r = (b.y() - a.y()) * (c.x() - a.x());
  if (std::abs(l - r) > 1e-12 * (std::abs(l) + std::abs(r))) return l > r ? 1 : -1;
  const Quad left = (wide(b.x()) - wide(a.x())) * (wide(c.y()) - wide(a.y()));
  const Quad right = (wide(b.y()) - wide(a.y())) * (wide(c.x()) - wide(a.x()));
  const Quad error = wide(1e-30) * (oracle::absolute(left) + oracle::absolute(right));
  return left - right > error ? 1 : right - left > error ? -1 : 0;
}

/// 1 inside, 0 outside, -1 on an edge or close to it.
int evenOdd(const Polygon& polygon, const Vector2d& p) {
  int inside = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const int side = sideOf(a, b, p);
    if (side == 0) return -1;
    if ((side > 0) == (b.y() > a.y())) inside = 1 - inside;
  }
  return inside;
}

/// The number of triangles that contain the point; -1 on an edge.
int covers(const Polygon& polygon, const CutPolygon& cut, const Vector2d& p) {
  int count = 0;
  for (const auto& [i, j, k] : cut.triangles) {
    const auto at = [&](std::int32_t n) { return polygon[static_cast<std::size_t>(n)]; };
    const int turn = sideOf(at(i), at(j), at(k));
    if (turn == 0) continue;
    const int sides[3] = {turn * sideOf(at(i), at(j), p), turn * sideOf(at(j), at(k), p),
                          turn * sideOf(at(k), at(i), p)};
    const int least = *std::min_element(sides, sides + 3);
    if (least == 0) return -1;
    if (least > 0) ++count;
  }
  return count;
}

double areaOf(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return 0.5 * ((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
}

// ------------------------------------------------------------------------------------------------
// polygons, counter-clockwise

/// Lattice cells connected by their sides: the outlines, the outer one first, the others clockwise.
/// With all corners of cells, or only those that turn. With `pinched`, cells may meet only at a
/// corner, which outlines then visit twice.
std::vector<Polygon> outlinesOfCells(Random& random, bool all_corners, bool pinched) {
  const int size = 2 + random.below(6);
  std::vector<std::vector<bool>> cell(static_cast<std::size_t>(size + 2),
                                      std::vector<bool>(static_cast<std::size_t>(size + 2)));
  const auto at = [&](int x, int y) -> std::vector<bool>::reference {
    return cell[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)];
  };
  at(1 + random.below(size), 1 + random.below(size)) = true;
  for (int i = 0; i < 3 * size * size; ++i) {
    const int x = 1 + random.below(size), y = 1 + random.below(size);
    if (at(x, y) || !(at(x - 1, y) || at(x + 1, y) || at(x, y - 1) || at(x, y + 1))) continue;
    at(x, y) = true;
    for (const int dx : {-1, 1})
      for (const int dy : {-1, 1})
        if (!pinched && at(x + dx, y + dy) && !at(x + dx, y) && !at(x, y + dy)) at(x, y) = false;
  }
  // Each edge with a cell on its left and none on its right, by its start.
  std::multimap<std::pair<int, int>, std::pair<int, int>> next;
  for (int x = 1; x <= size; ++x)
    for (int y = 1; y <= size; ++y) {
      if (!at(x, y)) continue;
      if (!at(x, y - 1)) next.insert({{x, y}, {x + 1, y}});
      if (!at(x + 1, y)) next.insert({{x + 1, y}, {x + 1, y + 1}});
      if (!at(x, y + 1)) next.insert({{x + 1, y + 1}, {x, y + 1}});
      if (!at(x - 1, y)) next.insert({{x, y + 1}, {x, y}});
    }
  std::vector<Polygon> outlines;
  while (!next.empty()) {  // the least corner belongs to the outer outline
    Polygon outline;
    for (auto edge = next.begin(); edge != next.end();) {
      outline.emplace_back(edge->first.first, edge->first.second);
      const auto end = edge->second;
      next.erase(edge);
      edge = next.find(end);
      if (next.count(end) == 2 && random.below(2) == 0) ++edge;
    }
    if (!all_corners) {
      Polygon turning;
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vector2d before = outline[i] - outline[(i + outline.size() - 1) % outline.size()],
                       after = outline[(i + 1) % outline.size()] - outline[i];
        if (before != after) turning.push_back(outline[i]);
      }
      outline = turning;
    }
    outlines.push_back(outline);
  }
  return outlines;
}

bool isOn(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  return sideOf(a, b, p) == 0 && (a - p).dot(b - p) <= 0;
}

/// Whether the open segment from a to b meets no edge of the polygon except at its ends.
bool isBridge(const Polygon& polygon, const Vector2d& a, const Vector2d& b) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    if (p != a && p != b && isOn(a, b, p)) return false;
    const int pq = sideOf(p, q, a) * sideOf(p, q, b), ab = sideOf(a, b, p) * sideOf(a, b, q);
    if (pq < 0 && ab < 0) return false;
    if ((isOn(p, q, a) && a != p && a != q) || (isOn(p, q, b) && b != p && b != q)) return false;
  }
  return evenOdd(polygon, 0.5 * (a + b)) == 1;
}

/// One polygon of all outlines: windows are joined to it by edges that it traverses twice. False if
/// no bridge was found by chance.
bool joinWindows(std::vector<Polygon> outlines, Random& random, Polygon& joined) {
  joined = outlines[0];
  for (std::size_t w = 1; w < outlines.size(); ++w) {
    Polygon window = outlines[w];
    bool found = false;
    for (int attempt = 0; attempt < 200 && !found; ++attempt) {
      const std::size_t i = static_cast<std::size_t>(random.below(static_cast<int>(joined.size()))),
                        j = static_cast<std::size_t>(random.below(static_cast<int>(window.size())));
      const Vector2d a = joined[i], b = window[j];
      // Where outlines meet, a bridge might come between the wrong edges.
      int visits = static_cast<int>(std::count(joined.begin(), joined.end(), b));
      for (std::size_t other = w; other < outlines.size(); ++other)
        visits += static_cast<int>(std::count(outlines[other].begin(), outlines[other].end(), b));
      if (visits > 1) continue;
      bool free = isBridge(joined, a, b);
      for (std::size_t other = w; other < outlines.size() && free; ++other) {
        const Polygon& o = outlines[other];
        for (std::size_t k = 0; k < o.size() && free; ++k) {
          const Vector2d &p = o[k], &q = o[(k + 1) % o.size()];
          free = !(p != b && isOn(a, b, p)) &&
                 !(sideOf(p, q, a) * sideOf(p, q, b) < 0 && sideOf(a, b, p) * sideOf(a, b, q) < 0);
        }
      }
      // The bridge must start between the edges of this visit of the corner.
      const Vector2d &before = joined[(i + joined.size() - 1) % joined.size()],
                     &after = joined[(i + 1) % joined.size()];
      const bool left = sideOf(before, a, b) > 0, right = sideOf(a, after, b) > 0;
      free = free && (sideOf(before, a, after) > 0 ? left && right : left || right);
      if (!free) continue;
      Polygon next(joined.begin(), joined.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      for (std::size_t k = 0; k <= window.size(); ++k)
        next.push_back(window[(j + k) % window.size()]);
      next.insert(next.end(), joined.begin() + static_cast<std::ptrdiff_t>(i), joined.end());
      joined = next;
      found = true;
    }
    if (!found) return false;
  }
  return true;
}

Polygon stairs(Random& random) {
  Polygon polygon = {{0, 0}};
  const int steps = 1 + random.below(12);
  double x = 0, y = 0;
  for (int i = 0; i < steps; ++i) {
    polygon.emplace_back(x += 1 + random.below(3), y);
    polygon.emplace_back(x, y += 1 + random.below(3));
  }
  if (random.below(2) == 0) {
    polygon.emplace_back(0, y);
  } else {  // a band: back next to the way up
    for (std::size_t i = polygon.size(); i-- > 0;)
      polygon.emplace_back(polygon[i] + Vector2d(-0.5, 0.5));
  }
  return polygon;
}

/// Corners of a small lattice in an order without crossings, made by removing crossings.
Polygon tangled(Random& random, bool on_lattice) {
  Polygon polygon;
  const int count = 4 + random.below(16), side = 3 + random.below(5);
  while (static_cast<int>(polygon.size()) < count &&
         static_cast<int>(polygon.size()) < side * side) {
    const Vector2d p = on_lattice ? Vector2d(random.below(side), random.below(side))
                                  : Vector2d(random.uniform(0, 1), random.uniform(0, 1));
    if (std::find(polygon.begin(), polygon.end(), p) == polygon.end()) polygon.push_back(p);
  }
  const std::size_t n = polygon.size();
  const auto at = [&](std::size_t i) -> Vector2d& { return polygon[i % n]; };
  for (int round = 0; round < 1000; ++round) {
    bool crossing = false;
    for (std::size_t i = 0; i < n && !crossing; ++i)
      for (std::size_t j = i + 1; j < n && !crossing; ++j) {
        const Vector2d &a = at(i), &b = at(i + 1), &c = at(j), &d = at(j + 1);
        const bool meet =
            sideOf(a, b, c) * sideOf(a, b, d) < 0 && sideOf(c, d, a) * sideOf(c, d, b) < 0;
        if (!meet || j == i + 1) continue;
        std::reverse(polygon.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                     polygon.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        crossing = true;
      }
    if (!crossing) break;
    if (round == 999) return {};
  }
  // Corners do not touch other edges either.
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      if (j != i && j != (i + 1) % n && isOn(at(i), at(i + 1), at(j))) return {};
  double area = 0;
  for (std::size_t i = 1; i + 1 < n; ++i) area += areaOf(at(0), at(i), at(i + 1));
  if (area < 0) std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

/// A room with walls that end at the opposite side, within its edge.
Polygon rooms(Random& random) {
  Polygon polygon = {{0, 0}};
  const int walls = 1 + random.below(6), height = 1 + random.below(5);
  for (int i = 0; i < walls; ++i)
    polygon.insert(polygon.end(),
                   {{3.0 * i + 1, 0}, {3.0 * i + random.below(4), height}, {3.0 * i + 2, 0}});
  polygon.insert(polygon.end(), {{3.0 * walls, 0}, {3.0 * walls, height}, {0, height}});
  return polygon;
}

Polygon star(Random& random) {
  Polygon polygon;
  const int count = 5 + random.below(60);
  const bool round = random.below(3) == 0;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count,
                 radius = round ? 1 : random.uniform(0.1, 1);
    polygon.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return polygon;
}

/// A wall with windows in rows, each joined to the previous one and the first to the corner:
/// bridges run along edges of other windows.
Polygon rows(Random& random) {
  const int columns = 1 + random.below(4);
  Polygon polygon = {{0, 0}};
  const double height = 3 + random.below(4);
  for (int i = 0; i < columns; ++i) {
    const double x = 4 * i + 1;
    polygon.insert(
        polygon.end(),
        {{x, 0}, {x, 1}, {x, height - 1}, {x + 2, height - 1}, {x + 2, 1}, {x, 1}, {x, 0}});
  }
  // Back to the outside, along the lower edge.
  polygon.insert(polygon.end(), {{4.0 * columns, 0}, {4.0 * columns, height}, {0, height}});
  return polygon;
}

Polygon randomPolygon(Random& random, std::string& kind) {
  for (;;) {
    Polygon polygon;
    switch (random.below(10)) {
      case 0:
      case 1:
        kind = "lattice";
        polygon = tangled(random, true);
        break;
      case 6:
        kind = "scattered";
        polygon = tangled(random, false);
        break;
      case 2:
        kind = "stairs";
        polygon = stairs(random);
        break;
      case 3:
        kind = "star";
        polygon = star(random);
        break;
      case 7:
        kind = "rooms";
        polygon = rooms(random);
        break;
      case 4:
        kind = "rows of windows";
        polygon = rows(random);
        break;
      default:
        kind = "windows";
        if (!joinWindows(outlinesOfCells(random, random.below(2) == 0, random.below(2) == 0),
                         random, polygon))
          continue;
    }
    if (polygon.size() < 3) continue;
    // Adds corners on straight edges, and double corners.
    for (int i = random.below(4); i > 0; --i) {
      const std::size_t k =
          static_cast<std::size_t>(random.below(static_cast<int>(polygon.size())));
      const Vector2d a = polygon[k], b = polygon[(k + 1) % polygon.size()];
      polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(k) + 1,
                     random.below(3) == 0 ? a : Vector2d(0.5 * (a + b)));
    }
    return polygon;
  }
}

// ------------------------------------------------------------------------------------------------

std::string shownPolygon(const std::vector<Vector3d>& corners) {
  std::string text;
  char line[100];
  for (const Vector3d& p : corners) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    text += line;
  }
  return text;
}

/// Compares a polygon's triangles with it at random places. False if they differ.
bool isCutRightly(const std::vector<Vector3d>& corners, Random& random) {
  const CutPolygon cut = cutPolygon(corners);
  const Vector3d normal = polygonNormal(corners);
  Eigen::Index axis;
  normal.cwiseAbs().maxCoeff(&axis);
  Polygon polygon;
  for (const Vector3d& p : corners) polygon.emplace_back(p[(axis + 1) % 3], p[(axis + 2) % 3]);
  Vector2d low = polygon[0], high = low;
  for (const Vector2d& p : polygon) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size = (high - low).maxCoeff();
  bool right =
      cut.crossing <= 1e-12 * size + 1e-15 * high.cwiseAbs().cwiseMax(low.cwiseAbs()).maxCoeff();
  double area = 0, covered = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    area += areaOf(polygon[0], polygon[i], polygon[i + 1]);
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
  const auto placeOf = [&](std::int32_t corner) {  // the first corner there
    return static_cast<std::int32_t>(
        std::find(polygon.begin(), polygon.end(), polygon[static_cast<std::size_t>(corner)]) -
        polygon.begin());
  };
  for (const auto& t : cut.triangles) {
    const auto at = [&](std::size_t k) { return polygon[static_cast<std::size_t>(t[k])]; };
    covered += std::abs(areaOf(at(0), at(1), at(2)));
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = placeOf(t[k]), to = placeOf(t[(k + 1) % 3]);
      ++edges[{from, to}];
      --edges[{to, from}];
    }
  }
  right =
      right && std::abs(covered - std::abs(area)) <= 1e-12 * std::max(size * size, std::abs(area));
  // Their edges are the polygon's.
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::int32_t from = placeOf(static_cast<std::int32_t>(i)),
                       to = placeOf(static_cast<std::int32_t>((i + 1) % polygon.size()));
    --edges[{from, to}];
    ++edges[{to, from}];
  }
  for (const auto& [edge, count] : edges)
    right = right && (count == 0 || edge.first == edge.second);
  for (int i = 0; i < 40; ++i) {
    const Vector2d p = low + Vector2d(random.uniform(-0.1, 1.1), random.uniform(-0.1, 1.1)) * size;
    const int inside = evenOdd(polygon, p), count = covers(polygon, cut, p);
    if (inside >= 0 && count >= 0) right = right && inside == count;
  }
  return right;
}

/// LEEWAY_TEST_POLYGONS sets the number of cases, and LEEWAY_TEST_SEED selects other ones.
TEST(EarClipping, RandomPolygonsAreWhatEvenOddSays) {
  const std::uint64_t seed = fromEnvironment("LEEWAY_TEST_SEED", 1);
  const auto count = static_cast<int>(
      fromEnvironment("LEEWAY_TEST_POLYGONS", static_cast<std::uint64_t>(casesToAsk(2000))));
  Random random(static_cast<unsigned>(seed));
  std::map<std::string, int> kinds;
  int wrong = 0;
  for (int i = 0; i < count; ++i) {
    std::string kind;
    Polygon polygon = randomPolygon(random, kind);
    ++kinds[kind];
    if (random.below(2) == 0) std::reverse(polygon.begin(), polygon.end());
    const double scale = std::pow(10, random.uniform(-6, 6));
    Vector3d u = Vector3d::UnitX(), v = Vector3d::UnitY(), origin = Vector3d::Zero();
    if (random.below(2) == 0) {
      const Eigen::Quaterniond q = Eigen::Quaterniond(random.uniform(-1, 1), random.uniform(-1, 1),
                                                      random.uniform(-1, 1), random.uniform(-1, 1))
                                       .normalized();
      u = q * u;
      v = q * v;
      origin = random.uniform(0, 10) * Vector3d(1, 2, 3);
    }
    std::vector<Vector3d> corners;
    for (const Vector2d& p : polygon) corners.push_back(scale * (origin + p.x() * u + p.y() * v));
    // All first corners of small ones.
    const std::size_t firsts = corners.size() <= 12 ? corners.size() : 2;
    for (std::size_t first = 0; first < firsts; ++first) {
      if (!isCutRightly(corners, random)) {
        ++wrong;
        ADD_FAILURE() << kind << ", case " << i << " of seed " << seed << "\n"
                      << shownPolygon(corners);
        break;
      }
      std::rotate(corners.begin(), corners.begin() + 1, corners.end());
    }
  }
  std::printf("%d polygons cut: %d wrong\n", count, wrong);
  for (const char* kind :
       {"lattice", "scattered", "stairs", "rooms", "star", "rows of windows", "windows"})
    EXPECT_GE(kinds[kind], count / 20) << kind;
}

}  // namespace
}  // namespace leeway::robots
