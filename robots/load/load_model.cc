// From description files to a Model.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/collision/shape.h"
#include "leeway/robots/input_error.h"
#include "robots/base/interruptible.h"
#include "robots/base/read_on.h"
#include "robots/base/tolerances.h"
#include "robots/cache/content_key.h"
#include "robots/cache/disk_cache.h"
#include "robots/load/fit_primitive.h"
#include "robots/load/read_document.h"
#include "robots/mesh/mesh_import.h"
#include "robots/mesh/mesh_path.h"
#include "robots/mesh/mesh_treatment.h"
#include "robots/model/model_builder.h"
#include "robots/motion/gap_file.h"
#include "robots/motion/kept_proofs.h"
#include "robots/motion/link_gaps.h"
#include "robots/urdf/srdf.h"
#include "robots/urdf/urdf_document.h"
#include "robots/urdf/xacro.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

namespace {

using collision::Shape;

/// Loads each mesh file once for each scale.
class Meshes {
 public:
  Meshes(const std::string& urdf_path, const LoadOptions& options)
      : urdf_path_(urdf_path), options_(options), cache_(options.cache) {}

  /// Loads all meshes of the links in parallel. Each is independent of the others, so the number of
  /// threads changes nothing. load() reports failures, in the order of the links. Throws Stopped.
  void loadAll(const UrdfDocument& document, const std::vector<std::pair<int, int>>& order) {
    for (const auto& [link, joint] : order)
      for (const UrdfCollision& collision : document.links[at(link)].collisions)
        if (collision.kind == UrdfCollision::Kind::kMesh) addTask(collision);
    // Largest first: else one thread may end with it alone.
    std::stable_sort(tasks_.begin(), tasks_.end(),
                     [](const Task& l, const Task& r) { return l.bytes > r.bytes; });
    if (tasks_.empty()) return;
    std::uintmax_t bytes = 0;
    for (const Task& task : tasks_) bytes += task.bytes;
    throwIfStopped(options_.stop, "meshes were read");
    workInterruptibly(bytes < kWorthAsking ? Stop() : options_.stop,
                      [&](const Stop& asked) { runAll(asked); });
  }

  /// The warnings of a mesh come with its first use.
  Shape load(const UrdfCollision& collision, const std::string& link,
             std::vector<std::string>& warnings) {
    Loaded& loaded = loaded_.at(keyOf(collision, &warnings));
    if (loaded.error) std::rethrow_exception(loaded.error);
    keys_.push_back(loaded.mesh->key);
    for (std::string& warning : loaded.mesh->warnings) warnings.push_back(std::move(warning));
    loaded.mesh->warnings.clear();
    const auto names = {std::string_view(link), std::string_view(collision.mesh_file)};
    static constexpr MeshTreatment kHull{MeshTreatment::Solid::kHull, 0};
    const MeshTreatment* treatment = treatmentOf(options_, names);
    if (treatment == nullptr && collision.is_hull) treatment = &kHull;
    if (treatment == nullptr) return loaded.mesh->shape;
    // Proofs about the robot are kept by what its meshes are.
    if (!keys_.back().empty()) {
      ContentKey key("treated");
      key.add(keys_.back());
      key.add(static_cast<double>(treatment->solid));
      key.add(treatment->weld);
      keys_.back() = key.finish();
    }
    return withTreatment(loaded.mesh->shape, *treatment);
  }

