// Reads OMPL.app's problems (.cfg): sections of `key = value`, with meshes next to the file. Keys
// mean what they mean to OMPL.app's benchmark program (ompl.kavrakilab.org/benchmark.html):
//
// - The robot's mesh is moved so that the mean of its vertices is the body's origin. In the plane,
//   this holds for x and y of the mean.
// - The bounds are those of the volume, else of the world. Start and goal widen them.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "planner/problem/fail_at.h"
#include "planner/problem/ompl_app/body_origin.h"
#include "planner/problem/other_formats.h"
#include "planner/problem/read_meshes.h"
#include "planner/problem/read_states.h"
#include "robots/base/files_read.h"
#include "robots/base/read_file.h"
#include "robots/mesh/mesh_import.h"

namespace leeway::planner {
namespace {

using robots::InputError;

constexpr std::size_t kShown = 40;  // of a wrong text [B]

const std::vector<std::string> kKeys = {
    "name",         "robot",        "world",        "objective",    "start.x",      "start.y",
    "start.z",      "start.theta",  "start.axis.x", "start.axis.y", "start.axis.z", "goal.x",
    "goal.y",       "goal.z",       "goal.theta",   "goal.axis.x",  "goal.axis.y",  "goal.axis.z",
    "volume.min.x", "volume.min.y", "volume.min.z", "volume.max.x", "volume.max.y", "volume.max.z"};
const std::vector<std::string> kBenchmarkKeys = {"time_limit", "mem_limit",  "run_count",
                                                 "output",     "save_paths", "description"};
/// How OMPL samples, steps and stops. Edges here have no resolution, and goals are reached exactly.
const std::set<std::string> kOfNoUse = {"objective.threshold",
                                        "threshold",
                                        "solution_length",
                                        "sampler",
                                        "longest_valid_segment_fraction",
                                        "projection.cellsize_factor"};
/// Keys of motions other than straight ones in SE(2) or SE(3).
const std::set<std::string> kRefused = {"control", "statespace"};

std::string_view trimmed(std::string_view text) {
  const auto isBlank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

/// The entries by section and key: "problem.start.x". Skips [planner], which may repeat keys.
class Config {
 public:
  struct Entry {
    std::string text;
    int line = 0;
  };

  explicit Config(std::string file) : file_(std::move(file)) {
    const std::string text = robots::readTextFile(file_, "an OMPL.app problem (.cfg)");
    std::string section;
    int line = 0;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      std::string_view row = std::string_view(text).substr(begin, end - begin);
      readLine(trimmed(row.substr(0, row.find('#'))), ++line, section);
      begin = end + 1;
    }
    if (entries_.lower_bound("problem.") == entries_.end())
      fail(0, "has no [problem]; an OMPL.app problem (.cfg) is expected");
  }

  const std::string& file() const { return file_; }
  const std::map<std::string, Entry>& entries() const { return entries_; }
  [[noreturn]] void fail(int line, const std::string& message) const {
    throw InputError(file_, line, message);
  }

  const Entry* find(const std::string& key) const {
    const auto entry = entries_.find("problem." + key);
    return entry == entries_.end() ? nullptr : &entry->second;
  }
  const Entry& at(const std::string& key, std::string_view accepted) const {
    const Entry* entry = find(key);
    if (entry == nullptr)
      fail(0, fmt::format("[problem] has no '{}'; {} is expected", key, accepted));
    return *entry;
  }
  double number(const std::string& key, std::string_view accepted) const {
    return numberOf(at(key, accepted), key, accepted);
  }
  double numberOf(const Entry& entry, const std::string& key, std::string_view accepted) const {
    const std::optional<double> value = robots::parseFinite(entry.text);
    if (!value)
      fail(entry.line,
           fmt::format("{} is '{}'; {} is expected", key, entry.text.substr(0, kShown), accepted));
    return *value;
  }

 private:
  void readLine(std::string_view row, int line, std::string& section) {
    if (row.empty()) return;
    if (row.front() == '[' && row.back() == ']') {
      section = std::string(trimmed(row.substr(1, row.size() - 2))) + ".";
      static const std::vector<std::string> kSections = {"problem", "planner", "benchmark"};
      if (std::find(kSections.begin(), kSections.end(), section.substr(0, section.size() - 1)) ==
          kSections.end())
        fail(line, fmt::format("unknown section {}{}", row.substr(0, kShown),
                               didYouMean(trimmed(row.substr(1, row.size() - 2)), kSections)));
      return;
    }
    const std::size_t equals = row.find('=');
    if (equals == std::string_view::npos)
      fail(line, fmt::format("'{}' is neither [section] nor key = value", row.substr(0, kShown)));
    const std::string key = section + std::string(trimmed(row.substr(0, equals)));
    if (key.starts_with("planner.")) return;
    const auto [entry, is_new] =
        entries_.insert({key, {std::string(trimmed(row.substr(equals + 1))), line}});
    if (!is_new)
      fail(line, fmt::format("'{}' again, after line {}; one value is expected",
                             key.substr(0, kShown), entry->second.line));
  }

  std::string file_;
  std::map<std::string, Entry> entries_;
};

class Loader {
 public:
  Loader(const std::string& path, const robots::Stop& stop) : config_(path), stop_(stop) {}

