#include "leeway/planner/ompl_state_space.h"

#include <ompl/base/ProjectionEvaluator.h>
#include <ompl/base/StateSampler.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <numbers>
#include <ostream>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/space/ompl_lock.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;
using Kind = ConfigurationSpace::Kind;
using Part = ConfigurationSpace::Part;

/// Cells of the default projection along each axis; OMPL's own spaces have the same number.
constexpr double kProjectionCells = 20;

double range(const ConfigurationSpace& space, const Part& part) {
  return part.kind == Kind::kLine ? space.upper(part.first) - space.lower(part.first)
                                  : collision::kTwoPi;
}

/// The greatest distance of two points in the given part.
double extent(const ConfigurationSpace& space, const Part& part) {
  return part.weight * (part.kind == Kind::kLine ? range(space, part) : std::numbers::pi);
}

double measure(const ConfigurationSpace& space, const Part& part) {
  // Unit quaternions up to sign have the volume pi^2 on the sphere, and an angle is twice the arc.
  if (part.kind == Kind::kRotation)
    return 8 * std::numbers::pi * std::numbers::pi * part.weight * part.weight * part.weight;
  return part.weight * range(space, part);
}

/// The first numbers of a point that are not part of a quaternion.
class FirstNumbers : public ob::ProjectionEvaluator {
 public:
  FirstNumbers(const OmplStateSpace* space, unsigned int dimension)
      : ProjectionEvaluator(space), own_(*space), dimension_(dimension) {}

  unsigned int getDimension() const override { return dimension_; }

  void defaultCellSizes() override {
    const ConfigurationSpace& space = own_.space();
    cellSizes_.clear();
    bounds_.resize(dimension_);
    for (unsigned int i = 0; i < dimension_; ++i) {
      const Part& part = space.parts()[i];
      const bool line = part.kind == Kind::kLine;
      bounds_.setLow(i, line                         ? space.lower(part.first)
                        : part.kind == Kind::kCircle ? -std::numbers::pi
                                                     : -1);
      bounds_.setHigh(i, line                         ? space.upper(part.first)
                         : part.kind == Kind::kCircle ? std::numbers::pi
                                                      : 1);
      const double width = bounds_.high[i] - bounds_.low[i];
      // A joint without range is one cell, because a size of zero would cause a division by zero.
      cellSizes_.push_back(width > 0 ? width / kProjectionCells : 1);
    }
  }

  void project(const ob::State* state, Eigen::Ref<Eigen::VectorXd> projection) const override {
    const std::span<const double> point = own_.point(state);
    for (unsigned int i = 0; i < dimension_; ++i)
      projection[static_cast<Eigen::Index>(i)] = point[at(own_.space().parts()[i].first)];
  }

 private:
  const OmplStateSpace& own_;
  unsigned int dimension_;
};

/// See OmplStateSpace.
class Sampler : public ob::StateSampler {
 public:
  Sampler(const OmplStateSpace* space, std::uint64_t seed, std::uint64_t stream)
      : StateSampler(space),
        own_(*space),
        random_(seed, stream),
        offset_(at(space->space().size()), 0.0) {}

