// The pairs of bodies that MuJoCo collides (engine_collision_driver.c). It leaves out:
// - bodies that no joint moves against each other,
// - a body and its parent, unless the parent stands still,
// - the pairs of <exclude>,
// - bodies whose masks do not meet.
// The geoms of a <pair> collide in any case.

#include <algorithm>

#include "collision/base/numbers.h"
#include "robots/mjcf/mjcf_bodies.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

class ContactReader {
 public:
  ContactReader(const MjcfFile& file, const MjcfSettings& settings, const MjcfBodies& bodies,
                UrdfDocument& document)
      : file_(file),
        settings_(settings),
        bodies_(bodies),
        document_(document),
        parents_(document.links.size(), -1) {
    for (const UrdfJoint& joint : document.joints) parents_[at(joint.child)] = joint.parent;
  }

  void read() {
    file_.eachOf("contact", [&](const XMLElement& e) {
      const std::string_view tag = e.Name();
      if (tag == "exclude") {
        checkAttributes(file_, e);
        excluded_.insert(std::minmax({bodyOf(e, "body1"), bodyOf(e, "body2")}));
      } else if (tag == "pair") {
        paired_.insert(std::minmax({bodyOfGeom(e, "geom1"), bodyOfGeom(e, "geom2")}));
      } else {
        file_.fail(e, "<" + std::string(tag) +
                          "> in <contact> is not known; exclude and pair would "
                          "be accepted");
      }
    });
    const int count = static_cast<int>(bodies_.bodies.size());
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b) decide(a, b);
    if (mixed_ > 0)
      document_.warnings.push_back(file_.main().path() +
                                   ": contype and conaffinity let only some geoms of " +
                                   std::to_string(mixed_) + (mixed_ == 1 ? " pair" : " pairs") +
                                   " of bodies collide; all geoms of these are checked");
  }

 private:
  const MjcfBody& body(int index) const { return bodies_.bodies[at(index)]; }

  int bodyOf(const XMLElement& e, const char* attribute) const {
    const std::string name = file_.of(e).attribute(e, attribute);
    const auto found = bodies_.by_name.find(name);
    if (found != bodies_.by_name.end()) return found->second;
    std::vector<std::string> known;
    for (const auto& [other, index] : bodies_.by_name) known.push_back(other);
    file_.failUnknown(e, "body", name, known);
  }

  int bodyOfGeom(const XMLElement& e, const char* attribute) const {
    const std::string name = file_.of(e).attribute(e, attribute);
    std::vector<std::string> known;
    for (int i = 0; i < static_cast<int>(bodies_.bodies.size()); ++i) {
      const std::set<std::string>& geoms = body(i).geoms;
      if (geoms.count(name) != 0) return i;
      known.insert(known.end(), geoms.begin(), geoms.end());
    }
    file_.failUnknown(e, "geom", name, known);
  }

  /// The weld of the parent of a body's weld: what the nearest joint from the body up moves it
  /// against.
  int weldParent(int index) const { return body(body(body(index).weld).parent).weld; }

  /// The reason why MuJoCo does not collide two bodies without a <pair>, a < b; null: it does.
  const char* why(int a, int b) {
    if (excluded_.count({a, b}) != 0) return "<exclude>";
    const int weld_a = body(a).weld, weld_b = body(b).weld;
    if (settings_.filters_parents && weld_a != 0 && weld_b != 0 &&
        (weldParent(a) == weld_b || weldParent(b) == weld_a))
      return "parent and child";
    std::size_t meeting = 0;
    for (const GeomMasks& m : body(a).masks)
      for (const GeomMasks& n : body(b).masks) meeting += m.meets(n) ? 1U : 0U;
    if (meeting == 0) return "contype and conaffinity";
    if (meeting < body(a).masks.size() * body(b).masks.size()) ++mixed_;
    return nullptr;
  }

  void decide(int a, int b) {
    if (body(a).masks.empty() || body(b).masks.empty() || body(a).weld == body(b).weld) return;
    const bool is_paired = paired_.count({a, b}) != 0;
    if (const char* reason = is_paired ? nullptr : why(a, b)) {
      document_.disabled_pairs.push_back({body(a).link, body(b).link, reason, true});
      return;
    }
    const int link_a = body(a).link, link_b = body(b).link;
    if (is_paired) document_.asked_pairs.emplace_back(link_a, link_b);
    if (parents_[at(link_a)] == link_b || parents_[at(link_b)] == link_a)
      document_.enabled_pairs.emplace_back(link_a, link_b);
  }

  const MjcfFile& file_;
  const MjcfSettings& settings_;
  const MjcfBodies& bodies_;
  UrdfDocument& document_;
  std::vector<int> parents_;                         // of the document's links; -1: the root
  std::set<std::pair<int, int>> excluded_, paired_;  // bodies, the lower first
  int mixed_ = 0;  // pairs of bodies of which only some geoms may collide
};

}  // namespace

void readContacts(const MjcfFile& file, const MjcfSettings& settings, const MjcfBodies& bodies,
                  UrdfDocument& document) {
  ContactReader(file, settings, bodies, document).read();
}

}  // namespace leeway::robots
