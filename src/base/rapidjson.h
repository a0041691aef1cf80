// The one way into RapidJSON, so that every translation unit sees it configured alike.
//
// RapidJSON checks its preconditions with RAPIDJSON_ASSERT, which aborts the process by default,
// and writes where memory would be when there is none. Ours throw: whatever a message or a schema
// contains, the worst that it can do is end in an error.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <stdexcept>

namespace fleetpub::base {

/// A RapidJSON precondition did not hold. Caught where the library is used.
class JsonAssertion : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] inline void ThrowJsonAssertion(const char* condition) {
  throw JsonAssertion(condition);
}

}  // namespace fleetpub::base

#ifdef RAPIDJSON_ASSERT
#error "Include base/rapidjson.h before anything that includes RapidJSON."
#endif
// NOLINTNEXTLINE(bugprone-macro-parentheses)
#define RAPIDJSON_ASSERT(x) ((x) ? void() : ::fleetpub::base::ThrowJsonAssertion(#x))
#define RAPIDJSON_ASSERT_THROWS 1
#define RAPIDJSON_NOEXCEPT_ASSERT(x) static_cast<void>(x)
#define RAPIDJSON_HAS_STDSTRING 1

#include <rapidjson/document.h>
#include <rapidjson/pointer.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/reader.h>
#include <rapidjson/stringbuffer.h>
#include <rapidjson/writer.h>

namespace fleetpub::base {

/// RapidJSON's Allocator concept over malloc(). Errors: std::bad_alloc.
class JsonMemory {
 public:
  // NOLINTNEXTLINE(readability-identifier-naming): RapidJSON's name
  static constexpr bool kNeedFree = true;

  [[nodiscard]] static void* Malloc(std::size_t size) { return Realloc(nullptr, 0, size); }
  [[nodiscard]] static void* Realloc(void* old, std::size_t /*old_size*/, std::size_t size) {
    if (size == 0) {
      std::free(old);
      return nullptr;
    }
    void* memory = std::realloc(old, size);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
  }
  static void Free(void* memory) { std::free(memory); }
};

using JsonEncoding = rapidjson::UTF8<>;
using JsonPool = rapidjson::MemoryPoolAllocator<JsonMemory>;
using JsonValue = rapidjson::GenericValue<JsonEncoding, JsonPool>;
using JsonDocument = rapidjson::GenericDocument<JsonEncoding, JsonPool, JsonMemory>;
using JsonPointer = rapidjson::GenericPointer<JsonValue, JsonMemory>;
using JsonReader = rapidjson::GenericReader<JsonEncoding, JsonEncoding, JsonMemory>;
using JsonBuffer = rapidjson::GenericStringBuffer<JsonEncoding, JsonMemory>;
using JsonWriter = rapidjson::Writer<JsonBuffer, JsonEncoding, JsonEncoding, JsonMemory>;
using JsonPrettyWriter =
    rapidjson::PrettyWriter<JsonBuffer, JsonEncoding, JsonEncoding, JsonMemory>;

}  // namespace fleetpub::base
