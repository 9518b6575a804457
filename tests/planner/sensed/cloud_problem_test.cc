// Clouds in problems: what is read, refused, filtered, planned among and verified.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "collision/base/numbers.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/save_problem.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/placed_model.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

using Eigen::Vector3d;

/// A ball of 0.1 m that moves in space, with its start and goal.
const std::string kBall =
    "leeway: 1\n"
    "body:\n"
    "  name: ball\n"
    "  joint: floating\n"
    "  bounds: {lower: [-2, -1, -1], upper: [2, 1, 1]}\n"
    "  shapes: [{sphere: {radius: 0.1}}]\n"
    "start: {position: [-1, 0, 0]}\n"
    "goal: {position: [1, 0, 0]}\n"
    "objects:\n";

class CloudProblems : public testing::Test {
 protected:
  Problem load(const std::string& text, const std::string& points = "0 0 0\n") {
    folder_.write("scan.xyz", points);
    return loadProblem(folder_.write("problem.yaml", text));
  }
  void expectError(const std::string& text, int line, std::initializer_list<std::string> words) {
    SCOPED_TRACE(text.substr(text.rfind("objects:")));
    folder_.write("scan.xyz", "0 0 0\n");
    const std::string path = folder_.write("problem.yaml", text);
    robots::expectInputError([&] { loadProblem(path); }, path, line, words);
  }
  /// A square grid of points across the way, with a hole around (y, z).
  static std::string wall(double spacing, double y, double z, double hole) {
    std::string points;
    for (double a = -1; a <= 1 + 1e-9; a += spacing)
      for (double b = -1; b <= 1 + 1e-9; b += spacing)
        if (std::hypot(a - y, b - z) > hole)
          points += "0 " + std::to_string(a) + " " + std::to_string(b) + "\n";
    return points;
  }
  /// The path of a ball that does not turn.
  static Path pathOf(const Problem& problem, const std::vector<Vector3d>& places) {
    Path path;
    for (const int v : problem.robot.variables)
      path.names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
    for (const Vector3d& p : places) path.positions.push_back({p.x(), p.y(), p.z(), 0, 0, 0, 1});
    return path;
  }
  Folder folder_;
};

TEST_F(CloudProblems, ACloudWithoutANameIsOneErrorWhereAllAreCollected) {
  folder_.write("scan.xyz", "0 0 0\n");
  robots::InputErrors errors;
  ProblemOptions options;
  options.load.errors = &errors;
  const std::string path = folder_.write(
      "problem.yaml", kBall + " - {n*ae: wall, cloud: {file: scan.xyz, radius: 0.02}}\n");
  EXPECT_THROW(loadProblem(path, options), robots::InputError);
  EXPECT_GT(errors.count(), 0U);
}

TEST_F(CloudProblems, PlansAmongBallsAsAmongSpheres) {
  // More balls than a PairTable has places.
  const std::string points = wall(0.03, 0.4, 0.3, 0.25);
  Problem problem =
      load(kBall + " - {name: wall, cloud: {file: scan.xyz, radius: 0.022}}\n" + "margin: 0.01\n",
           points);
  problem.limits = {60, 0};
  ASSERT_GT(problem.world.objects[0].cloud->size(), 4000U);
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  const VerifyResult verified = verify(problem, result.path);
  EXPECT_EQ(verified.status, VerifyStatus::kCertified) << verified.reason;
  EXPECT_GE(verified.clearance_lower, 0.01);
  EXPECT_LE(verified.clearance_lower, 0.13);  // the hole is 25 cm minus the balls

  // The same world as spheres.
  Problem spheres = problem;
  spheres.world.objects[0].geometries = geometriesOf(*problem.world.objects[0].cloud);
  spheres.world.objects[0].cloud = nullptr;
  const PlanResult twin = plan(spheres);
  EXPECT_EQ(twin.path.positions, result.path.positions);
  EXPECT_EQ(twin.certificate.clearance.lower, result.certificate.clearance.lower);
  EXPECT_EQ(verify(spheres, result.path).status, VerifyStatus::kCertified);
}

