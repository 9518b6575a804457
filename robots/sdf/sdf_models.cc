#include "robots/sdf/sdf_models.h"

#include <set>
#include <string_view>
#include <utility>

#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

/// Models that include others many times over make files without end.
constexpr std::size_t kMostFrames = 20000;

constexpr const char* kNoState = "the model stands as its poses have it, with joints at 0";

class ModelReader {
 public:
  explicit ModelReader(SdfFiles& files) : files_(files) {}

  SdfModels read() {
    const SdfSource& main = files_.main();
    XmlFile& file = *main.file;
    const XMLElement* root = &file.root();
    checkRoot(file);
    const XMLElement* world = file.onlyChild(*root, "world");
    if (world != nullptr) {
      root = world;
      // (A frame matters only to what names it, and that is refused.)
      expectOnly(file, *world, {"name"}, {"model", "include", "joint"},
                 {"light", "physics", "scene", "gui", "plugin", "gravity", "magnetic_field",
                  "atmosphere", "spherical_coordinates", "wind", "audio", "frame", "actor", "road",
                  "population", "state"});
      leaveOutChildren(file, *world, "state", "the robot stands as its <model> has it");
      for (const char* part : {"actor", "road", "population"})
        leaveOutChildren(file, *world, part, "it is no part of the robot, which cannot touch it");
      if (const XMLElement* joint = world->FirstChildElement("joint"))
        file.fail(*joint,
                  "a <joint> of the <world> is not read; one of the <model> would be "
                  "accepted");
    }
    const XMLElement* only = nullptr;
    for (const XMLElement* e = root->FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement()) {
      const std::string_view tag = e->Name();
      if (tag != "model" && tag != "include") continue;
      if (only != nullptr)
        file.fail(*e, "a second model, the first is in " + lineOf(only->GetLineNum()) +
                          "; a file with one robot, and models in its <model>, would be accepted");
      only = e;
    }
    if (only == nullptr) file.fail(*root, "there is no <model>; one is needed");
    const SdfScope outside{&main, "", "", false};
    if (std::string_view(only->Name()) == "include")
      readInclude(*only, outside, true);
    else
      readModel(main, *only, outside, {}, true);
    return std::move(models_);
  }

 private:
  /// The contents of an <include>, for the model that it names.
  struct Including {
    const XMLElement* element = nullptr;  // null: the model stands in its own file
    std::string name, placement;
    bool merges = false;
    SdfPose pose;
  };
  /// The first link and model in a model, by their whole names, if it has any.
  struct Contents {
    std::string link, model;
  };

  /// Refuses elements that a file may not have beside its model or world.
  static void checkRoot(XmlFile& file) {
    const XMLElement& root = file.root();
    expectOnly(file, root, {"version"}, {"model", "world", "include"}, {"light", "actor"});
    leaveOutChildren(file, root, "actor", "it is no part of the robot, which cannot touch it");
    if (root.FirstChildElement("world") == nullptr) return;
    for (const char* tag : {"model", "include"})
      if (const XMLElement* beside = root.FirstChildElement(tag))
        file.fail(*beside, "<" + std::string(tag) +
                               "> beside <world>; one robot would be accepted, "
                               "in <world> or in <sdf>");
  }

  void expectName(const SdfSource& source, const XMLElement& e, const std::string& name) const {
    const XmlFile& file = *source.file;
    const bool is_reserved = name.size() >= 4 && name.starts_with("__") && name.ends_with("__");
    const bool may_be_world = std::string_view(e.Name()) == "joint" && source.minor <= 6;
    if (name.empty() || is_reserved || (name == "world" && !may_be_world))
      file.fail(e, "the name " + inQuotes(name) + " of <" + e.Name() +
                       "> is reserved; another one would be accepted");
  }

  int add(SdfFrame frame) {
    if (models_.frames.size() >= kMostFrames)
      frame.file->fail(*frame.element,
                       "the model and those in it have more than 20000 links, "
                       "joints and frames; fewer would be accepted");
    return models_.frames.add(std::move(frame));
  }

  Contents readModel(const SdfSource& source, const XMLElement& e, const SdfScope& around,
                     const Including& by, bool is_outermost) {
    XmlFile& file = *source.file;
    expectOnly(
        file, e, {"name", "canonical_link", "placement_frame", "namespace"},
        {"link", "joint", "frame", "model", "include", "pose", "static"},
        {"self_collide", "allow_auto_disable", "enable_wind", "plugin", "gripper", "model_state"});
    leaveOutChildren(file, e, "model_state", kNoState);
    const std::string name = by.name.empty() ? file.attribute(e, "name") : by.name;
    expectName(source, e, name);
    if (is_outermost) models_.name = name;

    SdfScope scope = around;
    scope.source = &source;
    const XMLElement* stands =
        by.element == nullptr ? nullptr : around.file().onlyChild(*by.element, "static");
    scope.is_static = around.is_static || (stands != nullptr ? flagOf(around.file(), *stands,
                                                                      around.file().text(*stands))
                                                             : flagIn(file, e, "static", false));
    if (is_outermost) {
      scope.model = "__model__";
    } else if (by.merges) {
      scope.model = around.prefix + "_merged__" + name + "__model__";
    } else {
      scope.model = around.prefix + name;
      scope.prefix = scope.model + "::";
    }

    SdfFrame frame;
    frame.kind = SdfFrame::Kind::kModel;
    frame.name = scope.model;
    frame.scope = scope;
    frame.element = &e;
    frame.file = &file;
    const SdfPose pose = by.pose.element != nullptr ? by.pose : poseIn(source, e);
    frame.X_BF = pose.X;
    if (!is_outermost)
      frame.base = pose.relative_to.empty() ? around.model : around.whole(pose.relative_to);
    else if (!pose.relative_to.empty() && pose.relative_to != "world")
      file.fail(e, "the pose of the model is relative to " + inQuotes(pose.relative_to) +
                       "; one relative to the world would be accepted");
    const char* placement = e.Attribute("placement_frame");
    if (!by.placement.empty())
      frame.placed = scope.whole(by.placement);
    else if (placement != nullptr && *placement != '\0')
      frame.placed = scope.whole(placement);
    const int index = add(std::move(frame));

    Contents contents;
    file.eachElement(e, [&](const XMLElement& child) { readChild(child, scope, contents); });
    const char* canonical = e.Attribute("canonical_link");
    if (canonical != nullptr && *canonical != '\0')
      models_.frames.attach(index, scope.whole(canonical));
    else
      models_.frames.attach(index, contents.link.empty() ? contents.model : contents.link);
    if (by.merges) return contents;
    return {"", scope.model};
  }

