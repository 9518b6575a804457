// A program that writes a page and a picture of its plan.
//   view FOLDER    in the project's folder

#include <cstdio>
#include <string>

#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "leeway/view/page.h"

int main(int count, char** arguments) {
  using namespace leeway;
  if (count != 2) return 2;
  const std::string folder = arguments[1];
  const planner::Problem problem = planner::loadProblem("problems/shelf/reach.yaml");
  view::PageOptions options;
  planner::PlanOptions planning;
  view::recordSearch(planning, options.searched);
  const planner::PlanResult result = planner::plan(problem, planning);
  view::writePage(folder + "/plan.svg", problem, result, options);
  view::writePage(folder + "/path.svg", problem, result.path);
  try {
    view::writePage(folder + "/plan.html", problem, result, options);
  } catch (const robots::InputError& error) {
    std::printf("%s\n", error.what());
    if (std::string(error.what()).find("without node") == std::string::npos) return 1;
  }
  return result.status == planner::PlanStatus::kSolved ? 0 : 1;
}
