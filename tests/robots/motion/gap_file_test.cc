#include "robots/motion/gap_file.h"

#include <gtest/gtest.h>

#include <cstring>

#include "leeway/collision/shape.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

std::shared_ptr<const Model> body() {
  return freeBody("body", {{collision::Shape::sphere(0.1), {}, "ball"}}, JointType::kFloating,
                  Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
}

std::vector<LinkGap> gaps() {
  LinkGap gap;
  gap.link_a = gap.link_b = gap.joint = gap.other = 0;
  gap.gaps.assign(LinkGap::kArcs, 0.25F);
  gap.cells.assign(std::size_t{LinkGap::kArcs} * LinkGap::kArcs, 1);
  gap.cells[7] = 0;
  gap.cell_gap = 0.125F;
  return {gap, gap};
}

TEST(GapFile, GivesTheGapsAgain) {
  const std::vector<LinkGap> written = gaps();
  const auto read = gapsFromBytes(bytesOf(written), *body());
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ(bytesOf(*read), bytesOf(written));
  EXPECT_TRUE(gapsFromBytes(bytesOf({}), *body())->empty());
}

// By loadModel(): a robot from the cache equals the robot without a cache.
TEST(GapFile, IsKeptForARobotOfMeshes) {
  LEEWAY_NEEDS_DATA("robots/panda/panda.urdf");
  const Folder folder;
  const std::string panda = dataFolder() + "/robots/panda/panda";
  LoadOptions options;
  const auto load = [&](const std::string& srdf) {
    return loadModel(panda + ".urdf", srdf, options);
  };
  const auto none = load(panda + ".srdf"), none_without = load("");
  options.cache = folder.path();
  for (int run = 0; run < 2; ++run) {
    EXPECT_EQ(bytesOf(load(panda + ".srdf")->linkGaps()), bytesOf(none->linkGaps()));
    // If the SRDF's pairs are missing, more is proven.
    EXPECT_EQ(bytesOf(load("")->linkGaps()), bytesOf(none_without->linkGaps()));
  }
  EXPECT_NE(bytesOf(none->linkGaps()), bytesOf(none_without->linkGaps()));
}

TEST(GapFile, RefusesWhatQueriesCouldNotUse) {
  const auto refused = [&](const auto& change) {
    std::vector<LinkGap> changed = gaps();
    change(changed[1]);
    EXPECT_FALSE(gapsFromBytes(bytesOf(changed), *body()));
  };
  refused([](LinkGap& gap) { gap.link_a = 1; });
  refused([](LinkGap& gap) { gap.link_b = -1; });
  refused([](LinkGap& gap) { gap.joint = 1 << 30; });
  refused([](LinkGap& gap) { gap.gaps.pop_back(); });
  refused([](LinkGap& gap) { gap.gaps[3] = -1; });
  refused([](LinkGap& gap) { gap.gaps[3] = std::numeric_limits<float>::infinity(); });
  refused([](LinkGap& gap) { gap.cells.push_back(0); });
  refused([](LinkGap& gap) { gap.cells[5] = 2; });
  refused([](LinkGap& gap) { gap.cell_gap = std::numeric_limits<float>::quiet_NaN(); });
  const std::vector<std::byte> bytes = bytesOf(gaps());
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 50)
    EXPECT_FALSE(gapsFromBytes(std::span(bytes).first(size), *body())) << size;
  std::vector<std::byte> many = bytes;
  std::memset(many.data(), 0xff, 8);  // a huge number of gaps
  EXPECT_FALSE(gapsFromBytes(many, *body()));
}

}  // namespace
}  // namespace leeway::robots