TEST_F(CloudProblems, VerifyRefutesAPathThroughBalls) {
  const Problem problem = load(kBall + " - {name: wall, cloud: {file: scan.xyz, radius: 0.022}}\n",
                               wall(0.03, 0.4, 0.3, 0.25));
  const Path path = pathOf(problem, {{-1, 0, 0}, {1, 0, 0}});
  const VerifyResult refuted = verify(problem, path);
  EXPECT_EQ(refuted.status, VerifyStatus::kRefuted);
  EXPECT_EQ(refuted.b, "wall");
  // Where the balls leave room for the ball's whole way, it is certified.
  const Problem free = load(kBall + " - {name: wall, cloud: {file: scan.xyz, radius: 0.022}}\n",
                            wall(0.03, 0, 0, 0.25));
  const VerifyResult certified = verify(free, path);
  EXPECT_EQ(certified.status, VerifyStatus::kCertified) << certified.reason;
  EXPECT_GT(certified.clearance_lower, 0.04);
  EXPECT_LT(certified.clearance_lower, 0.17);
}

TEST_F(CloudProblems, VerifyCountsACloudThatMayBeTouched) {
  const std::string wall = kBall + " - {name: wall, cloud: {file: scan.xyz, radius: 0.022}}\n";
  const std::string allowed = "allowed: [[ball, wall]]\n";
  const auto verified = [&](const std::string& text) {
    const Problem problem = load(text);
    return verify(problem, pathOf(problem, {{-1, 0, 0}, {1, 0, 0}}));
  };
  EXPECT_EQ(verified(wall).status, VerifyStatus::kRefuted);
  EXPECT_EQ(plan(load(wall + allowed)).status, PlanStatus::kNothingChecked);
  const VerifyResult nothing = verified(wall + allowed);
  EXPECT_EQ(nothing.status, VerifyStatus::kNothingChecked);
  EXPECT_NE(nothing.reason.find("no pair with the world is checked"), std::string::npos);
  ASSERT_EQ(nothing.unchecked.size(), 1U);
  EXPECT_EQ(nothing.unchecked[0].why, Unchecked::kAllowed);
  EXPECT_EQ(nothing.unchecked[0].count, 1);
  // A cloud is also the only thing that is checked beside an object that may be touched.
  const std::string post = " - {name: post, position: [0, 0, 0.9], sphere: {radius: 0.1}}\n";
  const VerifyResult refuted = verified(wall + post + "allowed: [[ball, post]]\n");
  EXPECT_EQ(refuted.status, VerifyStatus::kRefuted) << refuted.reason;
  EXPECT_EQ(refuted.b, "wall");
}

TEST_F(CloudProblems, VerifyAgreesWithSpheresOnRandomEdges) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.8, 0.8);
  std::string points;
  for (int i = 0; i < 60; ++i)
    points += std::to_string(place(random)) + " " + std::to_string(place(random)) + " " +
              std::to_string(place(random)) + "\n";
  Problem problem = load(
      kBall + " - {name: dust, rpy: [0.3, 0, 1], cloud: {file: scan.xyz, radius: 0.05}}\n", points);
  Problem spheres = problem;
  spheres.world.objects[0].geometries = geometriesOf(*problem.world.objects[0].cloud);
  spheres.world.objects[0].cloud = nullptr;
  int certified = 0, refuted = 0;
  for (int i = 0; i < 60; ++i) {
    const Path path =
        pathOf(problem, {{-1, place(random), place(random)}, {1, place(random), place(random)}});
    for (Problem* p : {&problem, &spheres}) {
      p->start = path.positions[0];
      p->goals[0].ranges.clear();
      for (const double x : path.positions[1]) p->goals[0].ranges.emplace_back(x, x);
    }
    const VerifyResult of_cloud = verify(problem, path), of_spheres = verify(spheres, path);
    ASSERT_EQ(of_cloud.status, of_spheres.status) << i;
    certified += of_cloud.status == VerifyStatus::kCertified ? 1 : 0;
    refuted += of_cloud.status == VerifyStatus::kRefuted ? 1 : 0;
    if (of_cloud.status != VerifyStatus::kCertified) continue;
    // Both are lower bounds of one clearance, and neither is far below the other.
    EXPECT_GT(of_cloud.clearance_lower, 0.3 * of_spheres.clearance_lower);
    EXPECT_LT(of_cloud.clearance_lower, 3 * of_spheres.clearance_lower);
  }
  EXPECT_GT(certified, 5);
  EXPECT_GT(refuted, 5);
}

