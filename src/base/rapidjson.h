// The one way into RapidJSON, so that every translation unit sees it configured alike.
//
// RapidJSON checks its preconditions with RAPIDJSON_ASSERT, which aborts the process by default.
// Ours throws: whatever a message or a schema contains, the worst that it can do is end in an
// error.
#pragma once

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
#include <rapidjson/stringbuffer.h>
#include <rapidjson/writer.h>
