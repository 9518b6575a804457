// Problems as files: what is saved and loaded again is the same problem, and what files cannot say
// is refused.
#include "leeway/planner/save_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/settings.h"
#include "leeway/robots/placed_model.h"
#include "planner/save/problem_text.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

using collision::Shape;
using robots::expectInputError;

/// A ball in the plane, from one side of a box to the other.
Problem ball() {
  Problem problem;
  problem.name = "a ball";
  problem.robot.model = robots::freeBody("ball", {{Shape::sphere(0.1), {}, "ball"}},
                                         robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0});
  problem.robot.variables = {0, 1, 2};
  problem.start = {-1, 0, 0.1};
  problem.goals.push_back({"goal", {{1, 1}, {0, 0.1}, {-0.2, 0.2}}, {}});
  problem.world.objects.push_back({"box", {{Shape::box({0.1, 0.3, 0.2}), {}, "box"}}, {}});
  return problem;
}

/// Saves, loads, and expects the same problem; returns the one that was loaded.
Problem again(const Problem& problem) {
  const Folder folder;
  saveProblem(problem, folder.path("saved.yaml"));
  const Problem loaded = loadProblem(folder.path("saved.yaml"));
  EXPECT_EQ(problemDifference(problem, loaded), "");
  // And once more, from a file to a file.
  saveProblem(loaded, folder.path("again.yaml"));
  EXPECT_EQ(problemDifference(problem, loadProblem(folder.path("again.yaml"))), "");
  return loaded;
}

collision::Pose turned(double x, double angle) {
  collision::Pose X;
  X.translation = {x, 0.1, -1.0 / 3};
  X.rotation << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
  return X;
}

TEST(SaveProblem, ShippedProblemsComeBack) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(sourceFolder() + "/problems")) {
    if (entry.path().extension() != ".yaml" || entry.path().stem() == "scene0001" ||
        entry.path().stem() == "request0001")
      continue;
    SCOPED_TRACE(entry.path().string());
    const Problem problem = loadProblem(entry.path().string());
    const Problem loaded = again(problem);
    // Asked by the engine, too: the same distance of the same pair, to the rounding of rotations.
    if (problem.start_poses.empty() && problem.steps.empty()) {
      const auto clearance = [](const Problem& of) {
        EdgeCertifier certifier(std::make_shared<const CompiledScene>(of));
        std::vector<double> start;
        for (const int v : of.robot.variables)
          start.push_back(of.start[static_cast<std::size_t>(v)]);
        return certifier.clearance(start, 1e-9);
      };
      const StateCheck a = clearance(problem), b = clearance(loaded);
      EXPECT_EQ(a.verdict, b.verdict);
      EXPECT_NEAR(a.clearance.lower, b.clearance.lower, 2e-9);
    }
    ++count;
  }
  EXPECT_GT(count, 15);
}

/// Files give goals names by their places, and one may be left of two.
TEST(SaveProblem, KeepsOneGoalOfAList) {
  Problem problem = ball();
  for (const char* name : {"goal 1", "goal 2"}) {
    problem.goals[0].name = name;
    EXPECT_EQ(again(problem).goals.at(0).ranges, problem.goals[0].ranges);
  }
}

