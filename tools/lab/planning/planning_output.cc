#include <algorithm>
#include <map>
#include <utility>

#include "tools/lab/base/statistics.h"
#include "tools/lab/planning/planning_report.h"

namespace leeway::tools::report {
namespace {

constexpr std::size_t kSlowest = 5;

using Group = std::vector<const PlanningRow*>;

std::vector<double> timesOf(const Group& rows, double (*time)(const PlanningRow&)) {
  std::vector<double> times;
  for (const PlanningRow* r : rows)
    if (r->solved()) times.push_back(1e3 * time(*r));
  return times;
}

void addRow(Table& table, const std::string& set, const std::string& planner, const Group& rows,
            const Group& reference) {
  const auto count = [&](auto&& what) {
    return std::count_if(rows.begin(), rows.end(), [&](const PlanningRow* r) { return what(*r); });
  };
  const auto plan = timesOf(rows, [](const PlanningRow& r) { return r.plan_s; });
  const auto whole = timesOf(rows, [](const PlanningRow& r) { return r.whole(); });
  // Ratios of a run to our run of the same problem and seed, which has the same index.
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(rows.size(), reference.size()); ++i)
    if (rows[i]->solved() && reference[i]->solved() && reference[i]->length > 0)
      ratios.push_back(rows[i]->length / reference[i]->length);
  double stages[6] = {}, sum = 0;
  for (const PlanningRow* r : rows) {
    if (!r->solved()) continue;
    const double s[6] = {r->compile_s, r->plan_s, r->simplify_s,
                         r->improve_s, r->push_s, r->certify_s};
    for (int i = 0; i < 6; ++i) stages[i] += s[i], sum += s[i];
  }
  std::vector<Table::Cell> cells = {
      set,
      planner,
      rows.size(),
      count([](const PlanningRow& r) { return r.solved(); }),
      count([](const PlanningRow& r) { return r.status == "left out"; }),
      count([](const PlanningRow& r) { return r.colliding; }),
      median(plan),
      quantile(plan, 0.95),
      median(whole),
      quantile(whole, 0.95),
      quantile(whole, 1),
      median(ratios)};
  for (const double s : stages) cells.emplace_back(sum > 0 ? 100 * s / sum : 0);
  table.add(std::move(cells));
}

}  // namespace

Table planningRows(const std::vector<PlanningRow>& rows) {
  Table table({"problem", "planner", "seed", "status", "compile_s:.9f", "plan_s:.9f",
               "simplify_s:.9f", "improve_s:.9f", "push_s:.9f", "certify_s:.9f", "iterations",
               "length:.17g", "colliding"});
  for (const PlanningRow& r : rows)
    table.add({r.problem, r.planner, r.seed, r.status, r.compile_s, r.plan_s, r.simplify_s,
               r.improve_s, r.push_s, r.certify_s, r.iterations, r.length, r.colliding});
  return table;
}

Table planningTable(const std::vector<PlanningRow>& rows) {
  std::map<std::pair<std::string, std::string>, Group> groups;
  for (const PlanningRow& r : rows) {
    groups[{r.set, r.planner}].push_back(&r);
    groups[{"~all", r.planner}].push_back(&r);  // sorts last
  }
  Table table(
      {"set", "planner", "runs", "solved", "left out", "colliding", "plan [ms]:.2f", "95 %:.2f",
       "whole [ms]:.2f", "95 %:.2f", "most:.2f", "length:.3f", "compile [%]:.0f", "plan:.0f",
       "simplify:.0f", "improve:.0f", "push:.0f", "certify:.0f"},
      2);
  for (const auto& [key, group] : groups)
    addRow(table, key.first == "~all" ? "all" : key.first, key.second, group,
           groups[{key.first, "Leeway"}]);
  return table;
}

Table slowestRuns(const std::vector<PlanningRow>& rows) {
  Group own;
  for (const PlanningRow& r : rows)
    if (r.planner == "Leeway") own.push_back(&r);
  // Unsolved runs are the slowest.
  std::stable_sort(own.begin(), own.end(), [](const PlanningRow* a, const PlanningRow* b) {
    return std::pair(a->solved(), -a->whole()) < std::pair(b->solved(), -b->whole());
  });
  Table table({"the slowest runs of ours", "seed", "status", "whole [ms]:.1f", "iterations"}, 2);
  for (std::size_t i = 0; i < std::min(kSlowest, own.size()); ++i)
    table.add(
        {own[i]->problem, own[i]->seed, own[i]->status, 1e3 * own[i]->whole(), own[i]->iterations});
  return table;
}

}  // namespace leeway::tools::report
