#include "tools/view/subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/cloud_notes.h"
#include "leeway/planner/verify.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/validate/checks.h"
#include "planner/verify/path_check.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/pairs_too_near.h"
#include "tools/view/base/scene_names.h"
#include "tools/view/executed_clearance.h"

namespace leeway::tools::view {
namespace {

/// A file's name for a page. Pages are passed on, so they do not contain the machine's folders.
std::string shownName(const std::string& file) {
  const std::filesystem::path path(file);
  return path.is_absolute() ? (path.parent_path().filename() / path.filename()).string() : file;
}

/// Shortens paths of this machine to their last folder and name: a page may be sent to anyone.
std::string withoutFolders(std::string text) {
  std::error_code error;
  for (std::size_t i = text.find('/'); i != std::string::npos; i = text.find('/', i + 1)) {
    if (i > 0 && std::string_view(" '\"(").find(text[i - 1]) == std::string_view::npos) continue;
    // The longest folder that exists; its name may have spaces.
    for (std::size_t end = text.rfind('/'); end > i; end = text.rfind('/', end - 1)) {
      const std::string folder = text.substr(i, end - i);
      if (!std::filesystem::is_directory(folder, error)) continue;
      text.replace(i, end - i, std::filesystem::path(folder).filename().string());
      break;
    }
  }
  return text;
}

Subject begin(const planner::Problem& problem, const std::string& source) {
  Subject subject{problem, shownName(source), {}, {}, {}, {}, {}, {}, {}, {}, false, {}, {}, {}};
  subject.scene = subject.first_scene =
      std::make_shared<const planner::CompiledScene>(shownProblem(problem));
  const planner::Problem first = firstProblem(problem);
  if (!problem.steps.empty())
    subject.first_scene = std::make_shared<const planner::CompiledScene>(first);
  subject.ends = endsOf(problem, first, subject.first_scene, *subject.scene);
  for (const auto& list : {planner::problemWarnings(problem), subject.first_scene->warnings()})
    for (const std::string& warning : list) subject.warnings.push_back(withoutFolders(warning));
  return subject;
}

/// Drops the warnings of the first step's scene that do not hold in the scenes of all steps, as for
/// a margin of an object that is held first.
void keepCommonWarnings(Subject& subject) {
  for (const Stage& stage : subject.stages) {
    if (!stage.scene) continue;
    const std::vector<std::string> of_stage = stage.scene->warnings();
    for (const std::string& warning : subject.first_scene->warnings())
      if (std::find(of_stage.begin(), of_stage.end(), warning) == of_stage.end())
        std::erase(subject.warnings, withoutFolders(warning));
  }
}

std::string endNote(const Subject& subject, const End& end) {
  const PairNames names = pairNames(*subject.first_scene, end.check.pair);
  const planner::Interval& clearance = end.check.clearance;
  std::string text =
      clearance.upper <= 0
          ? fmt::format("{} is in collision: {} and {}, {} deep.", end.name, names.a, names.b,
                        clearanceText({-clearance.upper, -clearance.lower}))
          : fmt::format("{} is too near: {} and {}, {} apart; more than {:g} mm is required.",
                        end.name, names.a, names.b, clearanceText(clearance),
                        end.closest.margin * 1e3);
  const std::vector<PairNames> pairs = pairsTooNear(*subject.first_scene, end.position, names);
  if (pairs.size() == 2)
    text += fmt::format(" Both pairs that are too near: {}.", pairsText(pairs));
  else if (pairs.size() > 2)
    text += fmt::format(" All {} pairs that are too near: {}.", pairs.size(), pairsText(pairs));
  if (end.way_out.norm() > 0)
    text += fmt::format(" The arrow shows a way out for {} alone: {} mm.", names.a,
                        formatUpper(end.way_out.norm() * 1e3, 1));
  return text;
}

/// The start and the goals.
void noteEnds(Subject& subject, bool is_executed = false) {
  for (const End& end : subject.ends) {
    if (end.unreachable())
      subject.notes.push_back(
          fmt::format("No configuration was found for {}: its pose is drawn.", end.name));
    if (end.check.verdict != planner::Verdict::kFree && end.check.pair >= 0)
      subject.notes.push_back((is_executed ? fmt::format("With the obstacles as at {:g} s: ",
                                                         subject.problem.execution.start)
                                           : "") +
                              endNote(subject, end));
  }
}

void addLines(const std::string& text, Subject& subject) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) subject.notes.push_back(line);
}