  Problem load() {
    checkKeys();
    const Config::Entry* name = config_.find("name");
    problem_.name =
        name != nullptr ? name->text : std::filesystem::path(config_.file()).stem().string();
    // These keys distinguish problems in space from planar ones, as in OMPL.app.
    for (const char* key : {"start.z", "goal.z", "start.axis.x", "goal.axis.x"})
      planar_ = planar_ && config_.find(key) == nullptr;
    start_ = pose("start");
    goal_ = pose("goal");
    readWorld();
    readRobot();
    takeStart(config_.file(), line("start.x"), ranges(start_), problem_);
    problem_.goals.push_back(
        takeGoal(config_.file(), line("goal.x"), "goal", ranges(goal_), problem_));
    readObjective();
    const auto time = config_.entries().find("benchmark.time_limit");
    if (time != config_.entries().end()) {
      problem_.limits.time = config_.numberOf(time->second, "time_limit", "seconds above 0");
      if (!(problem_.limits.time > 0))
        config_.fail(
            time->second.line,
            fmt::format("time_limit is {}; seconds above 0 are expected", problem_.limits.time));
    }
    return std::move(problem_);
  }

 private:
  int line(const std::string& key) const { return config_.find(key)->line; }

  /// Refuses keys that seem to be misspelt. Warns of other unknown keys.
  void checkKeys() {
    for (const auto& [full, entry] : config_.entries()) {
      const bool is_problem = full.starts_with("problem.");
      if (!is_problem && !full.starts_with("benchmark.")) continue;
      const std::string section = full.substr(0, full.find('.') + 1);
      const std::string key = full.substr(section.size());
      const std::vector<std::string>& known = is_problem ? kKeys : kBenchmarkKeys;
      if (is_problem && kRefused.count(key) != 0)
        config_.fail(entry.line,
                     fmt::format("{} = {}: only rigid bodies that move freely in SE(2) or SE(3) "
                                 "are planned; leave it out for such a one",
                                 key, entry.text.substr(0, kShown)));
      if ((is_problem && kOfNoUse.count(key) != 0) ||
          std::find(known.begin(), known.end(), key) != known.end())
        continue;
      const std::string name = key.substr(0, kShown);
      // If the nearest name is also given, this key is probably not a misspelling of it.
      const std::string* meant = robots::nearestName(key, known);
      if (meant != nullptr && config_.entries().count(section + *meant) == 0)
        config_.fail(entry.line, fmt::format("unknown key '{}' in [{}]; did you mean '{}'?", name,
                                             section.substr(0, section.size() - 1), *meant));
      problem_.warnings.push_back(fmt::format("{}:{}: '{}' has no effect{}", config_.file(),
                                              entry.line, name, didYouMean(key, known)));
    }
  }

  /// Reads x y angle, or x y z and a quaternion.
  std::vector<double> pose(const std::string& end) const {
    const auto number = [&](const char* key, const char* accepted) {
      return config_.number(end + key, accepted);
    };
    constexpr const char* kLength = "a length";
    const double x = number(".x", kLength), y = number(".y", kLength);
    const double angle = number(".theta", "an angle [rad]");
    if (planar_) return {x, y, angle};
    const double z = number(".z", kLength);
    constexpr const char* kAxis = "a part of the axis that theta turns about";
    Eigen::Vector3d axis;
    for (int i = 0; i < 3; ++i) axis[i] = number((std::string(".axis.") + "xyz"[i]).c_str(), kAxis);
    if (!(axis.norm() > 0) || !std::isfinite(axis.norm()))
      config_.fail(line(end + ".axis.x"),
                   fmt::format("{}.axis is {} {} {}; an axis with a length is expected", end,
                               axis.x(), axis.y(), axis.z()));
    const Eigen::Quaterniond q(Eigen::AngleAxisd(angle, axis.normalized()));
    return {x, y, z, q.x(), q.y(), q.z(), q.w()};
  }

