#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "planner/base/did_you_mean.h"
#include "planner/problem/read_motion.h"
#include "planner/problem/read_shapes.h"
#include "planner/validate/format_keys.h"

namespace leeway::planner {
namespace {

using collision::VertexMotion;
using Vertices = std::vector<Eigen::Vector3d>;

class Skinning {
 public:
  Skinning(const YamlReader& reader, const Vertices& rest, std::vector<std::string>& warnings)
      : reader_(reader), rest_(rest), warnings_(warnings) {}

  std::shared_ptr<const VertexMotion> run() {
    reader_.expectKeys(keysOf("skinned"));
    result_.rest = rest_;
    for (const YamlReader& bone : reader_.at("bones", "a list of bones").items()) readBone(bone);
    if (const auto weights = reader_.find("weights")) {
      for (const YamlReader& weight : weights->items()) readWeight(weight);
    } else {
      weighByNearness();
    }
    for (const YamlReader& key : reader_.at("keys", "a list of keys").items()) readKey(key);
    result_.interpolation = readInterpolation(reader_);
    return VertexMotion::skinned(std::move(result_));
  }

 private:
  using BonePose = collision::SkinnedMotion::BonePose;

  int boneNumber(const YamlReader& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name.text());
    if (found == names_.end())
      name.fail(fmt::format("unknown bone '{}' in {}{}", name.text(), name.where(),
                            didYouMean(name.text(), names_)));
    return static_cast<int>(found - names_.begin());
  }

  BonePose readBonePose(const YamlReader& map, const BonePose& otherwise) {
    BonePose pose = otherwise;
    if (const auto position = map.find("position")) pose.translation = position->vector3();
    if (map.has("orientation") || map.has("rpy")) pose.quaternion = readOrientation(map, warnings_);
    return pose;
  }

  void readBone(const YamlReader& entry) {
    entry.expectKeys(keysOf("bone"));
    const YamlReader name = entry.at("name", "a name of its own");
    if (std::find(names_.begin(), names_.end(), name.text()) != names_.end())
      name.fail(fmt::format("{} '{}' is the name of an earlier bone; a name of its own is expected",
                            name.where(), name.text()));
    collision::SkinnedMotion::Bone bone;
    if (const auto parent = entry.find("parent")) bone.parent = boneNumber(*parent);
    bone.rest = readBonePose(entry, {});
    collision::Pose X_PB;
    X_PB.translation = bone.rest.translation;
    X_PB.rotation = rotationFromQuaternion(bone.rest.quaternion);
    const collision::Pose X_MB = bone.parent < 0 ? X_PB : poses_[at(bone.parent)] * X_PB;
    const auto tip = entry.find("tip");
    poses_.push_back(X_MB);
    tips_.push_back(X_MB * (tip ? tip->vector3() : Eigen::Vector3d(Eigen::Vector3d::Zero())));
    reaches_.push_back(0);
    if (const auto reach = entry.find("reach")) reaches_.back() = reach->sizeNumber();
    names_.push_back(name.text());
    result_.bones.push_back(bone);
  }

  void readWeight(const YamlReader& entry) {
    entry.expectKeys(keysOf("bone_weight"));
    const YamlReader vertex = entry.at("vertex", "a number from 0");
    const std::int64_t number = vertex.integer(0);
    if (number >= static_cast<std::int64_t>(rest_.size()))
      vertex.fail(
          fmt::format("{} is {}; 0 to {} is expected", vertex.where(), number, rest_.size() - 1));
    result_.weights.push_back({static_cast<int>(number),
                               boneNumber(entry.at("bone", "the name of a bone")),
                               entry.at("weight", "a number").sizeNumber()});
  }

  /// Distance of a point from a bone: the segment from its origin to its tip [m].
  double distance(std::size_t bone, const Eigen::Vector3d& p) const {
    const Eigen::Vector3d a = poses_[bone].translation, d = tips_[bone] - a;
    const double squared = d.squaredNorm();
    const double t = squared > 0 ? std::clamp((p - a).dot(d) / squared, 0.0, 1.0) : 0.0;
    return (p - a - t * d).norm();
  }

  /// Weights by distance: a bone at distance d weighs (1 - (d - least) / reach)^2 where the base is
  /// positive. `least` is the distance of the nearest bone, which therefore weighs 1.
  void weighByNearness() {
    for (std::size_t v = 0; v < rest_.size(); ++v) {
      double least = std::numeric_limits<double>::infinity();
      std::size_t nearest = 0;
      for (std::size_t b = 0; b < names_.size(); ++b)
        if (const double d = distance(b, rest_[v]); d < least) {
          least = d;
          nearest = b;
        }
      for (std::size_t b = 0; b < names_.size(); ++b) {
        const double further = distance(b, rest_[v]) - least;
        const double share = b == nearest ? 1 : reaches_[b] > 0 ? 1 - further / reaches_[b] : 0;
        if (share > 0)
          result_.weights.push_back({static_cast<int>(v), static_cast<int>(b), share * share});
      }
    }
  }

  void readKey(const YamlReader& entry) {
    entry.expectKeys(keysOf("skinned_key"));
    collision::SkinnedMotion::Key key;
    key.time = entry.at("time", "a number [s]").number();
    for (const auto& bone : result_.bones) key.poses.push_back(bone.rest);
    if (const auto poses = entry.find("poses"))
      for (const auto& [name, pose] : poses->entries()) {
        const auto found = std::find(names_.begin(), names_.end(), name);
        if (found == names_.end())
          pose.fail(fmt::format("unknown bone '{}' in {}{}", name, poses->where(),
                                didYouMean(name, names_)));
        pose.expectKeys(keysOf("pose"));
        BonePose& kept = key.poses[static_cast<std::size_t>(found - names_.begin())];
        kept = readBonePose(pose, kept);
      }
    result_.keys.push_back(std::move(key));
  }

  const YamlReader& reader_;
  const Vertices& rest_;
  std::vector<std::string>& warnings_;
  collision::SkinnedMotion result_;
  std::vector<std::string> names_;
  std::vector<collision::Pose> poses_;  // of the bones at rest, in the mesh's frame
  std::vector<Eigen::Vector3d> tips_;
  std::vector<double> reaches_;
};

}  // namespace

std::shared_ptr<const VertexMotion> readSkinned(const YamlReader& skinned, const Vertices& rest,
                                                std::vector<std::string>& warnings) {
  return Skinning(skinned, rest, warnings).run();
}

}  // namespace leeway::planner
