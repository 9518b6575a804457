#include "collision/shapes/hull_file.h"

#include <algorithm>
#include <utility>

#include "collision/shapes/hull_support.h"

namespace leeway::collision {
namespace {

using Triangle = std::array<std::int32_t, 3>;

bool isBelow(std::int32_t i, std::size_t count) {
  return i >= 0 && static_cast<std::size_t>(i) < count;
}

// Cells as plain numbers.
constexpr std::size_t kOfCell = sizeof(HullCell) / sizeof(std::uint16_t);

std::span<const std::uint16_t> numbersOf(const std::vector<HullCell>& cells) {
  return {cells.empty() ? nullptr : cells[0].vertex, cells.size() * kOfCell};
}

std::vector<HullCell> cellsFrom(ByteReader& from) {
  const std::span<const std::uint16_t> numbers = from.view<std::uint16_t>();
  std::vector<HullCell> cells(numbers.size() / kOfCell);
  for (std::size_t i = 0; i < cells.size(); ++i)
    std::copy_n(numbers.data() + i * kOfCell, kOfCell, cells[i].vertex);
  return cells;
}

// Whether the lists are empty, or valid for `count` vertices.
bool areLists(const std::vector<std::int32_t>& begin, const std::vector<std::int32_t>& list,
              std::size_t count) {
  if (begin.empty()) return list.empty();
  return begin.size() == count + 1 && begin.front() == 0 &&
         std::is_sorted(begin.begin(), begin.end()) &&
         static_cast<std::size_t>(begin.back()) == list.size() &&
         std::all_of(list.begin(), list.end(), [&](std::int32_t v) { return isBelow(v, count); });
}

}  // namespace

// Access to a ConvexHull for writing and reading files.
struct HullFile {
  static void pack(const ConvexHull& hull, ByteWriter& to) {
    to.array(hull.vertices_);
    to.array(hull.facets_);
    to.array(hull.neighbour_begin_);
    to.array(hull.neighbours_);
    for (const std::vector<HullCell>* cells : {&hull.support_->cells_, &hull.support_->more_})
      to.array(numbersOf(*cells));
  }

  static std::shared_ptr<const ConvexHull> unpack(ByteReader& from) {
    std::shared_ptr<ConvexHull> hull(new ConvexHull);
    hull->vertices_ = from.array<Vector>();
    hull->facets_ = from.array<Triangle>();
    hull->neighbour_begin_ = from.array<std::int32_t>();
    hull->neighbours_ = from.array<std::int32_t>();
    HullTable table;
    table.cells = cellsFrom(from);
    table.more = cellsFrom(from);
    const std::size_t count = hull->vertices_.size();
    if (from.failed() || count == 0 || count > kMostVertices) return nullptr;
    for (const Vector& v : hull->vertices_) {
      if (!v.allFinite()) return nullptr;
    }
    for (const Triangle& f : hull->facets_) {
      for (const std::int32_t v : f) {
        if (!isBelow(v, count)) return nullptr;
      }
    }
    if (!areLists(hull->neighbour_begin_, hull->neighbours_, count)) return nullptr;
    if (!HullSupport::isTable(table, *hull)) return nullptr;
    hull->support_ = std::make_unique<const HullSupport>(*hull, std::move(table));
    return hull;
  }

 private:
  static constexpr std::size_t kMostVertices = std::size_t{1} << 30;
};

void packHull(const ConvexHull& hull, ByteWriter& to) { HullFile::pack(hull, to); }

std::shared_ptr<const ConvexHull> unpackHull(ByteReader& from) { return HullFile::unpack(from); }

}  // namespace leeway::collision