  /// The primitive that is fitted to a mesh.
  UrdfCollision fitted(const UrdfCollision& collision, std::vector<std::string>& warnings) const {
    const IndexedMesh mesh =
        importTriangles(std::get<0>(keyOf(collision, &warnings)), Eigen::Vector3d::Ones(),
                        collision.file, collision.line, options_.stop);
    warnings.insert(warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
    return fittedPrimitive(collision, mesh);
  }

  const DiskCache& cache() const { return cache_; }
  const Stop& stop() const { return options_.stop; }
  /// ImportedMesh::key of each call of load().
  const std::vector<std::string>& keys() const { return keys_; }

 private:
  using Key = std::tuple<std::string, double, double, double>;
  struct Loaded {
    std::optional<ImportedMesh> mesh;
    std::exception_ptr error;
  };
  struct Task {
    Key key;
    const UrdfCollision* collision;  // the first that names it
    std::uintmax_t bytes;
    Loaded* result;
  };
  // More threads would wait for memory, or for the largest mesh.
  static constexpr std::size_t kMostThreads = 8;

  /// Throws for a file that is not found.
  Key keyOf(const UrdfCollision& collision, std::vector<std::string>* warnings = nullptr) const {
    const Eigen::Vector3d& scale = collision.mesh_scale;
    const std::string& from = collision.mesh_from.empty() ? urdf_path_ : collision.mesh_from;
    return {resolveMesh(collision.mesh_file, from, collision.line, options_, warnings), scale.x(),
            scale.y(), scale.z()};
  }

  void addTask(const UrdfCollision& collision) {
    Key key;
    try {
      key = keyOf(collision);
    } catch (const InputError&) {
      return;  // load() throws it again
    }
    const auto [place, is_new] = loaded_.try_emplace(key);
    if (!is_new) return;
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(std::get<0>(key), error);
    tasks_.push_back({key, &collision, error ? 0 : bytes, &place->second});
  }

  /// `asked` may be called from any thread.
  void runAll(const Stop& asked) const {
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
      for (std::size_t i = next++; i < tasks_.size(); i = next++) run(tasks_[i], asked);
    };
    const std::size_t most =
        std::min<std::size_t>(std::thread::hardware_concurrency(), kMostThreads);
    std::vector<std::thread> threads;
    threads.reserve(most);
    try {
      while (threads.size() + 1 < std::min(most, tasks_.size())) threads.emplace_back(work);
    } catch (const std::system_error&) {  // fewer threads do it
    }
    work();
    for (std::thread& thread : threads) thread.join();
    if (!asked || !asked()) return;
    const auto isLeft = [](const Task& task) { return !task.result->mesh; };
    const auto largest = std::find_if(tasks_.begin(), tasks_.end(), isLeft);
    throw Stopped("stopped while meshes were read" +
                  (largest == tasks_.end()
                       ? std::string()
                       : ", " + std::to_string(std::count_if(largest, tasks_.end(), isLeft)) +
                             " of " + std::to_string(tasks_.size()) + " left, the largest " +
                             std::get<0>(largest->key)));
  }

  void run(const Task& task, const Stop& asked) const {
    try {
      task.result->mesh = importMesh(std::get<0>(task.key), task.collision->mesh_scale,
                                     task.collision->file, task.collision->line, cache_, asked);
    } catch (...) {  // Stopped, too
      task.result->error = std::current_exception();
    }
  }

