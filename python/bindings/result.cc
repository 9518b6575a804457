#include <cmath>
#include <cstdio>

#include "leeway/planner/cloud_notes.h"
#include "leeway/planner/path_io.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/plan.h"
#include "python/bindings/scene.h"

namespace leeway::python {
namespace {

using planner::Certificate;
using planner::PathClearance;

std::string millimetres(double metres) {
  if (std::isinf(metres)) return metres > 0 ? "nothing near" : "not proven";
  // Rounded down: a bound stays a bound.
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3f", std::floor(metres * 1e6) / 1e3);
  return buffer;
}

std::string clearanceText(const PathClearance& c) {
  if (c.closest_segment < 0)
    return std::isfinite(c.clearance.lower)
               ? "nothing nearer than " + text(c.clearance.lower) + " m"
           : c.clearance.lower > 0 ? "nothing near"
                                   : "not measured";
  return "clearance " + text(c.clearance.lower) + " to " + text(c.clearance.upper) + " m between " +
         c.closest_a + " and " + c.closest_b;
}

std::string certificateText(const Certificate& c) {
  const std::string verdict = c.certified ? "certified" : "not certified";
  return verdict + (c.conditions.empty() ? "" : ", condition " + c.conditions) + ", " +
         clearanceText(c);
}

void defineClearance(py::module_& module) {
  py::class_<PathClearance> clearance(module, "PathClearance",
                                      "Bounds on the least clearance along a path, and where it "
                                      "is.");
  defineConstant(
      clearance, "lower", [](const PathClearance& self) { return self.clearance.lower; },
      "Every point of every edge keeps at least this [m]; inf where nothing is near.");
  defineConstant(
      clearance, "upper", [](const PathClearance& self) { return self.clearance.upper; },
      "The least clearance is at most this [m].");
  defineConstant(
      clearance, "closest",
      [](const PathClearance& self) { return pairObject(self.closest_a, self.closest_b); },
      "Names of the pair that is nearest, or None.");
  clearance.def_readonly("closest_edge", &PathClearance::closest_segment,
                         "The edge where that is; -1: none.");
  clearance.def_readonly("closest_t", &PathClearance::closest_t, "And where on it, in [0, 1].");
  defineConstant(
      clearance, "point_a", [](const PathClearance& self) { return array(self.closest_point_a); },
      "On the first of `closest`: (3,), world [m].");
  defineConstant(
      clearance, "point_b", [](const PathClearance& self) { return array(self.closest_point_b); },
      "On the second: (3,), world [m].");
  clearance.def("__repr__", [](const PathClearance& self) {
    return "<leeway.PathClearance: " + clearanceText(self) + ">";
  });
}

void defineCertificate(py::module_& module) {
  py::class_<Certificate, PathClearance> certificate(
      module, "Certificate",
      "The proof that comes with a path: bounds on the clearance of every point of every edge, "
      "over the pairs that are checked.");
  certificate.def_readonly("certified", &Certificate::certified,
                           "Every edge is proven to keep its margins.");
  defineConstant(certificate, "world", &Certificate::world,
                 "The clearance from the world alone: a PathClearance.");
  defineConstant(certificate, "self", &Certificate::self,
                 "The clearance among the robot's own links and what it holds: a PathClearance.");
  defineConstant(
      certificate, "edges",
      [](const Certificate& self) {
        std::vector<double> values;
        for (const planner::Interval& edge : self.segments)
          values.insert(values.end(), {edge.lower, edge.upper});
        return array(std::move(values), {static_cast<py::ssize_t>(self.segments.size()), 2});
      },
      "Bounds on the clearance of each edge: (edges, 2) [m]; an upper end may be inf: not looked "
      "for.");
  defineConstant(
      certificate, "unchecked",
      [](const Certificate& self) { return uncheckedList(self.unchecked); },
      "Pairs of which it says nothing: [(reason, how many, pairs), ...]. Pairs are by name where "
      "they are left out because they touch at the zero configuration, else empty.");
  defineConstant(
      certificate, "constraints",
      [](const Certificate& self) {
        py::list list;
        for (const planner::ConstraintResult& c : self.constraints)
          list.append(py::make_tuple(c.name, c.deviation, c.angle));
        return list;
      },
      "What constraints keep, proven: [(name, deviation [m], angle [rad]), ...].");
  defineConstant(
      certificate, "conditions",
      [](const Certificate& self) {
        return self.conditions.empty() ? py::object(py::none()) : py::str(self.conditions);
      },
      "'sampled': a condition of your own holds at the states that were looked at, and nothing is "
      "proven between them; None: there is none.");
  certificate.def("__bool__", [](const Certificate& self) { return self.certified; });
  certificate.def("__repr__", [](const Certificate& self) {
    return "<leeway.Certificate: " + certificateText(self) + ">";
  });
}

std::string lineOfResult(const Result& self) {
  const planner::PlanResult& r = self.value;
  std::string result = std::string("<leeway.Result: ") + toString(r.status) + " with " + r.planner +
                       ", seed " + std::to_string(r.seed);
  if (r.status == planner::PlanStatus::kSolved)
    result += ", " + std::to_string(r.path.positions.size()) + " waypoints, " +
              certificateText(r.certificate);
  else if (!r.reason.empty())
    result += ", " + r.reason;
  else if (!r.offending_a.empty())
    result += ", " + r.offending_a + " and " + r.offending_b;
  return result + ">";
}

std::string htmlOfResult(const Result& self) {
  const planner::PlanResult& r = self.value;
  std::vector<std::string> heading = {""};
  heading.insert(heading.end(), r.path.names.begin(), r.path.names.end());
  heading.emplace_back("clearance to next [mm]");
  std::vector<std::vector<std::string>> table;
  for (std::size_t i = 0; i < r.path.positions.size(); ++i) {
    std::vector<std::string> row = {std::to_string(i)};
    for (const double value : r.path.positions[i]) {
      char buffer[32];
      std::snprintf(buffer, sizeof buffer, "%.4f", value);
      row.emplace_back(buffer);
    }
    std::string clearance;
    if (i < r.certificate.segments.size()) {
      const double lower = r.certificate.segments[i].lower;
      clearance = (std::isfinite(lower) ? "at least " : "") + millimetres(lower);
    }
    row.push_back(clearance);
    table.push_back(row);
  }
  return htmlTable(self.problem->name + ": " + toString(r.status) + " with " + r.planner +
                       ", seed " + std::to_string(r.seed),
                   heading, table);
}

py::dict times(const Result& self) {
  py::dict result;
  result["compile"] = self.value.compile_s;
  result["plan"] = self.value.plan_s;
  result["simplify"] = self.value.simplify_s;
  result["improve"] = self.value.improve_s;
  result["push"] = self.value.push_s;
  result["certify"] = self.value.certify_s;
  return result;
}

py::dict counts(const Result& self) {
  py::dict result;
  result["iterations"] = self.value.iterations;
  result["states"] = self.value.states;
  result["edges"] = self.value.edges;
  result["undecided_edges"] = self.value.undecided_edges;
  result["distance_queries"] = self.value.distance_queries;
  return result;
}

void requirePath(const Result& self, const char* what) {
  if (self.value.path.positions.empty())
    throw py::value_error(std::string("no path to ") + what + ": the status is '" +
                          toString(self.value.status) + "'");
}

}  // namespace

void defineResult(py::module_& module) {
  defineClearance(module);
  defineCertificate(module);
  py::class_<Result> result(module, "Result",
                            "What plan() found. True if it is solved: then every edge of `path` is "
                            "proven to keep its margins.");
  const auto property = constantsOf(result, &Result::value);
  defineConstant(
      result, "status", [](const Result& self) { return toString(self.value.status); },
      "'solved', 'unsolved', 'partial' (a line of a task ends early, and the path is what there is "
      "until then), 'invalid_start', 'invalid_goal', 'nothing_checked' (no pair of shapes "
      "is checked, and nothing is planned) or 'not_compiled' (the time limit was over, or it was "
      "stopped, before planning began).");
  defineConstant(
      result, "path",
      [](const Result& self) {
        return array(self.value.path.positions, self.problem->robot.variables.size());
      },
      "The waypoints: (n, joints) [rad or m]; (0, joints) unless solved or partial.");
  defineConstant(
      result, "joint_names", [](const Result& self) { return listOf(self.value.path.names); },
      "Names of the path's columns.");
  property("certificate", &planner::PlanResult::certificate, "The proof of the path.");
  property("length", &planner::PlanResult::length, "Length of the path, see Robot.distance().");
  property("goal", &planner::PlanResult::goal, "Index of the goal that is reached; -1: none.");
  defineConstant(
      result, "steps",
      [](const Result& self) {
        py::list steps;
        for (const planner::PathStep& step : self.value.path.steps) steps.append(step);
        return steps;
      },
      "Of a task: its steps as stretches of the path, PathSteps; else empty.");
  property(
      "reason", &planner::PlanResult::reason,
      "Why a task failed, a goal of poses has no configuration or nothing is checked, in words; "
      "else "
      "''.");
  defineConstant(
      result, "line_end",
      [](const Result& self) -> py::object {
        const auto& end = self.value.line_end;
        if (!end) return py::none();
        py::dict where;
        where["step"] = self.problem->steps[static_cast<std::size_t>(end->step)].name;
        where["waypoint"] = end->waypoint;
        where["share"] = end->share;
        where["why"] = toString(end->why);
        return where;
      },
      "Where a line ends early: a dict of its `step`, the first `waypoint` of its poses that is "
      "not reached, the `share` of the way to it that is left behind, and `why`: 'limit', "
      "'singularity', 'collision' or 'stopped' (the time limit was reached, or the caller ended "
      "it); else None.");
  property("unreachable", &planner::PlanResult::unreachable,
           "Whether it is proven that a goal of poses has no configuration.");
  defineConstant(
      result, "blocked",
      [](const Result& self) {
        py::list blocked;
        for (const planner::BlockedPair& pair : self.value.blocked)
          blocked.append(py::make_tuple(pair.a, pair.b, pair.edges));
        return blocked;
      },
      "Unsolved: the pairs that were in the way of most edges, (a, b, edges) in falling order; of "
      "a "
      "task in the step that failed.");
  defineConstant(
      result, "gap",
      [](const Result& self) -> py::object {
        const planner::SearchGap& gap = self.value.gap;
        if (gap.from.empty()) return py::none();
        return py::make_tuple(gap.distance, array(std::span<const double>(gap.from)),
                              array(std::span<const double>(gap.to)));
      },
      "Unsolved, by Connect: how near its two trees came, (distance, point of the start's, point "
      "of the goals'); else None.");
  property(
      "long_turns", [](const planner::PlanResult& value) { return listOf(value.long_turns); },
      "Unsolved: joints whose limits bar the shorter turn to every goal that joints give.");
  defineConstant(
      result, "cost",
      [](const Result& self) {
        return std::isinf(self.value.cost.upper)
                   ? py::object(py::none())
                   : py::object(py::make_tuple(self.value.cost.lower, self.value.cost.upper));
      },
      "Bounds on what the path costs, (lower, upper), where the problem has such an objective, or "
      "wishes; else None.");
  defineConstant(
      result, "wishes",
      [](const Result& self) {
        py::list wishes;
        for (std::size_t i = 0; i < self.value.wishes.size(); ++i) {
          const planner::WishResult& of = self.value.wishes[i];
          py::dict wish;
          wish["between"] = self.problem->margins.wishes[i].name;
          wish["wish"] = self.problem->margins.wishes[i].clearance;
          wish["kept"] = of.kept ? py::object(py::bool_(*of.kept)) : py::object(py::none());
          wish["clearance"] = py::make_tuple(of.clearance.lower, of.clearance.upper);
          wish["cost"] = py::make_tuple(of.cost.lower, of.cost.upper);
          wishes.append(wish);
        }
        return wishes;
      },
      "What became of each of the problem's wishes: dicts of `between`, `wish` [m], `kept` "
      "(everywhere: proven True or False; None: not decided), and bounds on its least `clearance` "
      "[m] and on its `cost`. Empty unless solved.");
  property(
      "clearance_bound", &planner::PlanResult::clearance_bound,
      "With the objective 'clearance': no path has more than this, because its start or its goals "
      "have not [m].");
  property("planner", &planner::PlanResult::planner, "The planner's name.");
  property("seed", &planner::PlanResult::seed, "The seed.");
  property("deterministic", &planner::PlanResult::deterministic,
           "False for planners with threads or clocks of their own.");
  defineConstant(result, "times", times,
                 "What it took [s]: {compile, plan, simplify, improve, push, certify}.");
  defineConstant(result, "counts", counts,
                 "{iterations, states, edges, undecided_edges, distance_queries}.");
  property(
      "warnings", [](const planner::PlanResult& value) { return listOf(value.warnings); },
      "Margins and objects that have no effect, and goals that were left out.");
  defineConstant(
      result, "notes",
      [](const Result& self) { return listOf(planner::cloudNotes(*self.problem)); },
      "Those of its problem.");
  defineConstant(
      result, "offending",
      [](const Result& self) { return pairObject(self.value.offending_a, self.value.offending_b); },
      "Of an invalid start or goal: the pair that is too near, or None.");
  defineConstant(
      result, "problem", [](const Result& self) { return Problem(self.problem, true); },
      "The problem that it answers, constant; copy() gives one to change.");
  define(result, "trajectory", "(self, period=0.01)",
         "The path with times, within the limits of the problem's execution: along the certified "
         "edges, at rest at corners or through proven blends. `period` [s] is that of its arrays.",
         [](const Result& self, double period) {
           requirePath(self, "time");
           return trajectoryObject(self, period);
         });
  define(result, "save", "(self, file)",
         "Writes path and certificate; the file's ending chooses: .json, .yaml, .csv, .path. Whole "
         "or not at all.",
         [](const Result& self, const py::object& file) {
           requirePath(self, "save");
           const std::string path = fileName(file, "file");
           const Result held = self;
           released([&] { planner::writePath(path, *held.problem, held.value); });
         });
  result.def("__bool__", [](const Result& self) {
    return self.value.status == planner::PlanStatus::kSolved && self.value.certificate.certified;
  });
  result.def("__repr__", lineOfResult);
  result.def("_repr_html_", htmlOfResult);
}

}  // namespace leeway::python
