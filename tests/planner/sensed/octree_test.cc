// OctoMap's octrees: files that OctoMap wrote, random trees beside a list of their leaves, damage.

#include "leeway/planner/octree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/verify.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

using Eigen::Vector3d;

// Written by OctoMap 1.9.7 with cells of 0.1 m: (0.05, 0.05, 0.05), (0.15, 0.05, 0.05) and
// (-0.25, 0.35, -0.05) are occupied, (0.05, 0.15, 0.05) is free.
const std::string kBinary(
    "\x30\xC0\x00\x0C\x00\x0C\x00\x0C\x00\x0C\x00\x0C\x00\x0C\x00\x0C\x00\x0C\x00\x0C\x00\x0C\x00"
    "\x0C\x00\x0C\x00\x0C\x00\x30\x00\x80\x03\x00\x03\x00\x03\x00\x03\x00\x03\x00\x03\x00\x03\x00"
    "\x03\x00\x03\x00\x03\x00\x03\x00\x03\x00\x03\x00\x03\x00\x1A\x00",
    62);

/// The nodes of the same tree with their log odds, OctoMap's order.
std::string fullNodes(std::size_t skipped = 0) {
  const unsigned char children[] = {0x84, 0x20, 0x20, 0x20, 0x20, 0x20, 0x20, 0x20, 0x20,
                                    0x20, 0x20, 0x20, 0x20, 0x20, 0x40, 0x80, 0x00, 0x01,
                                    0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
                                    0x01, 0x01, 0x01, 0x01, 0x07, 0x00, 0x00, 0x00};
  std::string bytes;
  for (std::size_t i = 0; i < std::size(children); ++i) {
    const float log_odds = i + 1 == std::size(children) ? -0.405465F : 0.847298F;
    char raw[sizeof log_odds];
    std::memcpy(raw, &log_odds, sizeof log_odds);
    bytes.append(raw, sizeof raw);
    bytes.append(skipped, '\x7F');
    bytes.push_back(static_cast<char>(children[i]));
  }
  return bytes;
}

std::string headerOf(bool binary, const std::string& id = "OcTree", std::size_t size = 35) {
  return std::string("# Octomap OcTree ") + (binary ? "binary " : "") +
         "file\n# (feel free to add / change comments)\n#\nid " + id + "\nsize " +
         std::to_string(size) + "\nres 0.1\ndata\n";
}

bool isInside(const std::vector<robots::Geometry>& boxes, const Vector3d& p) {
  return std::any_of(boxes.begin(), boxes.end(), [&](const robots::Geometry& box) {
    return ((p - box.X_BG.translation).cwiseAbs().array() < box.shape.halfExtents().array()).all();
  });
}

class Octrees : public testing::Test {
 protected:
  std::vector<robots::Geometry> load(const std::string& name, const std::string& contents,
                                     Unseen unseen = Unseen::kFree) {
    return loadOctree(folder_.write(name, contents), unseen);
  }
  void expectError(const std::string& name, const std::string& contents, int line,
                   std::initializer_list<std::string> words) {
    SCOPED_TRACE(name + ": " + contents.substr(0, 120));
    const std::string path = folder_.write(name, contents);
    robots::expectInputError([&] { loadOctree(path, Unseen::kFree); }, path, line, words);
  }
  Folder folder_;
};