  std::string urdf_path_;
  const LoadOptions& options_;
  const DiskCache cache_;
  std::vector<std::string> keys_;
  std::map<Key, Loaded> loaded_;
  std::vector<Task> tasks_;
};

Shape makeShape(const UrdfCollision& collision, const std::string& link, Meshes& meshes,
                std::vector<std::string>& warnings) {
  return collision.kind == UrdfCollision::Kind::kMesh ? meshes.load(collision, link, warnings)
                                                      : primitiveOf(collision);
}

/// Link indices of the document, parents before children, depth first, children in the order of
/// their joints; [i] = (link, its joint or -1).
std::vector<std::pair<int, int>> treeOrder(const UrdfDocument& document) {
  std::vector<std::vector<int>> child_joints(document.links.size());
  std::vector<bool> has_parent(document.links.size(), false);
  for (std::size_t j = 0; j < document.joints.size(); ++j) {
    child_joints[at(document.joints[j].parent)].push_back(static_cast<int>(j));
    has_parent[at(document.joints[j].child)] = true;
  }
  const auto root = std::find(has_parent.begin(), has_parent.end(), false) - has_parent.begin();
  std::vector<std::pair<int, int>> order, stack{{static_cast<int>(root), -1}};
  while (!stack.empty()) {
    const auto [link, joint] = stack.back();
    stack.pop_back();
    order.emplace_back(link, joint);
    const std::vector<int>& children = child_joints[at(link)];
    // (clang 14 cannot read the library's views.) NOLINTNEXTLINE(modernize-loop-convert)
    for (auto j = children.rbegin(); j != children.rend(); ++j)
      stack.emplace_back(document.joints[at(*j)].child, *j);
  }
  return order;
}

std::vector<std::string> jointNames(const UrdfDocument& document) {
  std::vector<std::string> names;
  for (const UrdfJoint& joint : document.joints) names.push_back(joint.name);
  return names;
}

Joint rootJoint(const UrdfDocument& document, const std::optional<VirtualJoint>& asked) {
  Joint joint;
  joint.child_link = 0;
  joint.axis = Eigen::Vector3d::UnitZ();
  if (asked) {
    joint.name = asked->name;
    joint.type = asked->type;
    return joint;
  }
  const std::vector<std::string> taken = jointNames(document);
  joint.name = "root_joint";
  while (std::find(taken.begin(), taken.end(), joint.name) != taken.end()) joint.name += '_';
  return joint;
}

void requireFound(const std::map<std::string, MeshTreatment, std::less<>>& asked,
                  const std::set<std::string>& found, const std::string& urdf_path) {
  for (const auto& [name, treatment] : asked)
    if (found.count(name) == 0)
      throw InputError(urdf_path, 0,
                       "meshes names '" + name +
                           "', which is no link with a mesh and no mesh of the robot; the name of "
                           "a link that has one, or the path of a mesh as the URDF has it, would "
                           "be accepted");
}

void appendLink(const UrdfLink& source, int joint, Meshes& meshes, const LoadOptions& options,
                RobotDescription& model) {
  Link link;
  link.name = source.name;
  link.joint = joint;
  for (const UrdfCollision& collision : source.collisions) {
    const bool is_mesh = collision.kind == UrdfCollision::Kind::kMesh;
    if ((is_mesh || collision.fit) && options.kinematics_only) {
      model.lacks_meshes = true;
      if (is_mesh)
        static_cast<void>(treatmentOf(options, {link.name, collision.mesh_file}));  // it is known
      continue;
    }
    readOn(options.errors, [&] {
      if (collision.fit) {
        const UrdfCollision primitive = meshes.fitted(collision, model.warnings);
        link.geometries.push_back({primitiveOf(primitive), primitive.X_LG, collision.name});
        return;
      }
      link.geometries.push_back({makeShape(collision, source.name, meshes, model.warnings),
                                 collision.X_LG, collision.name});
    });
  }
  model.links.push_back(std::move(link));
}

void appendJoint(const UrdfJoint& source, const std::vector<int>& link_position,
                 RobotDescription& model) {
  Joint joint;
  joint.name = source.name;
  joint.type = source.type;
  joint.parent_link = link_position[at(source.parent)];
  joint.child_link = static_cast<int>(model.joints.size());
  joint.X_PJ = source.X_PJ;
  joint.axis = source.axis / source.axis.norm();
  model.joints.push_back(std::move(joint));
}

/// A mimic joint with a multiplier of 0, its own or of those that it follows, stands still.
void fixStillMimics(UrdfDocument& document) {
  const JointsByName joints = jointsByName(document);
  std::vector<std::pair<UrdfJoint*, double>> still;
  for (UrdfJoint& joint : document.joints) {
    double multiplier = 1, position = 0;
    for (const UrdfJoint* next = &joint; next->has_mimic; next = joints.at(next->mimic)) {
      position += multiplier * next->offset;
      multiplier *= next->multiplier;
    }
    if (multiplier == 0) still.emplace_back(&joint, position);
  }
  for (const auto& [joint, position] : still) {
    const bool is_bounded =
        joint->type == JointType::kRevolute || joint->type == JointType::kPrismatic;
    if (is_bounded && !(position >= joint->lower && position <= joint->upper))
      document.warnings.push_back(joint->file + ":" + std::to_string(joint->mimic_line) +
                                  ": joint " + inQuotes(joint->name) +
                                  " mimics with multiplier 0 and stands still at " +
                                  textOf(position) + ", beyond its limits, which are left out");
    lockAt(*joint, position);
  }
}

/// Follows a chain of mimics to the joint with a variable: m1 (m2 q + o2) + o1.
void resolveMimic(const JointsByName& joints, const UrdfJoint& source, RobotDescription& model) {
  Joint& joint = model.joints[at(model.findJoint(source.name))];
  const UrdfJoint* master = joints.at(source.mimic);
  joint.multiplier = source.multiplier;
  joint.offset = source.offset;
  while (master->has_mimic) {
    joint.offset += joint.multiplier * master->offset;
    joint.multiplier *= master->multiplier;
    master = joints.at(master->mimic);
  }
  joint.mimic = model.findJoint(master->name);
}

/// Lowers the limits on the motion of a mimic's master so that the mimic keeps its own.
void limitMaster(const UrdfJoint& source, RobotDescription& model) {
  const Joint& joint = model.joints[at(model.findJoint(source.name))];
  const int variable = model.joints[at(joint.mimic)].first_variable;
  if (!source.has_limit || joint.multiplier == 0 || variable < 0) return;
  Variable& master = model.variables[at(variable)];
  const double ratio = std::abs(joint.multiplier);
  master.acceleration = std::min(master.acceleration, source.acceleration / ratio);
  master.jerk = std::min(master.jerk, source.jerk / ratio);
  master.velocity = std::min(master.velocity, source.velocity / ratio);
}

void narrow(Variable& variable, double lower, double upper, const std::string& reason) {
  const bool below = lower > variable.lower + kSameLimit,
             above = upper < variable.upper - kSameLimit;
  if (!below && !above) return;
  if (below) variable.lower = lower;
  if (above) variable.upper = upper;
  variable.narrowed_by += (variable.narrowed_by.empty() ? "" : ", ") + reason;
}

/// Narrows a master's range so that its mimic stays within the mimic's own limits. Many URDFs copy
/// these limits from the master without the multiplier. If they leave the master no range, they are
/// left out with a warning.
void narrowMaster(const UrdfJoint& source, RobotDescription& model) {
  if (source.type != JointType::kRevolute && source.type != JointType::kPrismatic) return;
  const Joint& joint = model.joints[at(model.findJoint(source.name))];
  const Joint& master = model.joints[at(joint.mimic)];
  if (master.first_variable < 0) return;
  Variable& variable = model.variables[at(master.first_variable)];
  if (variable.lower == variable.upper) return;
  double lower = (source.lower - joint.offset) / joint.multiplier;
  double upper = (source.upper - joint.offset) / joint.multiplier;
  if (joint.multiplier < 0) std::swap(lower, upper);
  const std::string place = source.file + ":" + std::to_string(source.limit_line);
  const std::string name = "joint \"" + source.name + "\", which mimics \"" + master.name + "\"";
  const char* why = nullptr;
  if (master.type == JointType::kContinuous)
    why = "that joint has none";
  else if (!(std::max(lower, variable.lower) < std::min(upper, variable.upper)))
    why = "they leave it no range";
  if (why == nullptr)
    narrow(variable, lower, upper, "the limits of " + name + " (" + place + ")");
  else if (!source.lacks_range && (source.lower > -kInfinity || source.upper < kInfinity))
    model.warnings.push_back(place + ": the limits of " + name + ", are left out: " + why);
}

/// The key of all that provenGaps() reads of a model, with the keys of its meshes in the order of
/// the links. Empty where one of these is.
std::string keyOfGaps(const Model& model, const std::vector<std::string>& meshes) {
  ContentKey key("gaps");
  auto mesh = meshes.begin();
  // A hull is that of a mesh.
  const auto addMesh = [&](const Shape&) {
    if (mesh == meshes.end() || mesh->empty()) return false;
    key.add(std::string_view(*mesh++));
    return true;
  };
  if (!addModel(model, addMesh, key)) return {};
  for (const DisabledPair& pair : model.disabled_pairs) {
    key.add(std::string_view("disabled"));
    key.add(static_cast<double>(pair.link_a));
    key.add(static_cast<double>(pair.link_b));
  }
  return key.finish();
}

void addPairs(const UrdfDocument& document, const std::vector<int>& link_position,
              RobotDescription& robot) {
  const auto placed = [&](int a, int b) {
    return std::pair<int, int>(std::minmax(link_position[at(a)], link_position[at(b)]));
  };
  for (const DisabledPair& pair : document.disabled_pairs) {
    const auto [a, b] = placed(pair.link_a, pair.link_b);
    robot.disabled_pairs.push_back({a, b, pair.reason, pair.is_of_mjcf});
  }
  for (const auto& [a, b] : document.enabled_pairs) robot.enabled_pairs.push_back(placed(a, b));
  for (const auto& [a, b] : document.asked_pairs) robot.asked_pairs.push_back(placed(a, b));
}

/// The document's states, with the values of the joints that have variables.
void addStates(const UrdfDocument& document, RobotDescription& robot) {
  for (const UrdfState& source : document.states) {
    GroupState state{source.name, "all", {}};
    for (const auto& [index, values] : source.values) {
      const Joint& joint = robot.joints[at(robot.findJoint(document.joints[at(index)].name))];
      for (int k = 0; k < joint.variable_count; ++k)
        state.values.emplace_back(joint.first_variable + k, values[at(k)]);
    }
    robot.group_states.push_back(std::move(state));
  }
}

/// Links with visual shapes alone touch nothing, or these stand in. A robot whose moving links have
/// no shapes touches nothing, whatever it does.
void warnOfShapes(const UrdfDocument& document, const std::vector<std::pair<int, int>>& order,
                  RobotDescription& robot) {
  const auto warn = [&](const UrdfLink& of, const std::string& message) {
    robot.warnings.push_back(of.file + ":" + std::to_string(of.line) + ": " + message);
  };
  std::vector<const UrdfLink*> bare, standing;
  std::string bare_names, standing_names;
  const auto add = [](const UrdfLink& link, std::vector<const UrdfLink*>& to, std::string& names) {
    names += (to.empty() ? "" : ", ") + inQuotes(link.name);
    to.push_back(&link);
  };
  for (const UrdfLink& link : document.links) {
    if (link.has_visual && link.collisions.empty()) add(link, bare, bare_names);
    if (link.visual_stands_in) add(link, standing, standing_names);
  }
  if (bare.size() == 1)
    warn(*bare[0],
         "link " + bare_names + " has a <visual> and no <collision>: it will touch nothing");
  else if (!bare.empty())
    warn(*bare[0],
         std::to_string(bare.size()) +
             " links have a <visual> and no <collision>, and will touch nothing: " + bare_names);
  if (!standing.empty())
    warn(*standing[0],
         "the <visual> shapes of links without <collision> stand in for it: " + standing_names);
  std::vector<bool> moves;
  std::size_t first = robot.links.size();
  for (std::size_t l = 0; l < robot.links.size(); ++l) {
    const Joint& joint = robot.joints[l];
    moves.push_back(joint.type != JointType::kFixed ||
                    (joint.parent_link >= 0 && moves[at(joint.parent_link)]));
    if (!moves[l]) continue;
    if (!document.links[at(order[l].first)].collisions.empty()) return;
    first = std::min(first, l);
  }
  if (first == robot.links.size()) return;
  const UrdfLink& link = document.links[at(order[first].first)];
  warn(link, "neither link " + inQuotes(link.name) +
                 " nor any other that moves has a <collision>, or a geom that collides: the robot "
                 "will touch nothing");
}

/// provenGaps(), kept on disk.
std::vector<LinkGap> gapsOf(const Model& model, const Meshes& meshes) {
  // (Without meshes nothing is proven.)
  if (!meshes.cache().isOn() || meshes.keys().empty()) return provenGaps(model, meshes.stop());
  const std::string key = keyOfGaps(model, meshes.keys());
  if (const auto kept = meshes.cache().read(key))
    if (auto gaps = gapsFromBytes({kept->data(), kept->size()}, model)) return std::move(*gaps);
  std::vector<LinkGap> gaps = provenGaps(model, meshes.stop());
  meshes.cache().write(key, bytesOf(gaps));
  return gaps;
}

}  // namespace

