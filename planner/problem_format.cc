#include "planner/problem_format.h"

#include <array>
#include <stdexcept>

namespace leeway::planner {
namespace {

using Keys = std::string_view;

constexpr Keys kProblem[] = {"leeway",  "name",      "robot",    "body",    "joints", "start",
                             "goal",    "goals",     "objects",  "allowed", "margin", "margins",
                             "planner", "objective", "simplify", "limits",  "seed",   "moveit"};
constexpr Keys kRobot[] = {"urdf", "srdf", "packages", "group"};
constexpr Keys kBody[] = {"name", "joint", "bounds", "shapes"};
constexpr Keys kBounds[] = {"lower", "upper"};
constexpr Keys kShapeWords[] = {"box",       "sphere",     "cylinder", "capsule",    "cone",
                                "ellipsoid", "half_space", "mesh",     "convex_hull"};
constexpr Keys kShape[] = {"name",       "position", "orientation", "rpy",  "box",
                           "sphere",     "cylinder", "capsule",     "cone", "ellipsoid",
                           "half_space", "mesh",     "convex_hull"};
constexpr Keys kObject[] = {"name",   "position",  "orientation", "rpy",      "shapes",
                            "attach", "box",       "sphere",      "cylinder", "capsule",
                            "cone",   "ellipsoid", "half_space",  "mesh",     "convex_hull"};
constexpr Keys kBox[] = {"size"};
constexpr Keys kSphere[] = {"radius"};
constexpr Keys kRadiusLength[] = {"radius", "length"};
constexpr Keys kCone[] = {"radius", "height"};
constexpr Keys kEllipsoid[] = {"semi_axes"};
constexpr Keys kMesh[] = {"file", "scale"};
constexpr Keys kConvexHull[] = {"points", "file", "scale"};
constexpr Keys kAttach[] = {"link", "touch"};
constexpr Keys kPairMargin[] = {"between", "margin"};
constexpr Keys kPlanner[] = {"name", "parameters"};
constexpr Keys kLimits[] = {"time", "iterations"};
constexpr Keys kMoveit[] = {"scene", "request"};
constexpr Keys kPose[] = {"position", "orientation", "rpy"};
constexpr Keys kPlanarPose[] = {"position", "angle"};

const std::array kFormats = {MapFormat{"problem", kProblem},
                             MapFormat{"robot", kRobot},
                             MapFormat{"body", kBody},
                             MapFormat{"bounds", kBounds},
                             MapFormat{"shape", kShape},
                             MapFormat{"object", kObject},
                             MapFormat{"box", kBox},
                             MapFormat{"sphere", kSphere},
                             MapFormat{"cylinder", kRadiusLength},
                             MapFormat{"capsule", kRadiusLength},
                             MapFormat{"cone", kCone},
                             MapFormat{"ellipsoid", kEllipsoid},
                             MapFormat{"half_space", {}},
                             MapFormat{"mesh", kMesh},
                             MapFormat{"convex_hull", kConvexHull},
                             MapFormat{"attach", kAttach},
                             MapFormat{"pair_margin", kPairMargin},
                             MapFormat{"planner", kPlanner},
                             MapFormat{"limits", kLimits},
                             MapFormat{"moveit", kMoveit},
                             MapFormat{"pose", kPose},
                             MapFormat{"planar_pose", kPlanarPose}};

}  // namespace

std::span<const MapFormat> mapFormats() { return kFormats; }

std::span<const std::string_view> keysOf(std::string_view name) {
  for (const MapFormat& format : kFormats)
    if (format.name == name) return format.keys;
  throw std::logic_error("no such kind of map: " + std::string(name));
}

std::span<const std::string_view> shapeWords() { return kShapeWords; }

}  // namespace leeway::planner
