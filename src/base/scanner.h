// What reads times piece by piece.
#pragma once

#include <chrono>
#include <string_view>

namespace fleetpub::base {

/// Reads fixed-width numbers and punctuation from the front of a text.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}

  bool Digits(int count, int& value) {
    if (rest_.size() < static_cast<std::size_t>(count)) return false;
    value = 0;
    for (int i = 0; i < count; ++i) {
      const char c = rest_[static_cast<std::size_t>(i)];
      if (c < '0' || c > '9') return false;
      value = value * 10 + (c - '0');
    }
    rest_.remove_prefix(static_cast<std::size_t>(count));
    return true;
  }
  bool OneOf(std::string_view set) {
    if (rest_.empty() || set.find(rest_.front()) == std::string_view::npos) return false;
    rest_.remove_prefix(1);
    return true;
  }
  /// The digits after a decimal point.
  bool Fraction(std::chrono::microseconds& value) {
    int scale = 100'000;
    value = std::chrono::microseconds(0);
    if (rest_.empty() || rest_.front() < '0' || rest_.front() > '9') return false;
    while (!rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9') {
      value += std::chrono::microseconds(scale * (rest_.front() - '0'));
      scale /= 10;
      rest_.remove_prefix(1);
    }
    return true;
  }
  bool Word(std::string_view word) {
    if (!rest_.starts_with(word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }
  [[nodiscard]] bool AtEnd() const { return rest_.empty(); }
  [[nodiscard]] char Front() const { return rest_.empty() ? '\0' : rest_.front(); }

 private:
  std::string_view rest_;
};

}  // namespace fleetpub::base
