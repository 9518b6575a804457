#pragma once

#include <ompl/base/StateSpace.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "leeway/planner/configuration_space.h"

namespace leeway::planner {

/// A ConfigurationSpace for OMPL. A state is one flat array of doubles for joints and free bodies,
/// and interpolates as everywhere else in the library. The distance of two rotations is the angle
/// between them [rad] (half of it in OMPL's SO(3)), exact at small angles.
///
/// Samplers are uniform over the space, uniform near a state or normal about a state, always inside
/// the limits. Near a state, each variable is uniform separately within distance / weight, and a
/// rotation in the ball of that angle. About a state, the standard deviation is divided by the
/// weight in the same way. Samplers draw from the space's seed, the k-th sampler from stream k. So
/// one seed gives one sequence of samples, independent of other threads.
class OmplStateSpace : public ompl::base::StateSpace {
 public:
  class StateType : public ompl::base::State {
   public:
    double* values;  ///< in group order, after this struct in the same block of memory
    double& operator[](std::size_t i) { return values[i]; }
    double operator[](std::size_t i) const { return values[i]; }
  };

  /// Throws std::invalid_argument if a joint that is not continuous has no limits.
  explicit OmplStateSpace(std::shared_ptr<const ConfigurationSpace> space, std::uint64_t seed = 1);
  ~OmplStateSpace() override;

  const ConfigurationSpace& space() const { return *space_; }
  std::span<double> point(ompl::base::State* state) const;
  std::span<const double> point(const ompl::base::State* state) const;

  /// Degrees of freedom: 3 for a rotation, although it is stored as 4 numbers.
  unsigned int getDimension() const override;
  double getMaximumExtent() const override;
  /// Volume in the metric of distance(): products of ranges, 2 pi per circle, 8 pi^2 per rotation.
  double getMeasure() const override;
  void enforceBounds(ompl::base::State* state) const override;
  bool satisfiesBounds(const ompl::base::State* state) const override;
  void copyState(ompl::base::State* destination, const ompl::base::State* source) const override;
  double distance(const ompl::base::State* a, const ompl::base::State* b) const override;
  /// True when the distance is exactly zero.
  bool equalStates(const ompl::base::State* a, const ompl::base::State* b) const override;
  void interpolate(const ompl::base::State* from, const ompl::base::State* to, double t,
                   ompl::base::State* state) const override;
  ompl::base::StateSamplerPtr allocDefaultStateSampler() const override;
  ompl::base::State* allocState() const override;
  void freeState(ompl::base::State* state) const override;
  unsigned int getSerializationLength() const override;
  void serialize(void* serialization, const ompl::base::State* state) const override;
  void deserialize(ompl::base::State* state, const void* serialization) const override;
  double* getValueAddressAtIndex(ompl::base::State* state, unsigned int index) const override;
  /// The default projection uses the first two numbers, or the three of a free body's position, in
  /// cells of a twentieth of their range.
  void registerProjections() override;
  void printState(const ompl::base::State* state, std::ostream& out) const override;
  void printSettings(std::ostream& out) const override;

 private:
  std::shared_ptr<const ConfigurationSpace> space_;
  std::size_t size_;
  std::uint64_t seed_;
  bool plain_;  ///< only straight lines of weight 1: distance() has a separate loop for them
  mutable std::atomic<std::uint64_t> sampler_count_{0};  ///< the next sampler's stream
};

}  // namespace leeway::planner
