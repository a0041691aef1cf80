#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fleetpub::testing {

/// What several fakes were asked to do, in one order.
class Journal {
 public:
  void Record(std::string entry) { entries_.push_back(std::move(entry)); }
  void Record(std::string_view verb, std::span<const std::string> objects) {
    std::string entry(verb);
    for (const std::string& object : objects) entry += " " + object;
    entries_.push_back(std::move(entry));
  }

  [[nodiscard]] const std::vector<std::string>& entries() const { return entries_; }

 private:
  std::vector<std::string> entries_;
};

}  // namespace fleetpub::testing
