#include "delivery/topic_filter.h"

#include <algorithm>

namespace fleetpub::delivery {
namespace {

// The first level, which is taken off the text with its slash; `more` tells whether one stood
// there.
std::string_view TakeLevel(std::string_view& text, bool& more) {
  const std::string_view level = text.substr(0, text.find('/'));
  more = level.size() < text.size();
  text.remove_prefix(std::min(level.size() + 1, text.size()));
  return level;
}

}  // namespace

bool HasWildcard(std::string_view filter) {
  return filter.find_first_of("+#") != std::string_view::npos;
}

bool Matches(std::string_view filter, std::string_view topic) {
  // What begins with $ is the broker's own, and no wildcard at the start means it.
  if (topic.starts_with('$') && HasWildcard(filter.substr(0, 1))) return false;
  bool more_filter = true;
  bool more_topic = true;
  while (more_filter && more_topic) {
    const std::string_view wanted = TakeLevel(filter, more_filter);
    if (wanted == "#") return true;
    const std::string_view level = TakeLevel(topic, more_topic);
    if (wanted != "+" && wanted != level) return false;
  }
  // `a/#` means `a` itself too.
  return more_filter ? filter == "#" : !more_topic;
}

}  // namespace fleetpub::delivery
