#include <array>
#include <cmath>
#include <utility>

#include "tools/lab/growth/growth_report.h"

namespace leeway::tools::report {
namespace {

struct Quantity {
  const char* label;
  double (*of)(const GrowthRow&);
};

constexpr std::array<Quantity, 6> kQuantities = {{
    {"making [ms]", [](const GrowthRow& r) { return 1e3 * r.make_s; }},
    {"a change [ms]", [](const GrowthRow& r) { return 1e3 * r.change_s; }},
    {"memory [MB]", [](const GrowthRow& r) { return 1e-6 * r.bytes; }},
    {"an edge [us]", [](const GrowthRow& r) { return r.edge_us; }},
    {"median [us]", [](const GrowthRow& r) { return r.edge_median_us; }},
    {"planning [ms]", [](const GrowthRow& r) { return 1e3 * r.plan_s; }},
}};

Table quantities(const std::vector<GrowthRow>& rows, bool has_states) {
  std::vector<Table::Column> columns = {"family", "count", "engine"};
  for (const Quantity& quantity : kQuantities) columns.emplace_back(quantity.label, ".3f");
  for (const char* const name : {"states", "too high", "too low"})
    if (has_states) columns.emplace_back(name);
  columns.emplace_back("status");
  Table table(std::move(columns), 3);
  for (const GrowthRow& r : rows) {
    std::vector<Table::Cell> cells = {r.family, r.count, r.engine};
    for (const Quantity& quantity : kQuantities)
      cells.emplace_back(quantity.of(r) > 0 ? quantity.of(r) : std::nan(""));
    for (const int count : {r.states, r.too_high, r.too_low})
      if (has_states) cells.push_back(Table::Cell::onlyIf(r.states > 0, count));
    cells.emplace_back(r.status);
    table.add(std::move(cells));
  }
  return table;
}

}  // namespace

Table growthRows(const std::vector<GrowthRow>& rows) {
  Table table({"family", "count", "engine", "status", "make_s:.6g", "change_s:.6g", "bytes:.0f",
               "edges", "edge_us:.6g", "plan_s:.6g"});
  for (const GrowthRow& r : rows)
    table.add({r.family, r.count, r.engine, r.status, r.make_s, r.change_s, r.bytes, r.edges,
               r.edge_us, r.plan_s});
  return table;
}

Table sensedRows(const std::vector<GrowthRow>& rows) {
  Table table({"points", "engine", "status", "make_s:.6g", "change_s:.6g", "bytes:.0f", "edges",
               "edge_us:.6g", "edge_median_us:.6g", "plan_s:.6g", "states", "too_high", "too_low"});
  for (const GrowthRow& r : rows)
    table.add({r.count, r.engine, r.status, r.make_s, r.change_s, r.bytes, r.edges, r.edge_us,
               r.edge_median_us, r.plan_s, r.states, r.too_high, r.too_low});
  return table;
}

Table growthTable(const std::vector<GrowthRow>& rows) { return quantities(rows, false); }
Table sensedTable(const std::vector<GrowthRow>& rows) { return quantities(rows, true); }

}  // namespace leeway::tools::report