/// Notes what was left out of clouds, and what unseen space counts as.
void noteClouds(Subject& subject) {
  for (const std::string& note : planner::cloudNotes(subject.problem))
    subject.notes.push_back("Note: " + note + ".");
}

void noteNothingChecked(const std::string& why, Subject& subject) {
  subject.verdict = "nothing checked";
  subject.notes.push_back("Nothing was checked: " + why + ".");
}

/// Notes the proven clearance, and the objective.
void noteClearances(Subject& subject) {
  if (std::isfinite(subject.least.all.clearance.lower))
    subject.notes.push_back(fmt::format(
        "The {} is proven for every point of every edge{}. {}", leastText(subject.least),
        obstaclesText(subject.problem),
        !subject.problem.steps.empty()  ? "The path begins at the start and does all steps."
        : subject.problem.goals.empty() ? "The path begins at the start; no goal was given."
                                        : "The path begins at the start and ends in a goal."));
  else if (subject.least.all.clearance.lower > 0)
    subject.notes.push_back("There is nothing else that it could touch.");
  const planner::Objective& objective = subject.problem.objective;
  if (const auto* clearance = std::get_if<planner::MaximumClearance>(&objective))
    subject.notes.push_back(
        fmt::format("Asked for: as much clearance as possible, {}.",
                    clearance->of == planner::Pairs::kAll ? "of all pairs" : "from the world"));
  else if (std::holds_alternative<planner::MinimumCost>(objective))
    subject.notes.push_back("Asked for: a path that costs little, of length and nearness.");
  else if (const double kept = std::get<planner::MinimumLength>(objective).clearance;
           std::isfinite(kept))
    subject.notes.push_back(
        fmt::format("Asked for: a short path that keeps {:g} mm from the world.", kept * 1e3));
}

/// Checks limits, start, goal and condition as `leeway verify` does.
void checkWaypoints(const planner::Path& path, Subject& subject) {
  const planner::ConfigurationSpace& space = subject.scene->space();
  if (const auto fault = planner::verification::findFault(subject.problem, space, path,
                                                          !subject.problem.goals.empty())) {
    subject.good = false;
    subject.notes.push_back(
        fmt::format("Waypoint {} of the path: {}.", fault->waypoint, fault->reason));
  } else if (const auto state =
                 planner::verification::findUnaccepted(subject.problem, space, path)) {
    subject.good = false;
    subject.notes.push_back(state->reason + ".");
  }
}

/// Certifies each edge, and notes those that fail. Returns their places: edge and t.
std::vector<std::pair<int, double>> certifyPath(const planner::PathEdges& edges, Subject& subject) {
  std::vector<std::pair<int, double>> failures;
  planner::EdgeCertifier certifier(subject.scene);
  const planner::Path& path = edges.path;
  for (std::size_t i = 0; i < edges.places.size(); ++i) {
    const planner::EdgeCheck check = certifier.certify(path.positions[i], path.positions[i + 1],
                                                       planner::EdgeRequest::persistent());
    if (check.verdict == planner::Verdict::kFree) continue;
    const planner::PathEdges::Place& place = edges.places[i];
    const double t = place.along(check.t);
    failures.emplace_back(static_cast<int>(i), check.t);
    subject.good = false;
    const PairNames names = pairNames(*subject.scene, check.pair);
    const char* what =
        check.verdict == planner::Verdict::kNotFree ? "does not keep its margin" : "is undecided";
    subject.notes.push_back(names.a.empty()
                                ? fmt::format("Edge {} {} at t = {:.3f}.", place.segment, what, t)
                                : fmt::format("Edge {} {} at t = {:.3f}: {} and {}.", place.segment,
                                              what, t, names.a, names.b));
  }
  return failures;
}