TEST(SaveProblem, KeepsEveryShape) {
  Problem problem = ball();
  const std::vector<Eigen::Vector3d> corners = {
      {0, 0, 0}, {1. / 3, 0, 0}, {0, 0.1, 0}, {0, 0, 0.7}};
  const std::vector<collision::TriangleMesh::Triangle> faces = {
      {0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  const std::vector<collision::TriangleMesh::Triangle> open = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}};
  collision::MeshOptions surface;
  surface.solid = false;
  using collision::TriangleMesh;
  const std::vector<std::pair<std::string, Shape>> shapes = {
      {"sphere", Shape::sphere(0.1)},
      {"capsule", Shape::capsule(0.1, 1. / 3)},
      {"cylinder", Shape::cylinder(0.1, 0.3)},
      {"cone", Shape::cone(0.1, 0.3)},
      {"ellipsoid", Shape::ellipsoid({0.1, 0.2, 0.3})},
      {"half", Shape::halfSpace()},
      {"hull", Shape::convexHull(corners)},
      {"solid", Shape::mesh(TriangleMesh::make(corners, faces))},
      {"surface", Shape::mesh(TriangleMesh::make(corners, faces, surface))},
      {"open", Shape::mesh(TriangleMesh::make(corners, open))},
      {"../name: \"quoted\"\n# of a file\\", Shape::sphere(0.1)},
      {"true", Shape::sphere(0.1)},
      {"12", Shape::sphere(0.1)}};
  for (const auto& [name, shape] : shapes)
    problem.world.objects.push_back({name, {{shape, {}, name}}, turned(1, 0.3), nullptr, {}});
  problem.world.objects.push_back(
      {"two", {{Shape::sphere(0.1), turned(0.2, 1), "two"}, {Shape::sphere(0.2), {}, "b"}}, {}});
  problem.world.objects.back().color = {0.1, 0.2, 1};
  auto cloud = std::make_shared<PointCloud>();
  cloud->balls = {{{0.1, 0.2, 1. / 3}, 0.01}, {{1, 2, 3}, 0.02}};
  problem.world.objects.push_back({"cloud", {}, turned(0.5, -1), cloud});
  const Problem loaded = again(problem);
  EXPECT_EQ(loaded.world.objects.size(), problem.world.objects.size());
  EXPECT_EQ(loaded.world.objects[9].geometries[0].shape.mesh()->closedComponentCount(), 0);
  EXPECT_EQ(*loaded.world.objects[14].color, (std::array{0.1, 0.2, 1.0}));
}

TEST(SaveProblem, KeepsMarginsWishesAndSettings) {
  Problem problem = ball();
  for (const char* name : {"a", "b", "c"})
    problem.world.objects.push_back({name, {{Shape::sphere(0.1), {}, name}}, turned(1.5, 0)});
  problem.contacts.allowed = {{"ball", "a"}};
  problem.contacts.replace_srdf = true;
  problem.margins.common = 0.001;
  problem.margins.pairs = {{"ball", "world", 0.002, "ball and world"},
                           {"ball", "b", 0.003, "ball and bs"},
                           {"ball", "c", 0.003, "ball and bs"},
                           {"ball", "b", 0.004}};
  problem.margins.wishes = {{"any", {{"ball", "b"}, {"ball", "c"}}, 0.2, 3}};
  problem.planner.simplify = false;
  problem.limits = {7.5, 1000};
  problem.seed = std::numeric_limits<std::uint64_t>::max();
  problem.execution.velocities["ball/x"] = 0.3;
  problem.execution.corners = Corners::kStop;
  problem.execution.acceleration_scale = 0.5;
  problem.execution.jerk_scale = 0.25;
  again(problem);
  problem.margins.wishes.clear();
  problem.objective = MaximumClearance{Pairs::kAll, 0.3};
  again(problem);
  problem.objective = MinimumLength{0.02};
  again(problem);
  problem.objective = MinimumCost{1.5,
                                  {{{Nearness::Kind::kHinge, 0.1}, 2, true, Pairs::kSelf},
                                   {{Nearness::Kind::kInverse, 0.2}, 1, false, Pairs::kAll}}};
  again(problem);
  problem.limits.time = std::numeric_limits<double>::infinity();
  again(problem);
}

/// Regression: neighbours that MoveIt's matrix has checked could not be saved.
TEST(SaveProblem, KeepsPairsThatAreChecked) {
  const std::string arm = sourceFolder() + "/robots/arm7/arm7";
  Problem problem =
      problemFromStates(robots::loadModel(arm + ".urdf", arm + ".srdf"), "arm", "ready", "upright");
  problem.contacts.checked = {{"link1", "link2"}, {"hand", "link5"}};
  EXPECT_EQ(again(problem).contacts.checked, problem.contacts.checked);
}