TEST_F(Octrees, FilesThatOctoMapWroteHaveTheirCells) {
  for (const auto& [name, contents] :
       {std::pair<std::string, std::string>{"a.bt", headerOf(true) + kBinary},
        {"a.ot", headerOf(false) + fullNodes()},
        {"a.ot", headerOf(false, "OcTreeStamped") + fullNodes()},
        {"a.OT", headerOf(false, "ColorOcTree") + fullNodes(3)}}) {
    SCOPED_TRACE(name);
    const auto boxes = load(name, contents);
    // Two cells side by side are one box.
    ASSERT_EQ(boxes.size(), 2U);
    for (const robots::Geometry& box : boxes) EXPECT_EQ(box.shape.halfExtents().y(), 0.05);
    EXPECT_TRUE(isInside(boxes, {0.05, 0.05, 0.05}));
    EXPECT_TRUE(isInside(boxes, {0.1, 0.05, 0.05}));
    EXPECT_TRUE(isInside(boxes, {0.199, 0.001, 0.099}));
    EXPECT_TRUE(isInside(boxes, {-0.25, 0.35, -0.05}));
    EXPECT_FALSE(isInside(boxes, {0.05, 0.15, 0.05}));
    EXPECT_FALSE(isInside(boxes, {0.201, 0.05, 0.05}));
    EXPECT_FALSE(isInside(boxes, {-0.05, 0.05, 0.05}));
    // Everything but the free cell.
    const auto solid = load(name, contents, Unseen::kOccupied);
    EXPECT_FALSE(isInside(solid, {0.05, 0.15, 0.05}));
    EXPECT_TRUE(isInside(solid, {0.15, 0.15, 0.05}));
    EXPECT_TRUE(isInside(solid, {1, -2, 3.03}));
    EXPECT_TRUE(isInside(solid, {-3276.7, 3276.7, 3276.7}));
    EXPECT_FALSE(isInside(solid, {3276.9, 0, 0}));
  }
}

/// A random tree and its leaves; children are written as each format has it.
struct Tree {
  enum class Kind { kUnknown, kFree, kOccupied, kInner };
  Kind kind = Kind::kUnknown;
  std::vector<Tree> children;

  static Tree random(std::mt19937& random_number, int level, int deepest) {
    const auto inner = [&](int most) {
      Tree tree;
      tree.kind = Kind::kInner;
      for (int i = 0; i < 8; ++i) tree.children.push_back(random(random_number, most + 1, deepest));
      // OctoMap's inner nodes have a child that is known.
      if (std::all_of(tree.children.begin(), tree.children.end(),
                      [](const Tree& child) { return child.kind == Kind::kUnknown; }))
        tree.children[3].kind = Kind::kFree;
      return tree;
    };
    if (level < deepest && (level == 0 || random_number() % 3 == 0)) return inner(level);
    Tree leaf;
    leaf.kind = static_cast<Kind>(random_number() % 3);
    return leaf;
  }
  std::size_t count() const {
    std::size_t nodes = kind == Kind::kUnknown ? 0 : 1;
    for (const Tree& child : children) nodes += child.count();
    return nodes;
  }
  std::string binary() const {
    unsigned bits = 0;
    for (unsigned i = 0; i < 8; ++i) bits |= static_cast<unsigned>(children[i].kind) << (2 * i);
    std::string bytes = {static_cast<char>(bits), static_cast<char>(bits >> 8U)};
    for (const Tree& child : children)
      if (child.kind == Kind::kInner) bytes += child.binary();
    return bytes;
  }
  std::string full() const {
    const float log_odds = kind == Kind::kFree ? -1e-6F : 0.0F;  // 0: a probability of 1/2
    std::string bytes(sizeof log_odds + 1, '\0');
    std::memcpy(bytes.data(), &log_odds, sizeof log_odds);
    std::string below;
    for (unsigned i = 0; i < children.size(); ++i) {
      if (children[i].kind == Kind::kUnknown) continue;
      bytes[4] = static_cast<char>(static_cast<unsigned char>(bytes[4]) | 1U << i);
      below += children[i].full();
    }
    return bytes + below;
  }
  /// The kind of the leaf at p, in a cube with the lower corner `low`.
  Kind at(const Vector3d& p, Vector3d low, double edge) const {
    if (kind != Kind::kInner) return kind;
    unsigned child = 0;
    for (int k = 0; k < 3; ++k)
      if (p[k] > low[k] + edge / 2) {
        child |= 1U << static_cast<unsigned>(k);
        low[k] += edge / 2;
      }
    return children[child].at(p, low, edge / 2);
  }
};

