#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_set>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/motion_bound.h"
#include "leeway/robots/named_states.h"
#include "leeway/robots/placed_model.h"
#include "planner/base/did_you_mean.h"
#include "planner/problem/fail_at.h"
#include "planner/problem/other_formats.h"
#include "planner/problem/read_deforming.h"
#include "planner/problem/read_meshes.h"
#include "planner/problem/read_motion.h"
#include "planner/problem/read_objective.h"
#include "planner/problem/read_poses.h"
#include "planner/problem/read_settings.h"
#include "planner/problem/read_shapes.h"
#include "planner/problem/read_states.h"
#include "planner/problem/read_steps.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"
#include "planner/yaml/yaml_reader.h"
#include "robots/base/read_file.h"
#include "robots/base/read_on.h"

namespace leeway::planner {
namespace {

using robots::InputError;
using robots::Model;

void requireVersion(const YamlReader& file) {
  const auto version = file.find("leeway");
  const bool is_of_moveit = file.has("robot_model_name") || file.has("group_name");
  if (!version && is_of_moveit)
    file.fail(
        "key 'leeway' is missing: as MoveIt writes scenes and requests; a problem file that names "
        "both under 'moveit' is expected, or --robot with `leeway batch` or `leeway lint`");
  if (!version)
    file.fail("key 'leeway' is missing: no problem file of this program; 'leeway: 1' is expected");
  if (!version->isScalar() || version->text() != "1")
    version->fail(fmt::format("problem format version '{}' is not known; 'leeway: 1' is expected",
                              version->isScalar() ? version->text() : "?"));
}

/// Calls load(path) with the path at `place`. Errors about that file as a whole also name `place`.
template <class Load>
auto loadNamedAt(const YamlReader& place, const Load& load) {
  const std::string path = resolvedPath(place);
  try {
    return load(path);
  } catch (const InputError& error) {
    const std::string head = path + ": ", what = error.what();
    if (error.line() > 0 || error.file() != path || !what.starts_with(head)) throw;
    throw InputError(
        path, 0,
        fmt::format("{} ({}:{} names it)", what.substr(head.size()), place.file(), place.line()));
  }
}

/// Reads `bounds:` of joints.
std::shared_ptr<const Model> bounded(std::shared_ptr<const Model> model, const YamlReader& bounds) {
  robots::JointBounds read;
  bounds.eachEntry([&](const std::string& joint, const YamlReader& given) {
    const auto add = [&](const std::string& axis, const YamlReader& range, bool widens) {
      const std::vector<double> ends = range.numbers();
      if (ends.size() != 2)
        range.fail(fmt::format("{} is a list of {}; [lower, upper] is expected", range.where(),
                               ends.size()));
      const robots::JointBound bound{
          ends[0], ends[1], widens,
          fmt::format("{} ({}:{})", axis.empty() ? given.where() : range.where(), range.file(),
                      range.line())};
      if (const std::string fault = robots::boundFault(*model, joint, axis, bound); !fault.empty())
        range.fail(fmt::format("{}: {}", range.where(), fault));
      read[joint].insert_or_assign(axis, bound);
    };
    if (given.isList()) return add("", given, false);
    if (!given.isMap())
      given.fail(
          fmt::format("{} is {}; [lower, upper], {{range: [lower, upper], widen: true}}, or "
                      "ranges of x, y and z are expected",
                      given.where(), given.isScalar() ? "'" + given.text() + "'" : "nothing"));
    if (given.isEmpty())
      given.fail(fmt::format("{}: {}", given.where(), robots::emptyFault(*model, joint)));
    given.expectKeys(keysOf("joint_bounds"));
    if (const auto range = given.find("range")) {
      const auto widen = given.find("widen");
      for (const auto& [key, value] : given.entries())
        if (key != "range" && key != "widen")
          value.fail(fmt::format("key '{}' stands beside 'range' in {}; one of them is expected",
                                 key, given.where()));
      return add("", *range, widen && widen->boolean());
    }
    if (const auto widen = given.find("widen"))
      widen->fail(
          fmt::format("{} has no 'range' beside it; {{range: [lower, upper], widen: true}} "
                      "is expected",
                      widen->where()));
    given.eachEntry(
        [&](const std::string& axis, const YamlReader& range) { add(axis, range, false); });
  });
  return robots::withBounds(*model, read);
}

/// Reads `position`, and `orientation` or `rpy`, of `robot:`.
std::shared_ptr<const Model> placed(std::shared_ptr<const Model> model, const YamlReader& robot,
                                    std::vector<std::string>& warnings) {
  std::optional<YamlReader> first;
  for (const char* key : {"rpy", "orientation", "position"})
    if (const auto found = robot.find(key)) first = found;
  if (!first) return model;
  const robots::Pose X_WB = readPose(robot, warnings);
  if (const std::string fault = robots::basePoseFault(*model, X_WB); !fault.empty())
    first->fail(fmt::format("{}: {}", first->where(), fault));
  return robots::withBasePose(*model, X_WB);
}

/// `packages` of `robot:`. Meshes of objects are found in them, too.
void readPackages(const YamlReader& packages, robots::LoadOptions& load) {
  packages.eachEntry([&](const std::string& name, const YamlReader& folder) {
    const std::string path = resolvedPath(folder);
    if (!std::filesystem::is_directory(path))
      folder.fail(fmt::format("package '{}' has no folder '{}'; an existing folder is expected",
                              name, path));
    load.packages.emplace_back(name, path);
  });
}

/// Loads the robot of a problem file, with its place and its bounds.
std::shared_ptr<const Model> loadRobot(const YamlReader& file, const YamlReader& robot,
                                       const ProblemOptions& options,
                                       std::vector<std::string>& warnings) {
  robot.expectKeys(keysOf("robot"));
  robots::LoadOptions load = options.load;
  if (const auto xacro = robot.find("xacro")) {
    // Arguments of the command line come last and take precedence.
    decltype(load.xacro) arguments;
    for (const auto& [name, value] : xacro->entries())
      arguments.emplace_back(name, value.anyText());
    load.xacro.insert(load.xacro.begin(), arguments.begin(), arguments.end());
  }
  if (const auto visual = robot.find("visual_as_collision"))
    load.visual_as_collision = load.visual_as_collision || visual->boolean();
  const auto expectFile = [](const YamlReader& named) {
    const std::string path = resolvedPath(named);
    std::error_code error;
    const bool is_folder = std::filesystem::is_directory(path, error);
    if (is_folder || (!std::filesystem::exists(path, error) && !error))
      named.fail(fmt::format("{} names '{}', which {}; an existing file is expected", named.where(),
                             path, is_folder ? "is a folder" : "does not exist"));
  };
  const YamlReader urdf = robot.at("urdf", "the path of a URDF");
  const auto srdf = robot.find("srdf");
  expectFile(urdf);
  if (srdf) expectFile(*srdf);
  const auto loaded = [&](const std::string& srdf_path) {
    return loadNamedAt(urdf, [&](const std::string& urdf_path) {
      return robots::loadModel(urdf_path, srdf_path, load);
    });
  };
  std::shared_ptr<const Model> model = srdf ? loadNamedAt(*srdf, loaded) : loaded("");
  if (const auto limits = robot.find("joint_limits"))
    limits->readOn([&] {
      expectFile(*limits);
      model = loadNamedAt(*limits, [&](const std::string& limits_path) {
        return withJointLimits(*model, limits_path, load);
      });
    });
  robot.readOn([&] { model = placed(model, robot, warnings); });
  if (const auto bounds = file.find("bounds"))
    bounds->readOn([&] { model = bounded(model, *bounds); });
  return model;
}

std::shared_ptr<const Model> loadBody(const YamlReader& body, std::vector<std::string>& warnings,
                                      const robots::LoadOptions& load) {
  body.expectKeys(keysOf("body"));
  const YamlReader joint = body.at("joint", "planar or floating");
  const bool planar = joint.text() == "planar";
  if (!planar && joint.text() != "floating")
    joint.fail(
        fmt::format("{} is '{}'; planar or floating is expected", joint.where(), joint.text()));
  const YamlReader bounds = body.at("bounds", "lower and upper corner of where its origin may be");
  bounds.expectKeys(keysOf("bounds"));
  const auto corner = [&](const char* key) {
    const YamlReader value = bounds.at(key, planar ? "[x, y] in m" : "[x, y, z] in m");
    if (!planar) return value.vector3();
    const std::vector<double> v = value.numbers();
    if (v.size() != 2)
      value.fail(fmt::format("{} is a list of {}; [x, y] is expected", value.where(), v.size()));
    return Eigen::Vector3d(v[0], v[1], 0);
  };
  const Eigen::Vector3d lower = corner("lower"), upper = corner("upper");
  if ((lower.array() > upper.array()).any())
    bounds.fail("body.bounds has lower above upper; lower <= upper is expected");
  const auto name = body.find("name");
  const std::string body_name = name ? name->text() : "body";
  body.at("shapes", "a list of shapes");
  return robots::freeBody(body_name, readGeometries(body, body_name, warnings, load),
                          planar ? robots::JointType::kPlanar : robots::JointType::kFloating, lower,
                          upper);
}

std::vector<std::string> linkNames(const Model& model) {
  std::vector<std::string> names;
  for (const robots::Link& link : model.links) names.push_back(link.name);
  return names;
}

/// `group` of `robot:`: one, or a list of those that are planned together.
std::vector<std::string> readGroupNames(const YamlReader& group) {
  if (!group.isList()) return {group.text()};
  std::vector<std::string> names;
  for (const YamlReader& name : group.items()) names.push_back(name.text());
  return names;
}

int readLink(const YamlReader& reader, const Model& model) {
  const int link = model.findLink(reader.text());
  if (link < 0)
    reader.fail(fmt::format("unknown link '{}' in {}{}", reader.text(), reader.where(),
                            didYouMean(reader.text(), linkNames(model))));
  return link;
}

/// Reads which link holds an object, and which links it may touch.
Attachment readAttachment(const YamlReader& attach, const Model& model) {
  attach.expectKeys(keysOf("attach"));
  Attachment attachment;
  attachment.link = readLink(attach.at("link", "the name of the link that holds it"), model);
  if (const auto touch = attach.find("touch"))
    for (const YamlReader& link : touch->items())
      attachment.touch_links.push_back(readLink(link, model));
  return attachment;
}

/// Reads the shapes, the cloud or the octree of an object.
void readBody(const YamlReader& map, const robots::LoadOptions& load, Problem& problem,
              Object& object) {
  const auto cloud = map.find("cloud"), octree = map.find("octree");
  const auto expectAlone = [&](std::string_view word, std::string_view other) {
    if (map.has(other))
      map.fail(fmt::format("{} has both '{}' and '{}'; one is expected", map.where(), word, other));
  };
  if (octree) {
    for (const std::string_view other : {"shapes", "cloud"}) expectAlone("octree", other);
    for (const std::string_view other : shapeWords()) expectAlone("octree", other);
    object.geometries = readOctree(*octree, object.name, problem.warnings, load.stop);
    return;
  }
  if (!cloud) {
    object.geometries = readGeometries(map, object.name, problem.warnings, load);
    return;
  }
  // A saved cloud keeps its unseen space as shapes.
  const bool is_saved = cloud->has("balls") && !cloud->has("carve");
  if (!is_saved) expectAlone("cloud", "shapes");
  expectAlone("cloud", "attach");
  for (const std::string_view other : shapeWords()) expectAlone("cloud", other);
  if (map.has("shapes"))
    object.geometries = readGeometries(map, object.name, problem.warnings, load);
  readCloud(*cloud, object, problem.warnings, load.stop);
}

void readObject(const YamlReader& map, std::unordered_set<std::string>& taken,
                const robots::LoadOptions& load, Problem& problem) {
  map.expectKeys(keysOf("object"));
  const YamlReader name = map.at("name", "a name of its own");
  const bool is_taken =
      !taken.insert(name.text()).second || problem.robot.model->findLink(name.text()) >= 0;
  if (const std::string fault = objectNameFault(name.text(), is_taken); !fault.empty())
    name.fail(fmt::format("{} '{}' {}", name.where(), name.text(), fault));
  Object object{name.text(), {}, {}};
  // If reading goes on after a fault in it, the object's name is still known.
  map.readOn([&] {
    if (const auto color = map.find("color")) object.color = readColor(*color);
    readBody(map, load, problem, object);
    object.X_WO = readPose(map, problem.warnings);
  });
  Attachment attachment;
  const auto attach = map.find("attach"), moving = map.find("moving");
  const bool is_held = attach && !problem.robot.model->links.empty() && attach->readOn([&] {
    if (moving)
      moving->fail(
          fmt::format("key 'moving' stands beside 'attach', with whose link '{}' moves; "
                      "one of them is expected",
                      name.text()));
    attachment = readAttachment(*attach, *problem.robot.model);
    if (!(extentOf(object) < kInfinity))
      attach->fail(fmt::format(
          "'{}' has a half-space, which is not held; shapes of bounded size are expected",
          name.text()));
  });
  if (!is_held) {
    problem.world.objects.push_back(std::move(object));
    return;
  }
  attachment.X_LO = std::exchange(object.X_WO, robots::Pose());
  attachment.object = std::move(object);
  problem.robot.attachments.push_back(std::move(attachment));
}

/// The names of all links and objects, and of groups of them.
struct KnownNames {
  explicit KnownNames(const Problem& problem)
      : things(problem), has_one_link(problem.robot.model->links.size() == 1) {
    std::vector<std::string>& robot = groups[kRobotWord];
    robot = linkNames(*problem.robot.model);
    for (const Attachment& held : problem.robot.attachments) robot.push_back(held.object.name);
  }
  Names things;
  bool has_one_link;
  std::map<std::string, std::vector<std::string>> groups;
};

void expectKnown(const YamlReader& item, const YamlReader& list, const KnownNames& known) {
  if (known.things.isKnown(item.text())) return;
  std::vector<std::string> groups;
  for (const auto& [name, members] : known.groups) groups.push_back(name);
  item.fail(fmt::format("{}: {}", list.where(), known.things.unknown(item.text(), groups)));
}

/// Reads groups of links and objects. A group stands for all of its members.
void readGroups(const YamlReader& groups, KnownNames& known) {
  groups.eachEntry([&](const std::string& name, const YamlReader& list) {
    if (const std::string fault = objectNameFault(name, known.things.isKnown(name)); !fault.empty())
      list.fail(fmt::format("group '{}' {}", name, fault));
    if (list.items().empty())
      list.fail(fmt::format("group '{}' is empty; names of links or objects are expected", name));
    std::vector<std::string>& members = known.groups[name];
    list.eachItem([&](const YamlReader& item) {
      if (const std::string member = item.text();
          known.groups.count(member) != 0 && !known.things.isKnown(member))
        item.fail(fmt::format("{}: '{}' is a group; names of links or objects are expected",
                              list.where(), member));
      expectKnown(item, list, known);
      members.push_back(item.text());
    });
  });
}

/// The pairs that two names of links, objects or groups stand for.
struct NamePairs {
  std::vector<std::pair<std::string, std::string>> pairs;
  std::string group = {};  ///< "robot and boxes", if one of them is a group
};

/// Reads two names. `takes_words`: whether kWorldWord stands for all objects, and kRobotWord also
/// for what the robot takes hold of later.
NamePairs readNamePairs(const YamlReader& pair, const KnownNames& known, bool takes_words = false) {
  const std::vector<YamlReader> items = pair.items();
  if (items.size() != 2)
    pair.fail(fmt::format("{} is no pair; two different names of links or objects are expected",
                          pair.where()));
  const std::string names[] = {items[0].text(), items[1].text()};
  NamePairs read;
  std::vector<std::string> sides[2];
  const auto isWorld = [](const std::string& name) { return name == kWorldWord; };
  const auto isRobot = [&](const std::string& name) {
    return takes_words && name == kRobotWord &&
           (!known.things.isKnown(kRobotWord) || known.has_one_link);
  };
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string& other = names[1 - i];
    // Words stay words, so that they also hold for objects that are added later.
    if (isRobot(names[i]) && !isWorld(other)) {
      sides[i] = {names[i]};
      read.group = names[0] + " and " + names[1];
      continue;
    }
    if (takes_words && (isWorld(names[i]) || isRobot(names[i]))) {
      const std::string& side = known.groups.count(other) != 0 && other != kRobotWord
                                    ? known.groups.at(other).front()
                                    : other;
      if (const std::string fault = known.things.marginFault(names[i], side); !fault.empty())
        items[i].fail(fmt::format("{}: {}", pair.where(), fault));
      sides[i] = {names[i]};
      if (other == kRobotWord || names[i] == kRobotWord) read.group = names[0] + " and " + names[1];
      continue;
    }
    const auto group = known.groups.find(names[i]);
    if (group == known.groups.end()) {
      expectKnown(items[i], pair, known);
      sides[i] = {names[i]};
      continue;
    }
    sides[i] = group->second;
    // The only link of a robot may have this name.
    if (names[i] == kRobotWord && sides[i].size() > 1 && known.things.isKnown(kRobotWord))
      items[i].fail(fmt::format(
          "{}: 'robot' is the name of a link, and stands for all links and what they hold; a "
          "group of the links that are meant is expected",
          pair.where()));
    read.group = names[0] + " and " + names[1];
  }
  // A group paired with itself means the pairs within it.
  if (names[0] == names[1] && read.group.empty())
    pair.fail(fmt::format("{}: {}", pair.where(), sameName(names[0])));
  for (const std::string& a : sides[0])
    for (const std::string& b : sides[1])
      if (isRobot(a) || (a != b && !(names[0] == names[1] && a > b))) read.pairs.emplace_back(a, b);
  if (read.pairs.empty())
    pair.fail(fmt::format("{}: '{}' and '{}' stand for one thing; two different ones are expected",
                          pair.where(), names[0], names[1]));
  return read;
}

void readObjects(const YamlReader& objects, const robots::LoadOptions& load, Problem& problem) {
  std::unordered_set<std::string> taken;
  for (const Object& object : problem.world.objects) taken.insert(object.name);
  for (const Attachment& held : problem.robot.attachments) taken.insert(held.object.name);
  objects.eachItem([&](const YamlReader& object) { readObject(object, taken, load, problem); });
}

/// Warns of a negative margin. Some are intended, for models that are larger than the robot, but
/// most are mistakes, and answers would still be certified.
void warnOfOverlap(double value, const YamlReader& margin, Problem& problem) {
  if (value < 0)
    problem.warnings.push_back(fmt::format("{}:{}: {} is {}: bodies may overlap by that much",
                                           margin.file(), margin.line(), margin.where(), value));
}

/// Reads a wish for the pairs of an entry of `margins`.
void readWish(const YamlReader& entry, const YamlReader& clearance, const NamePairs& read,
              double margin, Problem& problem) {
  Wish wish{read.group.empty() ? fmt::format("{} and {}", read.pairs[0].first, read.pairs[0].second)
                               : read.group,
            read.pairs, clearance.number()};
  if (const auto weight = entry.find("weight")) wish.weight = weight->number();
  if (const auto fault = wishFault(wish, entry.where())) failAt(entry, *fault);
  if (!(wish.clearance > margin))
    clearance.fail(fmt::format("{} is {}, no more than the margin {}; more is expected",
                               clearance.where(), wish.clearance, margin));
  problem.margins.wishes.push_back(std::move(wish));
}

void readPairMargin(const YamlReader& entry, const KnownNames& known, Problem& problem) {
  entry.expectKeys(keysOf("pair_margin"));
  if (const auto weight = entry.find("weight"); weight && !entry.find("wish"))
    weight->fail("key 'weight' stands without 'wish', whose weight it is; both are expected");
  const auto wish = entry.find("wish");
  const YamlReader between = entry.at("between", "two names");
  // (Wishes have no words.)
  const NamePairs read = readNamePairs(between, known, !wish);
  // An entry with only a wish keeps the margin as it is.
  double margin = problem.margins.common;
  if (!wish || entry.has("margin")) {
    const YamlReader given = entry.at("margin", "a number [m]");
    margin = given.number();
    warnOfOverlap(margin, given, problem);
    for (const auto& [a, b] : readNamePairs(between, known, true).pairs)
      problem.margins.pairs.push_back({a, b, margin, read.group});
  }
  if (wish) readWish(entry, *wish, read, margin, problem);
}

/// Reads `auto` in `allowed`.
void readAuto(const YamlReader& word, const robots::Stop& stop, Problem& problem) {
  // A robot without its meshes is never checked, so no pair has to be allowed.
  if (!problem.robot.model->lacks_meshes) allowTouching(problem, stop);
  std::string& warning = problem.warnings.back();
  warning = fmt::format("{}:{}: {}", word.file(), word.line(), warning);
}

/// Reads the pairs in `allowed`; returns where it says `auto`, which needs to know all other pairs.
std::vector<YamlReader> readAllowed(const YamlReader& allowed, const KnownNames& known,
                                    Problem& problem) {
  if (allowed.isScalar() && allowed.text() != "auto")
    allowed.fail(
        fmt::format("allowed is '{}'; 'auto' or a list of pairs is expected", allowed.text()));
  if (allowed.isScalar()) return {allowed};
  std::vector<YamlReader> words;
  allowed.eachItem([&](const YamlReader& pair) {
    if (pair.isScalar() && pair.text() == "auto") return words.push_back(pair);
    // (Beside `moveit`, they hold over its matrix.)
    allowPairs(readNamePairs(pair, known).pairs, problem.contacts);
  });
  return words;
}

void readChecked(const YamlReader& checked, const KnownNames& known, Problem& problem) {
  const Names names(problem);
  checked.eachItem([&](const YamlReader& pair) {
    for (auto& links : readNamePairs(pair, known).pairs) {
      if (const std::string fault = names.checkedFault(links.first, links.second); !fault.empty())
        pair.fail(fmt::format("{}: {}", pair.where(), fault));
      problem.contacts.checked.push_back(std::move(links));
    }
  });
}

void readPairs(const YamlReader& file, const LinkPadding& padding, const robots::Stop& stop,
               Problem& problem) {
  KnownNames known(problem);
  if (const auto groups = file.find("groups")) readGroups(*groups, known);
  if (const auto replace = file.find("replace_srdf"))
    problem.contacts.replace_srdf = replace->boolean();
  std::vector<YamlReader> words;
  if (const auto allowed = file.find("allowed")) words = readAllowed(*allowed, known, problem);
  if (const auto checked = file.find("checked")) readChecked(*checked, known, problem);
  for (const YamlReader& word : words) readAuto(word, stop, problem);
  if (const auto margin = file.find("margin"))
    warnOfOverlap(problem.margins.common, *margin, problem);
  applyLinkPadding(padding, problem);
  const auto margins = file.find("margins");
  if (!margins) return;
  margins->eachItem([&](const YamlReader& entry) { readPairMargin(entry, known, problem); });
}

/// Returns the names in `list`, with groups replaced by their members.
std::vector<std::string> readNames(const YamlReader& list, const KnownNames& known) {
  std::vector<std::string> names;
  for (const YamlReader& item : list.items()) {
    const auto group = known.groups.find(item.text());
    if (group != known.groups.end()) {
      names.insert(names.end(), group->second.begin(), group->second.end());
      continue;
    }
    expectKnown(item, list, known);
    names.push_back(item.text());
  }
  return names;
}

/// Filters the clouds, after all things that they may name are known.
void filterClouds(const YamlReader& file, Problem& problem) {
  const auto objects = file.find("objects");
  if (!objects) return;
  KnownNames known(problem);
  if (const auto groups = file.find("groups")) readGroups(*groups, known);
  objects->eachItem([&](const YamlReader& map) {
    const auto cloud = map.find("cloud"), name = map.find("name");
    if (!cloud || !name) return;  // an object without a name is an error that is known
    for (Object& object : problem.world.objects)
      if (object.name == name->text() && object.cloud) {
        const auto carve = cloud->find("carve");
        filterCloud(*cloud, carve ? readNames(*carve, known) : std::vector<std::string>(), problem,
                    object);
      }
  });
}

void readPlannerOf(const YamlReader& planner, Problem& problem) {
  planner.expectKeys(keysOf("planner"));
  readSettings(planner, "planner", problem);
  if (const auto name = planner.find("name"))
    if (const auto error = plannerError(problem.planner.name, {})) name->fail(*error);
  if (const auto parameters = planner.find("parameters"))
    parameters->eachEntry([&](const std::string& name, const YamlReader& value) {
      problem.planner.parameters[name] = value.text();
      if (const auto error = plannerError(problem.planner.name, {{name, value.text()}}))
        value.fail(*error);
    });
}

void readObjectiveOf(const YamlReader& objective, Problem& problem) {
  problem.objective = readObjective(objective);
  if (const auto fault = wishesFault(problem)) objective.fail(*fault);
}

void readLimits(const YamlReader& limits, Problem& problem) {
  limits.expectKeys(keysOf("limits"));
  readSettings(limits, "limits", problem);
}

void readPlanner(const YamlReader& file, Problem& problem) {
  const auto section = [&](const char* key, const auto& read) {
    if (const auto found = file.find(key)) found->readOn([&] { read(*found, problem); });
  };
  section("planner", readPlannerOf);
  section("objective", readObjectiveOf);
  if (const auto error = improveFault(problem))
    file.readOn([&] { file.find("planner")->find("parameters")->find("improve")->fail(*error); });
  section("limits", readLimits);
}

void readStartAndGoals(const YamlReader& file, bool needs_goal, Problem& problem) {
  VariableRanges passive;
  file.readOn([&] {
    if (const auto joints = file.find("joints")) passive = readPassiveJoints(*joints, problem);
  });
  file.readOn([&] {
    readStart(file.at("start", "a group state, a list of values or a map by joint"), passive,
              problem);
  });
  for (const std::string key : {"steps", "waypoints"}) {
    const auto task = file.find(key);
    if (!task) continue;
    for (const std::string_view other : {"goal", "goals", "waypoints"})
      if (other != key && file.has(other))
        task->fail(fmt::format("key '{}' stands beside '{}'; one of them is expected", key, other));
    if (key == "waypoints") return readWay(*task, problem);
    KnownNames known(problem);
    if (const auto groups = file.find("groups")) readGroups(*groups, known);
    return readSteps(
        *task, [&](const YamlReader& pair) { return readNamePairs(pair, known).pairs; }, problem);
  }
  const auto goal = file.find("goal"), goals = file.find("goals");
  if (!goal && !goals && !needs_goal) return;
  if (goal.has_value() == goals.has_value())
    file.fail(fmt::format("the file has {}; one of them is expected",
                          goal ? "both 'goal' and 'goals'" : "neither 'goal' nor 'goals'"));
  if (goal) {
    problem.goals.push_back(readGoal(*goal, "goal", problem));
    return;
  }
  if (goals->items().empty()) goals->fail("goals is empty; at least one goal is expected");
  int number = 0;
  goals->eachItem([&](const YamlReader& item) {
    problem.goals.push_back(readGoal(item, fmt::format("goal {}", ++number), problem));
  });
}

/// Reads robot, start, goals and objects from MoveIt's files. The problem file may add objects, but
/// must not repeat the rest.
Problem fromMoveit(const YamlReader& file, const YamlReader& moveit, const ProblemOptions& options,
                   LinkPadding& padding) {
  moveit.expectKeys(keysOf("moveit"));
  for (const char* key : {"body", "joints", "start", "goal", "goals", "steps", "waypoints"})
    if (const auto other = file.find(key))
      other->fail(fmt::format(
          "key '{}' stands beside 'moveit', whose request says it; one of them is expected", key));
  const YamlReader robot = file.at("robot", "urdf and srdf");
  for (const char* key : {"group", "chain"})
    if (const auto group = robot.find(key))
      group->fail(fmt::format(
          "key '{}' stands beside 'moveit', whose request names the group; one of them is "
          "expected",
          key));
  std::vector<std::string> warnings;
  const auto model = loadRobot(file, robot, options, warnings);
  const YamlReader scene = moveit.at("scene", "the path of a planning scene");
  const YamlReader request = moveit.at("request", "the path of a motion plan request");
  Problem problem = loadNamedAt(scene, [&](const std::string& scene_path) {
    return loadNamedAt(request, [&](const std::string& request_path) {
      return loadMoveitUnpadded(model, scene_path, request_path, options, padding);
    });
  });
  problem.warnings.insert(problem.warnings.begin(), warnings.begin(), warnings.end());
  return problem;
}

/// Keeps the name of a faulty deforming obstacle if reading goes on, because others may refer to
/// it.
void keepName(const YamlReader& entry, Problem& problem) {
  if (const auto name = entry.find("name")) problem.world.objects.push_back({name->text(), {}, {}});
}

Problem fromOwnKeys(const YamlReader& file, const ProblemOptions& options) {
  Problem problem;
  const auto robot = file.find("robot"), body = file.find("body");
  if (robot.has_value() == body.has_value())
    file.fail(fmt::format("the file has {}; one of them is expected",
                          robot ? "both 'robot' and 'body'" : "neither 'robot' nor 'body'"));
  if (const auto bounds = file.find("bounds"); body && bounds)
    bounds->fail("key 'bounds' stands beside 'body'; 'body.bounds' is expected");
  problem.robot.model = robot ? loadRobot(file, *robot, options, problem.warnings)
                              : loadBody(*body, problem.warnings, options.load);
  const auto group = robot ? robot->find("group") : std::nullopt;
  const auto chain = robot ? robot->find("chain") : std::nullopt;
  if (group && chain)
    chain->fail("keys 'group' and 'chain' both say what is planned; one of them is expected");
  const std::vector<std::string> all = {"all"};
  if (chain) {
    const std::vector<YamlReader> ends = chain->items();
    if (ends.size() != 2)
      chain->fail(chain->where() + " is not a pair of links; [BASE, TIP] is expected");
    takeChain(file.file(), chain->line(), ends[0].text(), ends[1].text(), problem);
  } else {
    takeGroups(file.file(),
               group   ? group->line()
               : robot ? robot->line()
                       : body->line(),
               group ? readGroupNames(*group) : all, problem);
  }
  problem.start = problem.robot.model->defaultConfiguration();
  return problem;
}

}  // namespace

