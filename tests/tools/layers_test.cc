// tools/scripts/check_layers detects trees that break the rules. (A test of its own runs it on this
// tree.)

#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Layers : public CommandTest {
 protected:
  Answer check() const {
    return shell("'" + leeway::sourceFolder() + "/tools/scripts/check_layers' tree");
  }
  void expectBites(const std::string& file, const std::string& include) const {
    fs::remove_all(path("tree"));
    write("tree/collision/base/ok.cc", "#include \"leeway/collision/pose.h\"\n#include <vector>\n");
    EXPECT_EQ(check().status, 0);
    write("tree/" + file, "// comment\n#include " + include + "\n");
    const Answer answer = check();
    EXPECT_EQ(answer.status, 1) << file << " " << include;
    EXPECT_NE(answer.out.find(file + ":2:"), std::string::npos) << answer.out;
  }
};

TEST_F(Layers, EveryRuleBites) {
  expectBites("collision/base/a.cc", "\"leeway/robots/model.h\"");
  expectBites("collision/lanes/a.cc", "\"robots/urdf/urdf_document.h\"");
  expectBites("collision/base/a.cc", "\"collision/shapes/hull_support.h\"");
  expectBites("collision/mesh/a.cc", "\"leeway/collision/distance.h\"");
  expectBites("collision/base/a.cc", "\"collision/nowhere/a.h\"");
  expectBites("collision/base/a.cc", "\"leeway/collision/nothing.h\"");
  expectBites("robots/model/a.cc", "\"leeway/planner/plan.h\"");
  expectBites("planner/edge/a.cc", "\"planner/search/goals.h\"");
  expectBites("planner/edge/a.cc", "\"tools/leeway/support/verb.h\"");
  expectBites("planner/save/a.cc", "\"leeway/view/page.h\"");
  expectBites("planner/save/a.cc", "\"tools/view/subject.h\"");
  expectBites("tools/view/a.cc", "\"tools/leeway/support/terminal.h\"");
  expectBites("tools/view/include/leeway/view/page.h", "\"tools/view/subject.h\"");
  expectBites("tools/view/a.cc", "<CLI/CLI.hpp>");
  expectBites("tools/leeway/a.cc", "\"tests/support/command.h\"");
  expectBites("tools/truth/oracle/a.cc", "\"collision/convex/gjk/gjk.h\"");
  expectBites("tools/truth/oracle/a.cc", "\"leeway/robots/model.h\"");
  expectBites("collision/time/a.cc", "\"tools/truth/oracle/quad.h\"");
  expectBites("collision/base/a.h", "<ompl/base/State.h>");
  expectBites("collision/base/a.cc", "<yaml-cpp/yaml.h>");
  expectBites("collision/base/a.cc", "<fstream>");
  expectBites("collision/base/a.cc", "<urdf_parser/urdf_parser.h>");
  expectBites("collision/base/a.cc", "<hwy/foreach_target.h>");
  expectBites("robots/model/a.cc", "<ompl/base/State.h>");
  expectBites("planner/edge/a.cc", "<CLI/CLI.hpp>");
  expectBites("planner/include/leeway/planner/plan.h", "\"planner/search/limits.h\"");
  expectBites("robots/include/leeway/robots/model.h", "<tinyxml2.h>");
  expectBites("python/bindings/a.cc", "\"robots/model/fingerprint.h\"");
  expectBites("planner/edge/a.cc", "\"python/base/arrays.h\"");
  expectBites("python/bindings/a.cc", "\"tools/view/subject.h\"");
  expectBites("tools/view/include/leeway/view/page.h", "<nlohmann/json.hpp>");
}

TEST_F(Layers, UnlistedAndFullFoldersAreNamed) {
  write("tree/collision/attic/a.cc", "// comment\n");
  EXPECT_EQ(check().status, 1);
  fs::remove_all(path("tree"));
  for (int i = 0; i < 27; ++i)
    write("tree/collision/base/file" + std::to_string(i) + ".cc", "// comment\n");
  EXPECT_NE(check().out.find("more than 26 files"), std::string::npos);
}

TEST_F(Layers, CirclesBetweenComponentsAreNamed) {
  write("tree/collision/base/a.h", "#pragma once\n");
  write("tree/collision/base/a.cc", "#include \"collision/base/b.h\"\n");
  write("tree/collision/base/b.h", "#pragma once\n");
  write("tree/collision/base/b_simd.cc", "#include \"collision/base/b.h\"\n");
  EXPECT_EQ(check().status, 0) << check().out;
  write("tree/collision/base/b_simd.cc", "#include \"collision/base/a.h\"\n");
  Answer answer = check();
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.out.find("collision/base/a   <-"), std::string::npos) << answer.out;
  EXPECT_NE(answer.out.find("collision/base/b   <-"), std::string::npos) << answer.out;
  // A public header belongs to the source of its name.
  fs::remove_all(path("tree"));
  write("tree/collision/include/leeway/collision/pose.h", "#pragma once\n");
  write("tree/collision/base/pose.cc", "#include \"collision/base/a.h\"\n");
  write("tree/collision/base/a.h", "#include \"leeway/collision/pose.h\"\n");
  EXPECT_EQ(check().status, 1);
}

}  // namespace
}  // namespace leeway::tools::testing