  void sampleUniform(ob::State* state) override {
    const ConfigurationSpace& space = own_.space();
    const std::span<double> q = own_.point(state);
    for (const Part& part : space.parts()) {
      double& x = q[at(part.first)];
      if (part.kind == Kind::kLine)
        x = random_.uniform(space.lower(part.first), space.upper(part.first));
      if (part.kind == Kind::kCircle) x = random_.uniform(-std::numbers::pi, std::numbers::pi);
      if (part.kind == Kind::kRotation) random_.quaternion(&x);
    }
  }

  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    const ConfigurationSpace& space = own_.space();
    const std::span<const double> center = own_.point(near);
    bool anywhere = false;
    for (const Part& part : space.parts()) {
      const std::size_t i = at(part.first);
      const double reach = part.weight > 0 ? distance / part.weight : collision::kTwoPi;
      if (part.kind == Kind::kLine) {
        const double low = std::max(space.lower(part.first), center[i] - reach);
        const double high = std::min(space.upper(part.first), center[i] + reach);
        offset_[i] = random_.uniform(std::min(low, high), high) - center[i];
      }
      if (part.kind == Kind::kCircle) {
        const double turn = std::min(reach, std::numbers::pi);
        offset_[i] = random_.uniform(-turn, turn);
      }
      if (part.kind == Kind::kRotation) {
        anywhere = reach >= std::numbers::pi;
        random_.inBall(std::min(reach, std::numbers::pi), &offset_[i]);
        offset_[i + 3] = 0;
      }
    }
    space.advance(center, offset_, 1, own_.point(state));
    if (anywhere)
      for (const Part& part : space.parts())
        if (part.kind == Kind::kRotation && distance >= std::numbers::pi * part.weight)
          random_.quaternion(&own_.point(state)[at(part.first)]);
    own_.enforceBounds(state);
  }

  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    const ConfigurationSpace& space = own_.space();
    const std::span<const double> center = own_.point(mean);
    for (const Part& part : space.parts()) {
      const std::size_t i = at(part.first);
      const double sigma = part.weight > 0 ? deviation / part.weight : collision::kTwoPi;
      const std::size_t count = part.kind == Kind::kRotation ? 3 : 1;
      for (std::size_t k = 0; k < count; ++k) offset_[i + k] = sigma * random_.gaussian();
      if (part.kind == Kind::kRotation) offset_[i + 3] = 0;
    }
    space.advance(center, offset_, 1, own_.point(state));
    own_.enforceBounds(state);
  }

 private:
  const OmplStateSpace& own_;
  Random random_;
  std::vector<double> offset_;
};

}  // namespace

OmplStateSpace::OmplStateSpace(std::shared_ptr<const ConfigurationSpace> space, std::uint64_t seed)
    : space_(std::move(space)), size_(at(space_->size())), seed_(seed), plain_(true) {
  type_ = ob::STATE_SPACE_UNKNOWN;
  setName("Leeway" + getName());
  for (const Part& part : space_->parts()) {
    if (part.kind != Kind::kLine || part.weight != 1) plain_ = false;
    if (part.kind == Kind::kLine && !std::isfinite(range(*space_, part)))
      throw std::invalid_argument(
          "variable '" + space_->model().variables[at(space_->variables()[at(part.first)])].name +
          "' has no limits and cannot be sampled");
  }
}

OmplStateSpace::~OmplStateSpace() = default;

std::span<double> OmplStateSpace::point(ob::State* state) const {
  return {state->as<StateType>()->values, size_};
}

std::span<const double> OmplStateSpace::point(const ob::State* state) const {
  return {state->as<StateType>()->values, size_};
}

unsigned int OmplStateSpace::getDimension() const {
  unsigned int dimension = 0;
  for (const Part& part : space_->parts()) dimension += part.kind == Kind::kRotation ? 3 : 1;
  return dimension;
}

double OmplStateSpace::getMaximumExtent() const {
  double squared = 0;
  for (const Part& part : space_->parts()) squared += extent(*space_, part) * extent(*space_, part);
  return std::sqrt(squared);
}

double OmplStateSpace::getMeasure() const {
  double product = 1;
  for (const Part& part : space_->parts()) product *= measure(*space_, part);
  return product;
}

void OmplStateSpace::enforceBounds(ob::State* state) const {
  const std::span<double> q = point(state);
  for (const Part& part : space_->parts()) {
    double& x = q[at(part.first)];
    if (part.kind == Kind::kLine)
      x = std::clamp(x, space_->lower(part.first), space_->upper(part.first));
    if (part.kind == Kind::kCircle && std::abs(x) > std::numbers::pi)
      x = std::remainder(x, collision::kTwoPi);
    if (part.kind != Kind::kRotation) continue;
    double* r = &x;
    const double norm = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
    if (std::abs(norm - 1) <= kUnitToRounding) continue;
    for (int i = 0; i < 4; ++i) r[i] = norm > 0 ? r[i] / norm : (i == 3 ? 1 : 0);
  }
}

