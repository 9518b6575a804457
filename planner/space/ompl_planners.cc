#include "planner/space/ompl_planners.h"

#include <fmt/format.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/planners/AnytimePathShortening.h>
#include <ompl/geometric/planners/cforest/CForest.h>
#include <ompl/geometric/planners/est/BiEST.h>
#include <ompl/geometric/planners/est/EST.h>
#include <ompl/geometric/planners/est/ProjEST.h>
#include <ompl/geometric/planners/fmt/BFMT.h>
#include <ompl/geometric/planners/fmt/FMT.h>
#include <ompl/geometric/planners/informedtrees/ABITstar.h>
#include <ompl/geometric/planners/informedtrees/AITstar.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/kpiece/BKPIECE1.h>
#include <ompl/geometric/planners/kpiece/KPIECE1.h>
#include <ompl/geometric/planners/kpiece/LBKPIECE1.h>
#include <ompl/geometric/planners/pdst/PDST.h>
#include <ompl/geometric/planners/prm/LazyPRM.h>
#include <ompl/geometric/planners/prm/LazyPRMstar.h>
#include <ompl/geometric/planners/prm/PRM.h>
#include <ompl/geometric/planners/prm/PRMstar.h>
#include <ompl/geometric/planners/prm/SPARS.h>
#include <ompl/geometric/planners/prm/SPARStwo.h>
#include <ompl/geometric/planners/rlrt/BiRLRT.h>
#include <ompl/geometric/planners/rlrt/RLRT.h>
#include <ompl/geometric/planners/rrt/BiTRRT.h>
#include <ompl/geometric/planners/rrt/InformedRRTstar.h>
#include <ompl/geometric/planners/rrt/LBTRRT.h>
#include <ompl/geometric/planners/rrt/LazyRRT.h>
#include <ompl/geometric/planners/rrt/RRT.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTXstatic.h>
#include <ompl/geometric/planners/rrt/RRTsharp.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/geometric/planners/rrt/SORRTstar.h>
#include <ompl/geometric/planners/rrt/TRRT.h>
#include <ompl/geometric/planners/rrt/pRRT.h>
#include <ompl/geometric/planners/sbl/SBL.h>
#include <ompl/geometric/planners/sbl/pSBL.h>
#include <ompl/geometric/planners/sst/SST.h>
#include <ompl/geometric/planners/stride/STRIDE.h>
#include <ompl/util/Exception.h>
#include <ompl/util/RandomNumbers.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>

#include "leeway/planner/ompl_connect.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/space/ompl_lock.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

using Factory = std::function<ob::PlannerPtr(const ob::SpaceInformationPtr&)>;

struct Entry {
  PlannerTraits traits;
  Factory make;
};

constexpr bool kSeeded = true, kUnseeded = false;
constexpr bool kOptimizing = true, kFirst = false;
/// Largest number of workers, and of threads, in a problem [count]. Each worker has its own
/// certifier.
constexpr int kMostWorkers = 64;

constexpr bool kCells = true, kNoCells = false;

