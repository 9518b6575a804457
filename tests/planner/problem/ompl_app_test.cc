// OMPL.app's problems (.cfg): what is read, and what is said of what cannot be.

#include <gtest/gtest.h>

#include <string>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/kinematics.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

/// A tetrahedron with its corners' mean at (1, 2, 3). Of each face Assimp makes its own vertices
/// when it makes normals; each corner is in three faces, so that the mean is the corners'.
constexpr const char* kRobot =
    "v 0 1 2\nv 4 1 2\nv 0 5 2\nv 0 1 6\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// A wall 0.2 thick at x = 10, with z = -50 to 50 and y = -50 to 50.
constexpr const char* kWorld =
    "v 9.9 -50 -50\nv 10.1 -50 -50\nv 10.1 50 -50\nv 9.9 50 -50\n"
    "v 9.9 -50 50\nv 10.1 -50 50\nv 10.1 50 50\nv 9.9 50 50\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// One triangle (1, 0, 0), (0, 2, 0), (0, 0, 3) with z up: z is Assimp's y, y its -z.
constexpr const char* kZUp = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">1 0 0 0 2 0 0 0 3</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";

const std::string kSpace =
    "[problem]\nname = pass # a comment\nrobot=robot.obj\nworld = world.obj\n"
    "start.x = -5\nstart.y = 1\nstart.z = 2\nstart.theta = 0\nstart.axis.x = 1\nstart.axis.y = 0\n"
    "start.axis.z = 0\n"
    "goal.x = -7\ngoal.y = -60\ngoal.z = 2\ngoal.theta = 1.5\ngoal.axis.x = 0\ngoal.axis.y = 0\n"
    "goal.axis.z = 2\n";
const std::string kVolume =
    "volume.min.x = -20\nvolume.min.y = -30\nvolume.min.z = -10\n"
    "volume.max.x = 20\nvolume.max.y = 30\nvolume.max.z = 10\n";

class OmplApp : public ::testing::Test {
 protected:
  OmplApp() {
    folder_.write("robot.obj", kRobot);
    folder_.write("world.obj", kWorld);
    folder_.write("turned.dae", kZUp);
  }
  Problem load(const std::string& text) { return loadProblem(folder_.write("p.cfg", text)); }
  void expectRefused(const std::string& text, int line, std::initializer_list<std::string> words) {
    robots::expectInputError([&] { load(text); }, folder_.path("p.cfg"), line, words);
  }
  static std::string replaced(std::string text, const std::string& a, const std::string& b) {
    const std::size_t at = text.find(a);
    EXPECT_NE(at, std::string::npos) << a;
    return at == std::string::npos ? text : text.replace(at, a.size(), b);
  }
  Folder folder_;
};

TEST_F(OmplApp, ABodyInSpace) {
  const Problem problem =
      load(kSpace + kVolume + "objective = length\nobjective.threshold = 0\nsampler = gaussian\n" +
           "[benchmark]\ntime_limit=2.5\nmem_limit=1000\n[planner]\nrrt=\nrrt.range=3\nrrt=\n");
  EXPECT_EQ(problem.name, "pass");
  EXPECT_TRUE(problem.warnings.empty());
  EXPECT_EQ(problem.limits.time, 2.5);
  const robots::Model& model = *problem.robot.model;
  ASSERT_EQ(model.variables.size(), 7U);
  // The mean of the vertices is the body's origin.
  const robots::Geometry& robot = model.links[0].geometries.at(0);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : robot.shape.mesh()->vertices()) mean += 0.25 * (robot.X_BG * v);
  EXPECT_EQ(robot.shape.mesh()->vertices().size(), 4U);
  EXPECT_LT(mean.norm(), 1e-6);
  EXPECT_LT((robot.X_BG.translation - Eigen::Vector3d(-1, -2, -3)).norm(), 1e-6);
  EXPECT_EQ(std::vector<double>(problem.start.begin(), problem.start.end()),
            (std::vector<double>{-5, 1, 2, 0, 0, 0, 1}));
  const auto& goal = problem.goals.at(0).ranges;
  EXPECT_EQ(goal[0].first, -7);
  EXPECT_NEAR(goal[5].first, std::sin(0.75), 1e-15);
  EXPECT_NEAR(goal[6].first, std::cos(0.75), 1e-15);
  // The volume, which the goal widens.
  EXPECT_EQ(model.variables[0].lower, -20);
  EXPECT_EQ(model.variables[1].lower, -60);
  EXPECT_EQ(model.variables[1].upper, 30);
  EXPECT_EQ(model.variables[2].upper, 10);
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
}

TEST_F(OmplApp, ABodyInThePlane) {
  const Problem problem = load(
      "[problem]\nrobot = robot.obj\nworld = world.obj\nobjective = max_min_clearance\n"
      "start.x = -5\nstart.y = 1\nstart.theta = 0.5\ngoal.x = -9\ngoal.y = 2\ngoal.theta = 9\n");
  EXPECT_EQ(problem.name, "p");
  const robots::Model& model = *problem.robot.model;
  ASSERT_EQ(model.variables.size(), 3U);
  EXPECT_EQ(problem.start, (std::vector<double>{-5, 1, 0.5}));
  // Only x and y are centered.
  EXPECT_LT((model.links[0].geometries.at(0).X_BG.translation - Eigen::Vector3d(-1, -2, 0)).norm(),
            1e-6);
  // Without a volume, the world's box and both ends.
  EXPECT_EQ(model.variables[0].lower, -9);
  EXPECT_NEAR(model.variables[0].upper, 10.1, 1e-6);
  EXPECT_EQ(model.variables[1].upper, 50);
  EXPECT_TRUE(std::holds_alternative<MaximumClearance>(problem.objective));
}

