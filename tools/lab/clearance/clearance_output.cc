#include <algorithm>
#include <map>
#include <tuple>

#include "tools/lab/base/statistics.h"
#include "tools/lab/clearance/clearance_report.h"

namespace leeway::tools::report {
namespace {

/// Objective, planner, limit.
using Key = std::tuple<std::string, std::string, double>;
using Groups = std::map<Key, std::vector<const ClearanceRow*>>;

Groups grouped(const std::vector<ClearanceRow>& rows) {
  Groups groups;
  for (const ClearanceRow& row : rows)
    groups[{row.objective, row.planner, row.time}].push_back(&row);
  return groups;
}

double medianOf(const std::vector<const ClearanceRow*>& rows, double ClearanceRow::*value) {
  std::vector<double> values;
  for (const ClearanceRow* row : rows)
    if (row->solved() && row->*value == row->*value) values.push_back(row->*value);
  return median(values);
}

}  // namespace

Table clearanceRows(const std::vector<ClearanceRow>& rows) {
  Table table({"problem", "planner", "objective", "seed", "time_s:g", "status", "took_s:.9f",
               "least_m:.17g", "integral:.17g", "length:.17g", "colliding", "unsound"});
  for (const ClearanceRow& r : rows)
    table.add({r.problem, r.planner, r.objective, r.seed, r.time, r.status, r.took, r.least,
               r.integral, r.length, r.colliding, r.unsound});
  return table;
}

Table clearanceTable(const std::vector<ClearanceRow>& rows) {
  Table table({"objective", "planner", "limit [s]:g", "runs", "solved", "left out", "colliding",
               "least [mm]:.2f", "integral:.4f", "length:.3f"},
              3);
  for (const auto& [key, group] : grouped(rows)) {
    const auto count = [&of = group](auto&& what) {  // (clang 14 cannot capture structured
                                                     // bindings)
      return std::count_if(of.begin(), of.end(),
                           [&](const ClearanceRow* row) { return what(*row); });
    };
    table.add({std::get<0>(key), std::get<1>(key), std::get<2>(key), group.size(),
               count([](const ClearanceRow& r) { return r.solved(); }),
               count([](const ClearanceRow& r) { return r.status == "left out"; }),
               count([](const ClearanceRow& r) { return r.colliding; }),
               1e3 * medianOf(group, &ClearanceRow::least),
               medianOf(group, &ClearanceRow::integral), medianOf(group, &ClearanceRow::length)});
  }
  return table;
}

}  // namespace leeway::tools::report