template <typename Planner>
Entry entry(const char* name, bool deterministic, bool optimizing, bool projection,
            const char* summary) {
  // SST's steps are random and never aim at a goal.
  const bool exact = !std::is_same_v<Planner, og::SST>;
  // LazyPRM*'s A* adds and subtracts costs, and throws if they do not add up.
  const bool any_cost = !std::is_same_v<Planner, og::LazyPRMstar>;
  // LBTRRT adds up distances for every objective.
  const bool costs = !std::is_same_v<Planner, og::LBTRRT>;
  return {{name, deterministic, optimizing, any_cost, costs, projection, exact, summary},
          [](const ob::SpaceInformationPtr& si) { return std::make_shared<Planner>(si); }};
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list = {
      entry<OmplConnect>(kOwnPlanner, kSeeded, kFirst, kNoCells,
                         "two balanced trees with dynamic domains, our own (default)"),
      entry<og::RRTConnect>("RRTConnect", kSeeded, kFirst, kNoCells,
                            "two trees that grow towards each other"),
      entry<og::RRT>("RRT", kSeeded, kFirst, kNoCells, "one rapidly exploring random tree"),
      entry<og::LazyRRT>("LazyRRT", kSeeded, kFirst, kNoCells,
                         "a tree whose edges are checked once it reaches a goal"),
      entry<og::TRRT>("TRRT", kSeeded, kFirst, kNoCells, "a tree that avoids costly states"),
      entry<og::BiTRRT>("BiTRRT", kSeeded, kFirst, kNoCells, "two trees that avoid costly states"),
      entry<og::RRTstar>("RRTstar", kSeeded, kOptimizing, kNoCells,
                         "a tree that rewires itself to better paths"),
      entry<og::RRTsharp>("RRTsharp", kSeeded, kOptimizing, kNoCells,
                          "RRT* with relaxation of the whole tree"),
      entry<og::RRTXstatic>("RRTXstatic", kSeeded, kOptimizing, kNoCells,
                            "RRT# with an epsilon-consistent graph"),
      entry<og::InformedRRTstar>("InformedRRTstar", kSeeded, kOptimizing, kNoCells,
                                 "RRT* that samples where a better path can be"),
      entry<og::SORRTstar>("SORRTstar", kSeeded, kOptimizing, kNoCells,
                           "RRT* that sorts its samples by what they promise"),
      // OMPL 1.5.2 never sets the start's lower bound, and compares uninitialised memory.
      entry<og::LBTRRT>("LBTRRT", kUnseeded, kOptimizing, kNoCells,
                        "between RRT and RRT*: a lower bound decides what to rewire"),
      entry<og::EST>("EST", kSeeded, kFirst, kNoCells, "expansive tree, density by neighbours"),
      entry<og::BiEST>("BiEST", kSeeded, kFirst, kNoCells, "two expansive trees"),
      entry<og::ProjEST>("ProjEST", kSeeded, kFirst, kCells,
                         "expansive tree, density by projection"),
      entry<og::KPIECE1>("KPIECE1", kSeeded, kFirst, kCells, "exploration from the border cells"),
      entry<og::BKPIECE1>("BKPIECE1", kSeeded, kFirst, kCells, "KPIECE with two trees"),
      entry<og::LBKPIECE1>("LBKPIECE1", kSeeded, kFirst, kCells, "lazy KPIECE with two trees"),
      entry<og::PDST>("PDST", kSeeded, kFirst, kCells, "path-directed subdivision of cells"),
      entry<og::STRIDE>("STRIDE", kSeeded, kFirst, kNoCells,
                        "expansive tree, density by a nearest-neighbour structure"),
      entry<og::SBL>("SBL", kSeeded, kFirst, kCells, "two lazy trees over cells"),
      entry<og::SST>("SST", kSeeded, kOptimizing, kNoCells, "stable sparse tree"),
      entry<og::RLRT>("RLRT", kSeeded, kFirst, kNoCells, "range-less random tree"),
      entry<og::BiRLRT>("BiRLRT", kSeeded, kFirst, kNoCells, "two range-less random trees"),
      entry<og::FMT>("FMT", kSeeded, kFirst, kNoCells,
                     "a tree marched over a fixed number of samples"),
      entry<og::BFMT>("BFMT", kSeeded, kFirst, kNoCells, "FMT* from both ends"),
      entry<og::BITstar>("BITstar", kSeeded, kOptimizing, kNoCells,
                         "batches of samples, searched best first"),
      entry<og::ABITstar>("ABITstar", kSeeded, kOptimizing, kNoCells,
                          "BIT* with inflated and truncated search"),
      entry<og::AITstar>("AITstar", kSeeded, kOptimizing, kNoCells,
                         "BIT* with a heuristic that adapts to the problem"),
      entry<og::LazyPRM>("LazyPRM", kSeeded, kFirst, kNoCells,
                         "a roadmap whose edges are checked when a path needs them"),
      entry<og::LazyPRMstar>("LazyPRMstar", kSeeded, kOptimizing, kNoCells,
                             "LazyPRM with the connections of PRM*"),
      entry<og::PRM>("PRM", kUnseeded, kFirst, kNoCells, "a roadmap, in two threads"),
      entry<og::PRMstar>("PRMstar", kUnseeded, kOptimizing, kNoCells,
                         "a roadmap that tends to the best path, in two threads"),
      entry<og::SPARS>("SPARS", kUnseeded, kFirst, kNoCells,
                       "a sparse roadmap above a dense one, in two threads"),
      entry<og::SPARStwo>("SPARStwo", kUnseeded, kFirst, kNoCells,
                          "a sparse roadmap, in two threads"),
      entry<og::pRRT>("pRRT", kUnseeded, kFirst, kNoCells, "RRT, one tree grown by threads"),
      entry<og::pSBL>("pSBL", kUnseeded, kFirst, kCells, "SBL, trees grown by threads"),
      entry<og::CForest>("CForest", kUnseeded, kOptimizing, kNoCells,
                         "RRT* trees in threads that share paths"),
      entry<og::AnytimePathShortening>("AnytimePathShortening", kUnseeded, kOptimizing, kNoCells,
                                       "planners in threads, their paths shortened and crossed"),
  };
  return list;
}