Problem loadProblem(const std::string& yaml_path, const ProblemOptions& given) {
  if (robots::endingOf(yaml_path) == ".cfg") return loadOmplApp(yaml_path, given);
  ProblemOptions options = given;
  const robots::ErrorsSince wrong(options.load.errors);
  const YamlReader file = YamlReader::load(yaml_path, options.load.stop, options.load.errors);
  if (!file.isMap()) file.fail("is no map; a problem file (leeway: 1, ...) is expected");
  requireVersion(file);
  file.expectKeys(keysOf("problem"));
  std::set<std::string> meshes_found;
  const auto meshes = file.find("meshes");
  const bool gathers = given.load.meshes_found == nullptr;
  if (gathers && (meshes || !given.load.meshes.empty())) options.load.meshes_found = &meshes_found;
  if (meshes) {
    meshes->readOn([&] { readMeshes(*meshes, options.load); });
  }
  if (const auto robot = file.find("robot"); robot && robot->isMap())
    if (const auto packages = robot->find("packages"))
      packages->readOn([&] { readPackages(*packages, options.load); });
  const auto moveit = file.find("moveit");
  LinkPadding padding;
  Problem problem;
  const bool has_robot = file.readOn([&] {
    problem = moveit ? fromMoveit(file, *moveit, options, padding) : fromOwnKeys(file, options);
  });
  // If reading goes on without the robot, no name is a link.
  if (!has_robot) problem.robot.model = std::make_shared<const Model>(robots::RobotDescription());
  problem.name = std::filesystem::path(yaml_path).stem().string();
  readSettings(file, "", problem);
  const auto section = [&](const char* key, const auto& read) {
    if (const auto found = file.find(key)) found->readOn([&] { read(*found); });
  };
  section("objects",
          [&](const YamlReader& objects) { readObjects(objects, options.load, problem); });
  if (has_robot) {
    section("frames", [&](const YamlReader& frames) { readFrames(frames, problem); });
    section("execution", [&](const YamlReader& execution) { readExecution(execution, problem); });
  }
  // Their poses are those at the start of the execution.
  section("objects", [&](const YamlReader& objects) { readObjectMotions(objects, problem); });
  section("deforming", [&](const YamlReader& deforming) {
    deforming.eachItem([&](const YamlReader& entry) {
      robots::throwIfStopped(options.load.stop, "deforming obstacles were read");
      if (!entry.readOn([&] { readDeforming(entry, options.load, problem); }))
        entry.readOn([&] { keepName(entry, problem); });
    });
  });
  if (has_robot) {
    // Poses may be relative to anything that was read before.
    file.readOn([&] {
      if (!moveit) readStartAndGoals(file, options.needs_goal, problem);
    });
    file.readOn([&] { readPairs(file, padding, options.load.stop, problem); });
  }
  readPlanner(file, problem);
  // A crop depends on margins, wishes and costs.
  if (has_robot) file.readOn([&] { filterClouds(file, problem); });
  if (has_robot)
    section("constraints", [&](const YamlReader& list) { readConstraints(list, problem); });
  if (gathers) {
    if (meshes) file.readOn([&] { expectMeshesFound(*meshes, meshes_found, problem); });
    file.readOn([&] { expectMeshesFound(given.load, meshes_found, yaml_path, problem); });
  }
  wrong.throwFirst();
  warnOfOpenMeshes(yaml_path, problem);
  return validated(std::move(problem), yaml_path);
}

