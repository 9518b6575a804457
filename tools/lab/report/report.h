#pragma once

#include <string>
#include <vector>

#include "tools/lab/accuracy/accuracy_report.h"
#include "tools/lab/clearance/clearance_report.h"
#include "tools/lab/deform/deform_report.h"
#include "tools/lab/growth/growth_report.h"
#include "tools/lab/ik/ik_report.h"
#include "tools/lab/motion/motion_report.h"
#include "tools/leeway/support/verb.h"

namespace leeway::tools {

/// The verb `report` and the reports below it.
Verb addReport(CLI::App& command);

/// `leeway report cases FILE --raw OUT`: queries the engine for every case of `file` and writes one
/// line for each, `ID STATUS LOWER UPPER NS` (status as toString(); 17 digits; nanoseconds of the
/// query). Families seq-* keep one PairCache for each track. OUT may be "-": stdout. Returns the
/// exit status 0; throws robots::InputError.
int runReportCases(const std::string& file, const std::string& raw_output);

/// `leeway report cases FILE --reference REFERENCE`: compares the same queries with known truth.
/// Prints a table by family to stdout: cases, unsafe (the interval excludes the truth), failures
/// (limits, invalid), wrong and open verdicts, widths. Returns 0 if nothing is unsafe or wrong,
/// else 1; throws robots::InputError.
int runReportCasesAgainst(const std::string& file, const std::string& reference);

// Each of the following writes CSV files, most also pictures, into the folder of its options, and
// prints tables. Returns kYes if all answers of ours hold, else kNo; throws robots::InputError.

/// Time over true error of distances, and what each engine gets wrong.
int runReportAccuracy(report::AccuracyOptions options);

/// Updates and queries of deforming meshes, with every strategy and motion.
int runReportDeform(report::DeformReportOptions options);

/// Problems whose edges a report also measures.
struct MotionProblems {
  std::vector<std::string> files;
  std::string robot, srdf;  ///< files then are MoveIt scenes, requests beside them
  int edges = 200;          ///< of each problem
};

/// Time of contact, cost and errors by family; and edges of problems, certified and in steps.
int runReportMotion(report::MotionReportOptions options, const MotionProblems& problems);

/// Success, time and error of inverse kinematics, and proofs that poses are out of reach.
int runReportIk(report::IkReportOptions options);

/// Times, lengths and tails of plans, with OMPL's RRTConnect over the rivals.
int runReportPlanning(report::PlanningReportOptions options);

/// Cost of making a world, of an edge and of a plan as boxes, triangles and joints grow in number.
int runReportGrowth(report::GrowthReportOptions options);

/// The same as the points of a cloud grow in number, cost of seeing a tenth of them again, and
/// answers against the distances of all balls.
int runReportSensed(report::GrowthReportOptions options);

/// Least clearance from the world, and the integral of a hinge, against time, with OMPL's
/// objectives over the rivals' distances.
int runReportClearance(report::ClearanceReportOptions options);

}  // namespace leeway::tools
