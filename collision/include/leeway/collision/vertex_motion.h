#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <variant>
#include <vector>

#include "leeway/collision/pose.h"

namespace leeway::collision {

/// The class of a VertexMotion; kOwn: derived by an embedding program.
enum class MotionKind : unsigned char {
  kWaves,
  kLattice,
  kMorph,
  kSkinned,
  kReduced,
  kCache,
  kOwn
};

/// "waves", "lattice", "morph", "skinned", "reduced", "cache", "own": the word used in files and
/// messages.
const char* toString(MotionKind kind);

/// Thrown by the factories of VertexMotion; the message names the value and what is accepted.
class InvalidMotion : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The interpolation between two keys: (1 - s) times the first plus s times the second, where u in
/// [0, 1] is the fraction of the time between them. Before the first key and after the last, the
/// value of that key is held.
enum class Interpolation : unsigned char {
  kLinear,  ///< s = u: constant speed, which jumps at every key
  kSmooth,  ///< s = u^2 (3 - 2 u): at rest at every key, up to 1.5 times as fast in between
};

/// A travelling wave: a vertex with rest position r is displaced by
/// amplitude * sin(2 pi (direction . r / wavelength - frequency t) + phase).
struct Wave {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< of travel; made a unit vector
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();   // [m]
  double wavelength = 1;                                 // [m]
  double frequency = 1;                                  // [Hz]; negative: travels backwards
  double phase = 0;                                      // [rad]
};

/// Holds an edge fixed: waves are multiplied by (r - point) . direction / length, clamped to [0,
/// 1].
struct PinnedEdge {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       // [m]
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< away from the edge; made a unit vector
  double length = 1;                                     // [m]
};

struct WavesMotion {
  std::vector<Eigen::Vector3d> rest;  // [m]
  std::vector<Wave> waves;
  std::optional<PinnedEdge> pinned;
};

/// Free-form deformation (Sederberg and Parry 1986): the rest box has a grid of control points,
/// cells[k] + 1 along axis k, and a vertex at (u, v, w) of the box moves to the sum of the control
/// points weighted by Bernstein polynomials of degree cells[k]. Control points at their grid places
/// leave the mesh undeformed.
struct LatticeMotion {
  std::vector<Eigen::Vector3d> rest;  // [m], all within the box
  Eigen::Vector3d box_lower = Eigen::Vector3d::Zero(), box_upper = Eigen::Vector3d::Ones();  // [m]
  int cells[3] = {1, 1, 1};  ///< 1 to 16 each
  struct Key {
    double time = 0;                              // [s]
    std::vector<Eigen::Vector3d> control_points;  // [m]; x index fastest, then y, then z
  };
  std::vector<Key> keys;
  Interpolation interpolation = Interpolation::kLinear;
};

/// Morph targets: a vertex is the sum over the references of weight times its position there.
/// Weights need not sum to 1 nor lie in [0, 1].
struct MorphMotion {
  std::vector<std::vector<Eigen::Vector3d>> references;  // [m]
  struct Key {
    double time = 0;              // [s]
    std::vector<double> weights;  ///< one for each reference
  };
  std::vector<Key> keys;
  Interpolation interpolation = Interpolation::kLinear;
};

/// Linear blend skinning: a vertex with rest position r is the sum over bones b of
/// weight_b * X_b(t) * X_b(rest)^-1 * r. Between keys a bone's pose is interpolated in its parent's
/// frame: the translation linearly, the rotation by normalised linear interpolation of the two
/// quaternions along the shorter arc (nlerp: the axis of slerp, its speed within a factor of 4/pi,
/// no trigonometric functions).
struct SkinnedMotion {
  /// A rigid placement as files give it; the quaternion x y z w is normalised.
  struct BonePose {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // [m]
    Eigen::Vector4d quaternion = Eigen::Vector4d::UnitW();
  };
  struct Bone {
    int parent = -1;  ///< an earlier bone, in whose frame the poses are given; -1: the mesh's frame
    BonePose rest;
  };
  /// Weights >= 0; those of a vertex are divided by their sum.
  struct Weight {
    int vertex = 0, bone = 0;
    double weight = 1;
  };
  struct Key {
    double time = 0;              // [s]
    std::vector<BonePose> poses;  ///< one for each bone, in its parent's frame
  };
  std::vector<Eigen::Vector3d> rest;  // [m]
  std::vector<Bone> bones;
  /// At least one for each vertex, in any order; each pair of vertex and bone at most once.
  std::vector<Weight> weights;
  std::vector<Key> keys;
  Interpolation interpolation = Interpolation::kLinear;
};

/// Reduced deformation: rest position plus the sum over the modes of coordinate times displacement.
/// Either every mode is harmonic, with the coordinate amplitude * sin(2 pi frequency t + phase), or
/// the coordinates have keys.
struct ReducedMotion {
  struct Harmonic {
    double amplitude = 1;  // no unit
    double frequency = 1;  // [Hz]
    double phase = 0;      // [rad]
  };
  struct Key {
    double time = 0;                  // [s]
    std::vector<double> coordinates;  ///< one for each mode
  };
  std::vector<Eigen::Vector3d> rest;                // [m]
  std::vector<std::vector<Eigen::Vector3d>> modes;  // [m]
  std::vector<Harmonic> harmonics;                  ///< one for each mode, or none
  std::vector<Key> keys;                            ///< none when there are harmonics
  Interpolation interpolation = Interpolation::kLinear;
};

/// Recorded positions, as animation tools write them, linear in time between the frames.
struct CacheMotion {
  int vertex_count = 0;
  std::vector<double> times;               // [s], one for each frame
  std::vector<Eigen::Vector3d> positions;  // [m], frame by frame
};

/// The definition of a motion; nothing for kOwn.
using MotionSource = std::variant<std::monostate, WavesMotion, LatticeMotion, MorphMotion,
                                  SkinnedMotion, ReducedMotion, CacheMotion>;

/// The positions of a mesh's vertices at any time. Immutable; safe to use from many threads.
/// Positions are functions of a few parameters (weights, bone matrices, coordinates), so that one
/// vertex, or a bound of many, can be computed without the others. Same bytes on every machine.
/// Times [s], positions [m] in the mesh's frame.
class VertexMotion {
 public:
  /// All factories throw InvalidMotion if a number is not finite or exceeds 1e15 in magnitude, if
  /// counts do not match, if there are no vertices or no keys, or if key times do not increase.
  /// O(vertices x (references, modes, waves, control points, bones or frames)).
  static std::shared_ptr<const VertexMotion> waves(WavesMotion motion);
  static std::shared_ptr<const VertexMotion> lattice(LatticeMotion motion);
  static std::shared_ptr<const VertexMotion> morph(MorphMotion motion);
  static std::shared_ptr<const VertexMotion> skinned(SkinnedMotion motion);
  static std::shared_ptr<const VertexMotion> reduced(ReducedMotion motion);
  static std::shared_ptr<const VertexMotion> cache(CacheMotion motion);

