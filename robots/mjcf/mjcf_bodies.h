#pragma once

// Private to robots/mjcf: the tree of bodies.

#include <map>
#include <set>
#include <string>
#include <vector>

#include "robots/mjcf/mjcf_geoms.h"
#include "robots/mjcf/mjcf_settings.h"
#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

struct MjcfBody {
  std::string name;
  int parent = -1;              ///< body; -1: this is the world
  int link = -1;                ///< of the document
  int weld = 0;                 ///< the nearest body, from this one up, with a joint; 0: none has
  std::set<GeomMasks> masks;    ///< of its geoms that collide
  std::set<std::string> geoms;  ///< the names of its geoms
};

struct MjcfBodies {
  std::vector<MjcfBody> bodies;  ///< in MuJoCo's order: parents first, depth first
  std::vector<int> positions;    ///< the joints of the document in the order of MuJoCo's qpos
  std::map<std::string, int> by_name;
  std::map<std::string, int> left_out;  ///< numbers of elements, by kind
};

/// Reads <worldbody> into the links and joints of `document`. Throws InputError.
MjcfBodies readBodies(const MjcfFile& file, const MjcfSettings& settings,
                      const DefaultClasses& classes, UrdfDocument& document);

/// Turns the exclusions, masks and rules of <contact> into pairs of the document's links.
void readContacts(const MjcfFile& file, const MjcfSettings& settings, const MjcfBodies& bodies,
                  UrdfDocument& document);

}  // namespace leeway::robots
