#include "planner/compiled/prepared_robot.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/robots/input_error.h"
#include "planner/compiled/robot_pairs.h"
#include "robots/model/same_robot.h"

namespace leeway::planner {
namespace {

using robots::VariableRange;

/// Limits of planned variables, the start's values of the others.
std::vector<VariableRange> plannedRanges(const Problem& problem) {
  std::vector<VariableRange> ranges = robots::limitRanges(*problem.robot.model);
  std::vector<char> planned(ranges.size(), 0);
  for (const int v : problem.robot.variables) planned[at(v)] = 1;
  for (std::size_t v = 0; v < ranges.size(); ++v)
    if (!planned[v]) ranges[v] = {problem.start[v], problem.start[v]};
  return ranges;
}

// Comparison of the members that preparing reads.

bool isSame(const Attachment& x, const Attachment& y) {
  return x.object.name == y.object.name && x.link == y.link && x.touch_links == y.touch_links &&
         robots::isSamePose(x.X_LO, y.X_LO) &&
         robots::areSameGeometries(x.object.geometries, y.object.geometries);
}

std::vector<std::string> namesOf(const Contacts& contacts) {
  std::vector<std::string> names;
  for (const auto& [a, b] : contacts.allowed) {
    names.push_back(a);
    names.push_back(b);
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace

PreparedRobot::PreparedRobot(const Problem& problem, std::vector<VariableRange> ranges,
                             const ConfigurationSpace& space, const robots::Stop& stop)
    : robot_(*problem.robot.model),
      variables_(problem.robot.variables),
      ranges_(std::move(ranges)),
      attachments_(problem.robot.attachments),
      contacts_(problem.contacts),
      allowed_names_(namesOf(problem.contacts)) {
  RobotPairs pairs(problem, ranges_, stop);
  try {
    scene_ = pairs.builder().build();
  } catch (const std::invalid_argument& error) {
    throw robots::InputError(problem.name, 0, error.what());
  }
  carriers_ = pairs.carriers();
  unchecked_bodies_ = pairs.uncheckedBodies();
  warnings_ = pairs.takeWarnings();
  dropped_ends_ = pairs.takeDroppedEnds();
  dropped_ = std::make_shared<const std::vector<CompiledScene::Dropped>>(pairs.takeDropped());
  std::vector<const robots::LinkGap*> gaps;
  for (const collision::ScenePair& pair : scene_.pairs())
    gaps.push_back(pairs.linkGap(pair.body_a, pair.body_b));
  motions_ = makeRobotMotions(space, scene_, carriers_, ranges_, gaps);
}

const char* PreparedRobot::differenceFrom(const Problem& problem) const {
  return differenceFrom(problem, plannedRanges(problem));
}

const char* PreparedRobot::differenceFrom(const Problem& problem,
                                          std::span<const VariableRange> ranges) const {
  const auto isSameRange = [](const VariableRange& x, const VariableRange& y) {
    return x.lower == y.lower && x.upper == y.upper;
  };
  const auto &of_mine = attachments_, &of_other = problem.robot.attachments;
  if (!robots::isSameRobot(robot_, *problem.robot.model)) return "robot.model";
  if (variables_ != problem.robot.variables) return "robot.variables";
  if (!std::equal(ranges_.begin(), ranges_.end(), ranges.begin(), ranges.end(), isSameRange))
    return "start, in a variable that is not planned,";
  if (!std::equal(of_mine.begin(), of_mine.end(), of_other.begin(), of_other.end(),
                  [](const auto& x, const auto& y) { return isSame(x, y); }))
    return "robot.attachments";
  if (contacts_.replace_srdf != problem.contacts.replace_srdf ||
      contacts_.allowed != problem.contacts.allowed ||
      contacts_.checked != problem.contacts.checked)
    return "contacts";
  return nullptr;
}

std::shared_ptr<const PreparedRobot> PreparedRobot::of(const Problem& problem,
                                                       const ConfigurationSpace& space,
                                                       const robots::Stop& stop) {
  problem.robot.model->expectMeshes();
  std::vector<VariableRange> ranges = plannedRanges(problem);
  const auto fits = [&](const robots::PreparedStore::Entry& entry) {
    const auto* robot = dynamic_cast<const PreparedRobot*>(&entry);
    return robot != nullptr && robot->differenceFrom(problem, ranges) == nullptr;
  };
  const robots::PreparedStore& store = problem.robot.model->prepared;
  std::shared_ptr<const robots::PreparedStore::Entry> entry = store.find(fits);
  if (!entry) {
    std::shared_ptr<const PreparedRobot> robot(new PreparedRobot(problem, ranges, space, stop));
    entry = store.keep(std::move(robot), fits);
  }
  return std::static_pointer_cast<const PreparedRobot>(entry);
}

bool PreparedRobot::isAllowedName(const std::string& name) const {
  return std::binary_search(allowed_names_.begin(), allowed_names_.end(), name);
}

const RobotLanes& PreparedRobot::lanes(const robots::Model& model) const {
  std::call_once(lanes_once_, [&] {
    const RobotLanes::Source source{scene_, carriers_, motions_, variables_, ranges_};
    lanes_ = std::make_unique<const RobotLanes>(model, source);
  });
  return *lanes_;
}

}  // namespace leeway::planner
