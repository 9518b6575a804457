#include "python/bindings/world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "leeway/planner/depth_image.h"
#include "leeway/planner/octree.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/deforming.h"
#include "python/bindings/shapes.h"

namespace leeway::python {
namespace {

using planner::DeformingObstacle;
using planner::Object;
using planner::PointCloud;
using WorldClass = py::class_<World>;

/// Every adder ends with these.
const std::string kPlace = ", position=(0, 0, 0), orientation=None, rpy=None, color=None)";
const std::string kPlaceDoc =
    " Placed at `position` [m], turned by `orientation` (x y z w) or `rpy` (roll, pitch, yaw) "
    "[rad]. `color` (red, green, blue), each from 0 to 1, is for pages and pictures.";

/// A color, as add() and paint() take it.
std::optional<std::array<double, 3>> colorOf(const py::object& color) {
  if (color.is_none()) return std::nullopt;
  const std::vector<double> shares = numbers(color, "color", 3);
  for (const double share : shares)
    if (!(share >= 0 && share <= 1))
      throw py::value_error("color holds " + text(share) + "; numbers from 0 to 1 are expected");
  return std::array{shares[0], shares[1], shares[2]};
}

void requireNew(const World& world, const std::string& name) {
  if (name.empty()) throw py::value_error("name is empty; a name of its own is expected");
  if (world.has(name))
    throw py::value_error("'" + name +
                          "' is the name of another object or link; a name of its own is "
                          "expected");
}

/// Where something is added.
collision::Pose placeOf(const py::object& position, const py::object& orientation,
                        const py::object& rpy) {
  if (position.is_none()) throw py::value_error("position is None; a position (3,) is expected");
  return pose(position, orientation, rpy);
}

void add(World& world, const std::string& name, std::vector<collision::Geometry> geometries,
         const py::object& position, const py::object& orientation, const py::object& rpy,
         const py::object& color) {
  requireNew(world, name);
  const collision::Pose X_WO = placeOf(position, orientation, rpy);
  const auto painted = colorOf(color);
  warnIfOpen(geometries, "'" + name + "'");
  requireNew(world, name);  // what a warning calls may have added one
  world.change().objects.push_back({name, std::move(geometries), X_WO, nullptr, nullptr, painted});
}

/// A method that adds one shape. `Sizes` are the factory's arguments, all Python objects.
template <typename... Sizes>
void defineAdder(WorldClass& world, const char* name, const std::string& sizes, const char* doc,
                 collision::Shape (*factory)(const Sizes&...)) {
  define(world, name, "(self, name" + sizes + kPlace, std::string(doc) + kPlaceDoc,
         [factory](World& self, const std::string& object, const Sizes&... values,
                   const py::object& position, const py::object& orientation, const py::object& rpy,
                   const py::object& color) {
           add(self, object, {{factory(values...), {}, object}}, position, orientation, rpy, color);
         });
}

[[noreturn]] void unknown(const std::string& name) {
  throw py::key_error("no object '" + name + "'");
}

void remove(World& world, const std::string& name) {
  const auto named = [&](const Object& object) { return object.name == name; };
  if (!world.has(name)) unknown(name);
  planner::World& changed = world.change();
  std::erase_if(changed.objects, named);
  std::erase_if(changed.deforming, [&](const DeformingObstacle& o) { return named(o.object); });
}

collision::Pose poseOf(const World& world, const std::string& name) {
  for (const Object& object : world.value.objects)
    if (object.name == name) return object.X_WO;
  for (const DeformingObstacle& obstacle : world.value.deforming)
    if (obstacle.object.name == name) return obstacle.object.X_WO;
  unknown(name);
}

void move(World& world, const std::string& name, const py::object& position,
          const py::object& orientation, const py::object& rpy) {
  if (!world.has(name)) unknown(name);
  const collision::Pose X_WO = pose(position, orientation, rpy, poseOf(world, name));
  if (!world.has(name)) unknown(name);  // reading may run code in Python that changes the world
  for (const Object& object : world.value.objects)
    if (object.name == name && object.motion && object.motion->poses)
      throw py::value_error("'" + name +
                            "' stands where its motion has it; set_motion() is expected");
  planner::World& changed = world.change();
  for (Object& object : changed.objects)
    if (object.name == name) object.X_WO = X_WO;
  for (DeformingObstacle& obstacle : changed.deforming)
    if (obstacle.object.name == name) obstacle.object.X_WO = X_WO;
}

/// Calls use(object) for the object of that name.
template <class AnyWorld, class Use>
void withObject(AnyWorld& world, const std::string& name, const Use& use) {
  for (auto& object : world.objects)
    if (object.name == name) return use(object);
  for (auto& obstacle : world.deforming)
    if (obstacle.object.name == name) return use(obstacle.object);
  unknown(name);
}

/// The arguments of set_motion(). They are read before the object is looked up, because reading may
/// run code in Python that changes the world.
struct MotionGiven {
  std::optional<std::vector<collision::PoseMotion::Key>> keys;
  bool is_steady = false, are_positions = false;  // some pose is a position alone
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), turning = Eigen::Vector3d::Zero();
  std::optional<double> time;

