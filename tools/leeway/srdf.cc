#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/motion_bound.h"
#include "tools/leeway/info/input.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/pair_samples.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/view/base/output_file.h"

namespace leeway::tools {
namespace {

struct SrdfArguments {
  ProblemSource source;
  std::string file, output;
  int samples = 1000;
  std::uint64_t seed = 1;
  bool sampled = false, json = false;
};

/// The findings about a pair of links, strongest first.
enum class Why { kAdjacent, kRigid, kFile, kAlways, kNever, kNearlyAlways, kRest, kSampled, kSome };

struct Kind {
  const char* word;         ///< in JSON and in files
  const char* reason;       ///< MoveIt's reason in an SRDF; null: the pair stays checked
  const char* text;         ///< for people
  bool in_problems, named;  ///< a problem file needs it; people need the names
};
constexpr std::array kKinds = {
    Kind{"adjacent", "Adjacent", "a joint joins them", false, false},
    Kind{"rigid", "Adjacent", "rigidly attached to each other", false, false},
    Kind{"file", "User", "the robot's file lets them touch", false, false},
    Kind{"always", "Always", "touch always (proven)", true, true},
    Kind{"never", "Never", "never touch within the limits of all joints, without margins (proven)",
         false, false},
    Kind{"nearly_always", "Always", "touch nearly always (sampled)", true, true},
    Kind{"rest", "Default", "touch with all joints at zero (MJCF: qpos0), or at the nearest limit",
         true, true},
    Kind{"never_sampled", nullptr, "never touched in samples, which proves nothing", true, false},
    Kind{"sometimes", nullptr, "touch in some samples", false, false},
};
const Kind& kindOf(Why why) { return kKinds[static_cast<std::size_t>(why)]; }

struct LinkPair {
  std::string a, b;
  Why why = Why::kSome;
  int hits = -1;  ///< samples in which they touch; -1: not sampled
};

Why whyOf(planner::Unchecked why) {
  switch (why) {
    case planner::Unchecked::kRigid:
      return Why::kRigid;
    case planner::Unchecked::kAdjacent:
      return Why::kAdjacent;
    case planner::Unchecked::kTouchAlways:
      return Why::kAlways;
    case planner::Unchecked::kTouchSampled:
      return Why::kNearlyAlways;
    default:
      return Why::kFile;
  }
}

using NamePair = std::pair<std::string, std::string>;

std::set<NamePair> namesOf(const robots::Model& model,
                           const std::vector<std::pair<int, int>>& pairs) {
  std::set<NamePair> names;
  for (const auto& [a, b] : pairs)
    names.insert(std::minmax(model.links[static_cast<std::size_t>(a)].name,
                             model.links[static_cast<std::size_t>(b)].name));
  return names;
}

/// A share of fewer samples means little.
constexpr int kFewestSamples = 100;

/// Classifies all pairs of links with shapes: by proofs of the compiler first, then by samples.
std::vector<LinkPair> classify(const planner::CompiledScene& scene,
                               const SrdfArguments& arguments) {
  const robots::Model& model = scene.model();
  const auto touching = robots::touchingAtRest(model, interrupted);
  const std::set<NamePair> at_rest = namesOf(model, touching);
  // The compiler checks only pairs with one joint between them.
  const std::set<NamePair> always =
      namesOf(model, robots::provenTouching(model, touching, interrupted));
  std::vector<std::pair<int, int>> checked;
  for (const collision::ScenePair& pair : scene.scene().pairs())
    checked.emplace_back(
        model.findLink(scene.scene().bodies()[static_cast<std::size_t>(pair.body_a)].name),
        model.findLink(scene.scene().bodies()[static_cast<std::size_t>(pair.body_b)].name));
  const std::set<NamePair> never = namesOf(model, robots::provenApart(model, checked, interrupted));
  std::vector<LinkPair> pairs;
  for (const planner::CompiledScene::Dropped& d : scene.dropped())
    pairs.push_back({d.a, d.b, whyOf(d.why)});
  for (const PairSamples& entry : samplePairs(scene, arguments.samples, arguments.seed)) {
    PairNames names = pairNames(scene, entry.pair);
    if (model.findLink(names.a) > model.findLink(names.b)) std::swap(names.a, names.b);
    const NamePair pair = std::minmax(names.a, names.b);
    if (never.count(pair) != 0) {
      pairs.push_back({names.a, names.b, Why::kNever});
      continue;
    }
    const bool is_nearly_always =
        arguments.samples >= kFewestSamples && entry.hits >= kNearlyAlways * arguments.samples;
    const Why why = always.count(pair) != 0                    ? Why::kAlways
                    : is_nearly_always                         ? Why::kNearlyAlways
                    : at_rest.count(pair) != 0                 ? Why::kRest
                    : entry.hits == 0 && arguments.samples > 0 ? Why::kSampled
                                                               : Why::kSome;
    pairs.push_back({names.a, names.b, why, entry.hits});
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const LinkPair& x, const LinkPair& y) { return x.why < y.why; });
  return pairs;
}

bool isProposed(const LinkPair& pair, const SrdfArguments& arguments) {
  return kindOf(pair.why).reason != nullptr || (arguments.sampled && pair.why == Why::kSampled);
}

std::string whyText(const LinkPair& pair, const SrdfArguments& arguments) {
  std::string text = kindOf(pair.why).text;
  if (pair.hits >= 0) text += fmt::format("; in {} of {} samples", pair.hits, arguments.samples);
  return text;
}

std::string xmlText(const std::string& name) {
  std::string text;
  for (const char c : name)
    text += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  return text;
}

std::string srdfText(const std::string& robot, const std::vector<LinkPair>& pairs,
                     const SrdfArguments& arguments) {
  std::string text = fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", xmlText(robot));
  const bool has_never = std::any_of(pairs.begin(), pairs.end(), [](const LinkPair& pair) {
    return pair.why == Why::kNever || pair.why == Why::kSampled;
  });
  if (has_never)
    text +=
        "  <!-- Pairs of reason \"Never\" touch nowhere within the joints' limits. Remove them "
        "where "
        "joints\n       stand outside, limits are widened, or such links keep a margin. -->\n";
  for (const LinkPair& pair : pairs)
    if (isProposed(pair, arguments)) {
      const char* const reason = kindOf(pair.why).reason;
      text += fmt::format(
          "  <disable_collisions link1=\"{}\" link2=\"{}\" reason=\"{}\"/>  <!-- {} -->\n",
          xmlText(pair.a), xmlText(pair.b), reason != nullptr ? reason : "Never",
          whyText(pair, arguments));
    }
  return text + "</robot>\n";
}

std::string yamlText(const std::vector<LinkPair>& pairs, const SrdfArguments& arguments) {
  std::string text;
  for (const LinkPair& pair : pairs)
    if (isProposed(pair, arguments) && kindOf(pair.why).in_problems)
      text += fmt::format("  - [{}, {}]  # {}\n", Json(pair.a).dump(), Json(pair.b).dump(),
                          whyText(pair, arguments));
  return text.empty() ? "allowed: []\n" : "allowed:\n" + text;
}

Json documentOf(const std::string& robot, const std::vector<LinkPair>& pairs,
                const SrdfArguments& arguments) {
  Json counts = Json::object(), list = Json::array();
  for (const Kind& kind : kKinds) counts[kind.word] = 0;
  for (const LinkPair& pair : pairs) {
    const char* const word = kindOf(pair.why).word;
    counts[word] = counts[word].get<int>() + 1;
    list.push_back({{"a", pair.a},
                    {"b", pair.b},
                    {"why", word},
                    {"hits", pair.hits >= 0 ? Json(pair.hits) : Json()},
                    {"proposed", isProposed(pair, arguments)}});
  }
  return {{"file", arguments.file}, {"robot", robot},   {"samples", arguments.samples},
          {"seed", arguments.seed}, {"counts", counts}, {"pairs", list}};
}

void printPairs(const std::vector<LinkPair>& pairs, const SrdfArguments& arguments) {
  std::size_t proposed = 0;
  for (const LinkPair& pair : pairs)
    if (isProposed(pair, arguments)) ++proposed;
  fmt::print("{} of {} pairs of links need no check; {} stay checked\n", proposed, pairs.size(),
             pairs.size() - proposed);
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    std::vector<const LinkPair*> of_kind;
    for (const LinkPair& pair : pairs)
      if (static_cast<std::size_t>(pair.why) == k) of_kind.push_back(&pair);
    if (of_kind.empty()) continue;
    constexpr std::size_t kIndent = 7;
    fmt::print("{}",
               wrapped(fmt::format("{:5}  {}: {}\n", of_kind.size(), kKinds[k].text,
                                   isProposed(*of_kind[0], arguments) ? "left out" : "checked"),
                       kIndent));
    for (const LinkPair* pair : of_kind)
      if (kKinds[k].named)
        fmt::print("{}",
                   wrapped(fmt::format("         {} with {}{}\n", pair->a, pair->b,
                                       pair->hits >= 0 ? fmt::format(" ({} of {} samples)",
                                                                     pair->hits, arguments.samples)
                                                       : ""),
                           kIndent + 4));
  }
}