TEST_F(Octrees, BoxesAreTheLeavesOfRandomTrees) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  int counts[3] = {};
  std::size_t most = 0;
  for (int i = 0; i < 60; ++i) {
    const Tree tree = Tree::random(random, 0, 1 + i % 5);
    const double edge = 65536 * 0.1;
    std::vector<robots::Geometry> boxes[2];
    for (const bool solid : {false, true}) {
      const Unseen unseen = solid ? Unseen::kOccupied : Unseen::kFree;
      boxes[solid] = load("a.bt", headerOf(true, "OcTree", tree.count()) + tree.binary(), unseen);
      const auto full = load("a.ot", headerOf(false, "OcTree", tree.count()) + tree.full(), unseen);
      ASSERT_EQ(full.size(), boxes[solid].size());
      for (std::size_t b = 0; b < full.size(); ++b) {
        EXPECT_EQ(full[b].X_BG.translation, boxes[solid][b].X_BG.translation);
        EXPECT_EQ(full[b].shape.halfExtents(), boxes[solid][b].shape.halfExtents());
      }
      // Boxes do not overlap.
      double volume = 0;
      for (const robots::Geometry& box : full) volume += 8 * box.shape.halfExtents().prod();
      EXPECT_LE(volume, edge * edge * edge * (1 + 1e-12));
      most = std::max(most, full.size());
    }
    for (int k = 0; k < 200; ++k) {
      const Vector3d p(edge * (unit(random) - 0.5), edge * (unit(random) - 0.5),
                       edge * (unit(random) - 0.5));
      const Tree::Kind kind = tree.at(p, Vector3d::Constant(-edge / 2), edge);
      EXPECT_EQ(isInside(boxes[0], p), kind == Tree::Kind::kOccupied);
      EXPECT_EQ(isInside(boxes[1], p), kind != Tree::Kind::kFree);
      ++counts[static_cast<int>(kind)];
    }
  }
  for (const int count : counts) EXPECT_GT(count, 1000);
  EXPECT_GT(most, 100U);
}

TEST_F(Octrees, DamagedFilesAreRefused) {
  const std::string binary = headerOf(true) + kBinary, full = headerOf(false) + fullNodes();
  for (const auto& [name, good] : {std::pair{"a.bt", binary}, {"a.ot", full}}) {
    for (std::size_t size = 0; size < good.size(); size += 1 + size % 5)
      EXPECT_THROW(load(name, good.substr(0, size)), robots::InputError) << name << ' ' << size;
    expectError(name, good + "\n", 0,
                {"byte " + std::to_string(good.size()), "1 bytes stand after"});
  }
  expectError("a.bt", full, 1, {"does not begin with '# Octomap OcTree binary file'"});
  expectError("a.ot", binary, 1, {"does not begin with '# Octomap OcTree file'"});
  expectError("a.oct", binary, 0, {"'.oct'", ".bt and .ot"});
  expectError("a.bt", "version https://git-lfs.github.com/spec/v1\n", 0, {"Git LFS"});
  expectError("a.bt", headerOf(true, "OcTree", 34) + kBinary, 0,
              {"34 nodes, and the data has more"});
  // Nothing is made of more nodes than the header says.
  expectError("a.bt", headerOf(true, "OcTree", 3) + kBinary, 0,
              {"the header says 3 nodes, and the data has more"});
  expectError("a.bt", headerOf(true, "CountingOcTree") + kBinary, 0, {"'CountingOcTree'"});
  const auto with = [&](const std::string& line, const std::string& other) {
    std::string changed = binary;
    return changed.replace(changed.find(line), line.size(), other);
  };
  expectError("a.bt", with("res 0.1\n", ""), 1, {"the header has no res"});
  for (const std::string key : {"id OcTree\n", "size 35\n", "res 0.1\n"})
    expectError("a.bt", with("data\n", key + "data\n"), 7, {"stands twice"});
  expectError("a.bt", with("data\n", "res 1000\ndata\n"), 7, {"res stands twice"});
  expectError("a.bt", with("res 0.1", "res -1"), 0, {"resolution -1"});
  expectError("a.bt", with("res 0.1", "res x"), 6, {"res is 'x'"});
  expectError("a.bt", with("res 0.1", "ras 0.1"), 6, {"'ras' is not known"});
  expectError("a.bt", with("size 35", "size -5"), 5, {"size is '-5'"});
  expectError("a.bt", with("id OcTree\n", ""), 1, {"no id"});
  expectError("a.bt", "# Octomap OcTree binary file\nid OcTree\n", 2, {"ends within its header"});
  // Cells below the smallest.
  std::string deep;
  for (int i = 0; i < 17; ++i) deep += std::string("\x03\0", 2);
  expectError("a.bt", headerOf(true) + deep, 0, {"the smallest size has children"});
  std::string nan = fullNodes();
  const float not_a_number = NAN;
  std::memcpy(nan.data(), &not_a_number, sizeof not_a_number);
  expectError("a.ot", headerOf(false) + nan, 0, {"not a number"});
}