void allowTouching(Problem& problem, const robots::Stop& stop) {
  if (!problem.robot.model)
    throw InputError(problem.name, 0, "robot.model is missing; one of loadModel() is expected");
  const Model& model = *problem.robot.model;
  model.expectMeshes();
  std::vector<std::pair<int, int>> touching = robots::touchingAtRest(model, stop);
  const auto isChecked = [&](const std::pair<int, int>& links) {
    const std::string &a = model.links[at(links.first)].name,
                      &b = model.links[at(links.second)].name;
    return std::any_of(
        problem.contacts.checked.begin(), problem.contacts.checked.end(),
        [&](const auto& pair) { return pair == std::pair(a, b) || pair == std::pair(b, a); });
  };
  std::erase_if(touching, isChecked);
  std::string names;
  for (const auto& [a, b] : touching) {
    const std::string &name_a = model.links[at(a)].name, &name_b = model.links[at(b)].name;
    problem.contacts.allowed.emplace_back(name_a, name_b);
    names += fmt::format("{}{} and {}", names.empty() ? "" : "; ", name_a, name_b);
  }
  constexpr const char* kRest = "with all joints at zero (MJCF: qpos0), or at the nearest limit";
  problem.warnings.push_back(
      touching.empty()
          ? fmt::format("'auto' allows no pair of links: none touches {}", kRest)
          : fmt::format("'auto' allows {} of links, which touch {}: {}",
                        touching.size() == 1 ? "a pair" : fmt::format("{} pairs", touching.size()),
                        kRest, names));
}

Problem problemFromStates(std::shared_ptr<const Model> model, const std::string& group,
                          const std::string& start, const std::string& goal) {
  if (!model) throw InputError("", 0, "a model is missing; one of loadModel() is expected");
  Problem problem;
  problem.name = model->name;
  problem.robot.model = std::move(model);
  takeGroups("", 0, namedGroups(*problem.robot.model, group), problem);
  takeStates(start, goal, problem);
  validate(problem);
  return problem;
}

void takeStates(const std::string& start, const std::string& goal, Problem& problem) {
  problem.start = problem.robot.model->defaultConfiguration();
  takeStart("", 0, statedRanges("start", start, problem), problem);
  const VariableRanges ranges = statedRanges("goal", goal, problem);
  const auto states = robots::namedStates(*problem.robot.model);
  const bool is_named = std::any_of(states.begin(), states.end(),
                                    [&](const auto& state) { return state.name == goal; });
  problem.goals.push_back(takeGoal("", 0, is_named ? goal : "goal", ranges, problem));
  warnOfOthers(start, "start", problem);
  warnOfOthers(goal, "goal", problem);
}

}  // namespace leeway::planner