/// Converts to lower case, and * to the word "star" of OMPL's class names.
std::string normalizedName(std::string_view name) {
  std::string result;
  for (const char c : name) {
    if (c == '*')
      result += "star";
    else
      result += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return result;
}

const Entry* find(std::string_view name) {
  const std::string wanted = normalizedName(name);
  for (const Entry& e : entries())
    if (normalizedName(e.traits.name) == wanted) return &e;
  return nullptr;
}

/// A space for planners that are made only to list their parameters.
ob::SpaceInformationPtr smallSpace() {
  auto space = std::make_shared<ob::RealVectorStateSpace>(2);
  space->setBounds(0, 1);
  return std::make_shared<ob::SpaceInformation>(space);
}

/// "10." as "10".
std::string withoutDot(std::string number) {
  if (number.ends_with('.')) number.pop_back();
  return number;
}

std::string accepted(const ob::GenericParam& parameter) {
  const std::string& suggestion = parameter.getRangeSuggestion();
  if (suggestion.empty()) return "a number is expected, e.g. " + parameter.getValue();
  if (suggestion == "0,1") return "true or false is expected";
  // OMPL writes "first:step:last".
  const std::size_t first = suggestion.find(':'), last = suggestion.rfind(':');
  return "a number from " + withoutDot(suggestion.substr(0, first)) + " to " +
         withoutDot(suggestion.substr(last + 1)) + " is expected";
}

/// Sets a parameter and reads it back, because OMPL reads "1.5x" as 1.5 and "-1" as 4294967295, and
/// keeps any value that a setter sets.
std::optional<std::string> setParameter(ob::Planner& planner, const std::string& key,
                                        const std::string& value) {
  ob::ParamSet& parameters = planner.params();
  if (!parameters.hasParam(key)) {
    std::vector<std::string> names;
    parameters.getParamNames(names);
    if (names.empty()) return "planner parameter '" + key + "' is unknown: the planner has none";
    return "planner parameter '" + key + "' is unknown" + didYouMean(key, names);
  }
  ob::GenericParam& parameter = parameters[key];
  const std::string wrong = "planner parameter '" + key + "' cannot be '" + value + "'; ";
  // The only parameter that is not a number: AnytimePathShortening's list of planners.
  if (key == "planners") {
    if (!parameter.setValue(value)) return wrong + "planner names with commas between are expected";
    return std::nullopt;
  }
  const std::optional<double> meant = parameterNumber(value);
  const std::string& suggestion = parameter.getRangeSuggestion();
  const bool flag = suggestion == "0,1";
  if (!meant || (flag && *meant != 0 && *meant != 1)) return wrong + accepted(parameter);
  if (*meant < 0 && suggestion.find('-') == std::string::npos) return wrong + accepted(parameter);
  try {
    if (!parameter.setValue(flag ? (*meant == 1 ? "1" : "0") : value))
      return wrong + accepted(parameter);
  } catch (const std::exception&) {
    return wrong + accepted(parameter);
  }
  const std::optional<double> kept = parameterNumber(parameter.getValue());
  if (kept && std::abs(*kept - *meant) > kParameterDigits * std::abs(*meant))
    return wrong + accepted(parameter);
  return std::nullopt;
}

/// Parameters of our own planner that plan() supports, and OMPL's interface does not.
const std::vector<PlannerParameter>& ownParameters(const Entry& e) {
  static const std::vector<PlannerParameter> none,
      own = {{"improve", "0", "0.:1.:60."}, {"threads", "0", "0:1:64"}, {"workers", "1", "1:1:64"}};
  return e.traits.name == kOwnPlanner ? own : none;
}

/// Whether `key` is one of these; `error` describes a mistake in its value.
bool isOwnParameter(const Entry& e, const std::string& key, const std::string& value,
                    std::optional<std::string>& error) {
  for (const PlannerParameter& parameter : ownParameters(e)) {
    if (parameter.name != key) continue;
    const double least = parameter.name == "workers" ? 1 : 0;
    const std::optional<double> meant = parameterNumber(value);
    if (parameter.name == "improve") {
      if (!meant || !(*meant >= 0))
        error = "planner parameter 'improve' cannot be '" + value +
                "'; seconds, 0 or more, are expected";
      return true;
    }
    if (!meant || !(*meant >= least && *meant <= kMostWorkers) || *meant != std::floor(*meant))
      error = fmt::format(
          "planner parameter '{}' cannot be '{}'; a whole number from {} to {} is expected", key,
          value, static_cast<int>(least), kMostWorkers);
    return true;
  }
  return false;
}

std::string unknownPlanner(const std::string& name) {
  std::vector<std::string> names;
  for (const PlannerTraits& traits : plannerNames()) names.push_back(traits.name);
  return "planner '" + name + "' is unknown" + didYouMean(name, names);
}

}  // namespace