/// Five megabytes of data with 2^23 boxes, none of which can be joined: they are counted
/// while they are read.
TEST_F(Octrees, TooManyBoxesEndTheReading) {
  std::string data;
  // All levels but the last have eight children; those of the last are occupied where x + y + z is
  // even, so that no two share a face.
  const std::function<void(int)> add = [&](int level) {
    if (level < 7) {
      data += std::string("\xFF\xFF", 2);
      for (int child = 0; child < 8; ++child) add(level + 1);
      return;
    }
    unsigned kinds = 0;
    for (unsigned child = 0; child < 8; ++child)
      kinds |= (__builtin_popcount(child) % 2 == 0 ? 2U : 1U) << (2 * child);
    data += {static_cast<char>(kinds & 0xFF), static_cast<char>(kinds >> 8)};
  };
  add(0);
  OctreeData octree;
  octree.resolution = 0.1;
  octree.data = data;
  try {
    octreeBoxes(octree, Unseen::kFree);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("boxes; up to 4194304 are accepted"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(Octrees, EmptyTreesAndSingleCubes) {
  const std::string empty = headerOf(true, "OcTree", 0);
  EXPECT_TRUE(load("a.bt", empty).empty());
  const auto all = load("a.bt", empty, Unseen::kOccupied);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_DOUBLE_EQ(all[0].shape.halfExtents().x(), 3276.8);
  // OctoMap takes a root without children for a leaf, which is occupied.
  EXPECT_EQ(load("a.bt", headerOf(true, "OcTree", 1) + std::string(2, '\0')).size(), 1U);
}

// Problem files.

const std::string kBallAmongBoxes =
    "leeway: 1\n"
    "body:\n"
    "  name: ball\n"
    "  joint: floating\n"
    "  bounds: {lower: [-1, -1, -1], upper: [1, 1, 1]}\n"
    "  shapes: [{sphere: {radius: 0.1}}]\n"
    "start: {position: [-0.6, 0.05, 0.05]}\n"
    "goal: {position: [0.6, 0.05, 0.05]}\n"
    "objects:\n - name: map\n   octree: ";

TEST_F(Octrees, AProblemIsPlannedAmongLeavesAndVerified) {
  folder_.write("map.bt", headerOf(true) + kBinary);
  const Problem problem = loadProblem(folder_.write(
      "problem.yaml", kBallAmongBoxes + "{file: map.bt, unseen: free}\nmargin: 0.01\n"));
  ASSERT_EQ(problem.world.objects[0].geometries.size(), 2U);
  EXPECT_EQ(problem.world.objects[0].geometries[0].name, "map");
  ASSERT_EQ(problem.warnings.size(), 1U);
  EXPECT_NE(problem.warnings[0].find("problem.yaml:11: octree 'map' has 2 occupied boxes; unseen "
                                     "space is free"),
            std::string::npos)
      << problem.warnings[0];
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
  Path straight = result.path;
  straight.positions = {result.path.positions.front(), result.path.positions.back()};
  EXPECT_EQ(verify(problem, straight).status, VerifyStatus::kRefuted);
  // Where nothing was seen, nothing is free.
  const Problem solid = loadProblem(
      folder_.write("problem.yaml", kBallAmongBoxes + "{file: map.bt, unseen: occupied}\n"));
  EXPECT_EQ(plan(solid).status, PlanStatus::kInvalidStart);
}

TEST_F(Octrees, BadKeysNameTheirLine) {
  folder_.write("map.bt", headerOf(true) + kBinary);
  const auto expect = [&](const std::string& keys, int line,
                          std::initializer_list<std::string> words) {
    SCOPED_TRACE(keys);
    const std::string path = folder_.write("problem.yaml", kBallAmongBoxes + keys + "\n");
    robots::expectInputError([&] { loadProblem(path); }, path, line, words);
  };
  expect("{file: map.bt}", 11, {"'unseen'", "free or occupied"});
  expect("{unseen: free}", 11, {"'file'"});
  expect("{file: map.bt, unseen: maybe}", 11, {"unseen is 'maybe'", "free or occupied"});
  expect("{file: map.bt, unseen: free, unsen: 1}", 11, {"'unsen'", "'unseen'"});
  for (const std::string other : {"box: {size: [1, 1, 1]}", "shapes: [{sphere: {radius: 1}}]",
                                  "cloud: {file: a.xyz, radius: 1}"})
    expect("{file: map.bt, unseen: free}\n   " + other, 10, {"both 'octree' and"});
}

// MoveIt's scenes.

class MoveitOctomaps : public testing::Test {
 protected:
  Problem load(const std::string& octomap) {
    const std::string urdf = folder_.write(
        "r.urdf",
        "<robot name='r'><link name='base'/><link name='one'><collision><geometry><sphere "
        "radius='0.05'/></geometry></collision></link><joint name='a' type='prismatic'><parent "
        "link='base'/><child link='one'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' "
        "velocity='1' effort='1'/></joint></robot>");
    scene_ =
        folder_.write("scene.yaml", "name: s\nrobot_model_name: r\nworld:\n  octomap:\n" + octomap);
    const std::string request = folder_.write(
        "request.yaml",
        "group_name: all\nstart_state: {joint_state: {name: [a], position: [-0.9]}}\n"
        "goal_constraints: [{joint_constraints: [{joint_name: a, position: 0.9, tolerance_above: "
        "0.001, tolerance_below: 0.001, weight: 1}]}]\n");
    return loadMoveit(robots::loadModel(urdf, ""), scene_, request);
  }
  static std::string message(const std::string& data, const std::string& more = "") {
    return "    header: {frame_id: base}\n    origin: {position: {x: 0.1, y: 0, z: 0}, "
           "orientation: {x: 0, y: 0, z: 0, w: 1}}\n    octomap: {id: OcTree, binary: true, "
           "resolution: 0.1, data: [" +
           data + "]" + more + "}\n";
  }
  static std::string binaryData() {
    std::string text;
    for (const char c : kBinary)
      text += (text.empty() ? "" : ", ") +
              std::to_string(static_cast<int>(static_cast<signed char>(c)));
    return text;
  }
  Folder folder_;
  std::string scene_;
};

TEST_F(MoveitOctomaps, AreBoxesOfTheObjectOfThatName) {
  Problem problem = load(message(binaryData()));
  ASSERT_EQ(problem.world.objects.size(), 1U);
  const Object& object = problem.world.objects[0];
  EXPECT_EQ(object.name, "<octomap>");
  EXPECT_EQ(object.geometries.size(), 2U);
  EXPECT_EQ(object.X_WO.translation, Vector3d(0.1, 0, 0));
  ASSERT_FALSE(problem.warnings.empty());
  EXPECT_NE(problem.warnings.back().find("scene.yaml:7: octree '<octomap>' has 2 occupied boxes; "
                                         "unseen space is free"),
            std::string::npos)
      << problem.warnings.back();
  problem.limits = {0.3, 0};
  EXPECT_EQ(plan(problem).status, PlanStatus::kUnsolved);  // the boxes are in the only way
}

TEST_F(MoveitOctomaps, WithoutDataThereIsNone) {
  EXPECT_TRUE(load(message("")).world.objects.empty());
  EXPECT_TRUE(load("    header: {frame_id: base}\n").world.objects.empty());
}

TEST_F(MoveitOctomaps, DamagedOnesNameTheLine) {
  const auto expect = [&](const std::string& octomap, std::initializer_list<std::string> words) {
    SCOPED_TRACE(octomap);
    robots::expectInputError([&] { load(octomap); }, folder_.path("scene.yaml"), 7, words);
  };
  expect(message("3, 0, 3"), {"octomap.octomap", "byte 2", "ends within"});
  expect(message("300"), {"300", "a byte, from -128 to 255"});
  expect(message("0, 0, 7"), {"1 bytes stand after"});
  std::string other = message(binaryData());
  other.replace(other.find("OcTree"), 6, "MyTree");
  expect(other, {"'MyTree'"});
  std::string coarse = message(binaryData());
  coarse.replace(coarse.find("resolution: 0.1"), 15, "resolution: -1");
  expect(coarse, {"resolution -1"});
}

}  // namespace
}  // namespace leeway::planner