  MotionGiven(const py::object& times, const py::object& poses, const py::object& velocities,
              const py::object& turn, const py::object& at_time)
      : is_steady(!velocities.is_none() || !turn.is_none()) {
    if (times.is_none() != poses.is_none())
      throw py::value_error(std::string(times.is_none() ? "poses" : "times") +
                            " stand alone; times and poses are expected");
    if (!times.is_none()) {
      if (is_steady || !at_time.is_none())
        throw py::value_error(
            "times and poses stand beside velocity, turning or time; one of them is expected");
      readKeys(times, poses);
    }
    if (!is_steady && !keys && !at_time.is_none())
      throw py::value_error(
          "time stands without velocity or turning; age is expected, of a pose that was seen");
    if (!at_time.is_none()) time = number(at_time, "time");
    if (!velocities.is_none()) velocity = vector3(velocities, "velocity");
    if (!turn.is_none()) turning = vector3(turn, "turning");
  }

  void readKeys(const py::object& times, const py::object& poses) {
    const Rows at = scalars(times, "times");
    if (!py::isinstance<py::sequence>(poses) && !py::hasattr(poses, "__getitem__"))
      throw py::type_error("poses is no list; a pose for each time is expected");
    keys.emplace();
    for (const py::handle each : py::reinterpret_borrow<py::object>(poses)) {
      if (keys->size() == at.values.size()) break;
      keys->push_back({at.values[keys->size()], givenPose(each, "poses")});
      are_positions = are_positions || realArray(each, "poses").size() == 3;
    }
    if (keys->size() != at.values.size() || py::len(poses) != keys->size())
      throw py::value_error("times and poses differ in number; a pose for each time is expected");
  }