/// A path whose columns have names: those of the planned variables.
planner::Path namedPath(const planner::Problem& problem, planner::Path path) {
  if (path.names.empty())
    for (const int v : problem.robot.variables)
      path.names.push_back(problem.robot.model->variables[at(v)].name);
  return path;
}

/// Proves a path with lines or constraints as `leeway verify` does.
void verifyTask(const planner::Path& path, Subject& subject) {
  const planner::VerifyResult result = planner::verify(subject.problem, path);
  subject.good = result.status == planner::VerifyStatus::kCertified;
  if (!subject.good) subject.notes.push_back(result.reason);
}

}  // namespace

Subject subjectOfPath(const planner::Problem& problem, const std::string& source,
                      const planner::Path& of, const planner::Certificate* certificate,
                      const std::function<bool()>& stop) {
  Subject subject = begin(problem, source);
  const planner::Path given = namedPath(problem, of);
  const planner::PathEdges edges = planner::edgesOf(subject.scene->space(), given);
  const planner::Path& path = edges.path;
  subject.stages = stagesOf(problem, subject.scene, path);
  keepCommonWarnings(subject);
  subject.least = leastClearance(subject.stages, edges, stop);
  if (certificate != nullptr)
    narrow(subject.least, *certificate, certificate->world, certificate->self);
  std::string nothing;
  for (const Stage& stage : subject.stages)
    if (nothing.empty() && stage.scene) nothing = stage.scene->nothingChecked();
  std::vector<std::pair<int, double>> failures;
  subject.good = nothing.empty();
  if (!nothing.empty()) {
    noteNothingChecked(nothing, subject);
  } else if (problem.steps.empty() && problem.constraints.empty()) {
    checkWaypoints(given, subject);
    failures = certifyPath(edges, subject);
  } else {
    verifyTask(path, subject);
  }
  subject.timeline = timelineOfPath(problem, subject.scene, edges, subject.stages, subject.least,
                                    subject.good, failures);
  if (!nothing.empty()) return subject;
  // The problem of a result may not have the condition that it was planned with.
  const bool is_sampled =
      problem.condition.accept || (certificate != nullptr && !certificate->conditions.empty());
  subject.verdict = !subject.good ? "not certified"
                    : is_sampled  ? "certified, condition sampled"
                                  : "certified";
  if (subject.good) noteClearances(subject);
  if (subject.good && !problem.constraints.empty())
    if (const auto proven = planner::proveConstraints(*subject.scene, problem, path))
      addLines(constraintsText(problem, *proven), subject);
  if (subject.good && is_sampled)
    subject.notes.push_back(
        "A condition of the program holds at the states that were looked at; nothing is proven "
        "about it between them.");
  subject.notes.push_back(
      toString(countUnchecked(uncheckedIn(movingScenes(subject.stages, subject.first_scene)))) +
      ".");
  noteClouds(subject);
  noteEnds(subject);
  return subject;
}

Subject subjectOfPlan(const planner::Problem& problem, const std::string& source,
                      const planner::PlanResult& result, SearchEdges searched,
                      const std::function<bool()>& stop) {
  if (result.status == planner::PlanStatus::kSolved ||
      result.status == planner::PlanStatus::kPartial) {
    Subject subject = subjectOfPath(problem, source, result.path, &result.certificate, stop);
    subject.searched = std::move(searched);
    const bool is_part = result.status == planner::PlanStatus::kPartial;
    if (is_part) {
      subject.good = false;
      subject.verdict = "only a part of the line";
      subject.notes.insert(subject.notes.begin(), result.reason + ".");
    }
    subject.notes.push_back(fmt::format("{} with {}, seed {}: {}.", is_part ? "Planned" : "Solved",
                                        result.planner, result.seed, lengthText(result)));
    return subject;
  }
  Subject subject = begin(problem, source);
  subject.searched = std::move(searched);
  const Stage first{{}, {}, 0, 0, firstProblem(problem), subject.first_scene};
  const End* shown = &subject.ends.front();
  if (result.status == planner::PlanStatus::kInvalidGoal)
    for (auto end = subject.ends.rbegin(); end != subject.ends.rend(); ++end)
      if (!end->unreachable() && !end->isValid()) shown = &*end;
  subject.shown = shown->name;
  subject.timeline = timelineOfState(problem, subject.scene, first, shown->position);
  if (result.status == planner::PlanStatus::kNothingChecked)
    noteNothingChecked(result.reason, subject);
  else if (!result.reason.empty())
    subject.notes.push_back(result.reason + ".");
  switch (result.status) {
    case planner::PlanStatus::kNothingChecked:
      break;
    case planner::PlanStatus::kNotCompiled:
      subject.verdict = "not compiled";
      break;
    case planner::PlanStatus::kInvalidStart:
      subject.verdict = "start not valid";
      break;
    case planner::PlanStatus::kInvalidGoal:
      subject.verdict = "goal not valid";
      break;
    default:
      subject.verdict = "no path found";
      subject.notes.push_back(
          fmt::format("{} ended after {:.2f} s, {} and {}, {} of them undecided. "
                      "That no path was found does not prove that there is none.",
                      result.planner, result.plan_s, counted(result.iterations, "iteration"),
                      counted(result.edges, "edge"), result.undecided_edges));
  }
  subject.blocked = result.blocked;
  addLines(hindranceText(problem, result), subject);
  noteClouds(subject);
  noteEnds(subject);
  return subject;
}