TEST(SaveProblem, KeepsWhatDeforms) {
  const std::vector<Eigen::Vector3d> rest = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1. / 3}};
  const std::vector<collision::DeformableMesh::Triangle> faces = {{0, 1, 2}, {1, 3, 2}};
  const auto mesh = collision::DeformableMesh::make(rest, faces);
  using collision::VertexMotion;
  collision::WavesMotion waves{rest, {{{1, 0, 0}, {0, 0, 0.1}, 0.7, 0.3, 0.2}}, {}};
  waves.pinned = collision::PinnedEdge{{0, 0, 0}, {0, 1, 0}, 0.5};
  collision::LatticeMotion lattice;
  lattice.rest = rest;
  lattice.keys = {{0, {}}, {1, {}}};
  for (auto& key : lattice.keys)
    for (int i = 0; i < 8; ++i) key.control_points.emplace_back(i % 2, i / 2 % 2, i / 4);
  lattice.keys[1].control_points[7].z() += 0.25;
  const collision::MorphMotion morph{{rest, {{0, 0, 0.1}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.5}}},
                                     {{0, {1, 0}}, {2, {0.1, 0.9}}},
                                     collision::Interpolation::kSmooth};
  const collision::ReducedMotion reduced{
      rest, {{{0, 0, 0.1}, {0, 0, 0.2}, {0, 0, 1. / 3}, {0, 0, 0}}}, {{1, 0.3, 0.1}}, {}};
  collision::SkinnedMotion skinned;
  skinned.rest = rest;
  skinned.bones = {{-1, {}}, {0, {{0.5, 0, 0}, {0, 0, 0, 1}}}};
  for (int v = 0; v < 4; ++v) skinned.weights.push_back({v, v % 2, 0.7});
  skinned.keys = {{0, {{}, {{0.5, 0, 0}, {0, 0, 0, 1}}}},
                  {1, {{}, {{0.5, 0, 0.2}, {0, 0.6, 0, 0.8}}}}};
  collision::CacheMotion cache{4, {0, 0.5}, {}};
  for (int i = 0; i < 8; ++i) cache.positions.emplace_back(0.5, 0.25, 0.125 * i);
  const std::vector<std::shared_ptr<const VertexMotion>> motions = {nullptr,
                                                                    VertexMotion::waves(waves),
                                                                    VertexMotion::lattice(lattice),
                                                                    VertexMotion::morph(morph),
                                                                    VertexMotion::reduced(reduced),
                                                                    VertexMotion::skinned(skinned),
                                                                    VertexMotion::cache(cache)};
  for (const auto& motion : motions) {
    Problem problem = ball();
    problem.execution.start = 0.25;
    problem.world.deforming.push_back(
        makeDeformingObstacle("cloth", mesh, motion, turned(3, 0.4), 0.25, {}, 5));
    problem.world.deforming[0].object.color = {1, 0, 0};
    SCOPED_TRACE(motion ? toString(motion->kind()) : "none");
    again(problem);
  }
  // Regression: "world.deforming[0] would come back as another one". A vertex cache's file has
  // single precision.
  for (const bool of_times : {true, false}) {
    collision::CacheMotion precise = cache;
    (of_times ? precise.times.back() : precise.positions.back().x()) = 1.3;
    Problem problem = ball();
    problem.world.deforming.push_back(
        makeDeformingObstacle("cloth", mesh, VertexMotion::cache(precise), {}, 0, {}, 5));
    SCOPED_TRACE(of_times);
    again(problem);
  }
}

/// Another program's motion.
class OwnMotion final : public collision::VertexMotion {
 public:
  OwnMotion() : VertexMotion(collision::MotionKind::kOwn, 3, 0, {}) {}
  void parameters(double, std::span<double>) const override {}
  void vertices(std::span<const double>, int first, std::span<Eigen::Vector3d> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(i) + first);
  }
  double speedBound(double, double) const override { return 0; }
  double accelerationBound(double, double) const override { return 0; }
  double rounding(double, double) const override { return 0; }
};