  void readChild(const XMLElement& e, const SdfScope& scope, Contents& contents) {
    const std::string_view tag = e.Name();
    Contents inner;
    if (tag == "model")
      inner = readModel(*scope.source, e, scope, {}, false);
    else if (tag == "include")
      inner = readInclude(e, scope, false);
    else if (tag == "link" || tag == "joint" || tag == "frame")
      inner.link = readFrame(e, scope);
    if (contents.link.empty()) contents.link = inner.link;
    if (contents.model.empty()) contents.model = inner.model;
  }

  Contents readInclude(const XMLElement& e, const SdfScope& around, bool is_outermost) {
    XmlFile& file = around.file();
    if (const XMLElement* parameters = e.FirstChildElement("experimental:params"))
      file.fail(*parameters,
                "<experimental:params> changes the model that it includes, and is not "
                "read; a file with the changes would be accepted");
    expectOnly(file, e, {"merge"}, {"uri", "name", "pose", "placement_frame", "static"},
               {"plugin", "namespace", "model_state"});
    leaveOutChildren(file, e, "model_state", kNoState);
    const SdfSource& source = files_.include(*around.source, file.requiredChild(e, "uri"));
    const XMLElement& root = source.file->root();
    checkRoot(*source.file);
    const XMLElement* model = source.file->onlyChild(root, "model");
    if (model == nullptr)
      file.fail(e, "<include> names " + source.file->path() +
                       ", which has no <model>; a file with one would be accepted");
    if (!open_.insert(source.file).second)
      file.fail(e, "<include> names " + source.file->path() +
                       ", which includes this file; models that do not contain themselves would be "
                       "accepted");
    Including by;
    by.element = &e;
    by.name = textIn(file, e, "name");
    by.placement = textIn(file, e, "placement_frame");
    by.pose = poseIn(*around.source, e);
    if (!by.placement.empty() && by.pose.element == nullptr)
      file.fail(e, "<include> has the <placement_frame> " + inQuotes(by.placement) +
                       " and no <pose>, which would place it; both would be accepted");
    by.merges =
        !is_outermost && e.Attribute("merge") != nullptr && flagOf(file, e, e.Attribute("merge"));
    Contents contents = readModel(source, *model, around, by, is_outermost);
    open_.erase(source.file);
    return contents;
  }

  /// A link, joint or frame; returns the whole name of a link, else the empty string.
  std::string readFrame(const XMLElement& e, const SdfScope& scope) {
    XmlFile& file = scope.file();
    const std::string_view tag = e.Name();
    const std::string name = file.attribute(e, "name");
    expectName(*scope.source, e, name);
    SdfFrame frame;
    frame.name = scope.prefix + name;
    frame.scope = scope;
    frame.element = &e;
    frame.file = &file;
    const SdfPose pose = poseIn(*scope.source, e);
    frame.X_BF = pose.X;
    frame.base = scope.model;
    if (tag == "link") {
      frame.kind = SdfFrame::Kind::kLink;
      expectOnly(file, e, {"name"}, {"pose", "collision"},
                 {"visual", "inertial", "sensor", "gravity", "enable_wind", "self_collide",
                  "kinematic", "must_be_base_link", "velocity_decay", "projector", "audio_sink",
                  "audio_source", "battery", "light", "particle_emitter", "plugin"});
    } else if (tag == "joint") {
      frame.kind = SdfFrame::Kind::kJoint;
      expectOnly(file, e, {"name", "type"}, {"pose", "parent", "child", "axis", "axis2"},
                 {"physics", "sensor", "thread_pitch", "screw_thread_pitch", "gearbox_ratio",
                  "gearbox_reference_body", "plugin"});
      frame.base = frame.attached_to = scope.whole(file.text(file.requiredChild(e, "child")));
    } else {
      expectOnly(file, e, {"name", "attached_to"}, {"pose"});
      const char* to = e.Attribute("attached_to");
      frame.attached_to = to == nullptr || *to == '\0' ? scope.model : scope.whole(to);
      frame.base = frame.attached_to;
    }
    if (!pose.relative_to.empty()) frame.base = scope.whole(pose.relative_to);
    const SdfFrame::Kind kind = frame.kind;
    std::string whole = frame.name;
    const int index = add(std::move(frame));
    if (kind == SdfFrame::Kind::kJoint) models_.joints.push_back(index);
    if (kind != SdfFrame::Kind::kLink) return "";
    models_.links.push_back(index);
    return whole;
  }

  SdfFiles& files_;
  std::set<const XmlFile*> open_;  // those that the one that is read includes, and itself
  SdfModels models_;
};

}  // namespace

SdfModels readModels(SdfFiles& files) { return ModelReader(files).read(); }

}  // namespace leeway::robots
