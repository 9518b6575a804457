#pragma once

// Solids of unit cells on a grid: their inside is known exactly, and faces of two solids are flush
// about half of the time.

#include <array>
#include <map>
#include <memory>
#include <set>

#include "leeway/collision/triangle_mesh.h"
#include "tests/support/mesh_cases.h"

namespace leeway::collision::testing {

using Cell = std::array<int, 3>;
using Cells = std::set<Cell>;

/// The boundary of the cells, two triangles for each face.
inline TriangleSoup cellSoup(const Cells& cells) {
  TriangleSoup soup;
  std::map<Cell, int> numbers;
  const auto corner = [&](const Cell& c) {
    const auto [it, is_new] = numbers.insert({c, static_cast<int>(soup.vertices.size())});
    if (is_new) soup.vertices.emplace_back(c[0], c[1], c[2]);
    return it->second;
  };
  for (const Cell& cell : cells) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (const int side : {0, 1}) {
        Cell next = cell;
        next[k] += side == 1 ? 1 : -1;
        if (cells.count(next) > 0) continue;
        Cell p = cell;
        p[k] += side;
        Cell q = p, r = p, s = p;
        ++q[(k + 1) % 3], ++r[(k + 1) % 3], ++r[(k + 2) % 3], ++s[(k + 2) % 3];
        const int a = corner(p), b = corner(side == 1 ? q : s), c = corner(r),
                  d = corner(side == 1 ? s : q);
        soup.triangles.push_back({a, b, c});
        soup.triangles.push_back({a, c, d});
      }
    }
  }
  return soup;
}

/// One to three cells along each axis.
inline Cells randomBrick(Random& random) {
  const int x = 1 + random.below(3), y = 1 + random.below(3), z = 1 + random.below(3);
  Cells cells;
  for (int i = 0; i < x; ++i)
    for (int j = 0; j < y; ++j)
      for (int k = 0; k < z; ++k) cells.insert({i, j, k});
  return cells;
}

/// Two to eight cells, each next to another one. Some touch themselves along edges.
inline Cells randomPolycube(Random& random) {
  const auto count = static_cast<std::size_t>(2 + random.below(7));
  Cells cells{{0, 0, 0}};
  while (cells.size() < count) {
    auto beside = cells.begin();
    std::advance(beside, random.below(static_cast<int>(cells.size())));
    Cell next = *beside;
    next[static_cast<std::size_t>(random.below(3))] += random.below(2) == 0 ? 1 : -1;
    cells.insert(next);
  }
  return cells;
}

struct CellSolid {
  Cells cells;
  std::shared_ptr<const TriangleMesh> mesh;
};

/// Random cells whose mesh, made by `soup`, is closed and has no loose ends.
template <class MakeCells, class MakeSoup>
CellSolid cellSolid(const MakeCells& make_cells, const MakeSoup& soup) {
  for (;;) {
    CellSolid solid{make_cells(), nullptr};
    const TriangleSoup triangles = soup(solid.cells);
    solid.mesh = TriangleMesh::make(triangles.vertices, triangles.triangles);
    if (solid.mesh->closedComponentCount() == solid.mesh->componentCount()) return solid;
  }
}

/// A box of twelve triangles.
inline CellSolid randomBrickSolid(Random& random) {
  return cellSolid([&] { return randomBrick(random); },
                   [](const Cells& cells) {
                     const Cell& last = *cells.rbegin();
                     const Eigen::Vector3d half(0.5 * (last[0] + 1), 0.5 * (last[1] + 1),
                                                0.5 * (last[2] + 1));
                     return boxSoup(half, half);
                   });
}

inline CellSolid randomPolycubeSolid(Random& random) {
  return cellSolid([&] { return randomPolycube(random); }, cellSoup);
}

inline Cell moved(const Cell& cell, const Cell& by) {
  return {cell[0] + by[0], cell[1] + by[1], cell[2] + by[2]};
}

enum class CellContact : unsigned char { kApart, kTouch, kOverlap };

/// Whether B, moved by `by` cells, shares a cell with A, or only faces, edges or corners.
inline CellContact contactOf(const Cells& a, const Cells& b, const Cell& by) {
  CellContact contact = CellContact::kApart;
  for (const Cell& cell : b) {
    const Cell at = moved(cell, by);
    if (a.count(at) > 0) return CellContact::kOverlap;
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k)
          if (a.count(moved(at, {i, j, k})) > 0) contact = CellContact::kTouch;
  }
  return contact;
}

}  // namespace leeway::collision::testing
