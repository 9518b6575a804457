// `leeway report deform`: small runs; times are not tested.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/lab/pictures.h"
#include "tests/support/command.h"
#include "tools/lab/deform/deform_report.h"
#include "tools/lab/deform/deform_scenes.h"
#include "tools/lab/deform/own_mesh_engine.h"

namespace leeway::tools::testing {
namespace {

using namespace report;

TEST(ReportDeform, ScenesHaveTheirSizesAndMove) {
  for (const std::string& motion : deformMotions()) {
    const DeformScene scene = makeDeformScene(motion, 500, 1),
                      again = makeDeformScene(motion, 500, 1);
    EXPECT_EQ(scene.motion, motion);
    EXPECT_NEAR(static_cast<double>(scene.spec.triangles.size()), 500, 60) << motion;
    const std::size_t count = scene.spec.rest.size();
    std::vector<Eigen::Vector3d> early(count), late(count), same(count);
    scene.vertices(0.1, early);
    scene.vertices(0.8, late);
    again.vertices(0.8, same);
    EXPECT_EQ(late, same) << motion;
    double moved = 0;
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(late[i].allFinite()) << motion;
      moved = std::max(moved, (late[i] - early[i]).norm());
    }
    EXPECT_GT(moved, 0.02) << motion;
    for (const auto& t : scene.spec.triangles)
      for (const std::int32_t corner : t) {
        ASSERT_GE(corner, 0);
        ASSERT_LT(static_cast<std::size_t>(corner), count);
      }
  }
}

/// Reports every distance a metre too large.
class Liar : public MeshEngine {
 public:
  class Follower : public MeshFollower {
   public:
    explicit Follower(std::unique_ptr<MeshFollower> honest) : honest_(std::move(honest)) {}
    void setVertices(std::span<const Eigen::Vector3d> v, double time) override {
      honest_->setVertices(v, time);
    }
    void update() override { honest_->update(); }
    bool addBody(const collision::Shape& shape) override { return honest_->addBody(shape); }
    double distance(int body, const collision::Pose& X_WB) override {
      return honest_->distance(body, X_WB) + 1;
    }

   private:
    std::unique_ptr<MeshFollower> honest_;
  };
  explicit Liar(const MeshEngine& honest) : honest_(honest) {}
  const char* name() const override { return "liar"; }
  std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const override {
    return std::make_unique<Follower>(honest_.follow(spec));
  }

 private:
  const MeshEngine& honest_;
};

class Crasher : public MeshEngine {
 public:
  const char* name() const override { return "crasher"; }
  std::unique_ptr<MeshFollower> follow(const DeformingSpec&) const override { std::abort(); }
};

DeformReportOptions small() {
  DeformReportOptions options;
  options.motions = {"wave"};
  options.triangles = {200};
  options.frames = 4;
  return options;
}

TEST(ReportDeform, ComparesEveryDistance) {
  const auto own = makeOwnMeshEngines();
  ASSERT_STREQ(own[0]->name(), "leeway rebuild");
  const Liar liar(*own[2]);
  const auto rows = measureDeform({own[0].get(), own[2].get(), &liar}, small());
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].compared, 0) << "it is what the others are compared with";
  EXPECT_EQ(rows[1].compared, 4 * 27);
  EXPECT_EQ(rows[1].wrong, 0);
  EXPECT_EQ(rows[2].compared, 4 * 27);
  EXPECT_EQ(rows[2].wrong, 4 * 27);
  EXPECT_NEAR(rows[2].error, 1, 1e-6);
  EXPECT_TRUE(deformWords(rows).empty()) << "there is no hybrid";
  for (const DeformRow& r : rows) {
    EXPECT_EQ(r.frames, 4);
    EXPECT_GT(r.median.update, 0);
    EXPECT_GT(r.bandwidth_limit, 0);
  }
}