  /// The poses of an object that execution finds at `start`; null: it was only seen.
  std::shared_ptr<const collision::PoseMotion> posesOf(const Object& object, double start) const {
    if (keys) return collision::PoseMotion::keys(*keys);
    if (!is_steady) return nullptr;
    double from = time.value_or(0);
    if (!time && object.motion && object.motion->poses) {
      const collision::Pose X_WO = object.motion->poses->pose(start);
      if (X_WO.translation != object.X_WO.translation || X_WO.rotation != object.X_WO.rotation)
        throw py::value_error("'" + object.name +
                              "' moves already; the time at which it is at its present pose is "
                              "expected");
      from = start;
    }
    return collision::PoseMotion::steady({from, object.X_WO}, velocity, turning);
  }
};

void setMotion(World& world, const std::string& name, const py::object& times,
               const py::object& poses, const py::object& velocity, const py::object& turning,
               const py::object& time, const py::object& speed_bound, const py::object& turn_bound,
               const py::object& age, const py::object& start) {
  const MotionGiven given(times, poses, velocity, turning, time);
  planner::ObjectMotion motion;
  motion.speed_bound = speedBoundOf(speed_bound);
  motion.turn_bound = speedBoundOf(turn_bound, "turn_bound");
  motion.age = number(age, "age");
  const double begin = number(start, "start");
  const auto named = [&](const Object& object) { return object.name == name; };
  const auto& objects = world.value.objects;
  const auto found = std::find_if(objects.begin(), objects.end(), named);
  if (found == objects.end()) {
    if (!world.has(name)) unknown(name);
    throw py::value_error("'" + name + "' deforms; a rigid object is expected");
  }
  if (given.are_positions &&
      (isTurned(found->X_WO) || std::any_of(given.keys->begin(), given.keys->end(),
                                            [&](const auto& key) { return isTurned(key.X_WB); })))
    throw py::value_error("poses has a position alone, and '" + name +
                          "' is turned; positions and quaternions (7,) or matrices (4, 4) are "
                          "expected");
  motion.poses = given.posesOf(*found, begin);
  const Object moving = planner::movingObject(*found, motion, begin);
  for (Object& object : world.change().objects)
    if (named(object)) object = moving;
}

/// The shapes of an object, placed in the world.
std::vector<collision::Geometry> shapesOf(const World& world, const std::string& name) {
  std::vector<collision::Geometry> shapes_W;
  const auto append = [&](const Object& object) {
    if (object.name != name) return;
    for (collision::Geometry geometry : object.geometries) {
      geometry.X_BG = object.X_WO * geometry.X_BG;
      shapes_W.push_back(std::move(geometry));
    }
  };
  for (const Object& object : world.value.objects) append(object);
  for (const DeformingObstacle& obstacle : world.value.deforming) append(obstacle.object);
  if (shapes_W.empty()) throw py::key_error("no object with shapes is named '" + name + "'");
  return shapes_W;
}

/// Keywords of filters and of the place, as Python gives them.
struct CloudKeywords {
  const py::object &thin, &most_balls, &carve, &carve_margin, &position, &orientation, &rpy, &color;
};

/// Adds a cloud, filtered, with space that was not seen; returns what was left out.
py::list addFiltered(World& world, const std::string& name, PointCloud cloud,
                     const CloudKeywords& of, std::vector<collision::Geometry> unseen = {}) {
  Object object{name,    {},      pose(of.position, of.orientation, of.rpy),
                nullptr, nullptr, colorOf(of.color)};
  const double margin = number(of.carve_margin, "carve_margin");
  const std::vector<std::string> carve = namesOf(of.carve, "carve");
  if (carve.empty() && margin != 0)
    throw py::value_error("carve_margin stands without carve; both are expected");
  for (const std::string& shape : carve) {
    const std::vector<collision::Geometry> shapes_W = shapesOf(world, shape);
    planner::carve(cloud, unseen, object.X_WO, shapes_W, margin, shape);
  }
  if (!of.thin.is_none()) cloud = planner::thinned(cloud, number(of.thin, "thin"));
  if (!of.most_balls.is_none())
    cloud = planner::thinnedTo(cloud, whole<std::size_t>(of.most_balls, "most_balls"));
  object.geometries = std::move(unseen);
  py::list left_out;
  for (const planner::CloudFilter& filter : cloud.filters)
    left_out.append(py::make_tuple(filter.name, filter.what, filter.removed));
  object.cloud = std::make_shared<const PointCloud>(std::move(cloud));
  world.change().objects.push_back(std::move(object));
  return left_out;
}

py::list addCloud(World& world, const std::string& name, const py::object& points,
                  const py::object& radius, const py::object& thin, const py::object& most_balls,
                  const py::object& carve, const py::object& carve_margin,
                  const py::object& position, const py::object& orientation, const py::object& rpy,
                  const py::object& color) {
  requireNew(world, name);
  PointCloud cloud = cloudOf(points, radius);
  if (cloud.balls.empty()) throw py::value_error("points: " + planner::cloudFault(cloud));
  return addFiltered(world, name, std::move(cloud),
                     {thin, most_balls, carve, carve_margin, position, orientation, rpy, color});
}

/// A depth image as one block of memory, which the result keeps.
py::array depthOf(const py::object& depth, planner::DepthImage& image) {
  py::array array = realArray(depth, "depth");
  if (array.ndim() != 2)
    throw py::value_error("depth is expected to be an array of shape (rows, columns)");
  const auto take = [&](auto number, planner::DepthImage::Number type) {
    using Pixel = decltype(number);
    if (!py::isinstance<py::array_t<Pixel>>(array)) return false;
    array = py::array_t<Pixel, py::array::c_style | py::array::forcecast>::ensure(array);
    image.number = type;
    return true;
  };
  using Number = planner::DepthImage::Number;
  if (!take(std::uint16_t{}, Number::kUint16) && !take(float{}, Number::kFloat) &&
      !take(double{}, Number::kDouble))
    throw py::type_error("depth has the type " + std::string(py::str(array.dtype())) +
                         "; uint16, float32 or float64 is expected");
  image.first = array.data();
  image.height = static_cast<std::size_t>(array.shape(0));
  image.width = static_cast<std::size_t>(array.shape(1));
  image.stride = image.width * static_cast<std::size_t>(array.itemsize());
  return array;
}

/// One byte a pixel; empty for None.
std::vector<std::uint8_t> maskOf(const py::object& mask, const planner::DepthImage& image) {
  if (mask.is_none()) return {};
  const auto given = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(mask);
  if (!given) {
    PyErr_Clear();
    throw py::value_error("mask holds what is not a number; numbers or booleans are expected");
  }
  if (given.ndim() != 2 || static_cast<std::size_t>(given.shape(0)) != image.height ||
      static_cast<std::size_t>(given.shape(1)) != image.width)
    throw py::value_error("mask has another shape than depth; (" + std::to_string(image.height) +
                          ", " + std::to_string(image.width) + ") is expected");
  return {given.data(), given.data() + given.size()};
}

py::list addDepthImage(World& world, const std::string& name, const py::object& depth,
                       const py::object& radius, const py::object& fx, const py::object& fy,
                       const py::object& cx, const py::object& cy, const py::object& scale,
                       const py::object& slant, const py::object& mask, const std::string& unseen,
                       const py::object& range, const py::object& parts, const py::object& thin,
                       const py::object& most_balls, const py::object& carve,
                       const py::object& carve_margin, const py::object& position,
                       const py::object& orientation, const py::object& rpy,
                       const py::object& color) {
  requireNew(world, name);
  planner::DepthImage image;
  const py::array kept = depthOf(depth, image);
  const std::vector<std::uint8_t> bytes = maskOf(mask, image);
  if (!bytes.empty()) image.mask = bytes.data();
  planner::DepthCamera camera{number(fx, "fx"), number(fy, "fy"), number(cx, "cx"),
                              number(cy, "cy")};
  if (!scale.is_none()) camera.scale = number(scale, "scale");
  camera.slant = number(slant, "slant");
  planner::PointCloud cloud = planner::makeCloud(image, camera, number(radius, "radius"));
  if (cloud.balls.empty())
    throw py::value_error("depth: no pixel is a measurement; at least one above 0 is expected");
  if (unseen != "free" && unseen != "occupied")
    unknownWord("unseen", unseen, "'free' or 'occupied'");
  std::vector<collision::Geometry> space;
  if (unseen == "occupied") {
    if (range.is_none())
      throw py::value_error(
          "unseen='occupied' stands without range; the depth [m] up to which it is occupied is "
          "expected");
    space = planner::unseenShapes(
        image, camera,
        {number(range, "range"),
         parts.is_none() ? planner::UnseenSpace().most_parts : whole<std::size_t>(parts, "parts")});
  } else if (!range.is_none() || !parts.is_none()) {
    throw py::value_error((range.is_none() ? "parts" : "range") +
                          std::string(" stands without unseen='occupied'; both are expected"));
  }
  return addFiltered(world, name, std::move(cloud),
                     {thin, most_balls, carve, carve_margin, position, orientation, rpy, color},
                     std::move(space));
}

std::string htmlOfWorld(const World& world) {
  std::vector<std::vector<std::string>> table;
  const auto addRow = [&](const Object& object) {
    std::string shapes;
    for (const collision::Geometry& geometry : object.geometries)
      shapes += (shapes.empty() ? "" : ", ") + std::string(toString(geometry.shape.type()));
    if (object.cloud) shapes += "cloud of " + std::to_string(object.cloud->size()) + " balls";
    const Eigen::Vector3d& p = object.X_WO.translation;
    table.push_back({object.name, shapes, text(p.x()) + ", " + text(p.y()) + ", " + text(p.z())});
  };
  for (const Object& object : world.value.objects) addRow(object);
  for (const DeformingObstacle& obstacle : world.value.deforming) addRow(obstacle.object);
  return htmlTable("World", {"object", "shapes", "position [m]"}, table);
}

void addDeforming(World& world, const std::string& name, const py::object& vertices,
                  const py::object& faces, const py::object& motion, const py::object& bound,
                  const py::object& strategy, const py::object& position,
                  const py::object& orientation, const py::object& rpy, const py::object& color) {
  requireNew(world, name);
  const collision::Pose X_WO = placeOf(position, orientation, rpy);
  const auto mesh = deformableMesh(vertices, faces);
  const auto moves = motionOf(motion);
  const double speed_bound = speedBoundOf(bound);
  const auto painted = colorOf(color);
  collision::DeformOptions options;
  options.strategy = strategyOf(strategy);
  DeformingObstacle made = released([&] {
    return planner::makeDeformingObstacle(name, mesh, moves, X_WO, 0, options, speed_bound);
  });
  made.object.color = painted;
  requireNew(world, name);  // another thread may have added one meanwhile
  world.change().deforming.push_back(std::move(made));
}

void defineAdders(WorldClass& world) {
  defineAdder(world, "add_box", ", size", "Adds a box of whole edges (x, y, z) [m].", box);
  defineAdder(world, "add_sphere", ", radius", "Adds a sphere [m].", sphere);
  defineAdder(world, "add_cylinder", ", radius, length", "Adds a cylinder along its z [m].",
              cylinder);
  defineAdder(world, "add_capsule", ", radius, length",
              "Adds a capsule along its z, `length` being the straight part's [m].", capsule);
  defineAdder(world, "add_cone", ", radius, height", "Adds a cone along its z [m].", cone);
  defineAdder(world, "add_ellipsoid", ", semi_axes", "Adds an ellipsoid of semi-axes (3,) [m].",
              ellipsoid);
  defineAdder(world, "add_convex_hull", ", points", "Adds the hull of points (n, 3) [m].",
              convexHull);
  define(world, "add_octree", "(self, name, file, unseen" + kPlace,
         std::string("Adds the occupied leaves of an OctoMap file (.bt, .ot) as boxes. `unseen` is "
                     "'free' or 'occupied': what space counts as that the octree says nothing "
                     "about.") +
             kPlaceDoc,
         [](World& self, const std::string& name, const py::object& file, const std::string& unseen,
            const py::object& position, const py::object& orientation, const py::object& rpy,
            const py::object& color) {
           if (unseen != "free" && unseen != "occupied")
             unknownWord("unseen", unseen, "'free' or 'occupied'");
           const std::string path = fileName(file, "file");
           Interrupt interrupt;
           const auto stop = interrupt.callback();
           auto boxes = interrupt.released([&] {
             return planner::loadOctree(
                 path, unseen == "free" ? planner::Unseen::kFree : planner::Unseen::kOccupied,
                 stop);
           });
           for (collision::Geometry& box : boxes) box.name = name;
           add(self, name, std::move(boxes), position, orientation, rpy, color);
         });
  defineAdder(world, "add_height_field", ", heights, step, floor",
              "Adds what is below heights (rows, columns), as Shape.height_field() has it [m].",
              heightField);
  define(world, "add_half_space", "(self, name" + kPlace,
         std::string("Adds all below z = 0 of its frame: a floor.") + kPlaceDoc,
         [](World& self, const std::string& name, const py::object& position,
            const py::object& orientation, const py::object& rpy, const py::object& color) {
           add(self, name, {{collision::Shape::halfSpace(), {}, name}}, position, orientation, rpy,
               color);
         });
  define(world, "add_mesh",
         "(self, name, file=None, *, vertices=None, triangles=None, scale=1.0, solid='auto', "
         "weld=0.0" +
             kPlace,
         std::string(
             "Adds a mesh: a file (STL, OBJ, PLY, DAE, glTF), or vertices (n, 3) [m] and triangles "
             "(m, 3). `solid` and `weld` as in Shape.mesh().") +
             kPlaceDoc,
         [](World& self, const std::string& name, const py::object& file,
            const py::object& vertices, const py::object& faces, const py::object& scale,
            const std::string& solid, double weld, const py::object& position,
            const py::object& orientation, const py::object& rpy, const py::object& color) {
           add(self, name, {{mesh(file, vertices, faces, scale, solid, weld), {}, name}}, position,
               orientation, rpy, color);
         });
  define(world, "add_cloud",
         "(self, name, points, radius, *, thin=None, most_balls=None, carve=(), carve_margin=0.0" +
             kPlace,
         std::string("Adds a point cloud: the union of balls around points (n, 3) of float32 or "
                     "float64 [m], with one `radius` or (n,) [m]. Points that are not finite are "
                     "dropped; at least one point must stay. `carve` names objects: balls within "
                     "`carve_margin` [m] of them are "
                     "left out. `thin` [m]: one ball a cell of that size, which contains the "
                     "others. `most_balls`: at most so many balls, which contain the others. "
                     "Returns what was left out: a list of (filter, what, count).") +
             kPlaceDoc,
         addCloud);
  define(
      world, "add_depth_image",
      "(self, name, depth, radius, *, fx, fy, cx, cy, scale=None, slant=1.0471975511965976, "
      "mask=None, unseen='free', range=None, parts=None, thin=None, most_balls=None, carve=(), "
      "carve_margin=0.0" +
          kPlace,
      std::string(
          "Adds a depth image (rows, columns) of uint16, float32 or float64 as a point cloud in "
          "the camera's frame: x to the right of the picture, y down, z into the scene. `fx`, "
          "`fy`, `cx`, `cy` [pixels]: a camera without distortion. `scale` [m]: depth of a value "
          "of 1; 0.001 of whole numbers, else 1. Balls have the `radius` [m] plus a part that "
          "grows with depth, and cover flat surfaces up to `slant` [rad] from facing the "
          "camera. Pixels that are 0, not finite, or 0 in `mask` are dropped. With `unseen` "
          "'occupied', at most `parts` (1000) convex parts contain what the camera did not see "
          "within its "
          "picture and the depth `range` [m]: space behind surfaces, and all that dropped pixels "
          "look at; `carve` leaves out those that touch. The rest as in add_cloud().") +
          kPlaceDoc,
      addDepthImage);
  define(
      world, "add", "(self, name, shapes" + kPlace,
      std::string("Adds one rigid object: a Shape, or a list of shapes or pairs (shape, pose in "
                  "the object's frame).") +
          kPlaceDoc,
      [](World& self, const std::string& name, const py::object& shapes, const py::object& position,
         const py::object& orientation, const py::object& rpy, const py::object& color) {
        add(self, name, geometriesOf(shapes, name), position, orientation, rpy, color);
      });
  define(world, "add_deforming",
         "(self, name, vertices, triangles, *, motion=None, speed_bound=None, strategy='auto'" +
             kPlace,
         std::string("Adds a mesh whose vertices (n, 3) [m] move: as `motion` says, or as a "
                     "Replanner is told. Plans see it as it is at time 0. `speed_bound` [m/s] "
                     "bounds its vertices where their future is unknown.") +
             kPlaceDoc,
         addDeforming);
}

}  // namespace