Subject subjectOfExecution(const planner::Problem& problem, const std::string& source,
                           const std::vector<planner::ReplanStep>& steps,
                           planner::ReplanStatus status, const std::function<bool()>& stop) {
  Subject subject = begin(problem, source);
  const Stage whole{{}, {}, 0, 0, problem, subject.scene};
  const ExecutedClearance executed = executedClearance(problem, subject.scene, steps, stop);
  const bool certified = std::all_of(steps.begin(), steps.end(),
                                     [](const planner::ReplanStep& s) { return s.certified; });
  subject.least = executed.least;
  subject.measured_throughout = executed.is_known && certified;
  subject.timeline =
      steps.empty() ? timelineOfState(problem, subject.scene, whole, subject.ends.front().position)
                    : timelineOfSteps(problem, subject.scene, steps, executed);
  for (const planner::ReplanStep& step : steps)
    subject.decisions.emplace_back(step.time, toString(step.decision));
  subject.good = status == planner::ReplanStatus::kReached && certified;
  subject.verdict = fmt::format("{}{}", toString(status), subject.good ? ", certified" : "");
  if (status == planner::ReplanStatus::kNothingChecked)
    noteNothingChecked(subject.scene->nothingChecked(), subject);
  if (!certified)
    subject.notes.push_back(fmt::format("At {:.2f} s: {}.", steps.back().time, steps.back().why));
  else if (!steps.empty())
    subject.notes.push_back(fmt::format("Every step is proven: {}.", keptText(executed)));
  if (std::string nearest = nearestText(executed, certified); !nearest.empty())
    subject.notes.push_back(std::move(nearest));
  noteClouds(subject);
  noteEnds(subject, true);
  return subject;
}

Subject subjectOfStart(const planner::Problem& problem, const std::string& source) {
  Subject subject = begin(problem, source);
  const End& start = subject.ends.front();
  subject.shown = start.name;
  subject.timeline = timelineOfState(problem, subject.scene,
                                     {{}, {}, 0, 0, problem, subject.first_scene}, start.position);
  subject.notes.emplace_back("No goal is given: the start is shown.");
  std::string fault = subject.scene->space().brokenLimit(start.position);
  if (fault.empty())
    fault = planner::ConstraintProof(*subject.scene, problem).fault(start.position);
  if (!fault.empty()) subject.notes.push_back(fmt::format("The start: {}.", fault));
  subject.good = start.isValid() && fault.empty();
  subject.verdict = subject.good ? "start valid" : "start not valid";
  if (const std::string nothing = subject.scene->nothingChecked(); !nothing.empty()) {
    subject.good = false;
    noteNothingChecked(nothing, subject);
  }
  subject.notes.push_back(toString(planner::countUnchecked(subject.scene->dropped())) + ".");
  noteClouds(subject);
  noteEnds(subject);
  return subject;
}

}  // namespace leeway::tools::view
