// tools/scripts/check_docs detects wrong pages. (A test of its own runs it on this tree.)

#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Docs : public CommandTest {
 protected:
  Answer check() const {
    return shell("'" + leeway::sourceFolder() + "/tools/scripts/check_docs' tree");
  }
  /// A tree with one good page, and `line` as the fifth line of README.md.
  Answer checkWith(const std::string& line) const {
    fs::remove_all(path("tree"));
    write("tree/tools/CMakeLists.txt", "add_executable(bench_pairs pairs.cc)\n");
    write("tree/planner/problem.h",
          "struct Problem {\n  World world;\n};\nstruct World { int objects; };\n");
    write("tree/docs/page.md", "# A page: `words` & more\n");
    write("tree/README.md", "# Title\n\n[page](docs/page.md#a-page-words--more)\n\n" + line + "\n");
    return check();
  }
  void expectBites(const std::string& line) const {
    const Answer answer = checkWith(line);
    EXPECT_EQ(answer.status, 1) << line;
    EXPECT_NE(answer.out.find("README.md:"), std::string::npos) << line << answer.out;
  }
};

TEST_F(Docs, GoodPagesPass) {
  for (const char* line :
       {"", "`tools/CMakeLists.txt`", "`tools/*.txt`", "[here](#title)", "`tools/<name>.cc`",
        "[web](https://nowhere.example/x.md)", "`build/tools/bench_pairs --rounds 5`",
        "`Problem::world.objects`", "`fcl::Nothing::member`",
        "```text\ntools/nothing [x](nowhere.md)\n```", "`[x](nowhere.md)`"}) {
    const Answer answer = checkWith(line);
    EXPECT_EQ(answer.status, 0) << line << answer.out << answer.err;
  }
}

TEST_F(Docs, EveryRuleBites) {
  expectBites("[x](docs/nowhere.md)");
  expectBites("[x](docs/page.md#nothing)");
  expectBites("[x](#nothing)");
  expectBites("<img src=\"docs/nothing.svg\">");
  expectBites("see `tools/nothing.cc`");
  expectBites("see `leeway/collision/nothing.h`");
  expectBites("see `build/tools/bench_nothing`");
  expectBites("see `Problem::planner_parameters`");
  expectBites("see `planner::Problem::world.nothing`");
  expectBites("```sh\ntools/nothing\n```");
  expectBites(std::string(146, '\n'));
  ASSERT_EQ(checkWith("").status, 0);
  write("tree/docs/lonely.md", "# Nobody links here\n");
  EXPECT_EQ(check().status, 1);
  ASSERT_EQ(checkWith("").status, 0);
  write("tree/CHANGELOG.md", std::string(26, '\n'));
  EXPECT_EQ(check().status, 1);
}

}  // namespace
}  // namespace leeway::tools::testing
