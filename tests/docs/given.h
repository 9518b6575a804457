#pragma once

// What fragments of C++ on the pages may use without declaring it (CONTRIBUTING.md, "Pages"). They
// are compiled, not linked.

#include <ompl/geometric/planners/rrt/RRTConnect.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <memory>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/scene.h"
#include "leeway/collision/separation.h"
#include "leeway/collision/time_of_contact.h"
#include "leeway/collision/time_to_impact.h"
#include "leeway/collision/vertex_motion.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/guard.h"
#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/ompl_objectives.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "leeway/planner/trajectory.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/link_motion.h"
#include "leeway/view/page.h"

namespace given {

using namespace leeway;

// A robot, a problem, and a path that solves it.
extern std::shared_ptr<const robots::Model> robot;
extern planner::Problem problem;
extern planner::Path path;
extern planner::Object cart;
extern std::vector<double> q, dq;              // a configuration, and the difference to another
extern std::vector<double> start, goal;        // points of the planned group
extern std::vector<double> rates, max_rates;   // joints' rates now [rad/s or m/s], and their limits
extern std::vector<double> max_accelerations;  // [rad/s^2 or m/s^2]

// Shapes and scenes.
extern collision::Shape a, b, hand;
extern collision::Pose X_WA, X_WB, X_WA0, X_WA1, X_WC, X_WH, X_WO, X_WCrate;
extern collision::Scene scene;
collision::Pose poseOf(int body);
collision::PointMotion motionOf(int body);
extern int bodies;

// A mesh whose vertices move.
extern std::vector<Eigen::Vector3d> rest, seen;
extern std::vector<collision::DeformableMesh::Triangle> triangles;

// A program around all this.
bool running();
double now();          // [s]
extern double period;  // [s]
void brake();
void execute(const std::vector<planner::TimedPoint>& motion);
std::vector<double> wanted();
void send(std::span<const double> setpoints);

}  // namespace given