  virtual ~VertexMotion() = default;
  VertexMotion(const VertexMotion&) = delete;
  VertexMotion& operator=(const VertexMotion&) = delete;

  MotionKind kind() const { return kind_; }
  /// Returns a copy of the factory's argument, for programs that write it down.
  virtual MotionSource source() const { return source_ ? *source_ : MotionSource(); }
  int vertexCount() const { return vertex_count_; }
  /// Times between which the motion is smooth, increasing; may be empty [s].
  std::span<const double> keyTimes() const { return key_times_; }

  /// The number of parameters.
  int parameterCount() const { return parameter_count_; }
  /// The parameters at `time` [s], which must be finite; out.size() is parameterCount(). The cost
  /// does not depend on the number of vertices. Never throws or allocates.
  virtual void parameters(double time, std::span<double> out) const = 0;
  /// The vertices first ... first + out.size() - 1 for these parameters [m]; a vertex has the same
  /// bytes for every range. Never throws or allocates. O(out.size()).
  virtual void vertices(std::span<const double> parameters, int first,
                        std::span<Eigen::Vector3d> out) const = 0;
  /// All vertices at `time` [s]; positions.size() is vertexCount(). Allocates the parameters.
  void evaluate(double time, std::span<Eigen::Vector3d> positions) const;

  /// No vertex moves faster [m/s] or accelerates more [m/s^2] than this from t0 to t1, in exact
  /// arithmetic. Infinite if no bound is known; the acceleration is also infinite if speed jumps at
  /// a key strictly between t0 and t1. Updates rely on these bounds: if one is too small, queries
  /// miss moved triangles. Never throws or allocates. O(log keys + keys between).
  virtual double speedBound(double t0, double t1) const = 0;
  virtual double accelerationBound(double t0, double t1) const = 0;
  /// No vertex evaluated at a time from t0 to t1 is farther than this from the exact one [m].
  /// Evaluated vertices therefore move by at most speedBound * (t1 - t0) + 2 * rounding.
  virtual double rounding(double t0, double t1) const = 0;

 protected:
  /// For the classes of embedding programs, whose kind is kOwn. Throws InvalidMotion for no
  /// vertices, a negative parameter count, or key times that are not finite or do not increase.
  VertexMotion(MotionKind kind, int vertex_count, int parameter_count,
               std::vector<double> key_times);

 private:
  /// Returns `made`, a new motion, with its source.
  static std::shared_ptr<const VertexMotion> withSource(std::shared_ptr<VertexMotion> made,
                                                        MotionSource source);

  MotionKind kind_;
  int vertex_count_, parameter_count_;
  std::vector<double> key_times_;
  std::shared_ptr<const MotionSource> source_;
};

}  // namespace leeway::collision