std::optional<double> parameterNumber(std::string_view text) {
  if (text == "true" || text == "True" || text == "TRUE") return 1;
  if (text == "false" || text == "False" || text == "FALSE") return 0;
  return robots::parseFinite(text);
}

const std::vector<PlannerTraits>& plannerNames() {
  static const std::vector<PlannerTraits> names = [] {
    std::vector<PlannerTraits> result;
    for (const Entry& e : entries()) result.push_back(e.traits);
    return result;
  }();
  return names;
}

const PlannerTraits* findPlanner(std::string_view name) {
  const Entry* e = find(name);
  return e == nullptr ? nullptr : &e->traits;
}

std::vector<PlannerParameter> plannerParameters(std::string_view name) {
  std::vector<PlannerParameter> result;
  const Entry* e = find(name);
  if (e == nullptr) return result;
  const QuietOmpl quiet;
  const std::lock_guard<std::recursive_mutex> lock(omplSeedLock());
  const ob::PlannerPtr planner = e->make(smallSpace());
  for (const auto& [key, parameter] : planner->params().getParams())
    result.push_back({key, parameter->getValue(), parameter->getRangeSuggestion()});
  for (const PlannerParameter& own : ownParameters(*e)) result.push_back(own);
  std::sort(result.begin(), result.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return result;
}

std::optional<std::string> plannerError(const std::string& name,
                                        const std::map<std::string, std::string>& parameters) {
  const Entry* e = find(name);
  if (e == nullptr) return unknownPlanner(name);
  if (parameters.empty()) return std::nullopt;
  const QuietOmpl quiet;
  const std::lock_guard<std::recursive_mutex> lock(omplSeedLock());
  const ob::PlannerPtr planner = e->make(smallSpace());
  for (const auto& [key, value] : parameters) {
    std::optional<std::string> error;
    if (!isOwnParameter(*e, key, value, error)) error = setParameter(*planner, key, value);
    if (error) return error;
  }
  return std::nullopt;
}

ob::PlannerPtr makePlanner(const std::string& name,
                           const std::map<std::string, std::string>& parameters,
                           const ob::SpaceInformationPtr& space_information) {
  const Entry* e = find(name);
  if (e == nullptr) throw std::invalid_argument(unknownPlanner(name));
  ob::PlannerPtr planner = e->make(space_information);
  for (const auto& [key, value] : parameters) {
    std::optional<std::string> error;
    if (!isOwnParameter(*e, key, value, error)) error = setParameter(*planner, key, value);
    if (error) throw std::invalid_argument(*error);
  }
  return planner;
}

void seedOmpl(std::uint64_t seed) {
  // setSeed() warns if seeds were given out before, but takes the seed; it refuses only 0. Every
  // width of uint_fast32_t and the generator behind it keep thirty-one bits.
  const std::uint64_t mixed = (seed ^ (seed >> 31) ^ (seed >> 62)) & 0x7fffffffu;
  ompl::RNG::setSeed(mixed == 0 ? 0x7fffffffu : static_cast<std::uint_fast32_t>(mixed));
}

}  // namespace leeway::planner