TEST(SaveProblem, KeepsWhatMoves) {
  Problem problem = ball();
  problem.execution.start = 0.7;
  const auto add = [&](const std::string& name, double x, const ObjectMotion& motion) {
    const Object object = {name, {{Shape::sphere(0.1), {}, name}}, turned(x, 0.3)};
    problem.world.objects.push_back(movingObject(object, motion, problem.execution.start));
  };
  using collision::PoseMotion;
  add("seen", 5, {.poses = nullptr, .speed_bound = 0.3, .turn_bound = 0.2, .age = 0.1});
  add("steady", 6,
      {.poses = PoseMotion::steady({0.5, turned(6, 0.3)}, {0, 0, 0.1}, {0.1, 0, 0.2})});
  add("keys", 7,
      {.poses = PoseMotion::keys({{0, turned(7, 0.3)}, {2, turned(8, 1)}}),
       .speed_bound = 9,
       .turn_bound = 9});
  const Problem loaded = again(problem);
  const Problem still = ball();
  EXPECT_EQ(problemDifference(loaded, still), "world.objects");
  problem.world.objects[1].motion = nullptr;
  EXPECT_EQ(problemDifference(problem, loaded), "world.objects[1]");
}

TEST(SaveProblem, KeepsTheSpeedOfLines) {
  Problem problem = ball();
  problem.goals.clear();
  LineStep line;
  line.frame = "ball";
  line.by = {0.25, 0, 0};
  line.speed = 0.125;
  Step step;
  step.name = "slow";
  step.action = line;
  problem.steps = {step};
  EXPECT_EQ(std::get<LineStep>(again(problem).steps[0].action).speed, 0.125);
  Problem faster = problem;
  std::get<LineStep>(faster.steps[0].action).speed = 0.25;
  EXPECT_EQ(problemDifference(problem, faster), "steps[0]");
}

/// Gives a setting another value.
struct Change {
  Problem& problem;

  void operator()(SettingPlace<bool> place) const { *place(problem) = !*place(problem); }
  void operator()(SettingPlace<double> place) const { *place(problem) = 0.375; }
  void operator()(SettingPlace<std::int64_t> place) const { *place(problem) += 1; }
  void operator()(SettingPlace<std::uint64_t> place) const { *place(problem) += 1; }
  void operator()(SettingPlace<std::string> place) const { *place(problem) += "x"; }
  template <class Value>
  void operator()(SettingPlace<std::map<std::string, Value>> place) const {
    (*place(problem))["x"] = {};
  }
  void operator()(const WordSetting& choice) const {
    for (const WordSetting::Word& word : choice.words)
      if (word.value != choice.get(problem)) return choice.set(problem, word.value);
  }
  void operator()(PlannerParameterSetting of) const {
    problem.planner.parameters[std::string(of.parameter)] = "1";
  }
  void operator()(std::monostate) const {}
};

TEST(SaveProblem, NoSettingChangesUnseen) {
  int changed = 0;
  for (const Setting& setting : settings()) {
    if (std::holds_alternative<std::monostate>(setting.value)) continue;
    Problem problem = ball();
    if (setting.objective() == "clearance") problem.objective = MaximumClearance();
    Problem other = problem;
    std::visit(Change{other}, setting.value);
    const bool is_parameter = std::holds_alternative<PlannerParameterSetting>(setting.value);
    const std::string_view name = setting.member.empty() ? setting.key : setting.member;
    EXPECT_EQ(problemDifference(problem, other), is_parameter ? "planner.parameters" : name);
    ++changed;
  }
  EXPECT_GT(changed, 25);
  // 0 and infinity both are an unlimited time, but not an endless patience.
  Problem endless = ball(), none = ball();
  endless.limits.time = std::numeric_limits<double>::infinity();
  none.limits.time = 0;
  EXPECT_EQ(problemDifference(endless, none), "");
  endless.execution.patience = std::numeric_limits<double>::infinity();
  EXPECT_EQ(problemDifference(endless, none), "execution.patience");
}