int runSrdf(const SrdfArguments& arguments) {
  if (info::kindOf(arguments.file) != info::FileKind::kUrdf ||
      !(arguments.source.srdf + arguments.source.robot).empty())
    badUsage(
        "srdf looks at a robot alone; one URDF, MJCF or SDF file is expected, without an SRDF");
  if (!arguments.source.joint_limits.empty() || !arguments.source.bounds.empty())
    badUsage(
        "srdf proves what holds within the robot's own limits; it takes neither --joint-limits "
        "nor --bounds");
  static constexpr std::string_view kEndings[] = {".srdf", ".yaml", ".yml"};
  if (!arguments.output.empty()) {
    checkOutputFile(arguments.output, kEndings);
    expectApart(std::array{arguments.output}, std::array{arguments.file});
  }
  const planner::Problem problem =
      info::loadFile(arguments.file, info::FileKind::kUrdf, arguments.source);
  if (problem.robot.variables.empty())
    throw robots::InputError(arguments.file, 0,
                             "no joint can move; a robot whose links can meet is expected");
  const planner::CompiledScene scene(problem, interrupted);
  const std::string& robot = problem.robot.model->name;
  const std::vector<LinkPair> pairs = classify(scene, arguments);
  if (!arguments.output.empty())
    planner::writeFileWhole(arguments.output, arguments.output.ends_with(".srdf")
                                                  ? srdfText(robot, pairs, arguments)
                                                  : yamlText(pairs, arguments));
  if (arguments.json)
    printJson(documentOf(robot, pairs, arguments));
  else
    printPairs(pairs, arguments);
  return kYes;
}

}  // namespace

Verb addSrdf(CLI::App& command) {
  auto arguments = std::make_shared<SrdfArguments>();
  CLI::App* app = command.add_subcommand(
      "srdf", "propose which links of a robot need no check against each other");
  app->add_option("file", arguments->file, "URDF, MJCF or SDF file")->type_name("FILE")->required();
  addRobotArguments(*app, arguments->source);
  app->add_option("--output", arguments->output,
                  "write the pairs: .srdf, or .yaml with `allowed` of a problem file")
      ->type_name("FILE");
  addSamples(*app, "random configurations", arguments->samples, arguments->seed);
  app->add_flag("--sampled", arguments->sampled,
                "also leave out pairs that never touched in samples: nothing proves that they "
                "cannot");
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer("Example:\n  leeway srdf robots/arm6/arm6.urdf --output arm6.srdf");
  return {app, [arguments] { return runSrdf(*arguments); }};
}

}  // namespace leeway::tools