TEST(ReportDeform, OutlivesAnEngineThatAborts) {
  const auto own = makeOwnMeshEngines();
  const Crasher crasher;
  const auto rows = measureDeform({own[0].get(), &crasher}, small());
  for (const DeformRow& r : rows) EXPECT_FALSE(r.done);
}

TEST(ReportDeform, JudgesTheTextbookByTheTests) {
  DeformRow refit, hybrid, chosen;
  refit.motion = hybrid.motion = chosen.motion = "wave";
  refit.engine = "leeway refit";
  hybrid.engine = "leeway hybrid";
  chosen.engine = "leeway auto";
  refit.median.update = 40, hybrid.median.update = chosen.median.update = 4;
  refit.median.spheres = hybrid.median.spheres = 6, chosen.median.spheres = 11;
  for (const auto& [tests, verdict] :
       {std::pair{1.0, "are surpassed"}, std::pair{5.0, "are confirmed"},
        std::pair{20.0, "are refuted: less"}}) {
    refit.median.tolerance = hybrid.median.tolerance = tests;
    const std::string words = deformWords({refit, hybrid, chosen});
    EXPECT_NE(words.find(verdict), std::string::npos) << words;
    EXPECT_NE(words.find("are 10.0 times cheaper"), std::string::npos) << words;
    EXPECT_NE(words.find("auto takes 1.50 times what hybrid does"), std::string::npos) << words;
  }
}

class ReportDeformVerb : public CommandTest {};

/// Every motion with every applicable strategy, and the rivals of this build.
TEST_F(ReportDeformVerb, WritesEveryRow) {
  const Answer answer =
      run("report deform --triangles 200 --frames 3 --seconds 0.001 --output out --json");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  const json told = answer.document();
  EXPECT_EQ(told["own_errors"], 0);
  std::istringstream csv(read("out/deform.csv"));
  std::string header, line;
  std::getline(csv, header);
  EXPECT_EQ(header.rfind("motion,triangles,engine,status,frames,update_ns", 0), 0u) << header;
  std::map<std::string, std::set<std::string>> engines;
  std::size_t rows = 0;
  for (; std::getline(csv, line); ++rows) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
    EXPECT_NE(line.find(",done,3,"), std::string::npos) << line;
    const std::size_t first = line.find(','), second = line.find(',', first + 1);
    engines[line.substr(0, first)].insert(
        line.substr(second + 1, line.find(',', second + 1) - second - 1));
  }
  EXPECT_EQ(rows, told["rows"]);
  EXPECT_EQ(engines.size(), deformMotions().size());
  for (const auto& [motion, names] : engines) {
    for (const char* strategy : {"rebuild", "refit", "hybrid", "lazy", "auto"})
      EXPECT_TRUE(names.count(std::string("leeway ") + strategy)) << motion << " " << strategy;
    EXPECT_EQ(names.count("leeway morph"), motion == "morph") << motion;
    // Of the others only each frame's vertices are known.
    EXPECT_EQ(names.count("leeway hybrid moved"), motion != "twist" && motion != "explode")
        << motion;
  }
  if (hasPictures(told))
    for (const char* name : {"out/deform_update.svg", "out/deform_decay.svg"})
      expectPicture(read(name), static_cast<int>(engines.size()));
  EXPECT_GT(read("out/deform_frames.csv").size(), 3 * rows);
}

TEST_F(ReportDeformVerb, RefusesWhatItCannotUse) {
  expectRefused("report deform --motion boil", {"boil", "wave"});
  expectRefused("report deform --triangles 0", {"triangles"});
  expectRefused("report deform --frames 0", {"frames"});
  expectRefused("report deform --seconds -1", {"seconds"});
  // Fails before measuring, which would take minutes.
  write("file", "");
  expectRefused("report deform --full --output file", {"file", "Not a directory", "folder"});
  expectRefused("report deform --full --output file/below/it",
                {"file/below/it", "Not a directory"});
  fs::create_symlink("nowhere", folder_ / "link");
  expectRefused("report deform --full --output link", {"link"});
}

}  // namespace
}  // namespace leeway::tools::testing
