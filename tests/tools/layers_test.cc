// tools/check_layers passes on this tree (a test of its own) and bites on trees that break the
// rules.

#include "tests/build_paths.h"
#include "tests/tools/command.h"

namespace leeway::tools::testing {
namespace {

class Layers : public CommandTest {
 protected:
  Answer check() const { return shell("'" + leeway::sourceFolder() + "/tools/check_layers' tree"); }
  void expectBites(const std::string& file, const std::string& include) const {
    fs::remove_all(path("tree"));
    write("tree/collision/ok.cc", "#include \"leeway/collision/pose.h\"\n#include <vector>\n");
    EXPECT_EQ(check().status, 0);
    write("tree/" + file, "// comment\n#include " + include + "\n");
    const Answer answer = check();
    EXPECT_EQ(answer.status, 1) << file << " " << include;
    EXPECT_NE(answer.out.find(file + ":2:"), std::string::npos) << answer.out;
  }
};

TEST_F(Layers, EveryRuleBites) {
  expectBites("collision/a.cc", "\"leeway/robots/model.h\"");
  expectBites("collision/simd/a.cc", "\"robots/urdf_document.h\"");
  expectBites("robots/a.cc", "\"leeway/planner/plan.h\"");
  expectBites("planner/a.cc", "\"tools/leeway/verb.h\"");
  expectBites("tools/leeway/a.cc", "\"tests/tools/command.h\"");
  expectBites("tools/oracle/a.cc", "\"collision/gjk.h\"");
  expectBites("tools/oracle/a.cc", "\"leeway/robots/model.h\"");
  expectBites("collision/a.cc", "\"tools/oracle/quad.h\"");
  expectBites("collision/a.h", "<ompl/base/State.h>");
  expectBites("collision/a.cc", "<yaml-cpp/yaml.h>");
  expectBites("collision/a.cc", "<fstream>");
  expectBites("collision/a.cc", "<urdf_parser/urdf_parser.h>");
  expectBites("robots/a.cc", "<ompl/base/State.h>");
  expectBites("planner/a.cc", "<CLI/CLI.hpp>");
  expectBites("planner/include/leeway/planner/a.h", "\"planner/limits.h\"");
  expectBites("robots/include/leeway/robots/a.h", "<tinyxml2.h>");
}

}  // namespace
}  // namespace leeway::tools::testing
