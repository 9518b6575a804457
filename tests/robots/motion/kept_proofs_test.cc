#include "robots/motion/kept_proofs.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>

#include "leeway/robots/motion_bound.h"
#include "leeway/robots/placed_model.h"
#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

/// A turning arm with a tool that a post may reach, and a bracket.
constexpr const char* kArm = R"(<robot name="arm">
<link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="post"><collision><geometry><mesh filename="post.obj"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<link name="tool"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="stand" type="fixed"><parent link="base"/><child link="post"/><origin xyz="1 0 0.3"/></joint>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.4"/>
<axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="wrist" type="revolute"><parent link="arm"/><child link="tool"/><origin xyz="1 0 0"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>)";
constexpr const char* kPost =
    "v -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0 0.1 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

std::shared_ptr<const Model> arm(const std::string& cache, const std::string& post = kPost) {
  const Folder folder;
  folder.write("post.obj", post);
  LoadOptions options;
  options.cache = cache;
  return loadModel(folder.write("arm.urdf", kArm), "", options);
}

Pairs allPairs(const Model& model) {
  Pairs pairs;
  for (int a = 0; a < static_cast<int>(model.links.size()); ++a)
    for (int b = a + 1; b < static_cast<int>(model.links.size()); ++b) pairs.emplace_back(a, b);
  return pairs;
}

/// Counts how often a question was decided instead of read from the cache.
int asked(const Model& model, const Pairs& pairs, const char* kind = "test") {
  std::atomic<int> count = 0;
  const auto decide = [&](const std::pair<int, int>& pair) {
    ++count;
    return static_cast<unsigned char>((pair.first + pair.second) % 3);
  };
  const auto answers = decidePairs(model, pairs, {kind, "tested", decide}, {});
  EXPECT_EQ(answers.size(), pairs.size());
  for (std::size_t i = 0; i < answers.size(); ++i)
    EXPECT_EQ(answers[i], (pairs[i].first + pairs[i].second) % 3);
  return count;
}

TEST(KeptProofs, AreFoundByAllThatTheyDependOn) {
  const Folder folder;
  const auto model = arm(folder.path());
  const Pairs pairs = allPairs(*model);
  const int all = static_cast<int>(pairs.size());
  EXPECT_EQ(asked(*model, pairs), all);
  EXPECT_EQ(asked(*model, pairs), 0) << "kept";
  EXPECT_EQ(asked(*arm(folder.path()), pairs), 0) << "by another process, too";
  EXPECT_EQ(asked(*arm(""), pairs), all) << "without a folder nothing is kept";
  EXPECT_EQ(asked(*model, {pairs.begin(), pairs.end() - 1}), all - 1) << "other pairs";
  EXPECT_EQ(asked(*model, pairs, "other"), all) << "another question";
  const auto changed = [&](const auto& change) {
    auto copy = std::make_shared<Model>(*model);
    change(*copy);
    return asked(*copy, pairs);
  };
  EXPECT_EQ(changed([](Model&) {}), 0);
  EXPECT_EQ(changed([](Model& m) { m.variables[0].upper = 1.9; }), all);
  EXPECT_EQ(changed([](Model& m) { m.variables[0].file_limits = {-3, 3}; }), all);
  EXPECT_EQ(changed([](Model& m) { m.joints[2].X_PJ.translation.x() += 1e-9; }), all);
  EXPECT_EQ(changed([](Model& m) { m.links[3].geometries[0].X_BG.translation.x() += 1e-9; }), all);
  EXPECT_EQ(
      changed([](Model& m) { m.links[3].geometries[0].shape = collision::Shape::sphere(0.2); }),
      all);
  EXPECT_EQ(changed([](Model& m) { m.links[3].geometries.clear(); }), all);
  std::string other = kPost;
  other.replace(other.find("0.3"), 3, "0.4");
  EXPECT_EQ(asked(*arm(folder.path(), other), pairs), all) << "a vertex of a mesh";
  std::string open = kPost;
  open.resize(open.rfind("f "));
  EXPECT_EQ(asked(*arm(folder.path(), open), pairs), all) << "a surface without an inside";
}

TEST(KeptProofs, AreTheSameAsWithoutACache) {
  const Folder folder;
  const auto plain = arm(""), kept = arm(folder.path());
  const Pairs pairs = allPairs(*plain);
  for (int run = 0; run < 2; ++run) {
    EXPECT_EQ(provenApart(*kept, pairs), provenApart(*plain, pairs));
    EXPECT_EQ(provenTouching(*kept, pairs), provenTouching(*plain, pairs));
    EXPECT_EQ(touchAtJoints(*kept, pairs), touchAtJoints(*plain, pairs));
  }
  EXPECT_FALSE(provenApart(*plain, pairs).empty());
}

TEST(KeptProofs, ThatAreDamagedAreProvenAgain) {
  const Folder folder;
  const auto model = arm(folder.path());
  const Pairs pairs = allPairs(*model);
  asked(*model, pairs);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
    if (entry.is_regular_file()) {
      std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(-1, std::ios::end);
      file.put('\x7');
    }
  EXPECT_EQ(asked(*model, pairs), static_cast<int>(pairs.size()));
}

TEST(KeptProofs, EndWhereTheirCallerSaysSo) {
  const auto model = arm("");
  EXPECT_THROW(provenApart(*model, allPairs(*model), [] { return true; }), Stopped);
}

}  // namespace
}  // namespace leeway::robots
