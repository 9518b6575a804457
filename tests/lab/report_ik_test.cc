// `leeway report ik`, and what holds for every report; times are not tested.

#include <gtest/gtest.h>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class ReportIk : public CommandTest {};
class ReportUsage : public CommandTest {};

TEST_F(ReportIk, CountsWhatIsSolvedAndProven) {
  const Answer answer =
      run("report ik arm.urdf:lower --poses 30 --beyond 5 --no-rivals --output r");
  EXPECT_EQ(answer.status, 0) << answer.err;
  // robot, engine, poses, solved, coarse, wrong.
  EXPECT_NE(read("r/ik.csv").find("\narm,Leeway,30,30,0,0,"), std::string::npos)
      << read("r/ik.csv");
  // robot, beyond, proven, found, open.
  EXPECT_NE(read("r/ik_proofs.csv").find("\narm,5,5,0,0,"), std::string::npos)
      << read("r/ik_proofs.csv");
  EXPECT_EQ(run("report ik arm.urdf:lower --poses 3 --beyond 2 --output r --json").status, 0);
  expectRefused("report ik arm.urdf --output r", {"arm.urdf", "URDF:LINK"});
  expectRefused("report ik arm.urdf:hand --output r", {"hand"});
}

TEST_F(ReportUsage, NeedsTheNameOfAReport) { expectRefused("report", {"--help"}); }

TEST_F(ReportUsage, HelpIsItsHelpOption) {
  for (const char* report : {"report", "report motion"}) {
    const Answer answer = run(std::string("help ") + report);
    EXPECT_EQ(answer.status, 0) << report << answer.err;
    EXPECT_EQ(answer.out, run(std::string(report) + " --help").out) << report;
  }
}

TEST_F(ReportUsage, ExamplesRun) { expectExamplesRun("report"); }

}  // namespace
}  // namespace leeway::tools::testing