TEST_F(CloudProblems, BallsAtTheEndsOfSpaceAreVerified) {
  const Problem problem = load(kBall + " - {name: far, cloud: {file: scan.xyz, radius: 0.05}}\n",
                               "1e9 1e9 1e9\n-1e9 -1e9 -1e9\n0 0.5 0\n");
  const Path path = pathOf(problem, {{-1, 0, 0}, {1, 0, 0}});
  const VerifyResult certified = verify(problem, path);
  EXPECT_EQ(certified.status, VerifyStatus::kCertified) << certified.reason;
  EXPECT_GT(certified.clearance_lower, 0.17);
  EXPECT_LE(certified.clearance_lower, 0.35);
}

TEST_F(CloudProblems, FiltersAreAppliedInOrder) {
  const Problem problem = load(
      kBall +
          " - {name: can, position: [0, 0.5, 0], cylinder: {radius: 0.1, length: 0.2}}\n"
          " - name: scan\n"
          "   position: [0, 0.5, 0]\n"
          "   cloud: {file: scan.xyz, radius: 0.02, carve: [can, robot], carve_margin: 0.01, crop: "
          "0.3, thin: 0.05}\n"
          "margin: 0.01\n",
      "0.1 0 0\n"         // touches the can
      "0.129 0 0\n"       // within the margin of it
      "0.131 0 0\n"       // stays
      "-1 -0.385 0\n"     // touches the robot at its start
      "0.51 0.01 0.01\n"  // these two share a cell
      "0.53 0.02 0.02\n"  //
      "9 0 0\n"           // is out of reach
      "nan 0 0\n");
  const PointCloud& cloud = *problem.world.objects[1].cloud;
  ASSERT_EQ(cloud.filters.size(), 4U);
  const char* const names[] = {"drop", "carve", "crop", "thin"};
  const std::size_t removed[] = {1, 3, 1, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(cloud.filters[i].name, names[i]);
    EXPECT_EQ(cloud.filters[i].removed, removed[i]) << names[i];
  }
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_EQ(cloud.balls[0].center, Vector3d(0.131, 0, 0));
  EXPECT_EQ(cloud.balls[0].radius, 0.02);
  EXPECT_GT(cloud.balls[1].radius, 0.02);
  EXPECT_EQ(cloud.completeWithin(), 0.3);
}