/// Problems that share a folder of files do not replace each other's.
TEST(SaveProblem, LeavesTheFilesOfOtherProblemsAlone) {
  const auto withMesh = [](double size) {
    Problem problem = ball();
    const std::vector<Eigen::Vector3d> corners = {
        {0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
    const std::vector<collision::TriangleMesh::Triangle> faces = {
        {0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    problem.world.objects[0].geometries[0].shape =
        Shape::mesh(collision::TriangleMesh::make(corners, faces));
    return problem;
  };
  const Folder folder;
  const Problem small = withMesh(0.01), large = withMesh(0.3);
  saveProblem(small, folder.path("x.yaml"));
  saveProblem(large, folder.path("x.yml"));
  EXPECT_EQ(problemDifference(small, loadProblem(folder.path("x.yaml"))), "");
  EXPECT_EQ(problemDifference(large, loadProblem(folder.path("x.yml"))), "");
  // Where the problem itself cannot be written, what was there stays as it was.
  std::filesystem::create_directories(folder.path("y.yaml"));
  saveProblem(small, folder.path("y.yml"));
  EXPECT_THROW(saveProblem(large, folder.path("y.yaml")), robots::InputError);
  EXPECT_EQ(problemDifference(small, loadProblem(folder.path("y.yml"))), "");
}

TEST(SaveProblem, RefusesWhatFilesCannotSay) {
  const Folder folder;
  const std::string file = folder.write("kept.yaml", "as it was");
  const auto refused = [&](const Problem& problem, std::initializer_list<std::string> words) {
    expectInputError([&] { saveProblem(problem, file); }, file, 0, words);
    EXPECT_EQ(readText(file), "as it was");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  };
  Problem problem = ball();
  problem.goals[0].name = "the far side";
  refused(problem, {"the far side", "group state"});
  problem = ball();
  problem.condition.accept = [](std::span<const double>) { return true; };
  refused(problem, {"condition"});
  problem = ball();
  problem.world.objects.push_back({"nothing yet", {}, {}});
  refused(problem, {"nothing yet", "no shape"});
  problem = ball();
  problem.execution.duration = std::numeric_limits<double>::infinity();
  refused(problem, {"execution.duration", "finite"});
  problem = ball();
  robots::RobotDescription two = *problem.robot.model;
  two.variables[2].velocity = 0.5;
  problem.robot.model = std::make_shared<const robots::Model>(two);
  refused(problem, {"robot.model.variables[2]", "another one"});
  problem = ball();
  const std::vector<Eigen::Vector3d> rest = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<collision::DeformableMesh::Triangle> face = {{0, 1, 2}};
  problem.world.deforming.push_back(
      makeDeformingObstacle("own", collision::DeformableMesh::make(rest, face),
                            std::make_shared<OwnMotion>(), turned(3, 0)));
  refused(problem, {"the motion of 'own'", "waves"});
  problem = ball();
  problem.start[0] = 5;
  EXPECT_THROW(saveProblem(problem, file), robots::InputError);
  expectInputError([&] { saveProblem(ball(), folder.path("a.json")); }, folder.path("a.json"), 0,
                   {".yaml"});
  expectInputError([&] { saveProblem(ball(), folder.path("none/a.yaml")); },
                   folder.path("none/a.yaml"), 0, {"folder"});
}

TEST(SaveProblem, ColorsAreChecked) {
  Problem problem = ball();
  problem.world.objects[0].color = {0, 0.5, 1.5};
  EXPECT_THROW(validate(problem), robots::InputError);
  const Folder folder;
  const auto file = [&](const std::string& color) {
    return folder.write(
        "c.yaml",
        "leeway: 1\nbody: {joint: planar, bounds: {lower: [-1, -1], upper: [1, 1]},"
        " shapes: [{sphere: {radius: 0.1}}]}\nstart: [0, 0, 0]\ngoal: [1, 0, 0]\n"
        "objects:\n  - {name: a, position: [0, 9, 0], sphere: {radius: 0.1}, color: " +
            color + "}\n");
  };
  EXPECT_EQ(*loadProblem(file("[1, 0.5, 0]")).world.objects[0].color, (std::array{1.0, 0.5, 0.0}));
  for (const auto& [color, word] : {std::pair("red", "from 0 to 1"),
                                    {"[1, 0]", "list of 2"},
                                    {"[1, 0, 2]", "holds 2"},
                                    {"[1, 0, .nan]", "finite"}}) {
    const std::string name = file(color);
    expectInputError([&] { loadProblem(name); }, name, 6, {word});
  }
}

TEST(SaveProblem, BallsOfCloudsAreRead) {
  const Folder folder;
  const auto load = [&](const std::string& cloud) {
    return loadProblem(
        folder.write("b.yaml",
                     "leeway: 1\nbody: {joint: planar, bounds: {lower: [-1, -1], upper: [1, 1]},"
                     " shapes: [{sphere: {radius: 0.1}}]}\nstart: [0, 0, 0]\ngoal: [1, 0, 0]\n"
                     "objects:\n  - {name: a, position: [0, 9, 0], cloud: {" +
                         cloud + "}}\n"));
  };
  EXPECT_EQ(load("balls: [[0, 0, 0, 0.1], [1, 0, 0, 0.2]]").world.objects[0].cloud->size(), 2u);
  // A carved cloud comes back as one that holds for its place alone.
  Problem cut = load("balls: [[0, 0, 0, 0.1], [1, 0, 0, 0.2]]");
  const robots::Geometry post{Shape::sphere(0.1), cut.world.objects[0].X_WO, {}};
  for (const double margin : {0.1, 2.0}) {
    Object& object = cut.world.objects[0];
    object.cloud = std::make_shared<const PointCloud>(
        carved(*object.cloud, object.X_WO, {&post, 1}, margin, "post"));
    Problem loaded = again(cut);
    const PointCloud& cloud = *loaded.world.objects[0].cloud;
    EXPECT_EQ(cloud.size(), object.cloud->size());
    ASSERT_EQ(cloud.filters.size(), 1u);
    EXPECT_EQ(cloud.filters[0].removed, margin > 1 ? 2u : 1u);
    loaded.world.objects[0].X_WO.translation.x() = 1;
    expectInputError([&] { validate(loaded); }, loaded.name, 0, {"at which it was carved"});
  }
  // The balls of a thinned cloud still stand for others.
  Problem thin = load("balls: [[0, 0, 0, 0.1], [0.1, 0, 0, 0.2]]");
  std::shared_ptr<const PointCloud>& all = thin.world.objects[0].cloud;
  all = std::make_shared<const PointCloud>(thinned(*all, 1));
  EXPECT_TRUE(again(thin).world.objects[0].cloud->isThinned());
  const std::string name = folder.path("b.yaml");
  for (const auto& wrong : {std::pair("balls: []", "at least one"),
                            {"balls: [], thinned: 3", "at least one"},
                            {"balls: [[0, 0, 0, 1]], thinned: 0", "thinned"},
                            {"file: b.yaml, radius: 1, thinned: 1", "without 'balls'"},
                            {"balls: [[0, 0, 0, 1]], carved: 0", "carved"},
                            {"file: b.yaml, radius: 1, carved: 1", "without 'balls'"},
                            {"balls: [[0, 0, 0]]", "radius"},
                            {"balls: [[0, 0, 0, -1]]", "radius -1"},
                            {"balls: [[0, 0, 0, 1]], radius: 1", "beside"},
                            {"balls: [[0, 0, 0, 1]], unseen: occupied", "free"}})
    expectInputError([&] { load(wrong.first); }, name, 6, {wrong.second});
}

}  // namespace
}  // namespace leeway::planner
