#pragma once

// Private to robots/sdf: the frames of a model and of the models in it, as SDF 1.7 and later define
// them: each has a pose in another one (relative_to) and moves with a link (attached_to).

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "robots/sdf/sdf_file.h"

namespace leeway::robots {

/// Where an element of a model is: what names in it stand for.
struct SdfScope {
  const SdfSource* source = nullptr;
  std::string prefix;      ///< of names: "gripper::left::"
  std::string model;       ///< the whole name of the model's frame
  bool is_static = false;  ///< the model stands still in the world

  XmlFile& file() const { return *source->file; }
  /// The whole name of what `name` stands for here.
  std::string whole(const std::string& name) const;
};

struct SdfFrame {
  enum class Kind : unsigned char { kModel, kLink, kJoint, kFrame };
  Kind kind = Kind::kFrame;
  std::string name;  ///< whole: the names of the models around it, but the outermost, with "::"
  SdfScope scope;    ///< what it is in; of a model: what is in it
  const tinyxml2::XMLElement* element = nullptr;
  const XmlFile* file = nullptr;  ///< of `element`
  std::string base;               ///< the frame that X_BF is given in; empty: the world
  Pose X_BF;
  std::string placed;       ///< X_BF is the pose of this frame of the model; empty: of the model's
  std::string attached_to;  ///< the frame that it moves with; of a link: empty
};

class SdfFrames {
 public:
  /// Throws InputError for a second frame of that name.
  int add(SdfFrame frame);
  /// Lets a frame move with the one of that whole name.
  void attach(int frame, std::string to) {
    frames_[static_cast<std::size_t>(frame)].attached_to = std::move(to);
  }
  std::size_t size() const { return frames_.size(); }
  const SdfFrame& operator[](int index) const { return frames_[static_cast<std::size_t>(index)]; }

  /// The frame of that whole name. Throws InputError that names `at` in `file`.
  int find(const std::string& whole, const XmlFile& file, const tinyxml2::XMLElement& at) const;
  /// X_AB at the model's initial positions; a or b -1: the world. Where one frame is given in the
  /// other this is the pose as written. Throws InputError for poses that lead in a circle.
  Pose relative(int a, int b) const;
  /// The link that a frame moves with; -1: none, it stands still. Throws InputError.
  int linkOf(int frame) const;

 private:
  /// The frame and those that it is given in, up to the world.
  std::vector<int> chain(int frame) const;
  /// The pose of the frame in the one that it is given in.
  Pose inBase(int frame) const;
  int baseOf(int frame) const;
  void push(SdfFrame frame);

  std::vector<SdfFrame> frames_;
  mutable std::vector<int> bases_;       // of the frames; they are looked up once
  mutable std::map<int, Pose> in_base_;  // of frames with `placed`; they are computed once
  std::map<std::string, int> by_name_;
};

}  // namespace leeway::robots
