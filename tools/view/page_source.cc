#include "tools/view/page_source.h"

// Includes the file's bytes directly, because a compiler takes seconds for half a megabyte as an
// array of numbers.
#ifdef LEEWAY_PAGE
__asm__(
    ".section .rodata\n"
    ".global leeway_view_page\n"
    ".global leeway_view_page_end\n"
    ".hidden leeway_view_page\n"
    ".hidden leeway_view_page_end\n"
    "leeway_view_page:\n"
    ".incbin \"" LEEWAY_PAGE
    "\"\n"
    "leeway_view_page_end:\n"
    ".byte 0\n"
    ".text\n");
extern "C" __attribute__((visibility("hidden"))) const char leeway_view_page[],
    leeway_view_page_end[];
#endif

namespace leeway::tools::view {

std::string_view pageSource() {
#ifdef LEEWAY_PAGE
  return {leeway_view_page, static_cast<std::size_t>(leeway_view_page_end - leeway_view_page)};
#else
  return {};
#endif
}

}  // namespace leeway::tools::view