planner::PointCloud cloudOf(const py::object& points, const py::object& radius) {
  py::array array = realArray(points, "points");
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw py::value_error(
        "points has shape " + std::string(py::str(array.attr("shape"))) +
        "; shape (n, 3) is expected" +
        (array.ndim() == 2 && array.shape(1) > 3 ? ", such as points[:, :3] or points.T" : ""));
  const bool is_float = py::isinstance<py::array_t<float>>(array);
  const bool is_double = py::isinstance<py::array_t<double>>(array);
  // Rows of a broadcast array share their memory.
  if ((!is_float && !is_double) || array.strides(1) != array.itemsize() ||
      array.strides(0) < 3 * array.itemsize())
    array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!array) {
    PyErr_Clear();
    throw py::value_error("points hold what is not a number; float32 or float64 is expected");
  }
  const bool as_float = is_float && py::isinstance<py::array_t<float>>(array);
  const planner::PointArray xyz{
      array.data(), static_cast<std::size_t>(array.shape(0)),
      array.shape(0) > 1 ? static_cast<std::size_t>(array.strides(0)) : 0,
      as_float ? planner::PointArray::Number::kFloat : planner::PointArray::Number::kDouble};
  const Rows radii = scalars(radius, "radius");
  return radii.shape.empty() ? planner::makeCloud(xyz, radii.values.at(0))
                             : planner::makeCloud(xyz, radii.values);
}

