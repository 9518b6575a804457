#include "leeway/planner/octree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>

#include "leeway/robots/text.h"
#include "planner/sensed/cloud_source.h"
#include "robots/base/read_file.h"
#include "robots/mesh/scan.h"

// The formats: OctoMap's OccupancyOcTreeBase::readBinaryNode() and
// OcTreeBaseImpl::readNodesRecurs().

namespace leeway::planner {
namespace {

constexpr int kLevels = 16;
constexpr std::int32_t kCells = 1 << kLevels;  // along each edge of the root
constexpr std::size_t kMostBoxes = std::size_t{1} << 22U;
constexpr double kSmallestResolution = 1e-9, kLargestResolution = 1e4;  // [m]

/// A box of cells.
struct Cells {
  std::array<std::int32_t, 3> low, high;
};

/// Joins boxes that share a whole face across the axis.
void join(std::vector<Cells>& boxes, std::size_t axis) {
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto across = [&](const Cells& c) {
    return std::tuple(c.low[u], c.high[u], c.low[v], c.high[v]);
  };
  std::sort(boxes.begin(), boxes.end(), [&](const Cells& a, const Cells& b) {
    return across(a) != across(b) ? across(a) < across(b) : a.low[axis] < b.low[axis];
  });
  std::size_t last = 0;
  for (std::size_t i = 1; i < boxes.size(); ++i)
    if (across(boxes[i]) == across(boxes[last]) && boxes[i].low[axis] == boxes[last].high[axis])
      boxes[last].high[axis] = boxes[i].high[axis];
    else
      boxes[++last] = boxes[i];
  boxes.resize(std::min(boxes.size(), last + 1));
}

class OctreeReader {
 public:
  /// `size`: the number of nodes that a file's header promises.
  OctreeReader(const OctreeData& octree, Unseen unseen, std::optional<std::size_t> size)
      : octree_(octree), takes_unseen_(unseen == Unseen::kOccupied), size_(size) {
    if (octree.id == "ColorOcTree")
      skipped_ = 3;
    else if (octree.id != "OcTree" && octree.id != "OcTreeStamped")
      throw std::invalid_argument(fmt::format(
          "an octree with the id {}; OcTree, ColorOcTree and OcTreeStamped are accepted",
          robots::shown(octree.id)));
  }

