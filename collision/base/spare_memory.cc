#include "collision/base/spare_memory.h"

#include <algorithm>
#include <new>

namespace leeway::collision {
namespace {

constexpr std::size_t kBlockAlignment = 64;
/// Limits on the blocks that a thread keeps, and on their total bytes.
constexpr std::size_t kMostBlocks = 48, kMostBytes = std::size_t{8} << 20U;

/// Precedes each block.
struct Header {
  std::size_t bytes;
};
static_assert(sizeof(Header) <= kBlockAlignment);

Header* headerOf(void* memory) {
  return reinterpret_cast<Header*>(static_cast<std::byte*>(memory) - kBlockAlignment);
}
void* memoryOf(Header* block) { return reinterpret_cast<std::byte*>(block) + kBlockAlignment; }

void release(Header* block) { ::operator delete (block, std::align_val_t{kBlockAlignment}); }

/// Set when the thread ends: no more blocks are kept. It is not a member of Spare, because
/// compilers omit the last stores of Spare's destructor.
thread_local bool spare_is_gone = false;

/// The blocks that a thread keeps, in the order in which they were given back.
struct Spare {
  ~Spare() {
    for (std::size_t i = 0; i < count; ++i) release(blocks[i]);
    spare_is_gone = true;
  }
  Header* blocks[kMostBlocks];
  std::size_t count = 0, bytes = 0;
};
thread_local Spare spare;

}  // namespace

void* takeMemory(std::size_t bytes) {
  // Skips a block that is far too large, because it fits a larger request.
  for (std::size_t i = spare_is_gone ? 0 : spare.count; i-- > 0;) {
    Header* const block = spare.blocks[i];
    if (block->bytes < bytes || block->bytes > 2 * bytes) continue;
    spare.bytes -= block->bytes;
    std::copy(spare.blocks + i + 1, spare.blocks + spare.count, spare.blocks + i);
    --spare.count;
    return memoryOf(block);
  }
  void* const block = ::operator new (kBlockAlignment + bytes, std::align_val_t{kBlockAlignment});
  return memoryOf(::new (block) Header{bytes});
}

void giveBackMemory(void* memory) noexcept {
  if (memory == nullptr) return;
  Header* const block = headerOf(memory);
  if (spare_is_gone || block->bytes > kMostBytes) return release(block);
  // Drops the oldest blocks first.
  std::size_t gone = 0;
  for (; gone < spare.count &&
         (spare.count - gone == kMostBlocks || spare.bytes + block->bytes > kMostBytes);
       ++gone) {
    spare.bytes -= spare.blocks[gone]->bytes;
    release(spare.blocks[gone]);
  }
  std::copy(spare.blocks + gone, spare.blocks + spare.count, spare.blocks);
  spare.count -= gone;
  spare.blocks[spare.count++] = block;
  spare.bytes += block->bytes;
}

}  // namespace leeway::collision