std::vector<std::string> namesOf(const py::object& names, const char* name) {
  if (py::isinstance<py::str>(names))
    throw py::type_error(std::string(name) + " is '" + std::string(py::str(names)) +
                         "'; a list of names is expected");
  std::vector<std::string> all;
  for (const py::handle item : py::list(names)) {
    if (!py::isinstance<py::str>(item))
      throw py::type_error(std::string(name) + " holds what is of type " +
                           Py_TYPE(item.ptr())->tp_name + "; names are expected");
    all.push_back(py::str(item));
  }
  return all;
}

bool hasObject(const planner::World& world, const std::string& name) {
  const auto named = [&](const Object& object) { return object.name == name; };
  return std::any_of(world.objects.begin(), world.objects.end(), named) ||
         std::any_of(world.deforming.begin(), world.deforming.end(),
                     [&](const DeformingObstacle& o) { return named(o.object); });
}

std::vector<std::string> objectNames(const planner::World& world) {
  std::vector<std::string> all;
  for (const Object& object : world.objects) all.push_back(object.name);
  for (const DeformingObstacle& obstacle : world.deforming) all.push_back(obstacle.object.name);
  return all;
}

collision::Pose seenPose(const planner::World& world, const std::string& name, py::handle given,
                         double time, const std::set<std::string>& turned) {
  const collision::Pose X_WO = givenPose(given, "pose");
  if (realArray(given, "pose").size() != 3) return X_WO;
  bool was_turned = turned.count(name) > 0;
  for (const Object& object : world.objects)
    if (object.name == name)
      was_turned = was_turned ||
                   isTurned(object.motion && object.motion->poses ? object.motion->poses->pose(time)
                                                                  : object.X_WO);
  if (was_turned)
    throw py::value_error("pose is a position alone, and '" + name +
                          "' was turned; a position and quaternion (7,) or a matrix (4, 4) is "
                          "expected");
  return X_WO;
}

