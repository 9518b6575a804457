#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "tools/report/base/statistics.h"
#include "tools/report/planning/planning_report.h"

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

std::string rowOf(const std::string& set, const std::string& planner, const Group& rows,
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
  std::string shares;
  for (const double s : stages) shares += fmt::format(" {:>4.0f}", sum > 0 ? 100 * s / sum : 0);
  return fmt::format(
      "{:<22} {:<22} {:>5} {:>6} {:>8} {:>9} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>7.3f} "
      "{}\n",
      set, planner, rows.size(), count([](const PlanningRow& r) { return r.solved(); }),
      count([](const PlanningRow& r) { return r.status == "left out"; }),
      count([](const PlanningRow& r) { return r.colliding; }), median(plan), quantile(plan, 0.95),
      median(whole), quantile(whole, 0.95), quantile(whole, 1), median(ratios), shares);
}

}  // namespace

std::string planningCsv(const std::vector<PlanningRow>& rows) {
  std::string text =
      "problem,planner,seed,status,compile_s,plan_s,simplify_s,improve_s,push_s,certify_s,"
      "iterations,length,colliding\n";
  for (const PlanningRow& r : rows)
    text += fmt::format(
        "\"{}\",\"{}\",{},{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{},{:.17g},{}\n", r.problem,
        r.planner, r.seed, r.status, r.compile_s, r.plan_s, r.simplify_s, r.improve_s, r.push_s,
        r.certify_s, r.iterations, r.length, r.colliding ? 1 : 0);
  return text;
}

std::string planningTable(const std::vector<PlanningRow>& rows) {
  std::map<std::pair<std::string, std::string>, Group> groups;
  Group own;
  for (const PlanningRow& r : rows) {
    groups[{r.set, r.planner}].push_back(&r);
    groups[{"~all", r.planner}].push_back(&r);  // sorts last
    if (r.planner == "Leeway") own.push_back(&r);
  }
  std::string text = fmt::format(
      "{:<22} {:<22} {:>5} {:>6} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7}  shares: compile, "
      "plan, simplify, improve, push, certify [%]\n",
      "set", "planner", "runs", "solved", "left out", "colliding", "plan ms", "95 %", "whole ms",
      "95 %", "most", "length");
  for (const auto& [key, group] : groups)
    text += rowOf(key.first == "~all" ? "all" : key.first, key.second, group,
                  groups[{key.first, "Leeway"}]);
  // Unsolved runs are the slowest.
  std::stable_sort(own.begin(), own.end(), [](const PlanningRow* a, const PlanningRow* b) {
    return std::pair(a->solved(), -a->whole()) < std::pair(b->solved(), -b->whole());
  });
  text += "the slowest runs of ours\n";
  for (std::size_t i = 0; i < std::min(kSlowest, own.size()); ++i)
    text += fmt::format("  {}, seed {}: {}, {:.1f} ms, {} iterations\n", own[i]->problem,
                        own[i]->seed, own[i]->status, 1e3 * own[i]->whole(), own[i]->iterations);
  return text;
}

}  // namespace leeway::tools::report