  std::vector<Cells> read() {
    const Cells root{{-kCells / 2, -kCells / 2, -kCells / 2}, {kCells / 2, kCells / 2, kCells / 2}};
    if (octree_.data.empty())
      addUnseen(root);
    else if (octree_.binary)
      readBinary(root, 0);
    else
      readFull(root, 0);
    if (at_ < octree_.data.size())
      fail(fmt::format("{} bytes stand after the last node; the end is expected",
                       octree_.data.size() - at_));
    if (size_ && nodes_ != *size_)
      fail(fmt::format("the header says {} nodes, and the data has {}", *size_, nodes_));
    joinAll();
    return std::move(boxes_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw std::invalid_argument(fmt::format("byte {}: {}", octree_.first_byte + at_, message));
  }

  const std::byte* take(std::size_t size) {
    if (octree_.data.size() - at_ < size)
      fail(fmt::format("the data ends within its nodes, after {} of them", nodes_));
    const char* const begin = octree_.data.data() + at_;
    at_ += size;
    return reinterpret_cast<const std::byte*>(begin);
  }

  /// Child 0 to 7: x, y and z are in the upper half where bit 0, 1 and 2 are set.
  static Cells childOf(const Cells& parent, unsigned child) {
    Cells cells = parent;
    for (unsigned k = 0; k < 3; ++k) {
      const std::int32_t middle = parent.low[k] + (parent.high[k] - parent.low[k]) / 2;
      ((child >> k & 1U) != 0 ? cells.low[k] : cells.high[k]) = middle;
    }
    return cells;
  }

  /// Joins what is there before its memory doubles, so that damaged data cannot take much of it.
  void add(const Cells& cells) {
    if (boxes_.size() == 2 * kMostBoxes) joinAll();
    boxes_.push_back(cells);
  }
  void joinAll() {
    for (const std::size_t axis : {0U, 1U, 2U}) join(boxes_, axis);
    if (boxes_.size() > kMostBoxes)
      fail(fmt::format("{} boxes; up to {} are accepted", boxes_.size(), kMostBoxes));
  }
  void countNodes(std::size_t more) {
    nodes_ += more;
    if (size_ && nodes_ > *size_)
      fail(fmt::format("the header says {} nodes, and the data has more", *size_));
  }
  void addUnseen(const Cells& cells) {
    if (takes_unseen_) add(cells);
  }

  void requireSmaller(int level) const {
    if (level >= kLevels)
      fail(fmt::format("a cell of the smallest size has children; at most {} levels are accepted",
                       kLevels));
  }

  /// A node of two bits for each child.
  void readBinary(const Cells& cells, int level) {
    requireSmaller(level);
    const std::byte* const bytes = take(2);
    const unsigned kinds = std::to_integer<unsigned>(bytes[0]) | std::to_integer<unsigned>(bytes[1])
                                                                     << 8U;
    countNodes(1);
    // OctoMap takes an inner node without a child for an occupied leaf.
    if (kinds == 0) return add(cells);
    const auto kindOf = [&](unsigned child) { return kinds >> (2 * child) & 3U; };
    for (unsigned child = 0; child < 8; ++child) {
      const unsigned kind = kindOf(child);
      countNodes(kind == 1 || kind == 2 ? 1U : 0U);
      if (kind == 0) addUnseen(childOf(cells, child));
      if (kind == 2) add(childOf(cells, child));
    }
    for (unsigned child = 0; child < 8; ++child)
      if (kindOf(child) == 3) readBinary(childOf(cells, child), level + 1);
  }

  /// A node with its log odds.
  void readFull(const Cells& cells, int level) {
    const auto log_odds = robots::loadNumber<float>(take(sizeof(float)));
    if (std::isnan(log_odds)) fail("log odds that are not a number; a number is expected");
    take(skipped_);
    const unsigned children = std::to_integer<unsigned>(*take(1));
    countNodes(1);
    if (children == 0) {
      if (log_odds >= 0) add(cells);
      return;
    }
    requireSmaller(level);
    for (unsigned child = 0; child < 8; ++child)
      if ((children >> child & 1U) != 0)
        readFull(childOf(cells, child), level + 1);
      else
        addUnseen(childOf(cells, child));
  }

  const OctreeData& octree_;
  bool takes_unseen_;
  std::optional<std::size_t> size_;
  std::size_t skipped_ = 0, at_ = 0, nodes_ = 0;
  std::vector<Cells> boxes_;
};

/// The number after a key of the header.
double headerNumber(const CloudSource& source, std::string_view word, std::string_view key,
                    CloudPlace place) {
  const auto number = robots::parseNumber(word);
  if (number && std::isfinite(*number)) return *number;
  source.fail(place, fmt::format("{} is {}; a number is expected", key, robots::shown(word)));
}

struct Header {
  OctreeData octree;
  std::size_t size = 0;
};

Header readHeader(const CloudSource& source, bool binary) {
  std::string_view rest = source.text();
  const std::string_view kind = binary ? "# Octomap OcTree binary file" : "# Octomap OcTree file";
  if (!rest.starts_with(kind))
    source.fail({1, 0}, fmt::format("does not begin with '{}', as its ending says", kind));
  Header header;
  header.octree.binary = binary;
  std::optional<std::size_t> size;
  std::optional<std::string> id;
  std::set<std::string_view> keys;
  for (std::size_t line = 1;; ++line) {
    const std::vector<std::string_view> words = wordsOf(robots::takeLine(rest));
    if (!words.empty() && words[0] == "data") break;
    if (rest.empty())
      source.fail({line, 0},
                  "the file ends within its header; id, size, res and data are expected");
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string_view word = words.size() == 2 ? words[1] : std::string_view();
    if (!keys.insert(words[0]).second)
      source.fail({line, 0},
                  fmt::format("{} stands twice in the header; once is expected", words[0]));
    if (words[0] == "id")
      id = word;
    else if (words[0] == "size")
      size = readCount(source, word, "size", {line, 0});
    else if (words[0] == "res")
      header.octree.resolution = headerNumber(source, word, "res", {line, 0});
    else
      source.fail({line, 0},
                  fmt::format("the header's line {} is not known; id, size, res and data "
                              "are accepted",
                              robots::shown(words[0])));
  }
  for (const char* key : {"id", "size", "res"})
    if (!keys.contains(key))
      source.fail({1, 0}, fmt::format("the header has no {}; it is expected", key));
  header.octree.id = *id;
  header.size = *size;
  header.octree.data = rest;
  header.octree.first_byte = source.text().size() - rest.size();
  return header;
}

/// As octreeBoxes(); `size` as for OctreeReader.
std::vector<robots::Geometry> boxesOf(const OctreeData& octree, Unseen unseen,
                                      std::optional<std::size_t> size) {
  const double resolution = octree.resolution;
  if (!(resolution >= kSmallestResolution && resolution <= kLargestResolution))
    throw std::invalid_argument(fmt::format("resolution {}; {} to {} m is accepted", resolution,
                                            kSmallestResolution, kLargestResolution));
  const std::vector<Cells> boxes = OctreeReader(octree, unseen, size).read();
  std::vector<robots::Geometry> geometries;
  geometries.reserve(boxes.size());
  for (const Cells& cells : boxes) {
    Eigen::Vector3d half, middle;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      half[k] = 0.5 * (cells.high[i] - cells.low[i]) * resolution;
      middle[k] = 0.5 * (cells.high[i] + cells.low[i]) * resolution;
    }
    geometries.push_back({collision::Shape::box(half), {Eigen::Matrix3d::Identity(), middle}, {}});
  }
  return geometries;
}

}  // namespace

std::vector<robots::Geometry> octreeBoxes(const OctreeData& octree, Unseen unseen) {
  return boxesOf(octree, unseen, std::nullopt);
}

std::vector<robots::Geometry> loadOctree(const std::string& path, Unseen unseen,
                                         const robots::Stop& stop) {
  const std::string ending = robots::endingOf(path);
  if (ending != ".bt" && ending != ".ot")
    throw robots::InputError(
        path, 0,
        fmt::format("has the ending '{}', which no format of octrees has; .bt and .ot are accepted",
                    ending));
  const CloudSource source = readSource(path, "an octree", stop);
  source.pause(0);
  const Header header = readHeader(source, ending == ".bt");
  try {
    return boxesOf(header.octree, unseen, header.size);
  } catch (const std::invalid_argument& error) {
    throw robots::InputError(path, 0, error.what());
  }
}

}  // namespace leeway::planner