bool OmplStateSpace::satisfiesBounds(const ob::State* state) const {
  return space_->withinLimits(point(state));
}

void OmplStateSpace::copyState(ob::State* destination, const ob::State* source) const {
  // memmove() instead of memcpy(), because some planners copy a state onto itself.
  std::memmove(destination->as<StateType>()->values, source->as<StateType>()->values,
               size_ * sizeof(double));
}

double OmplStateSpace::distance(const ob::State* a, const ob::State* b) const {
  if (!plain_) return space_->distance(point(a), point(b));
  const double* x = a->as<StateType>()->values;
  const double* y = b->as<StateType>()->values;
  double squared = 0;
  for (std::size_t i = 0; i < size_; ++i) squared += (y[i] - x[i]) * (y[i] - x[i]);
  return std::sqrt(squared);
}

bool OmplStateSpace::equalStates(const ob::State* a, const ob::State* b) const {
  const std::span<const double> x = point(a), y = point(b);
  return std::equal(x.begin(), x.end(), y.begin()) || distance(a, b) == 0;
}

void OmplStateSpace::interpolate(const ob::State* from, const ob::State* to, double t,
                                 ob::State* state) const {
  space_->interpolate(point(from), point(to), t, point(state));
}

ob::StateSamplerPtr OmplStateSpace::allocDefaultStateSampler() const {
  // The base class contains a generator of OMPL's, which our sampler does not use; see
  // omplSeedLock().
  const std::lock_guard<std::recursive_mutex> lock(omplSeedLock());
  return std::make_shared<Sampler>(this, seed_, sampler_count_++);
}

ob::State* OmplStateSpace::allocState() const {
  static_assert(sizeof(StateType) % alignof(double) == 0);
  void* block = ::operator new(sizeof(StateType) + size_ * sizeof(double));
  auto* state = new (block) StateType;
  state->values = new (static_cast<char*>(block) + sizeof(StateType)) double[size_]();
  return state;
}

void OmplStateSpace::freeState(ob::State* state) const {
  ::operator delete(static_cast<void*>(state->as<StateType>()));
}

unsigned int OmplStateSpace::getSerializationLength() const {
  return static_cast<unsigned int>(size_ * sizeof(double));
}

void OmplStateSpace::serialize(void* serialization, const ob::State* state) const {
  std::memcpy(serialization, state->as<StateType>()->values, size_ * sizeof(double));
}

void OmplStateSpace::deserialize(ob::State* state, const void* serialization) const {
  std::memcpy(state->as<StateType>()->values, serialization, size_ * sizeof(double));
}

double* OmplStateSpace::getValueAddressAtIndex(ob::State* state, unsigned int index) const {
  return index < size_ ? state->as<StateType>()->values + index : nullptr;
}

void OmplStateSpace::registerProjections() {
  const std::span<const Part> parts = space_->parts();
  if (parts.empty()) return;
  const robots::Model& model = space_->model();
  const int joint = model.variables[at(space_->variables()[0])].joint;
  const bool body = model.joints[at(joint)].type == robots::JointType::kFloating;
  const std::size_t dimension = std::min<std::size_t>(body ? 3 : 2, parts.size());
  registerDefaultProjection(
      std::make_shared<FirstNumbers>(this, static_cast<unsigned int>(dimension)));
}

void OmplStateSpace::printState(const ob::State* state, std::ostream& out) const {
  if (state == nullptr) {
    out << "no state\n";
    return;
  }
  const char* separator = "";
  for (const double x : point(state)) {
    out << separator << x;
    separator = " ";
  }
  out << '\n';
}

void OmplStateSpace::printSettings(std::ostream& out) const {
  out << "space '" << getName() << "' of " << getDimension() << " dimensions, seed " << seed_
      << '\n';
  for (int i = 0; i < space_->size(); ++i)
    out << "  " << space_->model().variables[at(space_->variables()[at(i)])].name << " ["
        << space_->lower(i) << ", " << space_->upper(i) << "]\n";
}

}  // namespace leeway::planner
