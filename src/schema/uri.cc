#include "schema/uri.h"

#include <fmt/format.h>

#include <cctype>
#include <charconv>

namespace fleetpub::schema {
namespace {

struct Uri {
  std::string_view scheme;     // `http:`
  std::string_view authority;  // `//host`
  std::string_view path;
  std::string_view query;     // `?a`
  std::string_view fragment;  // `#b`
};

std::string_view TakeScheme(std::string_view& rest) {
  const std::size_t end = rest.find_first_of(":/?#");
  if (end == 0 || end == std::string_view::npos || rest[end] != ':') return {};
  const std::string_view scheme = rest.substr(0, end + 1);
  rest.remove_prefix(end + 1);
  return scheme;
}

std::string_view TakeUntil(std::string_view& rest, std::string_view stops, std::size_t from = 0) {
  const std::string_view taken = rest.substr(0, rest.find_first_of(stops, from));
  rest.remove_prefix(taken.size());
  return taken;
}

Uri Split(std::string_view text) {
  Uri uri;
  uri.scheme = TakeScheme(text);
  if (text.starts_with("//")) uri.authority = TakeUntil(text, "/?#", 2);
  uri.path = TakeUntil(text, "?#");
  uri.query = TakeUntil(text, "#");
  uri.fragment = text;
  return uri;
}

// RFC 3986 §5.2.4
std::string RemoveDotSegments(std::string_view path) {
  std::string result;
  while (!path.empty()) {
    std::size_t end = path.find('/', 1);
    if (end == std::string_view::npos) end = path.size();
    const std::string_view segment = path.substr(0, end);
    const bool last = end == path.size();
    if (segment == "/.." || segment == "..") {
      result.erase(std::min(result.rfind('/'), result.size()));
      if (last) result += '/';
    } else if (segment == "/." || segment == ".") {
      if (last) result += '/';
    } else {
      result += segment;
    }
    path.remove_prefix(end);
  }
  return result;
}

// RFC 3986 §5.2.3
std::string Merge(const Uri& base, std::string_view path) {
  if (!base.authority.empty() && base.path.empty()) return fmt::format("/{}", path);
  return fmt::format("{}{}", base.path.substr(0, base.path.rfind('/') + 1), path);
}

}  // namespace

std::string ResolveUri(std::string_view base, std::string_view reference) {
  const Uri from = Split(base);
  const Uri to = Split(reference);
  if (!to.scheme.empty()) return std::string(reference);
  if (!to.authority.empty()) return fmt::format("{}{}", from.scheme, reference);
  if (to.path.empty()) {
    const std::string_view query = to.query.empty() ? from.query : to.query;
    return fmt::format("{}{}{}{}{}", from.scheme, from.authority, from.path, query, to.fragment);
  }
  const std::string path =
      RemoveDotSegments(to.path.starts_with('/') ? std::string(to.path) : Merge(from, to.path));
  return fmt::format("{}{}{}{}{}", from.scheme, from.authority, path, to.query, to.fragment);
}

std::pair<std::string, std::string> SplitFragment(std::string_view uri) {
  const std::size_t hash = uri.find('#');
  if (hash == std::string_view::npos) return {std::string(uri), ""};
  std::string fragment;
  for (std::size_t i = hash + 1; i < uri.size(); ++i) {
    unsigned char byte = 0;
    const char* digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      fragment += static_cast<char>(byte);
      i += 2;
    } else {
      fragment += uri[i];
    }
  }
  return {std::string(uri.substr(0, hash)), fragment};
}

}  // namespace fleetpub::schema
