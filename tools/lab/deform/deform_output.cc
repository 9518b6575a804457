#include <fmt/format.h>

#include <cmath>

#include "tools/lab/deform/deform_report.h"

namespace leeway::tools::report {
namespace {

const DeformRow* find(const std::vector<DeformRow>& rows, const DeformRow& like,
                      const std::string& engine) {
  for (const DeformRow& r : rows)
    if (r.motion == like.motion && r.triangles == like.triangles && r.engine == engine) return &r;
  return nullptr;
}

constexpr const char* kYardstick = "FCL AABB refit";

bool isOurs(const DeformRow& row) { return row.engine.rfind("leeway", 0) == 0; }

}  // namespace

Table deformRows(const std::vector<DeformRow>& rows) {
  Table table({"motion",
               "triangles",
               "engine",
               "status",
               "frames",
               "update_ns",
               "update_low_ns",
               "update_high_ns",
               "spheres_12_ns",
               "capsules_12_ns",
               "tolerance_12_ns",
               "mesh_far_ns",
               "mesh_near_ns",
               "mesh_touching_ns",
               "nodes_touched",
               "vertices_touched",
               "bandwidth_limit_ns",
               "compared",
               "wrong",
               "largest_error_m",
               "decay"});
  for (const DeformRow& r : rows)
    table.add({r.motion,
               r.triangles,
               r.engine,
               r.done ? "done" : "failed",
               r.frames,
               r.median.update,
               r.update_low,
               r.update_high,
               r.median.spheres,
               r.median.capsules,
               r.median.tolerance,
               r.median.far,
               r.median.near,
               r.median.touching,
               r.nodes,
               r.vertices,
               r.bandwidth_limit,
               r.compared,
               r.wrong,
               r.error,
               r.decay});
  return table;
}

Table deformFrameRows(const std::vector<DeformRow>& rows) {
  Table table({"motion", "triangles", "engine", "frame", "update_ns", "spheres_12_ns",
               "capsules_12_ns", "tolerance_12_ns", "mesh_far_ns", "mesh_near_ns",
               "mesh_touching_ns"});
  for (const DeformRow& r : rows)
    for (std::size_t f = 0; f < r.by_frame.size(); ++f) {
      const DeformFrame& t = r.by_frame[f];
      if (!std::isnan(t.update))
        table.add({r.motion, r.triangles, r.engine, f + 1, t.update, t.spheres, t.capsules,
                   t.tolerance, t.far, t.near, t.touching});
    }
  return table;
}

Table deformTable(const std::vector<DeformRow>& rows) {
  Table table({"motion", "triangles", "engine", "update [us]", "/ FCL", "/ limit",
               "12 spheres [us]", "12 capsules", "12 d > 5 cm", "1k far", "1k near", "1k touching",
               "update + 12 d > 5 cm", "decay:.1f", "wrong", "compared"},
              3);
  for (const DeformRow& r : rows) {
    const DeformRow* yardstick = find(rows, r, kYardstick);
    const DeformFrame& t = r.median;
    const double tolerance = isOurs(r) ? t.tolerance : std::nan("");
    table.add({r.motion, r.triangles, r.done ? r.engine : r.engine + " (failed)", t.update / 1e3,
               yardstick == nullptr ? std::nan("") : t.update / yardstick->median.update,
               t.update / r.bandwidth_limit, t.spheres / 1e3, t.capsules / 1e3, tolerance / 1e3,
               t.far / 1e3, t.near / 1e3, t.touching / 1e3, (t.update + tolerance) / 1e3, r.decay,
               Table::Cell::onlyIf(r.compared > 0, r.wrong),
               Table::Cell::onlyIf(r.compared > 0, r.compared)});
  }
  return table;
}

std::string deformWords(const std::vector<DeformRow>& rows) {
  std::string text;
  for (const DeformRow& hybrid : rows) {
    if (hybrid.engine != "leeway hybrid" || !hybrid.done) continue;
    const DeformRow* refit = find(rows, hybrid, "leeway refit");
    if (refit == nullptr || !refit->done) continue;
    const DeformFrame &h = hybrid.median, &r = refit->median;
    const double alone = r.update / h.update,
                 tested = (r.update + r.tolerance) / (h.update + h.tolerance),
                 asked = (r.update + r.spheres) / (h.update + h.spheres);
    const double judged = std::isnan(tested) ? alone : tested;
    text += fmt::format("{}, {}: hybrid updates are {:.1f} times cheaper than full refits",
                        hybrid.motion, hybrid.triangles, alone);
    if (!std::isnan(tested))
      text +=
          fmt::format(", {:.1f} with 12 tolerance tests, {:.1f} with 12 distances", tested, asked);
    text += fmt::format("; the textbook's four to five times {}.", judged < 4 ? "are refuted: less"
                                                                   : judged <= 5 ? "are confirmed"
                                                                                 : "are surpassed");
    const DeformRow* moved = find(rows, hybrid, "leeway hybrid moved");
    if (moved != nullptr && moved->done) {
      const DeformFrame& m = moved->median;
      text += fmt::format(" Where it is known how far vertices move: {:.1f}", r.update / m.update);
      const double with = (r.update + r.tolerance) / (m.update + m.tolerance);
      if (!std::isnan(with)) text += fmt::format(", {:.1f} with 12 tests", with);
      text += ".";
    }
    // The engine with the cheapest frame among those with distance queries.
    const DeformRow *best = nullptr, *chosen = find(rows, hybrid, "leeway auto");
    const auto frame = [](const DeformRow& row) { return row.median.update + row.median.spheres; };
    for (const DeformRow& other : rows) {
      if (!isOurs(other) || &other == chosen || !other.done || other.motion != hybrid.motion ||
          other.triangles != hybrid.triangles || std::isnan(frame(other)))
        continue;
      if (best == nullptr || frame(other) < frame(*best)) best = &other;
    }
    if (best != nullptr && chosen != nullptr && chosen->done)
      text += fmt::format(" With 12 distances auto takes {:.2f} times what {} does.",
                          frame(*chosen) / frame(*best), best->engine.substr(7));
    text += "\n";
  }
  return text;
}

}  // namespace leeway::tools::report
