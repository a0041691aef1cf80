// References between schemas are URIs (RFC 3986); these are the two operations that `$id` and
// `$ref` need.
#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace fleetpub::schema {

/// `reference` seen from `base` (RFC 3986 §5.2). Both may be relative or empty.
[[nodiscard]] std::string ResolveUri(std::string_view base, std::string_view reference);

/// Before and after the first `#`; the fragment is percent-decoded.
[[nodiscard]] std::pair<std::string, std::string> SplitFragment(std::string_view uri);

}  // namespace fleetpub::schema