/// OMPL.app leaves Assimp's own up axis, y, in force.
TEST_F(OmplApp, ZUpIsTurnedToYUp) {
  const Problem problem = load(replaced(kSpace, "world.obj", "turned.dae") + kVolume);
  const auto& vertices = problem.world.objects.at(0).geometries.at(0).shape.mesh()->vertices();
  double highest = 0, lowest = 0;
  for (const Eigen::Vector3d& v : vertices) {
    highest = std::max(highest, v.y());
    lowest = std::min(lowest, v.z());
  }
  EXPECT_NEAR(highest, 3, 1e-6);
  EXPECT_NEAR(lowest, -2, 1e-6);
}

/// The world comes exactly, even where Assimp would not read it, and warnings with the problem.
TEST_F(OmplApp, MeshesAreReadExactly) {
  folder_.write("far.obj", std::string(kWorld) + "v 4000000.04 0 0\nf 1 2 9\nl 1 2\n");
  const Problem problem = load(replaced(kSpace, "world.obj", "far.obj") + kVolume);
  const auto& vertices = problem.world.objects.at(0).geometries.at(0).shape.mesh()->vertices();
  EXPECT_EQ(vertices[0].x(), 9.9);
  EXPECT_EQ(vertices.back().x(), 4000000.04);
  ASSERT_EQ(problem.warnings.size(), 1U);
  EXPECT_NE(problem.warnings[0].find("p.cfg:4: mesh " + folder_.path("far.obj") + ":17: left out"),
            std::string::npos)
      << problem.warnings[0];
}

TEST_F(OmplApp, UnknownKeysAreTold) {
  const Problem problem = load(kSpace + kVolume + "volum.min.x = 3\n[benchmark]\nturbo = 1\n");
  ASSERT_EQ(problem.warnings.size(), 2U);
  EXPECT_NE(problem.warnings[0].find("p.cfg:27: 'turbo' has no effect"), std::string::npos)
      << problem.warnings[0];
  EXPECT_NE(problem.warnings[1].find("p.cfg:25: 'volum.min.x' has no effect; did you mean "
                                     "'volume.min.x'?"),
            std::string::npos)
      << problem.warnings[1];
}

/// With a volume the problem would be solved without its world.
TEST_F(OmplApp, MisspeltKeysAreRefused) {
  expectRefused(replaced(kSpace, "world = ", "wrld = ") + kVolume, 4,
                {"unknown key 'wrld' in [problem]; did you mean 'world'?"});
  expectRefused(kSpace + kVolume + "objectve = max_min_clearance\n", 25,
                {"did you mean 'objective'?"});
  expectRefused(kSpace + kVolume + "[benchmark]\ntime_limt = 1\n", 26,
                {"unknown key 'time_limt' in [benchmark]; did you mean 'time_limit'?"});
  expectRefused(kSpace + kVolume + "[benchmrk]\ntime_limit = 1\n", 25,
                {"unknown section [benchmrk]; did you mean 'benchmark'?"});
}

TEST_F(OmplApp, MessagesNameLineAndKey) {
  expectRefused("", 0, {"has no [problem]"});
  expectRefused("leeway: 1\n", 1, {"'leeway: 1' is neither [section] nor key = value"});
  expectRefused("[problem]\nname = x\nrobot = robot.obj\n", 0, {"has no 'start.x'", "a length"});
  expectRefused(replaced(kSpace, "start.y = 1", "start.y = one"), 6,
                {"start.y is 'one'", "a length is expected"});
  expectRefused(replaced(kSpace, "goal.x = -7", "goal.x = nan"), 12, {"goal.x is 'nan'"});
  expectRefused(replaced(kSpace, "goal.axis.y = 0\n", "goal.axis.why = 0\n"), 17,
                {"unknown key 'goal.axis.why' in [problem]; did you mean 'goal.axis.y'?"});
  expectRefused(replaced(kSpace, "start.axis.x = 1", "start.axis.x = 0"), 9,
                {"start.axis is 0 0 0"});
  expectRefused(kSpace + "start.x = 3\n", 19, {"'problem.start.x' again, after line 5"});
  expectRefused(replaced(kSpace, "robot.obj", "nowhere.dae"), 3, {"nowhere.dae", "is not there"});
  expectRefused(replaced(kSpace, "robot=robot.obj\n", ""), 0, {"no 'robot'"});
  expectRefused(replaced(kSpace, "world = world.obj\n", ""), 0, {"neither 'world' nor 'volume'"});
  expectRefused(kSpace + replaced(kVolume, "max.z = 10", "max.z = -11"), 21,
                {"volume.min.z is -10, above -11"});
  expectRefused(kSpace + replaced(kVolume, "volume.max.y = 30\n", ""), 0, {"'volume.max.y'"});
  expectRefused(kSpace + "objective = mechanical_work\n", 19,
                {"'mechanical_work'", "length or max_min_clearance"});
  expectRefused(kSpace + "control = kinematic_car\n", 19, {"kinematic_car", "rigid bodies"});
  expectRefused(kSpace + "[benchmark]\ntime_limit = 0\n", 20, {"time_limit is 0"});
  robots::expectInputError([&] { loadProblem(folder_.path("nowhere.cfg")); },
                           folder_.path("nowhere.cfg"), 0, {"OMPL.app"});
}

}  // namespace
}  // namespace leeway::planner
