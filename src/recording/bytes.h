// Base64 (RFC 4648 §4) and SHA-256, by OpenSSL.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace fleetpub::recording {

[[nodiscard]] std::string EncodeBase64(std::string_view bytes);
/// Nothing when it is none.
[[nodiscard]] std::optional<std::string> DecodeBase64(std::string_view text);

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void Add(std::string_view bytes);
  /// Of all that was added, in lower-case hexadecimal digits. More may follow.
  [[nodiscard]] std::string Digest() const;
  void Restart();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fleetpub::recording