bool isTurned(const collision::Pose& X_WO) { return X_WO.rotation != Eigen::Matrix3d::Identity(); }

bool World::has(const std::string& name) const { return hasObject(value, name); }

planner::World& World::change() {
  if (is_constant)
    throw py::type_error(
        "this World is that of a problem that was compiled or answered; copy() gives one to "
        "change");
  ++changes;
  return value;
}

void defineWorld(py::module_& module) {
  auto world =
      defineClass<WorldClass>(module, "World", "()",
                              "What surrounds the robot: named objects at rest, and meshes that "
                              "deform. Threads may share it.",
                              [] { return World{}; });
  defineAdders(world);
  define(world, "move", "(self, name, position=None, orientation=None, rpy=None)",
         "Moves an object to `position` [m], and turns it to `orientation` (x y z w) or `rpy` "
         "(roll, pitch, yaw) [rad]. What is not given stays as it was.",
         move);
  define(
      world, "set_motion",
      "(self, name, *, times=None, poses=None, velocity=None, turning=None, time=None, "
      "speed_bound=None, turn_bound=None, age=0.0, start=0.0)",
      "Says how an object moves, for Replanner and Guard; plans see it as it is at `start`, which "
      "is the setting start_time [s]. Through `poses` at `times` [s], straight and by the shorter "
      "turn between them; or from its pose at `time` (default 0; of one that moves already, "
      "`start`) at a constant `velocity` [m/s] and `turning` (3,) [rad/s] in the world; or without "
      "these it was only seen at its pose, "
      "`age` [s] before `start`. `speed_bound` [m/s] of its origin (of a cloud: of its points) and "
      "`turn_bound` [rad/s] hold where its motion is not known.",
      setMotion);
  define(world, "remove", "(self, name)", "Removes an object. KeyError where there is none.",
         remove);
  define(world, "pose", "(self, name)", "Where an object is: (4, 4), read-only; move() changes it.",
         [](const World& self, const std::string& name) {
           return constant(matrix(poseOf(self, name)));
         });
  define(
      world, "paint", "(self, name, color)",
      "Gives an object a color (red, green, blue), each from 0 to 1, for pages and pictures; None: "
      "they choose one.",
      [](World& self, const std::string& name, const py::object& color) {
        const auto painted = colorOf(color);
        if (!self.has(name)) unknown(name);
        withObject(self.change(), name, [&](Object& object) { object.color = painted; });
      });
  define(world, "color", "(self, name)",
         "The color of an object, (red, green, blue); None: it has none.",
         [](const World& self, const std::string& name) {
           py::object color = py::none();
           withObject(self.value, name, [&](const Object& object) {
             if (object.color)
               color = py::make_tuple((*object.color)[0], (*object.color)[1], (*object.color)[2]);
           });
           return color;
         });
  define(world, "copy", "(self)",
         "Another world with the same objects, as copy.copy() and copy.deepcopy() give; shapes are "
         "shared.",
         [](const World& self) { return World{self.value}; });
  defineCopies(world, [](const World& self) { return World{self.value}; });
  defineConstant(
      world, "names", [](const World& self) { return listOf(objectNames(self.value)); },
      "Names of all objects.");
  world.def("__len__", [](const World& self) {
    return self.value.objects.size() + self.value.deforming.size();
  });
  world.def("__contains__", [](const World& self, const py::object& name) {
    return py::isinstance<py::str>(name) && self.has(word(name, "name"));
  });
  world.def("__iter__",
            [](const World& self) { return py::iter(listOf(objectNames(self.value))); });
  world.def("__repr__", [](const World& self) {
    return "<leeway.World of " +
           std::to_string(self.value.objects.size() + self.value.deforming.size()) + " objects>";
  });
  world.def("_repr_html_", htmlOfWorld);
}

}  // namespace leeway::python