TEST_F(CloudProblems, ACropSmallerThanAMarginIsRefused) {
  Problem problem = load(kBall +
                             " - {name: scan, cloud: {file: scan.xyz, radius: 0.02, crop: 0.05}}\n"
                             "margin: 0.04\n",
                         "0 0.5 0\n");
  EXPECT_NO_THROW(CompiledScene{problem});
  const auto refused = [&] {
    try {
      CompiledScene scene(problem);
    } catch (const robots::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  problem.margins.common = 0.06;
  EXPECT_NE(refused().find("cloud 'scan' lacks what is farther than 0.05 m"), std::string::npos);
  problem.margins.common = 0;
  problem.margins.wishes.push_back({"wide", {{"ball", "scan"}}, 0.1, 1});
  EXPECT_NE(refused().find("a crop of at least that"), std::string::npos);
  problem.margins.wishes.clear();
  problem.objective = MinimumLength{0.2};
  EXPECT_NE(refused().find("0.2 m"), std::string::npos);
  const auto cost = [](Nearness::Kind kind, double distance, Pairs of) {
    return MinimumCost{1, {{{kind, distance}, 1, false, of}}};
  };
  problem.objective = cost(Nearness::Kind::kHinge, 0.05, Pairs::kWorld);
  EXPECT_EQ(refused(), "");
  problem.objective = cost(Nearness::Kind::kHinge, 0.3, Pairs::kAll);
  EXPECT_NE(refused().find("0.3 m"), std::string::npos) << refused();
  problem.objective = cost(Nearness::Kind::kInverse, 0.01, Pairs::kWorld);
  EXPECT_NE(refused().find("cost reaches inf m"), std::string::npos) << refused();
  problem.objective = cost(Nearness::Kind::kInverse, 0.01, Pairs::kSelf);
  EXPECT_EQ(refused(), "");
}

/// Regression: a place beyond the joint's limit, where points had been cropped, was free.
TEST_F(CloudProblems, OutsideTheLimitsACroppedCloudLeavesPlacesUndecided) {
  folder_.write("slider.urdf", R"(<robot name="s"><link name="base"/>
<link name="car"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="car"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
</robot>)");
  const Problem cropped = load(
      "leeway: 1\nrobot: {urdf: slider.urdf}\nstart: [0.1]\ngoal: [0.4]\nobjects:\n"
      " - {name: scan, cloud: {file: scan.xyz, radius: 0.01, crop: 0.02}}\n",
      "0.3 0 0.07\n0.9 0 0\n");
  EXPECT_EQ(cropped.world.objects[0].cloud->size(), 1U);
  Problem empty = cropped;
  empty.world.objects.clear();
  const auto without = std::make_shared<const CompiledScene>(empty);
  const auto decide = [](const std::shared_ptr<const CompiledScene>& scene, double x) {
    return EdgeCertifier(scene).decide(std::vector<double>{x});
  };
  for (const auto& scene : {std::make_shared<const CompiledScene>(cropped),
                            without->withObjects(cropped.world.objects)}) {
    EXPECT_EQ(decide(scene, 0.1), Verdict::kFree);
    EXPECT_EQ(decide(scene, 0.9), Verdict::kUndecided);
  }
  EXPECT_EQ(decide(without, 0.9), Verdict::kFree);
}

/// Regression: a saved crop lost the reach that it was made for, and a carved cloud its pose, so
/// that in an edited file places were free where the scan has points.
TEST_F(CloudProblems, SavedCloudsHoldForTheirRobotAndPlace) {
  folder_.write("slider.urdf", R"(<robot name="s"><link name="base"/>
<link name="car"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="car"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
</robot>)");
  const std::string file = folder_.path("saved.yaml");
  const auto save = [&](const std::string& filters, const std::string& points) {
    const Problem problem = load(
        "leeway: 1\nrobot: {urdf: slider.urdf}\nstart: [0]\ngoal: [0.5]\nobjects:\n"
        " - {name: post, box: {size: [0.1, 0.1, 0.1]}, position: [0, 0.11, 0]}\n"
        " - {name: scan, position: [0, 0.1, 0], rpy: [0.3, 0.4, 0], cloud: "
        "{file: scan.xyz, radius: 0.02, " +
            filters + "}}\n",
        points);
    saveProblem(problem, file);
    const Problem loaded = loadProblem(file);
    const PointCloud &before = *problem.world.objects[1].cloud,
                     &after = *loaded.world.objects[1].cloud;
    EXPECT_EQ(after.size(), before.size());
    ASSERT_EQ(after.filters.size(), 1U);
    EXPECT_EQ(after.filters.back().removed, before.filters.back().removed);
    EXPECT_EQ(after.completeWithin(), before.completeWithin());
  };
  const auto edited = [&](const std::string& old, const std::string& now) {
    std::string text = readText(file);
    const std::size_t place = text.find(old);
    if (place == std::string::npos) return "no " + old + " in " + text;
    try {
      loadProblem(folder_.write("edited.yaml", text.replace(place, old.size(), now)));
    } catch (const robots::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto expectRefused = [&](const std::string& old, const std::string& now,
                                 const std::string& words) {
    const std::string message = edited(old, now);
    EXPECT_NE(message.find(words), std::string::npos) << message;
    EXPECT_NE(message.find("cloud 'scan'"), std::string::npos) << message;
    EXPECT_NE(message.find("edited.yaml:"), std::string::npos) << message;
  };
  const std::string wider = "bounds: {x: {range: [0, 2], widen: true}}\nstart:";
  const auto expectHeld = [&] {
    EXPECT_EQ(edited("0.5", "0.4"), "");
    expectRefused("start:", wider, "reaches less far");
    expectRefused("position: [0, 0.1, 0]", "position: [0, -0.2, 0]", "cropped");
  };
  save("crop: 0.1", "0.2 0.4 0\n1.2 0 0\n");
  expectHeld();
  save("crop: 0.1", "1.2 0 0\n");
  expectHeld();
  save("carve: [post]", "0 0 0\n0.5 0.9 0\n");
  expectRefused("position: [0, 0.1, 0]", "position: [0, -0.2, 0]", "was carved");
}

/// Regression: a certificate promised a controller 330 mm where points 70 mm away were cropped.
TEST_F(CloudProblems, CertificatesClaimNoMoreThanACropLeaves) {
  const Problem problem =
      load(kBall + " - {name: scan, cloud: {file: scan.xyz, radius: 0.1, crop: 0.01}}\n",
           "0 0.6 0\n0 5 0\n");
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  const Certificate& proof = result.certificate;
  EXPECT_TRUE(proof.certified);
  EXPECT_EQ(proof.clearance.lower, 0.01);
  EXPECT_EQ(proof.world.clearance.lower, 0.01);
  for (const Interval& segment : proof.segments) EXPECT_LE(segment.lower, 0.01);
  EXPECT_GT(proof.clearance.upper, 0.1);
  const VerifyResult verified = verify(problem, result.path);
  EXPECT_EQ(verified.status, VerifyStatus::kCertified);
  EXPECT_EQ(verified.clearance_lower, 0.01);
  // Single places and edges claim no more either, also if no ball is left.
  Problem empty = problem;
  auto nothing = std::make_shared<PointCloud>(*problem.world.objects[0].cloud);
  nothing->balls.clear();
  empty.world.objects[0].cloud = nothing;
  for (const Problem* of : {&problem, static_cast<const Problem*>(&empty)}) {
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(*of));
    const std::vector<double>&a = result.path.positions[0], &b = result.path.positions[1];
    EXPECT_LE(certifier.clearance(a, 1e-4).clearance.lower, 0.01);
    EXPECT_LE(certifier.tooNear(a, 1e-4).clearance.lower, 0.01);
    for (const Pairs pairs : {Pairs::kAll, Pairs::kWorld})
      EXPECT_LE(certifier.edgeClearance(a, b, {.pairs = pairs}).clearance.lower, 0.01);
    EXPECT_GT(certifier.edgeClearance(a, b, {.pairs = Pairs::kSelf}).clearance.lower, 1);
  }
}

TEST_F(CloudProblems, ACropThatDoesNotSufficeNamesItsLine) {
  const std::string begin =
      kBall + " - {name: can, sphere: {radius: 0.1}, position: [0, 0.9, 0]}\n";
  const std::string cloud =
      begin + " - {name: scan, cloud: {file: scan.xyz, radius: 0.1, crop: 0.05}}\n";
  expectError(cloud + "margin: 0.1\n", 11, {"crop", "'scan'", "0.1 m"});
  expectError(cloud + "margins: [{between: [ball, can], margin: 0.2}]\n", 11, {"crop", "0.2 m"});
  expectError(cloud + "objective: {integral: {inverse: 0.1}}\n", 11, {"crop", "inf"});
  std::string task = cloud;
  const std::string goal = "goal: {position: [1, 0, 0]}\n";
  task.replace(task.find(goal), goal.size(),
               "steps: [{name: grasp, attach: {object: can, link: ball}}]\n");
  expectError(task, 11, {"crop", "step 'grasp' attaches an object", "not cropped"});
}

/// A cloud that was cropped lacks what another robot, or the same in another state, reaches.
TEST_F(CloudProblems, ACropHoldsForTheRobotAndThePlaceOfItsCloud) {
  folder_.write("arm.urdf", R"(<robot name="arm"><link name="base"/>
<link name="l1"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="l2"><collision><origin xyz="0.15 0 0"/><geometry><box size="0.3 0.05 0.05"/></geometry></collision></link>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="2" effort="1"/></joint>
<joint name="ext" type="prismatic"><parent link="l1"/><child link="l2"/><origin xyz="0.4 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper="1" velocity="2" effort="1"/></joint>
</robot>)");
  folder_.write("arm.srdf", R"(<robot name="arm"><group name="rot"><joint name="a"/></group>
<group name="both"><joint name="a"/><joint name="ext"/></group></robot>)");
  const Problem whole = load(
      "leeway: 1\nrobot: {urdf: arm.urdf, srdf: arm.srdf, group: rot}\nstart: [-0.5]\ngoal: [0.5]\n"
      "objects:\n - {name: wall, cloud: {file: scan.xyz, radius: 0.02, crop: 0.1}}\n"
      " - {name: stick, box: {size: [1, 0.03, 0.03]}, position: [1, 0, 0.3]}\n",
      "1.2 0 0\n0 0.7 0\n");
  ASSERT_EQ(whole.world.objects[0].cloud->size(), 1U);
  const auto refused = [](const Problem& problem) {
    try {
      CompiledScene scene(problem);
    } catch (const robots::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto edited = [&](const auto& edit) {
    Problem problem = whole;
    edit(problem);
    return refused(problem);
  };
  const auto expectRefused = [](const std::string& message, const std::string& words) {
    EXPECT_NE(message.find("cloud 'wall' "), std::string::npos) << message;
    EXPECT_NE(message.find(words), std::string::npos) << message;
  };
  EXPECT_EQ(refused(whole), "");
  const std::string less = "reaches less far";
  expectRefused(refused(attachObject(whole, "stick", "l2")), less);
  expectRefused(edited([](Problem& p) { p.start[1] = 0.7; }), less);
  expectRefused(edited([](Problem& p) {
                  p.robot.variables = {0, 1};
                  p.goals.clear();
                }),
                less);
  expectRefused(edited([](Problem& p) {
                  robots::Pose X_WB;
                  X_WB.translation = {0.55, 0, 0};
                  p.robot.model = robots::withBasePose(*p.robot.model, X_WB);
                }),
                less);
  expectRefused(edited([](Problem& p) { p.world.objects[0].X_WO.translation.x() = -0.7; }),
                "another pose");
  expectRefused(edited([](Problem& p) {
                  p.goals.clear();
                  Step& step = p.steps.emplace_back();
                  step.name = "take";
                  step.action = AttachStep{"stick", "l2", {}};
                }),
                "step 'take' attaches an object");
  // Less reach is covered, and the joints that are planned may start elsewhere.
  EXPECT_EQ(edited([](Problem& p) { p.start[0] = 0.9; }), "");
  EXPECT_EQ(edited([](Problem& p) {
              p.robot.model = robots::withBounds(*p.robot.model, {{"a", {{"", {-0.6, 0.6}}}}});
            }),
            "");
  EXPECT_EQ(edited([](Problem& p) { p.world.objects.pop_back(); }), "");
  // The same holds for objects that come later.
  Problem bare = whole;
  bare.world.objects.erase(bare.world.objects.begin());
  const std::vector<Object> wall{whole.world.objects[0]};
  EXPECT_NO_THROW(CompiledScene(bare).withObjects(wall));
  bare.start[1] = 0.7;
  EXPECT_THROW(CompiledScene(bare).withObjects(wall), robots::InputError);
}

TEST_F(CloudProblems, BallsThatAProgramSetsAreChecked) {
  Problem problem = load(kBall + " - {name: scan, cloud: {file: scan.xyz, radius: 0.02}}\n");
  const auto with = [&](const PointCloud::Ball& ball) {
    PointCloud cloud;
    cloud.balls.push_back(ball);
    problem.world.objects[0].cloud = std::make_shared<const PointCloud>(cloud);
    CompiledScene scene(problem);
  };
  EXPECT_NO_THROW(with({{0, 0.5, 0}, 0.02}));
  EXPECT_THROW(with({{0, 0.5, 0}, -0.02}), robots::InputError);
  EXPECT_THROW(with({{0, 0.5, 0}, std::nan("")}), robots::InputError);
  EXPECT_THROW(with({{0, 1e300, 0}, 0.02}), robots::InputError);
  EXPECT_THROW(with({{0, std::nan(""), 0}, 0.02}), robots::InputError);
  problem.world.objects[0].cloud = std::make_shared<const PointCloud>();
  EXPECT_THROW(CompiledScene{problem}, robots::InputError) << "no ball is no obstacle";
}

TEST_F(CloudProblems, ACloudIsNotHeld) {
  Problem problem = load(kBall + " - {name: scan, cloud: {file: scan.xyz, radius: 0.02}}\n");
  EXPECT_THROW(attachObject(problem, "scan", "ball"), std::invalid_argument);
  Attachment held;
  held.object = problem.world.objects[0];
  held.link = 0;
  problem.world.objects.clear();
  problem.robot.attachments.push_back(held);
  EXPECT_THROW(CompiledScene{problem}, robots::InputError);
}

TEST_F(CloudProblems, ACloudThatMovesByABoundIsNotCropped) {
  const auto with = [](const std::string& filters, const std::string& motion) {
    return kBall + " - {name: can, sphere: {radius: 0.1}, position: [0, 0.9, 0]}\n" +
           " - name: scan\n   cloud: {file: scan.xyz, radius: 0.1" + filters +
           "}\n   moving: " + motion + "\n";
  };
  const auto motionOf = [&](const std::string& filters, const std::string& motion) {
    const Problem problem = load(with(filters, motion));
    validate(problem);
    return *problem.world.objects.back().motion;
  };
  EXPECT_EQ(motionOf("", "{speed_bound: 0.2}").speed_bound, 0.2);
  EXPECT_EQ(motionOf("", "{speed_bound: 0.2}").turn_bound, 0);
  EXPECT_EQ(motionOf("", "{speed_bound: 0.2, turn_bound: 0.1, age: 1}").turn_bound, 0.1);
  EXPECT_EQ(motionOf(", carve: [can]", "{speed_bound: 0.2}").speed_bound, 0.2);
  EXPECT_EQ(motionOf(", thin: 0.1", "{velocity: [0.1, 0, 0]}").speed_bound, kInfinity);
  expectError(with("", "{turn_bound: 0.2}"), 13, {"no 'speed_bound'"});
  expectError(with(", crop: 1", "{speed_bound: 0.2}"), 12, {"'scan' moves", "was cropped"});
  expectError(with(", carve: [can]", "{velocity: [0.1, 0, 0]}"), 12, {"carved for one place"});
}

TEST_F(CloudProblems, WhatMovesIsCarvedOutAtTheStartOnly) {
  const Problem problem =
      load(kBall +
           " - {name: can, sphere: {radius: 0.1}, position: [0, 0.9, 0], moving: {speed_bound: 1, "
           "turn_bound: 0}}\n"
           " - {name: jar, sphere: {radius: 0.1}, position: [0, -0.9, 0]}\n"
           " - {name: scan, cloud: {file: scan.xyz, radius: 0.1, carve: [can, robot]}}\n");
  const std::vector<std::string> can = {"can"}, rest = {"jar", "robot"}, none, cloud = {"scan"};
  EXPECT_EQ(shapesToCarve(problem, can).size(), 1u);
  EXPECT_EQ(shapesToCarve(problem, rest, problem.start).size(), 2u);
  EXPECT_THROW((void)shapesToCarve(problem, can, problem.start), std::invalid_argument);
  EXPECT_THROW((void)shapesToCarve(problem, none), std::invalid_argument);
  EXPECT_THROW((void)shapesToCarve(problem, cloud), std::invalid_argument);
  // Beyond its limits the robot would carve out what it is not at.
  std::vector<double> beyond = problem.start;
  for (const double x : {2.5, kInfinity, std::nan("")}) {
    beyond[0] = x;
    EXPECT_THROW((void)shapesToCarve(problem, rest, beyond), std::invalid_argument) << x;
  }
}

TEST_F(CloudProblems, BadKeysNameTheirLine) {
  const std::string begin = kBall + " - {name: can, sphere: {radius: 0.1}}\n - name: scan\n   ";
  expectError(begin + "cloud: {file: scan.xyz}\n", 12, {"'radius'"});
  expectError(begin + "cloud: {radius: 0.1}\n", 12, {"'file'"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0}\n", 12, {"radius 0", "1e-09"});
  expectError(begin + "cloud: {file: scan.xyz, radius: -1}\n", 12, {"radius -1"});
  expectError(begin + "cloud: {file: scan.xyz, radius: .nan}\n", 12, {"radius"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, thinn: 1}\n", 12,
              {"'thinn'", "'thin'"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, thin: 0}\n", 12, {"a cell of 0;"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, crop: -1}\n", 12, {"distance -1"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, carve_margin: 1}\n", 12,
              {"'carve_margin' stands without 'carve'"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, carve: [cam]}\n", 12,
              {"no link or object is named 'cam'", "did you mean 'can'"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, carve: []}\n", 12,
              {"carve", "is empty; names of links or objects are expected"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, carve: [scan]}\n", 12,
              {"'scan', which is a cloud"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1, carve: [can], carve_margin: -1}\n", 12,
              {"carve_margin"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1}\n   box: {size: [1, 1, 1]}\n", 11,
              {"both 'cloud' and 'box'"});
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1}\n   attach: {link: ball}\n", 11,
              {"both 'cloud' and 'attach'"});
  // Only a saved cloud has shapes, too: its unseen space.
  const std::string shapes = "   shapes: [{sphere: {radius: 1}}]\n";
  expectError(begin + "cloud: {file: scan.xyz, radius: 0.1}\n" + shapes, 11,
              {"both 'cloud' and 'shapes'"});
  expectError(begin + "cloud: {balls: [[0, 0, 0, 1]], carve: [can]}\n" + shapes, 11,
              {"both 'cloud' and 'shapes'"});
}

TEST_F(CloudProblems, ReachContainsTheRobotWhereverItGoes) {
  const Problem problem = loadProblem(sourceFolder() + "/problems/pick_place/can.yaml");
  const std::vector<PointCloud::Ball> reach = reachOf(problem);
  const robots::Model& model = *problem.robot.model;
  std::mt19937 random(2);
  double farthest = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<double> q = problem.start;
    for (const int v : problem.robot.variables) {
      const robots::Variable& variable = model.variables[static_cast<std::size_t>(v)];
      std::uniform_real_distribution<double> value(variable.lower, variable.upper);
      q[static_cast<std::size_t>(v)] = value(random);
    }
    for (const robots::Geometry& g : shapesOf(problem, "robot", q)) {
      const Vector3d p = g.X_BG * g.shape.boundingCenter();
      farthest = std::max(farthest, p.norm());
      EXPECT_TRUE(std::any_of(reach.begin(), reach.end(), [&](const PointCloud::Ball& ball) {
        return (p - ball.center).norm() + g.shape.boundingRadius() <= ball.radius + 1e-9;
      }));
    }
  }
  EXPECT_GT(farthest, 0.8);
  for (const PointCloud::Ball& ball : reach) EXPECT_LT(ball.radius, 2);
  EXPECT_THROW(shapesOf(problem, "cann"), std::invalid_argument);
  EXPECT_EQ(shapesOf(problem, "bin").size(), 5U);
}

}  // namespace
}  // namespace leeway::planner