std::shared_ptr<const Model> loadModel(const std::string& urdf_path, const std::string& srdf_path,
                                       const LoadOptions& options) {
  const ErrorsSince wrong(options.errors);
  if (!options.xacro.empty() && !isXacro(urdf_path) && !isXacro(srdf_path))
    throw InputError(urdf_path, 0,
                     "is no xacro file, and has no use for the xacro argument \"" +
                         options.xacro.front().first +
                         "\"; a file that ends in .xacro would be accepted");
  XmlFile file(urdf_path, "URDF", options);
  UrdfDocument document = readDocument(file, options, false);
  if (!document.essence.empty()) compareWithUrdfdom(document);
  fixStillMimics(document);
  std::optional<XmlFile> srdf;
  if (!srdf_path.empty()) srdf.emplace(srdf_path, "SRDF", options);

  RobotDescription robot;
  robot.name = document.name;
  robot.urdf_file = urdf_path;
  robot.srdf_file = srdf_path;
  std::error_code no_folder;  // it may be gone
  robot.folder = std::filesystem::current_path(no_folder).string();
  robot.cache = options.cache;
  robot.warnings = document.warnings;
  const std::vector<std::pair<int, int>> order = treeOrder(document);
  std::vector<int> link_position(document.links.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    link_position[at(order[i].first)] = static_cast<int>(i);
  std::optional<VirtualJoint> virtual_joint;
  if (srdf)
    virtual_joint = readVirtualJoint(*srdf, document.links[at(order.front().first)].name,
                                     jointNames(document), robot);
  std::set<std::string> found;
  LoadOptions noting = options;
  if (noting.meshes_found == nullptr) noting.meshes_found = &found;
  const std::set<std::string> found_before = *noting.meshes_found;
  Meshes meshes(urdf_path, noting);
  if (!options.kinematics_only) meshes.loadAll(document, order);
  for (const auto& [link, joint] : order) {
    appendLink(document.links[at(link)], static_cast<int>(robot.joints.size()), meshes, noting,
               robot);
    if (joint < 0)
      robot.joints.push_back(rootJoint(document, virtual_joint));
    else
      appendJoint(document.joints[at(joint)], link_position, robot);
  }
  OpenMeshes open;
  const UrdfLink* first_open = nullptr;
  for (std::size_t i = 0; i < order.size(); ++i) {
    open.add(robot.links[i].name, robot.links[i].geometries);
    if (first_open == nullptr && !open.isEmpty()) first_open = &document.links[at(order[i].first)];
  }
  if (first_open != nullptr)
    robot.warnings.push_back(first_open->file + ":" + std::to_string(first_open->line) + ": " +
                             open.text(false));
  if (options.meshes_found == nullptr) requireFound(options.meshes, found, urdf_path);
  robot.read_with = {options.packages, options.xacro, options.visual_as_collision, {}};
  for (const auto& [name, treatment] : options.meshes)
    if (found_before.count(name) == 0 && noting.meshes_found->count(name) != 0)
      robot.read_with.meshes.emplace(name, treatment);
  const JointsByName joints = jointsByName(document);
  for (const UrdfJoint& joint : document.joints)
    if (joint.has_mimic) resolveMimic(joints, joint, robot);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int source = order[i].second;
    const bool bounded = robot.joints[i].type == JointType::kRevolute ||
                         robot.joints[i].type == JointType::kPrismatic;
    const UrdfJoint* joint = source < 0 ? nullptr : &document.joints[at(source)];
    const double lower = bounded ? joint->lower : -kInfinity,
                 upper = bounded ? joint->upper : kInfinity;
    appendVariables(robot, static_cast<int>(i), Eigen::Vector3d::Constant(lower),
                    Eigen::Vector3d::Constant(upper),
                    joint != nullptr ? joint->velocity : kInfinity);
    for (int k = 0; joint != nullptr && k < robot.joints[i].variable_count; ++k) {
      Variable& variable = robot.variables[at(robot.joints[i].first_variable + k)];
      variable.acceleration = joint->acceleration;
      variable.jerk = joint->jerk;
      if (!joint->rest.empty()) variable.rest = joint->rest[at(k)];
    }
  }
  std::set<std::string_view> names;  // those of a planar joint a are a/x, a/y and a/theta
  for (const Variable& variable : robot.variables)
    if (!names.insert(variable.name).second) {
      const int source = order[at(variable.joint)].second;
      throw InputError(source < 0 ? urdf_path : document.joints[at(source)].file,
                       source < 0 ? 0 : document.joints[at(source)].line,
                       "the variable '" + variable.name +
                           "' is there twice; joints whose variables have names of their own are "
                           "expected");
    }
  for (const UrdfJoint& joint : document.joints) {
    if (!joint.has_mimic) continue;
    limitMaster(joint, robot);
    narrowMaster(joint, robot);
  }
  addPairs(document, link_position, robot);
  addStates(document, robot);
  if (srdf) readSrdf(*srdf, robot);
  warnOfShapes(document, order, robot);
  wrong.throwFirst();
  auto model = std::make_shared<Model>(std::move(robot));
  model->keepGaps(gapsOf(*model, meshes));
  return model;
}

}  // namespace leeway::robots
