#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/leeway/support/verb.h"

namespace leeway::tools {

/// The verb `report` and the reports below it.
Verb addReport(CLI::App& command);

/// `leeway report cases FILE --raw OUT`: asks the engine for every case of `file` and writes one
/// line a case, `ID STATUS LOWER UPPER NS` (status as toString(); 17 digits; nanoseconds of the
/// query). Families seq-* keep a PairCache a track. OUT may be "-": stdout. Returns the exit status
/// 0; throws robots::InputError.
int runReportCases(const std::string& file, const std::string& raw_output);

/// `leeway report cases FILE --reference REFERENCE`: the same queries held against known truth.
/// Prints a table by family to stdout: cases, unsafe (the interval does not hold the truth),
/// failures (limits, invalid), wrong and open verdicts, widths. Returns 0 when nothing is unsafe or
/// wrong, else 1; throws robots::InputError.
int runReportCasesAgainst(const std::string& file, const std::string& reference);

struct ReportAccuracyArguments {
  std::string output = "report";
  std::uint64_t seed = 1;
  int per_family = 40;
  int passes = 15;
  std::string cases, reference;       ///< both or none: cases of a file instead of made ones
  std::vector<std::string> families;  ///< parts of names; none: all
  bool no_rivals = false;
  bool json = false;
};

/// `leeway report accuracy`: time against true error for ours and for the rivals that are there,
/// and what each gets wrong. Writes accuracy.csv, hard_cases.csv, accuracy.svg and hard_cases.svg
/// into `output`. Returns 0 when every answer of ours holds the truth, else 1; throws
/// robots::InputError.
int runReportAccuracy(const ReportAccuracyArguments& arguments);

struct ReportDeformArguments {
  std::string output = "report";
  std::uint64_t seed = 1;
  int frames = 100;
  double seconds = 0.25;  ///< that one engine may take for one mesh
  std::vector<int> triangles = {2000, 20000, 200000};
  std::vector<std::string> motions;  ///< none: all
  bool no_rivals = false;
  bool json = false;
};

/// `leeway report deform`: updates and queries of deforming meshes, every strategy and motion, with
/// the rivals that are there. Writes deform.csv, deform_frames.csv, deform_update.svg and
/// deform_decay.svg into `output`. Returns 0 when all strategies agree on every distance, else 1;
/// throws robots::InputError.
int runReportDeform(const ReportDeformArguments& arguments);

struct ReportMotionArguments {
  std::string output = "report";
  std::uint64_t seed = 1;
  int cases = 100;  ///< a family
  int passes = 5;
  std::vector<std::string> families;  ///< none: all
  std::vector<std::string> problems;  ///< whose edges are looked at besides
  std::string robot, srdf;            ///< problems then are MoveIt scenes, requests beside them
  int edges = 200;                    ///< of each problem
  bool no_rivals = false;
  bool json = false;
};

/// `leeway report motion`: time of contact, cost and errors by family, with the rivals that are
/// there; and the edges of problems, certified and in steps. Writes motion.csv and motion.svg, and
/// edges.csv and edges.svg where there are problems, into `output`. Returns 0 when no answer of
/// ours is wrong or left open, else 1; throws robots::InputError.
int runReportMotion(const ReportMotionArguments& arguments);

struct ReportIkArguments {
  std::string output = "report";
  std::uint64_t seed = 1;
  int poses = 1000, beyond = 200;  ///< a robot
  std::vector<std::string> robots = {"robots/arm6/arm6.urdf:tool",
                                     "robots/arm7/arm7.urdf:hand"};  ///< URDF:LINK
  bool no_rivals = false;
  bool json = false;
};

/// `leeway report ik`: success, time and error of inverse kinematics on the poses of random
/// configurations, with the rivals that are there; proofs that poses are out of reach. Writes
/// ik.csv into `output`. Returns 0 when no answer of ours is wrong, else 1; throws
/// robots::InputError.
int runReportIk(const ReportIkArguments& arguments);

struct ReportPlanningArguments {
  std::vector<std::string> inputs;  ///< as those of `batch`
  std::string output = "report";
  std::string robot, srdf;  ///< inputs then are MoveIt scenes, requests beside them
  std::uint64_t seed = 1;   ///< the first
  int seeds = 1;
  double time = 10;  ///< limit of a run [s]
  bool no_rivals = false;
  bool json = false;
};

/// `leeway report planning`: times, lengths and tails of plans, with OMPL's RRTConnect over the
/// rivals that are there in the same run. Writes planning.csv into `output`. Returns 0 when no path
/// of ours collides, else 1; throws robots::InputError.
int runReportPlanning(const ReportPlanningArguments& arguments);

struct ReportGrowthArguments {
  std::string output = "report";
  std::uint64_t seed = 1;
  std::vector<std::int64_t> boxes = {10, 100, 1000, 10000, 100000};
  std::vector<std::int64_t> triangles = {1000, 10000, 100000};
  std::vector<std::int64_t> joints = {2, 4, 7, 14, 28, 40};
  std::vector<std::string> families;  ///< none: all
  int edges = 200;                    ///< of each family
  double time = 30;                   ///< limit of a plan [s]
  bool no_rivals = false;
  bool json = false;
};

/// `leeway report growth`: what making a world, an edge and a plan cost as boxes, triangles and
/// joints grow in number, with the rivals that are there. Writes growth.csv and growth.svg into
/// `output`. Returns 0 when every plan of ours is solved, else 1; throws robots::InputError.
int runReportGrowth(const ReportGrowthArguments& arguments);

struct ReportClearanceArguments : ReportPlanningArguments {  // without its limit
  std::vector<double> times = {0.01, 0.1, 1, 10, 30};        ///< limits of runs [s]
  double hinge = 0.1;                                        ///< of the integral [m]
};

/// `leeway report clearance`: least clearance from the world and integral of a hinge against time,
/// beside OMPL's objectives over the rivals' distances in the same run. Writes clearance.csv and
/// clearance.svg into `output`. Returns 0 when what ours told held the dense values of all paths,
/// else 1; throws robots::InputError.
int runReportClearance(const ReportClearanceArguments& arguments);

}  // namespace leeway::tools
