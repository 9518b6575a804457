#include "robots/motion/kept_proofs.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "robots/base/interruptible.h"
#include "robots/cache/disk_cache.h"

namespace leeway::robots {
namespace {

constexpr std::size_t kMostThreads = 16;

template <class Item>
void addAll(std::span<const Item> items, ContentKey& key) {
  key.add(std::as_bytes(items));
}

void addPose(const Pose& pose, ContentKey& key) {
  for (const double number : pose.rotation.reshaped()) key.add(number);
  for (const double number : pose.translation) key.add(number);
}

void addJoints(const Model& model, ContentKey& key) {
  for (const Joint& joint : model.joints) {
    key.add(std::string_view("joint"));
    addPose(joint.X_PJ, key);
    for (const double number : joint.axis) key.add(number);
    for (const double number :
         {static_cast<double>(joint.type), static_cast<double>(joint.parent_link),
          static_cast<double>(joint.child_link), static_cast<double>(joint.first_variable),
          static_cast<double>(joint.variable_count), static_cast<double>(joint.mimic),
          joint.multiplier, joint.offset})
      key.add(number);
  }
  for (const Variable& variable : model.variables) {
    key.add(std::string_view("variable"));
    const auto [low, high] =
        variable.file_limits.value_or(std::pair(variable.lower, variable.upper));
    for (const double number : {static_cast<double>(variable.joint), variable.lower, variable.upper,
                                low, high, variable.rest})
      key.add(number);
  }
}

/// Adds what distances from the surface of a mesh or hull depend on.
void addSurface(const collision::Shape& shape, ContentKey& key) {
  if (const collision::ConvexHull* hull = shape.hull()) addAll(hull->vertices(), key);
  if (const collision::TriangleMesh* mesh = shape.mesh()) {
    addAll(mesh->vertices(), key);
    addAll(mesh->triangles(), key);
    for (int c = 0; c < mesh->componentCount(); ++c)
      key.add(static_cast<double>(mesh->isClosed(c)));
    key.add(static_cast<double>(mesh->pieces().use));
  }
}

/// Empty: the answers are not kept.
std::string keyOf(const Model& model, std::span<const std::pair<int, int>> pairs,
                  const char* kind) {
  ContentKey key(kind);
  const auto add = [&](const collision::Shape& shape) {
    addSurface(shape, key);
    return true;
  };
  if (!addModel(model, add, key)) return {};
  addAll(pairs, key);
  return key.finish();
}

std::vector<unsigned char> decideAll(std::span<const std::pair<int, int>> pairs,
                                     const DecidePair& question, const Stop& asked) {
  std::vector<unsigned char> answers(pairs.size());
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < pairs.size(); i = next++) {
        throwIfStopped(asked, question.what);
        answers[i] = question.decide(pairs[i]);
      }
    } catch (...) {  // Stopped, too
      const std::lock_guard<std::mutex> lock(mutex);
      failure = std::current_exception();
      next = pairs.size();
    }
  };
  const std::size_t most = std::min<std::size_t>(std::thread::hardware_concurrency(), kMostThreads);
  std::vector<std::thread> threads;
  threads.reserve(most);
  try {
    while (threads.size() + 1 < std::min(most, pairs.size())) threads.emplace_back(work);
  } catch (const std::system_error&) {  // fewer threads do it
  }
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  return answers;
}

bool areAnswers(std::span<const std::byte> bytes, std::size_t count) {
  return bytes.size() == count && std::all_of(bytes.begin(), bytes.end(), [](std::byte b) {
           return std::to_integer<unsigned char>(b) < DecidePair::kMost;
         });
}

}  // namespace

bool addModel(const Model& model, const std::function<bool(const collision::Shape&)>& addSurface,
              ContentKey& key) {
  addJoints(model, key);
  for (const Link& link : model.links) {
    key.add(std::string_view("link"));
    for (const Geometry& geometry : link.geometries) {
      const collision::Shape& shape = geometry.shape;
      key.add(std::string_view("geometry"));
      addPose(geometry.X_BG, key);
      key.add(static_cast<double>(shape.type()));
      for (const double number : {shape.radius(), shape.halfLength()}) key.add(number);
      for (const double number : shape.halfExtents()) key.add(number);
      const bool has_surface = shape.mesh() != nullptr || shape.hull() != nullptr;
      if (shape.deformable() != nullptr || (has_surface && !addSurface(shape))) return false;
    }
  }
  return true;
}

std::vector<unsigned char> decidePairs(const Model& model,
                                       std::span<const std::pair<int, int>> pairs,
                                       const DecidePair& question, const Stop& stop) {
  if (pairs.empty()) return {};
  const DiskCache cache{model.cache};
  const std::string key = cache.isOn() ? keyOf(model, pairs, question.kind) : "";
  if (!key.empty())
    if (const auto kept = cache.read(key)) {
      const std::span<const std::byte> bytes(kept->data(), kept->size());
      if (areAnswers(bytes, pairs.size())) {
        std::vector<unsigned char> answers;
        for (const std::byte b : bytes) answers.push_back(std::to_integer<unsigned char>(b));
        return answers;
      }
    }
  std::vector<unsigned char> answers;
  workInterruptibly(stop, [&](const Stop& asked) { answers = decideAll(pairs, question, asked); });
  if (!key.empty()) cache.write(key, std::as_bytes(std::span(answers)));
  return answers;
}

}  // namespace leeway::robots
