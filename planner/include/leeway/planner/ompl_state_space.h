#pragma once

#include <ompl/base/StateSampler.h>
#include <ompl/base/StateSpace.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "leeway/planner/random.h"

namespace leeway::planner {

/// A ConfigurationSpace as OMPL knows spaces: joint groups, continuous joints and free bodies in
/// one flat array of doubles a state, so that planner, certificate and verifier interpolate with
/// the same function. Rotations are quaternions xyzw whose distance is the angle [rad] (OMPL's
/// SO(3) has half of it), exact at small angles. Samplers draw from the space's own seed, the k-th
/// one made from stream k: the same seed gives the same samples, whatever other threads do. Throws
/// std::invalid_argument when a joint that is not continuous has no limits.
class OmplStateSpace : public ompl::base::StateSpace {
 public:
  class StateType : public ompl::base::State {
   public:
    double* values;  ///< in group order, behind this struct in the same block of memory
    double& operator[](std::size_t i) { return values[i]; }
    double operator[](std::size_t i) const { return values[i]; }
  };

  explicit OmplStateSpace(std::shared_ptr<const ConfigurationSpace> space, std::uint64_t seed = 1);
  ~OmplStateSpace() override;

  const ConfigurationSpace& space() const { return *space_; }
  std::span<double> point(ompl::base::State* state) const;
  std::span<const double> point(const ompl::base::State* state) const;

  /// Degrees of freedom: a rotation counts 3 though it is stored as 4 numbers.
  unsigned int getDimension() const override;
  double getMaximumExtent() const override;
  /// Volume in the metric of distance(): products of ranges, 2 pi a circle, 8 pi^2 a rotation.
  double getMeasure() const override;
  void enforceBounds(ompl::base::State* state) const override;
  bool satisfiesBounds(const ompl::base::State* state) const override;
  void copyState(ompl::base::State* destination, const ompl::base::State* source) const override;
  double distance(const ompl::base::State* a, const ompl::base::State* b) const override;
  /// True when the distance is exactly zero: neither rounding nor small motions are equality.
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
  /// Default projection: the first two numbers, three when they are a free body's position, in
  /// cells of a twentieth of their range.
  void registerProjections() override;
  void printState(const ompl::base::State* state, std::ostream& out) const override;
  void printSettings(std::ostream& out) const override;

 private:
  std::shared_ptr<const ConfigurationSpace> space_;
  std::size_t size_;
  std::uint64_t seed_;
  bool plain_;  ///< straight lines of weight 1 only: the common case, worth a loop of its own in
                ///< distance()
  mutable std::atomic<std::uint64_t> sampler_count_{0};  ///< the next sampler's stream
};

/// Uniform over the space, uniform near a state, normal about a state.
class OmplStateSampler : public ompl::base::StateSampler {
 public:
  OmplStateSampler(const OmplStateSpace* space, std::uint64_t seed, std::uint64_t stream);
  void sampleUniform(ompl::base::State* state) override;
  /// Each variable by itself within distance / weight of `near` (rotations: in the ball of that
  /// angle), inside the limits.
  void sampleUniformNear(ompl::base::State* state, const ompl::base::State* near,
                         double distance) override;
  /// Each variable by itself with that standard deviation / weight, inside the limits.
  void sampleGaussian(ompl::base::State* state, const ompl::base::State* mean,
                      double deviation) override;

 private:
  const OmplStateSpace& own_;
  Random random_;
  std::vector<double> offset_;
};

}  // namespace leeway::planner