  static VariableRanges ranges(const std::vector<double>& values) {
    VariableRanges given;
    for (const double value : values) given.push_back({true, value, value, 0});
    return given;
  }

  std::string meshFile(const Config::Entry& entry) const {
    const std::filesystem::path folder = std::filesystem::path(config_.file()).parent_path();
    std::string file = (folder / entry.text).string();
    robots::FilesRead::note(file);
    return file;
  }

  collision::Shape readMesh(const Config::Entry& entry) {
    robots::throwIfStopped(stop_, "meshes were read");
    robots::ImportedMesh mesh =
        robots::importForOmplApp(meshFile(entry), config_.file(), entry.line);
    problem_.warnings.insert(problem_.warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
    return mesh.shape;
  }

  void include(const Eigen::Vector3d& p) {
    lower_ = lower_.cwiseMin(p);
    upper_ = upper_.cwiseMax(p);
  }

  void readWorld() {
    const double infinity = std::numeric_limits<double>::infinity();
    lower_.setConstant(infinity);
    upper_.setConstant(-infinity);
    const bool has_volume = std::any_of(kKeys.begin(), kKeys.end(), [&](const std::string& key) {
      return key.starts_with("volume.") && config_.find(key) != nullptr;
    });
    for (int i = 0; i < (planar_ ? 2 : 3) && has_volume; ++i) {
      const std::string low = std::string("volume.min.") + "xyz"[i];
      const std::string high = std::string("volume.max.") + "xyz"[i];
      lower_[i] = config_.number(low, "a corner of where the origin may be");
      upper_[i] = config_.number(high, "a corner of where the origin may be");
      if (!(lower_[i] <= upper_[i]))
        config_.fail(line(low), fmt::format("{} is {}, above {}; lower <= upper is expected", low,
                                            lower_[i], upper_[i]));
    }
    if (const Config::Entry* world = config_.find("world")) {
      const collision::Shape mesh = readMesh(*world);
      for (const Eigen::Vector3d& v : mesh.mesh()->vertices())
        if (!has_volume) include(v);
      problem_.world.objects.push_back({"environment", {{mesh, {}, "environment"}}, {}});
    } else if (!has_volume) {
      config_.fail(0,
                   "[problem] has neither 'world' nor 'volume'; one of them bounds where the body "
                   "may go");
    }
    for (const std::vector<double>& end : {start_, goal_})
      include({end[0], end[1], planar_ ? 0 : end[2]});
  }

  void readRobot() {
    const Config::Entry& file = config_.at("robot", "the file of the body's mesh");
    const collision::Shape mesh = readMesh(file);
    robots::Pose X_LG;
    X_LG.translation = -bodyOrigin(meshFile(file), config_.file(), file.line);
    if (planar_) X_LG.translation.z() = 0;
    problem_.robot.model = robots::freeBody(
        "robot", {{mesh, X_LG, "robot"}},
        planar_ ? robots::JointType::kPlanar : robots::JointType::kFloating, lower_, upper_);
    for (int i = 0; i < static_cast<int>(problem_.robot.model->variables.size()); ++i)
      problem_.robot.variables.push_back(i);
    problem_.start = problem_.robot.model->defaultConfiguration();
  }

  void readObjective() {
    const Config::Entry* objective = config_.find("objective");
    if (objective == nullptr || objective->text == "length") return;
    if (objective->text != "max_min_clearance")
      config_.fail(objective->line,
                   fmt::format("objective is '{}'; length or max_min_clearance is expected",
                               objective->text.substr(0, kShown)));
    problem_.objective = MaximumClearance();
  }

  Config config_;
  robots::Stop stop_;
  Problem problem_;
  bool planar_ = true;
  std::vector<double> start_, goal_;
  Eigen::Vector3d lower_, upper_;
};

}  // namespace

Problem loadOmplApp(const std::string& path, const ProblemOptions& options) {
  Problem problem = Loader(path, options.load.stop).load();
  warnOfOpenMeshes(path, problem);
  return validated(std::move(problem), path);
}

}  // namespace leeway::planner
