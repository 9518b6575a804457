#include "planner/validate/format_keys.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace leeway::planner {
namespace {

using Keys = std::string_view;

constexpr Keys kRobot[] = {
    "urdf",     "srdf",        "joint_limits", "packages",           "xacro", "group", "chain",
    "position", "orientation", "rpy",          "visual_as_collision"};
constexpr Keys kBody[] = {"name", "joint", "bounds", "shapes"};
constexpr Keys kBounds[] = {"lower", "upper"};
constexpr Keys kJointBounds[] = {"x", "y", "z", "range", "widen"};
constexpr Keys kShapeWords[] = {"box",         "sphere",      "cylinder",   "capsule",
                                "cone",        "ellipsoid",   "half_space", "mesh",
                                "convex_hull", "height_field"};
constexpr Keys kShape[] = {"name",       "position", "orientation", "rpy",         "box",
                           "sphere",     "cylinder", "capsule",     "cone",        "ellipsoid",
                           "half_space", "mesh",     "convex_hull", "height_field"};
constexpr Keys kObject[] = {"name",         "position",  "orientation", "rpy",      "shapes",
                            "attach",       "box",       "sphere",      "cylinder", "capsule",
                            "cone",         "ellipsoid", "half_space",  "mesh",     "convex_hull",
                            "height_field", "cloud",     "octree",      "moving",   "color"};
constexpr Keys kMoving[] = {"keys",        "velocity",   "turning", "time",
                            "speed_bound", "turn_bound", "age"};
constexpr Keys kMovingKey[] = {"time", "position", "orientation", "rpy"};
constexpr Keys kOctree[] = {"file", "unseen"};
constexpr Keys kCloud[] = {"file",   "camera",  "radius",    "balls", "unseen",
                           "carved", "cropped", "thinned",   "carve", "carve_margin",
                           "crop",   "thin",    "most_balls"};
constexpr Keys kCarved[] = {"removed", "position", "orientation", "rpy"};
constexpr Keys kCropped[] = {"removed", "distance", "position", "orientation", "rpy", "reach"};
constexpr Keys kCamera[] = {"fx", "fy", "cx", "cy", "scale", "slant", "range", "mask", "parts"};
constexpr Keys kHeightField[] = {"file", "step", "scale", "offset", "floor", "missing"};
constexpr Keys kBox[] = {"size"};
constexpr Keys kSphere[] = {"radius"};
constexpr Keys kRadiusLength[] = {"radius", "length"};
constexpr Keys kCone[] = {"radius", "height"};
constexpr Keys kEllipsoid[] = {"semi_axes"};
constexpr Keys kMesh[] = {"file", "scale"};
constexpr Keys kMeshTreatment[] = {"solid", "weld"};
constexpr Keys kConvexHull[] = {"points", "file", "scale"};
constexpr Keys kAttach[] = {"link", "touch"};
constexpr Keys kPairMargin[] = {"between", "margin", "wish", "weight"};
constexpr Keys kObjective[] = {"length", "clearance", "integral", "weighted"};
constexpr Keys kNearness[] = {"hinge", "inverse", "of"};
constexpr Keys kWeightedObjective[] = {"length", "integral", "worst"};
constexpr Keys kWeightedNearness[] = {"hinge", "inverse", "of", "weight"};
constexpr Keys kMoveit[] = {"scene", "request"};
constexpr Keys kDeforming[] = {"name",   "position", "orientation", "rpy",      "grid",    "mesh",
                               "motion", "margin",   "speed_bound", "strategy", "options", "color"};
constexpr Keys kGrid[] = {"size", "cells"};
constexpr Keys kDeformOptions[] = {"volume", "hybrid_split", "restructure_factor",
                                   "expected_queries"};
constexpr Keys kMotion[] = {"waves", "pinned", "lattice", "morph", "skinned", "reduced", "cache"};
constexpr Keys kWave[] = {"direction", "amplitude", "wavelength", "frequency", "phase"};
constexpr Keys kPinned[] = {"point", "direction", "length"};
constexpr Keys kLattice[] = {"box", "cells", "keys", "interpolation"};
constexpr Keys kLatticeKey[] = {"time", "moved"};
constexpr Keys kControlPoint[] = {"at", "by"};
constexpr Keys kMorph[] = {"references", "keys", "interpolation"};
constexpr Keys kMorphKey[] = {"time", "weights"};
constexpr Keys kTarget[] = {"file", "scale", "bumps"};
constexpr Keys kBump[] = {"center", "radius", "by"};
constexpr Keys kSkinned[] = {"bones", "weights", "keys", "interpolation"};
constexpr Keys kBone[] = {"name", "parent", "position", "orientation", "rpy", "tip", "reach"};
constexpr Keys kBoneWeight[] = {"vertex", "bone", "weight"};
constexpr Keys kSkinnedKey[] = {"time", "poses"};
constexpr Keys kReduced[] = {"modes", "harmonics", "keys", "interpolation"};
constexpr Keys kHarmonic[] = {"amplitude", "frequency", "phase"};
constexpr Keys kReducedKey[] = {"time", "coordinates"};
constexpr Keys kCache[] = {"file", "scale", "start", "rate", "times", "frames"};
constexpr Keys kPose[] = {"position", "orientation", "rpy"};
constexpr Keys kFrame[] = {"link", "position", "orientation", "rpy"};
constexpr Keys kPoses[] = {"pose", "poses"};
constexpr Keys kFramePose[] = {"frame",       "relative_to",        "position",       "rpy",
                               "orientation", "position_tolerance", "angle_tolerance"};
constexpr Keys kConstraint[] = {
    "name", "frame",       "relative_to", "position",  "position_tolerance",
    "rpy",  "orientation", "axis",        "direction", "angle"};
constexpr Keys kStep[] = {"name", "move", "line", "attach", "detach", "allowed"};
constexpr Keys kLine[] = {
    "frame",           "by",   "rpy", "orientation", "poses", "relative_to", "position_tolerance",
    "angle_tolerance", "speed"};
constexpr Keys kWaypoint[] = {"position", "rpy", "orientation", "via"};
constexpr Keys kAttachStep[] = {"object", "link", "touch"};
constexpr Keys kPlanarPose[] = {"position", "angle"};

const std::array kFormats = {MapFormat{"mesh_treatment", kMeshTreatment},
                             MapFormat{"robot", kRobot},
                             MapFormat{"body", kBody},
                             MapFormat{"bounds", kBounds},
                             MapFormat{"joint_bounds", kJointBounds},
                             MapFormat{"shape", kShape},
                             MapFormat{"object", kObject},
                             MapFormat{"moving", kMoving},
                             MapFormat{"moving_key", kMovingKey},
                             MapFormat{"cloud", kCloud},
                             MapFormat{"carved", kCarved},
                             MapFormat{"cropped", kCropped},
                             MapFormat{"camera", kCamera},
                             MapFormat{"octree", kOctree},
                             MapFormat{"box", kBox},
                             MapFormat{"sphere", kSphere},
                             MapFormat{"cylinder", kRadiusLength},
                             MapFormat{"capsule", kRadiusLength},
                             MapFormat{"cone", kCone},
                             MapFormat{"ellipsoid", kEllipsoid},
                             MapFormat{"half_space", {}},
                             MapFormat{"mesh", kMesh},
                             MapFormat{"convex_hull", kConvexHull},
                             MapFormat{"height_field", kHeightField},
                             MapFormat{"attach", kAttach},
                             MapFormat{"pair_margin", kPairMargin},
                             MapFormat{"objective", kObjective},
                             MapFormat{"nearness", kNearness},
                             MapFormat{"weighted_objective", kWeightedObjective},
                             MapFormat{"weighted_nearness", kWeightedNearness},
                             MapFormat{"moveit", kMoveit},
                             MapFormat{"deforming", kDeforming},
                             MapFormat{"grid", kGrid},
                             MapFormat{"deform_options", kDeformOptions},
                             MapFormat{"motion", kMotion},
                             MapFormat{"wave", kWave},
                             MapFormat{"pinned", kPinned},
                             MapFormat{"lattice", kLattice},
                             MapFormat{"lattice_key", kLatticeKey},
                             MapFormat{"control_point", kControlPoint},
                             MapFormat{"morph", kMorph},
                             MapFormat{"morph_key", kMorphKey},
                             MapFormat{"target", kTarget},
                             MapFormat{"bump", kBump},
                             MapFormat{"skinned", kSkinned},
                             MapFormat{"bone", kBone},
                             MapFormat{"bone_weight", kBoneWeight},
                             MapFormat{"skinned_key", kSkinnedKey},
                             MapFormat{"reduced", kReduced},
                             MapFormat{"harmonic", kHarmonic},
                             MapFormat{"reduced_key", kReducedKey},
                             MapFormat{"cache", kCache},
                             MapFormat{"pose", kPose},
                             MapFormat{"planar_pose", kPlanarPose},
                             MapFormat{"frame", kFrame},
                             MapFormat{"poses", kPoses},
                             MapFormat{"frame_pose", kFramePose},
                             MapFormat{"constraint", kConstraint},
                             MapFormat{"step", kStep},
                             MapFormat{"line", kLine},
                             MapFormat{"waypoint", kWaypoint},
                             MapFormat{"attach_step", kAttachStep}};

/// The maps whose keys are in the table of settings, and their places in a file.
struct SettingMap {
  std::string_view name, place;
};
constexpr SettingMap kSettingMaps[] = {{"problem", ""},
                                       {"length_objective", "objective.length"},
                                       {"clearance_objective", "objective.clearance"},
                                       {"planner", "planner"},
                                       {"limits", "limits"},
                                       {"execution", "execution"}};

std::vector<std::string_view> keysAt(std::string_view place) {
  std::vector<std::string_view> keys;
  for (const Setting& setting : settings()) {
    std::string_view key = keyIn(place, setting);
    key = key.substr(0, key.find('.'));
    if (!key.empty() && std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  }
  return keys;
}

}  // namespace

std::string_view keyIn(std::string_view place, const Setting& setting) {
  const std::string_view key = setting.key;
  if (place.empty()) return key;
  const bool is_in = key.starts_with(place) && key.substr(place.size()).starts_with('.');
  return is_in ? key.substr(place.size() + 1) : std::string_view();
}

std::span<const MapFormat> mapFormats() {
  static const std::vector<std::vector<std::string_view>> keys = [] {
    std::vector<std::vector<std::string_view>> all;
    for (const SettingMap& map : kSettingMaps) all.push_back(keysAt(map.place));
    return all;
  }();
  static const std::vector<MapFormat> formats = [] {
    std::vector<MapFormat> all;
    for (std::size_t i = 0; i < keys.size(); ++i) all.push_back({kSettingMaps[i].name, keys[i]});
    all.insert(all.end(), kFormats.begin(), kFormats.end());
    return all;
  }();
  return formats;
}

std::span<const std::string_view> keysOf(std::string_view name) {
  for (const MapFormat& format : mapFormats())
    if (format.name == name) return format.keys;
  throw std::logic_error("no such kind of map: " + std::string(name));
}

std::span<const std::string_view> shapeWords() { return kShapeWords; }

}  // namespace leeway::planner
